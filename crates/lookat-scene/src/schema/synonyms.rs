//! Words of other programs (Mitsuba, Blender, POV-Ray, Arnold) and other versions of pbrt for types and parameters of
//! pbrt-v3, as plain data.

use std::collections::HashSet;

/// A word from elsewhere, and what to write instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Synonym {
    /// The word as written in its table: lower case, without `_`, `-` and spaces, in American spelling.
    pub word: &'static str,
    /// The pbrt-v3 name that replaces it; empty if no name does.
    pub name: &'static str,
    /// Other necessary changes, or the reason why no name replaces the word; empty for a plain rename.
    pub advice: &'static str,
}

/// The words for the types of a directive, and for its parameters.
pub(crate) struct Table {
    directive: &'static str,
    types: &'static [TypeRow],
    parameters: &'static [Row],
}

/// A row for words that all become the type `name`: the words, the name, the advice.
type TypeRow = (&'static [&'static str], &'static str, &'static str);

/// A row for words that all become the parameter `name`: the types (empty: all), the words, the name, the advice.
type Row = (&'static [&'static str], &'static [&'static str], &'static str, &'static str);

const TABLES: &[Table] = &[
    CAMERA,
    FILM,
    PIXEL_FILTER,
    SAMPLER,
    INTEGRATOR,
    ACCELERATOR,
    SHAPE_TABLE,
    MATERIAL_TABLE,
    LIGHT_SOURCE,
    AREA_LIGHT_SOURCE,
    TEXTURE_TABLE,
];

/// The synonym of a type of `directive`.
pub fn type_synonym(directive: &str, word: &str) -> Option<Synonym> {
    let plain = plain(word);
    let rows = table(directive)?.types.iter();
    rows.filter_map(|(words, name, advice)| found(&plain, words, name, advice)).next()
}

/// The synonyms of a parameter of a `directive` of type `kind`, in order of preference.
pub fn parameter_synonyms<'a>(
    directive: &str,
    kind: &'a str,
    word: &str,
) -> impl Iterator<Item = Synonym> + use<'a> {
    let plain = plain(word);
    rows(directive, kind).filter_map(move |(_, words, name, advice)| found(&plain, words, name, advice))
}

/// The words that mean the parameter `name`, each once.
pub(super) fn words_for(directive: &str, kind: &str, name: &str) -> Vec<&'static str> {
    let of_name = rows(directive, kind).filter(|(_, _, known, _)| *known == name);
    let mut words: Vec<&str> = of_name.flat_map(|(_, words, ..)| words.iter().copied()).collect();
    let mut seen = HashSet::new();
    words.retain(|word| seen.insert(*word));
    words
}

fn rows<'a>(directive: &str, kind: &'a str) -> impl Iterator<Item = &'static Row> + use<'a> {
    let rows = table(directive).map_or(&[][..], |table| table.parameters);
    rows.iter().filter(move |(kinds, ..)| kinds.is_empty() || kinds.contains(&kind))
}

fn table(directive: &str) -> Option<&'static Table> {
    let directive = if directive == "MakeNamedMaterial" { "Material" } else { directive };
    TABLES.iter().find(|table| table.directive == directive)
}

/// A word as the tables write it.
fn plain(word: &str) -> String {
    word.to_ascii_lowercase()
        .replace(['_', '-', ' '], "")
        .replace("colour", "color")
        .replace("centre", "center")
}

fn found(plain: &str, words: &[&'static str], name: &'static str, advice: &'static str) -> Option<Synonym> {
    let word = words.iter().find(|word| **word == plain)?;
    Some(Synonym { word, name, advice })
}

const SAMPLES: &str = "the Sampler sets the samples per pixel, with \"integer pixelsamples\"";
const PLACE: &str = "to place it, write Translate, Rotate, Scale or Transform before the directive";
/// The advice for a type that another one replaces.
pub(crate) const OLDER: &str = "a type of an older pbrt";
const EMIT: &str =
    "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1], written before the Shape, makes the Shape emit light";

const LOOKAT: &str =
    "write LookAt before Camera, with the eye, the point to look at and the up vector, three numbers each";
const RESOLUTION: &str =
    "Film \"image\" sets the size, with \"integer xresolution\" and \"integer yresolution\"";
const APERTURE: &str = "lensradius is half the diameter of the aperture";

#[rustfmt::skip]
pub(super) const CAMERA: Table = Table {
    directive: "Camera",
    types: &[
        (&["thinlens", "pinhole", "persp", "perspectivepinhole"], "perspective", ""),
        (&["ortho", "parallel"], "orthographic", ""),
        (&["spherical", "panorama", "panoramic", "equirectangular", "latlong"], "environment", ""),
    ],
    parameters: &[
        (&["perspective", "orthographic", "environment"], &["aperture", "aperturediameter", "aperturesize", "aperturewidth", "lensdiameter"], "lensradius", APERTURE),
        (&[], &["aperture", "apertureradius", "radius", "lens", "defocusradius", "dof", "depthoffield", "bokeh", "blur", "defocus"], "lensradius", "focaldistance sets the distance that is sharp"),
        (&[], &["fstop", "fnumber", "aperturefstop"], "", "lensradius is the focal length divided by twice the f-stop, in the units of the scene"),
        (&[], &["focus", "focusdistance", "focaldist", "focallengthdistance", "focalplane", "distance"], "focaldistance", ""),
        (&[], &["focallength", "lenslength"], "", "\"float fov\" is the angle of the shorter side in degrees: 2 atan(s / 2f), with the shorter side s of the film and the focal length f"),
        (&["perspective"], &["zoom", "wideangle", "telephoto"], "", "\"float fov\" is the angle of view: a smaller angle shows less of the scene, and larger"),
        (&[], &["shutter", "shutterspeed", "exposuretime"], "", "\"float shutteropen\" and \"float shutterclose\" are the times of the shutter; \"float scale\" of Film sets the exposure"),
        (&[], &["angle", "fieldofview", "viewangle", "yfov", "xfov"], "fov", "fov is the angle of the shorter side, in degrees"),
        (&[], &["fovaxis"], "", "fov is always the angle of the shorter side: leave fov_axis out"),
        (&[], &["eye", "origin", "position", "from", "location", "pos", "up", "lookat", "look", "target", "to", "direction", "sky"], "", LOOKAT),
        (&[], &["toworld", "transform", "matrix", "rotation", "translate"], "", PLACE),
        (&[], &["resolution", "width", "height", "xresolution", "yresolution", "size"], "", RESOLUTION),
        (&[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
        (&[], &["near", "nearclip", "nearplane", "far", "farclip", "farplane", "clipstart", "clipend", "hither", "yon"], "", "pbrt-v3 has no clip planes: leave it out"),
        (&[], &["aspect", "aspectratio"], "frameaspectratio", ""),
        (&[], &["orthowidth", "orthographicscale", "orthoscale", "scale"], "", "\"float screenwindow\" [xmin xmax ymin ymax] is the part that is seen"),
    ],
};

#[rustfmt::skip]
const FILM: Table = Table {
    directive: "Film",
    types: &[
        (&["rgb", "hdrfilm", "ldrfilm", "exr", "png", "file"], "image", ""),
    ],
    parameters: &[
        (&[], &["width", "xres", "imagewidth", "resolutionx"], "xresolution", ""),
        (&[], &["height", "yres", "imageheight", "resolutiony"], "yresolution", ""),
        (&[], &["resolution", "size", "res"], "", "write \"integer xresolution\" and \"integer yresolution\""),
        (&[], &["output", "file", "outputfile", "image", "name"], "filename", ""),
        (&[], &["crop", "croprect", "cropbounds", "region"], "cropwindow", "cropwindow is xmin xmax ymin ymax, from 0 to 1"),
        (&[], &["exposure", "iso", "gain", "sensor", "imagingratio"], "", "\"float scale\" multiplies the picture: write 2 to the power of the exposure in stops"),
        (&[], &["gamma", "tonemap", "colorspace"], "", "exr and pfm pictures are linear, png and tga pictures sRGB: leave it out"),
        (&[], &["filter", "rfilter"], "", "PixelFilter sets the filter"),
        (&[], &["premultiplyalpha", "writefrequency", "display"], "", "an option of an older pbrt: leave it out"),
        (&[], &["samples", "spp", "pixelsamples"], "", SAMPLES),
        (&[], &["maxluminance", "clamp", "maxcomponentvalue"], "maxsampleluminance", "maxsampleluminance is the largest luminance of a sample"),
    ],
};

#[rustfmt::skip]
const PIXEL_FILTER: Table = Table {
    directive: "PixelFilter",
    types: &[
        (&["tent", "bartlett"], "triangle", ""),
        (&["lanczos", "windowedsinc"], "sinc", ""),
        (&["gauss"], "gaussian", ""),
        (&["catmullrom"], "mitchell", "Catmull-Rom is \"mitchell\" with \"float B\" 0 and \"float C\" 0.5"),
        (&["blackmanharris"], "gaussian", ""),
    ],
    parameters: &[
        (&[], &["radius", "size", "support"], "", "\"float xwidth\" and \"float ywidth\" are the radius along each axis, in pixels"),
        (&[], &["width"], "", "\"float xwidth\" and \"float ywidth\" are half the width, in pixels"),
        (&[], &["xradius"], "xwidth", ""),
        (&[], &["yradius"], "ywidth", ""),
        (&["gaussian"], &["stddev", "sigma"], "", "\"float alpha\" is 1 / (2 sigma^2)"),
    ],
};

#[rustfmt::skip]
const SAMPLER: Table = Table {
    directive: "Sampler",
    types: &[
        (&["independent", "uniform"], "random", ""),
        (&["ldsampler", "hammersley"], "halton", ""),
        (&["bestcandidate", "adaptive"], "halton", OLDER),
        (&["zsobol", "paddedsobol", "pmj02bn", "pmj", "bluenoise", "orthogonal"], "sobol", ""),
        (&["multijitter", "jittered", "grid"], "stratified", ""),
    ],
    parameters: &[
        (&["stratified"], &["samples", "spp", "pixelsamples", "samplecount", "samplesperpixel", "count", "nsamples"], "", "\"integer xsamples\" times \"integer ysamples\" is the number of samples of each pixel"),
        (&[], &["samples", "spp", "samplecount", "samplesperpixel", "count", "nsamples", "aasamples"], "pixelsamples", ""),
        (&["random"], &["xsamples", "ysamples"], "", "\"integer pixelsamples\" is the product of xsamples and ysamples"),
        (&[], &["minsamples", "maxsamples"], "pixelsamples", ""),
        (&[], &["seed"], "", "the option --seed of lookat sets the seed"),
    ],
};

#[rustfmt::skip]
const INTEGRATOR: Table = Table {
    directive: "Integrator",
    types: &[
        (&["pathtracer", "pathtracing", "simplepath", "gi"], "path", ""),
        (&["irradiancecache", "igi", "glossyprt", "diffuseprt", "useprobes", "dipolesubsurface"], "path", OLDER),
        (&["direct"], "directlighting", ""),
        (&["ao", "ambient", "occlusion"], "ambientocclusion", ""),
        (&["volpathmis", "volpathsimple", "simplevolpath", "volumetricpath"], "volpath", ""),
        (&["bidirectional", "ptracer"], "bdpt", ""),
        (&["pssmlt", "metropolis"], "mlt", ""),
        (&["photonmapper", "ppm"], "sppm", ""),
        (&["photonmap", "exphotonmap"], "sppm", OLDER),
    ],
    parameters: &[
        (&[], &["depth", "bounces", "maxbounces", "raydepth", "recursion", "maxraydepth"], "maxdepth", ""),
        (&[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
        (&["sppm"], &["maxdist"], "radius", "radius is the first search radius of photons, in the units of the scene"),
        (&[], &["maxspeculardepth"], "maxdepth", ""),
        (&[], &["rrdepth", "russianroulettedepth"], "", "roulette starts at the fifth surface; \"float rrthreshold\" 0 turns it off"),
        (&[], &["lightsampler"], "lightsamplestrategy", "lightsamplestrategy is \"uniform\", \"power\" or \"spatial\""),
    ],
};

#[rustfmt::skip]
const ACCELERATOR: Table = Table {
    directive: "Accelerator",
    types: &[
        (&["octree", "embree", "sah"], "bvh", ""),
        (&["grid"], "bvh", OLDER),
    ],
    parameters: &[
        (&[], &["refineimmediately"], "", "an option of an older pbrt: leave it out"),
    ],
};

const SURFACE: &str =
    "to set the surface, write Material before the Shape, as in Material \"matte\" \"rgb Kd\" [.5 .5 .5]";

#[rustfmt::skip]
const SHAPE_TABLE: Table = Table {
    directive: "Shape",
    types: &[
        (&["mesh", "triangles", "triangle", "polymesh", "polygonmesh", "indexedfaceset"], "trianglemesh", ""),
        (&["ply", "meshfile"], "plymesh", ""),
        (&["obj", "wavefront", "serialized", "stl", "gltf", "fbx"], "plymesh", "\"plymesh\" reads only PLY: convert the mesh to PLY"),
        (&["rectangle", "quad", "square", "plane", "bilinearmesh"], "", "pbrt-v3 has no such shape: write it as Shape \"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"integer indices\" [0 1 2 0 2 3]"),
        (&["cube", "box"], "", "pbrt-v3 has no such shape: write it as a \"trianglemesh\" of 8 points and 12 triangles"),
        (&["torus"], "", "pbrt-v3 has no such shape: convert it to PLY for Shape \"plymesh\""),
        (&["ball", "globe", "uvsphere", "icosphere"], "sphere", ""),
        (&["circle", "disc"], "disk", ""),
        (&["tube", "rod"], "cylinder", ""),
        (&["hair", "curves", "bsplinecurve", "linearcurve", "bezier", "strand"], "curve", ""),
        (&["subdiv", "subdivision", "catmullclark"], "loopsubdiv", "\"loopsubdiv\" takes triangles"),
        (&["terrain", "height", "displacementmap"], "heightfield", ""),
        (&["instance", "shapegroup"], "", "ObjectBegin and ObjectEnd define an object, ObjectInstance places a copy"),
    ],
    parameters: &[
        (&["sphere", "disk", "cylinder", "cone", "paraboloid"], &["r", "rad", "size"], "radius", ""),
        (&["sphere", "disk", "cylinder", "cone", "paraboloid"], &["diameter"], "radius", "radius is half the diameter"),
        (&["sphere", "disk", "cylinder", "cone", "paraboloid", "hyperboloid"], &["center", "position", "origin", "location", "pos"], "", "the shape is at the origin: to move it, write Translate before the Shape"),
        (&["cylinder", "paraboloid"], &["height", "length", "p0", "p1"], "", "\"float zmin\" and \"float zmax\" are its ends along z"),
        (&["curve"], &["radius", "thickness", "widths", "r"], "width", "width is twice the radius"),
        (&["trianglemesh", "plymesh", "loopsubdiv", "nurbs", "heightfield", "hyperboloid"], &["radius", "size", "scale"], "", "to change its size, write Scale before the Shape"),
        (&["trianglemesh", "loopsubdiv", "curve", "nurbs"], &["vertices", "points", "positions", "vertex", "controlpoints", "pos"], "P", ""),
        (&["trianglemesh", "loopsubdiv"], &["faces", "triangles", "index", "tris", "vertexindices", "faceindex"], "indices", ""),
        (&["trianglemesh", "curve"], &["normals", "vertexnormals", "normal"], "N", ""),
        (&["trianglemesh"], &["tangents", "tangent"], "S", ""),
        (&["trianglemesh"], &["texcoords", "uvs", "texturecoordinates", "texcoord"], "uv", ""),
        (&["trianglemesh"], &["file", "filename"], "", "Shape \"plymesh\" reads a mesh from a file"),
        (&["plymesh"], &["file", "mesh", "path", "name"], "filename", ""),
        (&["heightfield"], &["heights", "z"], "Pz", ""),
        (&[], &["toworld", "transform", "matrix", "rotation", "translate", "flipnormals"], "", "to place the shape, write Translate, Rotate, Scale or Transform before the Shape; ReverseOrientation flips its normals"),
        (&[], &["emission", "emit", "radiance", "emitter", "l", "intensity", "power", "strength", "light"], "", EMIT),
        (&[], &["material", "bsdf", "shader", "color", "albedo", "diffuse", "basecolor", "roughness", "kd"], "", SURFACE),
    ],
};

const NORMAL_MAP: &str = "pbrt-v3 has no normal maps; \"texture bumpmap\" is a height";
const GLOSSY: &[&str] = &["plastic", "substrate", "uber", "translucent"];

#[rustfmt::skip]
const MATERIAL_TABLE: Table = Table {
    directive: "Material",
    types: &[
        (&["diffuse", "lambertian", "lambert", "roughdiffuse", "orennayar"], "matte", ""),
        (&["dielectric", "thindielectric", "roughdielectric", "refractive", "transparent"], "glass", ""),
        (&["conductor", "roughconductor", "metallic", "chrome"], "metal", ""),
        (&["shinymetal", "brushedmetal"], "metal", OLDER),
        (&["roughplastic", "coateddiffuse", "phong", "blinn", "glossy", "glossydiffuse"], "plastic", ""),
        // RGB of metals: Tungsten's ComplexIorData, from the spectra of refractiveindex.info.
        (&["gold", "au"], "metal", "gold has \"rgb eta\" [.143 .375 1.44] \"rgb k\" [3.98 2.39 1.60]"),
        (&["silver", "ag"], "metal", "silver has \"rgb eta\" [.155 .117 .138] \"rgb k\" [4.83 3.12 2.15]"),
        (&["aluminium", "aluminum", "al"], "metal", "aluminum has \"rgb eta\" [1.66 .880 .521] \"rgb k\" [9.22 6.27 4.84]"),
        (&["chromium", "cr"], "metal", "chromium has \"rgb eta\" [4.37 2.92 1.65] \"rgb k\" [5.21 4.23 3.75]"),
        (&["copper", "cu"], "metal", "copper is the default"),
        (&["water"], "glass", "water has \"float eta\" 1.33"),
        (&["ice"], "glass", "ice has \"float eta\" 1.31"),
        (&["diamond"], "glass", "diamond has \"float eta\" 2.42"),
        (&["coatedconductor"], "metal", "pbrt-v3 has no coat on metal"),
        (&["diffusetransmission", "difftrans"], "translucent", ""),
        (&["principled", "principledbsdf", "principledbsdfnode", "standardsurface", "pbr"], "disney", ""),
        (&["ashikhminshirley", "coated", "glossy2"], "substrate", ""),
        (&["blendbsdf", "blend", "mixture"], "mix", ""),
        (&["null", "interface", "empty"], "none", ""),
        (&["measured"], "", "\"measured\" is a type of an older pbrt and of pbrt-v4; pbrt-v3 has no equivalent"),
        (&["bluepaint", "clay", "felt", "primer", "skin"], "", "this is a type of an older pbrt; pbrt-v3 has no equivalent"),
        (&["emission", "emissive", "emitter", "light", "arealight", "diffuselight"], "", "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] makes the shapes that follow it emit light"),
        (&["twosided"], "", "all materials of pbrt-v3 have two sides: use the material inside \"twosided\""),
        (&["mask"], "", "the parameter \"texture alpha\" of Shape \"trianglemesh\" and \"plymesh\" cuts holes"),
        (&["bumpmap", "normalmap"], "", "the parameter \"texture bumpmap\" of a material gives its height; pbrt-v3 has no normal maps"),
    ],
    parameters: &[
        (&["matte", "plastic", "substrate", "uber", "translucent"], &["albedo", "diffuse", "color", "reflectance", "basecolor", "diffusecolor", "diffusereflectance"], "Kd", ""),
        (&["mirror"], &["albedo", "color", "reflectance", "basecolor", "specular", "specularreflectance", "kd", "ks"], "Kr", ""),
        (&["glass"], &["color", "albedo", "basecolor", "transmittance", "transmission", "speculartransmittance", "tint", "kd"], "Kt", ""),
        (&["uber"], &["transmittance", "transmission", "speculartransmittance"], "Kt", ""),
        (&["glass", "uber"], &["specularreflectance", "reflection", "reflect", "mirror"], "Kr", ""),
        (&["glass"], &["specular"], "Kr", ""),
        (&["metal"], &["color", "albedo", "reflectance", "basecolor", "specular", "specularreflectance", "kd", "ks", "kr"], "", "the index of refraction defines a metal: for a reflectance r, write \"rgb eta\" [1 1 1] and \"rgb k\" with 2 sqrt(r / (1 - r)) in each channel"),
        (GLOSSY, &["specular", "specularcolor", "specularreflectance", "gloss", "reflection"], "Ks", ""),
        (&["glass", "uber"], &["ior", "intior", "n", "refraction", "refractionindex", "refractiveindex", "indexofrefraction", "etat"], "eta", ""),
        (&["metal"], &["ior", "n"], "eta", "the eta of a metal is a color or a spectrum, and k its absorption"),
        (&["plastic", "translucent"], &["ior", "eta", "index", "intior", "n"], "", "its index is always 1.5; \"uber\" has \"float eta\""),
        (&["matte", "mirror"], &["ior", "eta", "index"], "", "this material has no index of refraction; \"glass\", \"uber\" and \"metal\" have"),
        (&["matte"], &["roughness", "uroughness", "vroughness"], "", "the roughness of matte is \"float sigma\": the spread of its facets' slopes in degrees, from 0 to 90"),
        (&["mirror"], &["roughness", "uroughness", "vroughness"], "", "a mirror is smooth; \"metal\" has roughness"),
        (&["glass", "substrate"], &["roughness"], "", "write it twice, as \"float uroughness\" and \"float vroughness\""),
        (&["plastic", "metal", "uber", "translucent"], &["shininess", "exponent", "glossiness", "glossyroughness"], "", "\"float roughness\" goes from 0, which is smooth, to 1"),
        (&["glass", "substrate"], &["shininess", "exponent", "glossiness"], "", "\"float uroughness\" and \"float vroughness\" go from 0, which is smooth, to 1"),
        (&["kdsubsurface"], &["meanfreepath"], "mfp", ""),
        (&["subsurface"], &["sigmaprimes"], "sigma_s", ""),
        (&["subsurface", "kdsubsurface"], &["index"], "eta", ""),
        (&["uber"], &["alpha", "transparency"], "opacity", "opacity is the fraction of the surface that is opaque"),
        (&["mix"], &["bsdf1", "material1", "first", "tex1"], "namedmaterial1", ""),
        (&["mix"], &["bsdf2", "material2", "second", "tex2"], "namedmaterial2", ""),
        (&["mix"], &["weight", "fraction", "factor", "blend", "fac"], "amount", "amount is the share of namedmaterial1"),
        (&[], &["emission", "emit", "emissive", "emissioncolor", "radiance", "l", "ke", "power", "strength", "intensity"], "", EMIT),
        (&[], &["bump", "displacement", "heightmap"], "bumpmap", ""),
        (&[], &["normalmap", "normal"], "", NORMAL_MAP),
        (&[], &["alpha", "opacity", "mask", "transparency"], "", "\"texture alpha\" of Shape \"trianglemesh\" and \"plymesh\" cuts holes; \"uber\" has \"opacity\""),
    ],
};

const DIRECTION: &str = "write \"to\" as a point: \"from\" plus the direction";
const POINT_LIGHTS: &[&str] = &["point", "spot", "goniometric", "projection"];

#[rustfmt::skip]
const LIGHT_SOURCE: Table = Table {
    directive: "LightSource",
    types: &[
        (&["envmap", "environment", "constant", "sky", "skydome", "hdri", "dome", "background", "sunsky"], "infinite", ""),
        (&["infinitesample"], "infinite", OLDER),
        (&["directional", "sun", "parallel"], "distant", ""),
        (&["omni", "pointlight", "bulb"], "point", ""),
        (&["spotlight"], "spot", ""),
        (&["projector", "slide"], "projection", ""),
        (&["ies", "photometric"], "goniometric", "\"goniometric\" takes a picture of the light in all directions as \"mapname\", no IES file"),
        (&["arealight", "rectangle", "quad", "mesh"], "", "AreaLightSource \"diffuse\" makes the shapes that follow it emit light"),
    ],
    parameters: &[
        (POINT_LIGHTS, &["l", "intensity", "color", "radiance", "emission", "emit"], "I", ""),
        (POINT_LIGHTS, &["power", "strength", "energy", "flux", "watts", "lumens"], "", "\"rgb I\" is the power divided by 4 pi, in each channel"),
        (&["distant", "infinite", "exinfinite"], &["i", "intensity", "color", "radiance", "irradiance", "emission", "emit"], "L", ""),
        (&["distant", "infinite", "exinfinite"], &["power", "strength", "energy", "illuminance"], "", "\"rgb L\" is the radiance, and \"rgb scale\" multiplies it"),
        (&["point", "spot", "distant"], &["position", "location", "origin", "pos", "eye", "center"], "from", ""),
        (&["spot", "distant"], &["target", "lookat", "look", "pointat"], "to", ""),
        (&["spot", "distant"], &["direction", "dir"], "", DIRECTION),
        (&["spot"], &["cutoffangle", "angle", "cutoff"], "coneangle", ""),
        (&["spot"], &["spotsize", "outerangle", "fov"], "coneangle", "coneangle is half of the angle of the cone, in degrees"),
        (&["spot"], &["conedelta", "penumbra"], "conedeltaangle", ""),
        (&["spot"], &["beamwidth", "innerangle", "spotblend", "falloff"], "", "\"float conedeltaangle\" is the angle inside the edge of the cone over which the light falls to 0"),
        (&["infinite", "exinfinite", "goniometric", "projection"], &["filename", "file", "map", "texture", "image", "imagefile", "bitmap"], "mapname", ""),
        (&["infinite", "exinfinite", "goniometric", "projection"], &["rotation", "toworld", "transform"], "", PLACE),
        (&["point", "spot"], &["radius", "size"], "", "this light is a point; for a light with a size, write a small sphere after AreaLightSource \"diffuse\""),
        (&["distant"], &["radius", "size", "angle"], "", "this light has a direction but no size; for a sun of any size, use LightSource \"infinite\" with a map"),
    ],
};

#[rustfmt::skip]
const AREA_LIGHT_SOURCE: Table = Table {
    directive: "AreaLightSource",
    types: &[
        (&["arealight", "emitter", "mesh", "point"], "diffuse", ""),
    ],
    parameters: &[
        (&[], &["i", "radiance", "emission", "emit", "color", "intensity"], "L", ""),
        (&[], &["power", "strength", "energy", "flux", "watts"], "", "\"rgb L\" is the power divided by pi and by the area of the shape; half of that with \"twosided\""),
        (&[], &["radius", "size", "width", "height"], "", "the Shape that follows sets the size of the light"),
        (&[], &["sides", "doublesided"], "twosided", ""),
    ],
};

#[rustfmt::skip]
const TEXTURE_TABLE: Table = Table {
    directive: "Texture",
    types: &[
        (&["bitmap", "image", "imagetexture", "picture"], "imagemap", ""),
        (&["checker", "checkers", "chess"], "checkerboard", ""),
        (&["noise", "perlin", "turbulence"], "fbm", ""),
        (&["polkadots"], "dots", ""),
        (&["multiply", "product"], "scale", ""),
        (&["blend", "lerp"], "mix", ""),
        (&["solid", "color", "value"], "constant", ""),
    ],
    parameters: &[
        (&["imagemap"], &["file", "image", "map", "mapname", "bitmap", "path", "texture"], "filename", ""),
        (&["imagemap"], &["encoding", "srgb", "colorspace"], "", "\"bool gamma\" says whether the values are on the sRGB curve"),
        (&["imagemap"], &["filter", "filtertype"], "", "\"bool trilinear\" \"true\" replaces the anisotropic filter"),
        (&["imagemap"], &["wrapmode", "extension", "swrap", "repeat"], "wrap", ""),
        (&["constant"], &["color", "rgb", "tex1"], "value", ""),
        (&["checkerboard", "mix"], &["color0", "a", "even", "color1value"], "tex1", ""),
        (&["checkerboard", "mix"], &["color1"], "tex1", ""),
        (&["checkerboard", "mix"], &["color1", "b", "odd", "color2"], "tex2", ""),
        (&["mix"], &["factor", "fac", "weight", "alpha"], "amount", "amount is the share of tex2"),
        (&["scale"], &["tex", "texture"], "tex1", ""),
        (&["scale"], &["scale", "factor"], "tex2", ""),
        (&[], &["uoffset", "offsetu"], "udelta", ""),
        (&[], &["voffset", "offsetv"], "vdelta", ""),
        (&[], &["scale", "uvscale", "tiling"], "", "\"float uscale\" and \"float vscale\" repeat it"),
        (&[], &["toworld", "touv", "transform"], "", PLACE),
    ],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds;

    #[test]
    fn words_are_written_as_they_are_looked_up() {
        let types = TABLES.iter().flat_map(|table| table.types.iter().copied());
        let parameters = TABLES.iter().flat_map(|table| table.parameters);
        let parameters = parameters.map(|(_, words, name, advice)| (*words, *name, *advice));
        for (words, name, advice) in types.chain(parameters) {
            assert!(!name.is_empty() || !advice.is_empty(), "{words:?} lead nowhere");
            for word in words {
                assert!(
                    word.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit()),
                    "{word}"
                );
            }
        }
    }

    /// Every name is in the schema, and so is every type.
    #[test]
    fn names_exist() {
        for Table { directive, types, parameters } in TABLES {
            let of = || kinds().filter(|kind| kind.directive == *directive);
            let is_type = |name: &str| of().any(|kind| kind.name == name);
            for (words, name, _) in *types {
                assert!(name.is_empty() || is_type(name), "{directive}: {words:?} become {name}");
            }
            for (kinds, words, name, _) in *parameters {
                assert!(kinds.iter().all(|kind| is_type(kind)), "{directive} {kinds:?}");
                let has = |kind: &crate::schema::Kind| kind.parameters().any(|it| it.name == *name);
                let mut named = of().filter(|kind| kinds.is_empty() || kinds.contains(&kind.name));
                assert!(name.is_empty() || named.any(has), "{directive}: {words:?} become {name}");
            }
        }
    }

    #[test]
    fn the_type_decides() {
        let name = |kind, word| parameter_synonyms("Material", kind, word).next().map(|it| it.name);
        assert_eq!(name("matte", "albedo"), Some("Kd"));
        assert_eq!(name("mirror", "base_color"), Some("Kr"));
        assert_eq!(name("matte", "Roughness"), Some(""));
        assert_eq!(name("matte", "teapot"), None);
        assert_eq!(type_synonym("Material", "rough_plastic").map(|it| it.name), Some("plastic"));
        assert!(words_for("Camera", "perspective", "lensradius").contains(&"aperture"));
    }
}
