//! Words of other programs (Mitsuba, Blender, POV-Ray, Arnold) and other versions of pbrt for the directives, types and
//! parameters of pbrt-v3, as plain data.

/// A word from elsewhere, and what to write instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Synonym {
    /// The word as written in this table: lower case, without `_` and `-`.
    pub word: &'static str,
    /// The pbrt-v3 name that replaces it; empty if no name does.
    pub name: &'static str,
    /// Other necessary changes, or the reason why no name replaces the word; empty for a plain rename.
    pub advice: &'static str,
}

/// A row for words that all become `name`: the directive, its types (empty: all), the words, the name, the advice.
type Row = (&'static str, &'static [&'static str], &'static [&'static str], &'static str, &'static str);

/// The synonym of a directive.
pub fn directive_synonym(word: &str) -> Option<Synonym> {
    lookup(DIRECTIVES, "", "", word)
}

/// The synonym of a type of `directive`.
pub fn type_synonym(directive: &str, word: &str) -> Option<Synonym> {
    lookup(TYPES, directive, "", word)
}

/// The synonyms of a parameter of a `directive` of type `kind`, in order of preference.
pub fn parameter_synonyms<'a>(
    directive: &'a str,
    kind: &'a str,
    word: &str,
) -> impl Iterator<Item = Synonym> + use<'a> {
    found(PARAMETERS, directive, kind, word)
}

fn lookup(rows: &'static [Row], directive: &str, kind: &str, word: &str) -> Option<Synonym> {
    found(rows, directive, kind, word).next()
}

fn found<'a>(
    rows: &'static [Row],
    directive: &'a str,
    kind: &'a str,
    word: &str,
) -> impl Iterator<Item = Synonym> + use<'a> {
    let plain: String = word.to_ascii_lowercase().replace(['_', '-'], "");
    rows.iter().filter_map(move |(of, kinds, words, name, advice)| {
        let is_of = *of == directive && (kinds.is_empty() || kinds.contains(&kind));
        let word = words.iter().find(|word| is_of && **word == plain)?;
        Some(Synonym { word, name, advice })
    })
}

#[rustfmt::skip]
const DIRECTIVES: &[Row] = &[
    ("", &[], &["surfaceintegrator"], "", "this is a directive of an older pbrt; in pbrt-v3 it is Integrator \"path\""),
    ("", &[], &["renderer", "volumeintegrator"], "", "this is a directive of an older pbrt; pbrt-v3 has only Integrator: delete this directive"),
    ("", &[], &["volume", "exterior", "interior"], "", "this is a directive of an older pbrt; pbrt-v3 has MakeNamedMedium and MediumInterface"),
    ("", &[], &["arealight"], "", "this is a directive of an older pbrt; in pbrt-v3 it is AreaLightSource"),
    ("", &[], &["searchpath"], "", "this is a directive of an older pbrt; in pbrt-v3 names of files are relative to the scene: delete it"),
    ("", &[], &["filter", "rfilter", "reconstructionfilter"], "", "write PixelFilter, as in PixelFilter \"gaussian\""),
    ("", &[], &["light"], "", "write LightSource \"point\", or AreaLightSource \"diffuse\" before a shape that glows"),
    ("", &[], &["pointlight", "omnilight", "lightpoint"], "", "write LightSource \"point\" \"rgb I\" [1 1 1]"),
    ("", &[], &["spotlight"], "", "write LightSource \"spot\" \"rgb I\" [1 1 1]"),
    ("", &[], &["distantlight", "directionallight", "sunlight", "sun", "lightdistant"], "", "write LightSource \"distant\" \"rgb L\" [1 1 1]"),
    ("", &[], &["environmentlight", "envmap", "environmentmap", "skylight", "sky", "skydome", "domelight", "background", "infinitelight"], "", "write LightSource \"infinite\", with \"string mapname\" for a picture"),
    ("", &[], &["emitter", "emission"], "", "write AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] before the shapes that glow"),
    ("", &[], &["sphere"], "", "write Shape \"sphere\" \"float radius\" 1; to move it, write Translate before it"),
    ("", &[], &["disk", "disc", "circle"], "", "write Shape \"disk\" \"float radius\" 1"),
    ("", &[], &["cylinder", "tube"], "", "write Shape \"cylinder\" with \"radius\", \"zmin\" and \"zmax\""),
    ("", &[], &["cone"], "", "write Shape \"cone\" with \"radius\" and \"height\""),
    ("", &[], &["curve", "hair", "bezier"], "", "write Shape \"curve\" with \"point P\""),
    ("", &[], &["mesh", "trianglemesh", "triangles", "triangle", "polygonmesh", "polygon", "polymesh", "mesh2"], "", "write Shape \"trianglemesh\" with \"point P\" and \"integer indices\""),
    ("", &[], &["plymesh", "ply"], "", "write Shape \"plymesh\" \"string filename\" \"mesh.ply\""),
    ("", &[], &["obj", "objmesh"], "", "pbrt-v3 reads no OBJ: convert the mesh to PLY for Shape \"plymesh\""),
    ("", &[], &["box", "cube", "plane", "quad", "rectangle", "square"], "", "write Shape \"trianglemesh\": pbrt-v3 has no shape for it"),
    ("", &[], &["bsdf", "shader", "surface"], "", "write Material, as in Material \"matte\" \"rgb Kd\" [.5 .5 .5]"),
    ("", &[], &["namedbsdf", "makenamedbsdf"], "", "MakeNamedMaterial defines a material, NamedMaterial uses it"),
    ("", &[], &["pigment", "color", "colour", "finish"], "", "write a color as a parameter: Material \"matte\" \"rgb Kd\" [.5 .5 .5]"),
    ("", &[], &["medium", "media"], "", "write MakeNamedMedium to define a medium, MediumInterface to use it"),
    ("", &[], &["sensor"], "", "write Camera and Film"),
    ("", &[], &["output", "resolution", "imagesize"], "", "write Film \"image\" \"integer xresolution\" 640 \"integer yresolution\" 480 \"string filename\" \"a.exr\""),
    ("", &[], &["samples", "spp", "pixelsamples"], "", "write Sampler \"halton\" \"integer pixelsamples\" 64"),
    ("", &[], &["eye", "lookto", "origin"], "", "write LookAt with nine numbers: the eye, the point it looks at, the up direction"),
    ("", &[], &["fov"], "", "write Camera \"perspective\" \"float fov\" 45"),
    ("", &[], &["matrix", "toworld"], "", "write Transform with 16 numbers in brackets"),
    ("", &[], &["rotatex", "rotatey", "rotatez"], "", "write Rotate with an angle in degrees and an axis, as in Rotate 90 1 0 0"),
    ("", &[], &["pushtransform", "pushmatrix"], "", "write TransformBegin"),
    ("", &[], &["poptransform", "popmatrix"], "", "write TransformEnd"),
    ("", &[], &["pushattributes", "pushattribute"], "", "write AttributeBegin"),
    ("", &[], &["popattributes", "popattribute"], "", "write AttributeEnd"),
    ("", &[], &["instance"], "", "ObjectBegin and ObjectEnd define an object, ObjectInstance places a copy"),
    ("", &[], &["scene", "world"], "", "WorldBegin and WorldEnd enclose the lights and shapes"),
];

#[rustfmt::skip]
const TYPES: &[Row] = &[
    ("Accelerator", &[], &["grid"], "bvh", "\"grid\" is a type of an older pbrt"),
    ("Accelerator", &[], &["octree", "embree", "sah"], "bvh", ""),
    ("Camera", &[], &["thinlens", "pinhole", "persp", "perspectivepinhole"], "perspective", ""),
    ("Camera", &[], &["ortho", "parallel"], "orthographic", ""),
    ("Camera", &[], &["spherical", "panorama", "panoramic", "equirectangular", "latlong"], "environment", ""),
    ("Film", &[], &["rgb", "hdrfilm", "ldrfilm", "exr", "png", "file"], "image", ""),
    ("Integrator", &[], &["pathtracer", "pathtracing", "simplepath", "gi"], "path", ""),
    ("Integrator", &[], &["direct"], "directlighting", ""),
    ("Integrator", &[], &["ao", "ambient", "occlusion"], "ambientocclusion", ""),
    ("Integrator", &[], &["volpathmis", "volpathsimple", "simplevolpath", "volumetricpath"], "volpath", ""),
    ("Integrator", &[], &["bidirectional", "ptracer"], "bdpt", ""),
    ("Integrator", &[], &["pssmlt", "metropolis"], "mlt", ""),
    ("Integrator", &[], &["photonmap", "photonmapper", "ppm"], "sppm", ""),
    ("LightSource", &[], &["envmap", "environment", "constant", "sky", "skydome", "hdri", "dome", "background", "sunsky"], "infinite", ""),
    ("LightSource", &[], &["directional", "sun", "parallel"], "distant", ""),
    ("LightSource", &[], &["omni", "pointlight", "bulb"], "point", ""),
    ("LightSource", &[], &["spotlight"], "spot", ""),
    ("LightSource", &[], &["projector", "slide"], "projection", ""),
    ("LightSource", &[], &["ies", "photometric"], "goniometric", "\"goniometric\" takes a picture of the light in all directions as \"mapname\", no IES file"),
    ("LightSource", &[], &["arealight", "rectangle", "quad", "mesh"], "", "AreaLightSource \"diffuse\" makes the shapes that follow it emit light"),
    ("AreaLightSource", &[], &["arealight", "emitter", "mesh", "point"], "diffuse", ""),
    ("Material", &[], &["diffuse", "lambertian", "lambert", "roughdiffuse", "orennayar"], "matte", ""),
    ("Material", &[], &["dielectric", "thindielectric", "roughdielectric", "refractive", "transparent"], "glass", ""),
    ("Material", &[], &["conductor", "roughconductor", "metallic", "shinymetal", "brushedmetal", "chrome"], "metal", ""),
    ("Material", &[], &["roughplastic", "coateddiffuse", "phong", "blinn", "glossy", "glossydiffuse"], "plastic", ""),
    ("Material", &[], &["coatedconductor"], "metal", "pbrt-v3 has no coat on metal"),
    ("Material", &[], &["diffusetransmission", "difftrans"], "translucent", ""),
    ("Material", &[], &["principled", "principledbsdf", "principledbsdfnode", "standardsurface", "pbr"], "disney", ""),
    ("Material", &[], &["ashikhminshirley", "coated", "glossy2"], "substrate", ""),
    ("Material", &[], &["blendbsdf", "blend", "mixture"], "mix", ""),
    ("Material", &[], &["null", "interface", "empty"], "none", ""),
    ("Material", &[], &["measured"], "", "\"measured\" is a type of an older pbrt and of pbrt-v4; pbrt-v3 has no equivalent"),
    ("Material", &[], &["bluepaint", "clay", "felt", "primer", "skin"], "", "this is a type of an older pbrt; pbrt-v3 has no equivalent"),
    ("Material", &[], &["emission", "emissive", "emitter", "light", "arealight", "diffuselight"], "", "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] makes the shapes that follow it emit light"),
    ("Material", &[], &["twosided"], "", "all materials of pbrt-v3 have two sides: use the material inside \"twosided\""),
    ("Material", &[], &["mask"], "", "the parameter \"texture alpha\" of Shape \"trianglemesh\" and \"plymesh\" cuts holes"),
    ("Material", &[], &["bumpmap", "normalmap"], "", "the parameter \"texture bumpmap\" of a material gives its height; pbrt-v3 has no normal maps"),
    ("PixelFilter", &[], &["tent", "bartlett"], "triangle", ""),
    ("PixelFilter", &[], &["lanczos", "windowedsinc"], "sinc", ""),
    ("PixelFilter", &[], &["gauss"], "gaussian", ""),
    ("PixelFilter", &[], &["catmullrom"], "mitchell", "Catmull-Rom is \"mitchell\" with \"float B\" 0 and \"float C\" 0.5"),
    ("PixelFilter", &[], &["blackmanharris"], "gaussian", ""),
    ("Sampler", &[], &["independent", "uniform"], "random", ""),
    ("Sampler", &[], &["ldsampler", "hammersley", "bestcandidate", "adaptive"], "halton", ""),
    ("Sampler", &[], &["zsobol", "paddedsobol", "pmj02bn", "pmj", "bluenoise", "orthogonal"], "sobol", ""),
    ("Sampler", &[], &["multijitter", "jittered", "grid"], "stratified", ""),
    ("Shape", &[], &["mesh", "triangles", "triangle", "polymesh", "polygonmesh", "indexedfaceset"], "trianglemesh", ""),
    ("Shape", &[], &["ply", "meshfile"], "plymesh", ""),
    ("Shape", &[], &["obj", "wavefront", "serialized", "stl", "gltf", "fbx"], "plymesh", "\"plymesh\" reads only PLY: convert the mesh to PLY"),
    ("Shape", &[], &["rectangle", "quad", "square", "plane", "bilinearmesh"], "", "pbrt-v3 has no such shape: write it as Shape \"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"integer indices\" [0 1 2 0 2 3]"),
    ("Shape", &[], &["cube", "box"], "", "pbrt-v3 has no such shape: write it as a \"trianglemesh\" of 8 points and 12 triangles"),
    ("Shape", &[], &["torus"], "", "pbrt-v3 has no such shape: convert it to PLY for Shape \"plymesh\""),
    ("Shape", &[], &["ball", "globe", "uvsphere", "icosphere"], "sphere", ""),
    ("Shape", &[], &["circle", "disc"], "disk", ""),
    ("Shape", &[], &["tube", "rod"], "cylinder", ""),
    ("Shape", &[], &["hair", "curves", "bsplinecurve", "linearcurve", "bezier", "strand"], "curve", ""),
    ("Shape", &[], &["subdiv", "subdivision", "catmullclark"], "loopsubdiv", "\"loopsubdiv\" takes triangles"),
    ("Shape", &[], &["terrain", "height", "displacementmap"], "heightfield", ""),
    ("Shape", &[], &["instance", "shapegroup"], "", "ObjectBegin and ObjectEnd define an object, ObjectInstance places a copy"),
    ("Texture", &[], &["bitmap", "image", "imagetexture", "picture"], "imagemap", ""),
    ("Texture", &[], &["checker", "checkers", "chess"], "checkerboard", ""),
    ("Texture", &[], &["noise", "perlin", "turbulence"], "fbm", ""),
    ("Texture", &[], &["polkadots"], "dots", ""),
    ("Texture", &[], &["multiply", "product"], "scale", ""),
    ("Texture", &[], &["blend", "lerp"], "mix", ""),
    ("Texture", &[], &["solid", "color", "value"], "constant", ""),
];

const LOOKAT: &str =
    "write LookAt before Camera, with the eye, the point to look at and the up vector, three numbers each";
const RESOLUTION: &str =
    "Film \"image\" sets the size, with \"integer xresolution\" and \"integer yresolution\"";
const SAMPLES: &str = "the Sampler sets the samples per pixel, with \"integer pixelsamples\"";
const PLACE: &str = "to place it, write Translate, Rotate, Scale or Transform before the directive";
const EMIT: &str =
    "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1], written before the Shape, makes the Shape emit light";
const APERTURE: &str = "lensradius is half the diameter of the aperture";
const DIRECTION: &str = "write \"to\" as a point: \"from\" plus the direction";
const SURFACE: &str =
    "to set the surface, write Material before the Shape, as in Material \"matte\" \"rgb Kd\" [.5 .5 .5]";
const NORMAL_MAP: &str = "pbrt-v3 has no normal maps; \"texture bumpmap\" is a height";
const POINT_LIGHTS: &[&str] = &["point", "spot", "goniometric", "projection"];
const GLOSSY: &[&str] = &["plastic", "substrate", "uber", "translucent"];

#[rustfmt::skip]
const PARAMETERS: &[Row] = &[
    // Camera
    ("Camera", &["perspective", "orthographic", "environment"], &["aperture", "aperturediameter", "aperturesize", "aperturewidth", "lensdiameter"], "lensradius", APERTURE),
    ("Camera", &[], &["aperture", "apertureradius", "radius", "lens", "defocusradius"], "lensradius", ""),
    ("Camera", &[], &["fstop", "fnumber", "aperturefstop"], "", "lensradius is the focal length divided by twice the f-stop, in the units of the scene"),
    ("Camera", &[], &["focus", "focusdistance", "focaldist", "focallengthdistance", "focalplane", "distance"], "focaldistance", ""),
    ("Camera", &[], &["focallength", "lenslength"], "", "\"float fov\" is the angle of the shorter side in degrees: 2 atan(s / 2f), with the shorter side s of the film and the focal length f"),
    ("Camera", &[], &["angle", "fieldofview", "viewangle", "yfov", "xfov"], "fov", "fov is the angle of the shorter side, in degrees"),
    ("Camera", &[], &["fovaxis"], "", "fov is always the angle of the shorter side: leave fov_axis out"),
    ("Camera", &[], &["eye", "origin", "position", "from", "location", "pos", "up", "lookat", "look", "target", "to", "direction", "sky"], "", LOOKAT),
    ("Camera", &[], &["toworld", "transform", "matrix", "rotation", "translate"], "", PLACE),
    ("Camera", &[], &["resolution", "width", "height", "xresolution", "yresolution", "size"], "", RESOLUTION),
    ("Camera", &[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
    ("Camera", &[], &["near", "nearclip", "nearplane", "far", "farclip", "farplane", "clipstart", "clipend", "hither", "yon"], "", "pbrt-v3 has no clip planes: leave it out"),
    ("Camera", &[], &["aspect", "aspectratio"], "frameaspectratio", ""),
    ("Camera", &[], &["orthowidth", "orthographicscale", "orthoscale", "scale"], "", "\"float screenwindow\" [xmin xmax ymin ymax] is the part that is seen"),
    // Film
    ("Film", &[], &["width", "xres", "imagewidth", "resolutionx"], "xresolution", ""),
    ("Film", &[], &["height", "yres", "imageheight", "resolutiony"], "yresolution", ""),
    ("Film", &[], &["resolution", "size", "res"], "", "write \"integer xresolution\" and \"integer yresolution\""),
    ("Film", &[], &["output", "file", "outputfile", "image", "name"], "filename", ""),
    ("Film", &[], &["crop", "croprect", "cropbounds", "region"], "cropwindow", "cropwindow is xmin xmax ymin ymax, from 0 to 1"),
    ("Film", &[], &["exposure", "iso", "gain", "sensor", "imagingratio"], "", "\"float scale\" multiplies the picture: write 2 to the power of the exposure in stops"),
    ("Film", &[], &["gamma", "tonemap", "colorspace"], "", "exr and pfm pictures are linear, png and tga pictures sRGB: leave it out"),
    ("Film", &[], &["filter", "rfilter"], "", "PixelFilter sets the filter"),
    ("Film", &[], &["samples", "spp", "pixelsamples"], "", SAMPLES),
    ("Film", &[], &["maxluminance", "clamp", "maxcomponentvalue"], "maxsampleluminance", "maxsampleluminance is the largest luminance of a sample"),
    // PixelFilter
    ("PixelFilter", &[], &["radius", "size", "support"], "", "\"float xwidth\" and \"float ywidth\" are the radius along each axis, in pixels"),
    ("PixelFilter", &[], &["width"], "", "\"float xwidth\" and \"float ywidth\" are half the width, in pixels"),
    ("PixelFilter", &[], &["xradius"], "xwidth", ""),
    ("PixelFilter", &[], &["yradius"], "ywidth", ""),
    ("PixelFilter", &["gaussian"], &["stddev", "sigma"], "", "\"float alpha\" is 1 / (2 sigma^2)"),
    // Sampler
    ("Sampler", &["stratified"], &["samples", "spp", "pixelsamples", "samplecount", "samplesperpixel", "count", "nsamples"], "", "\"integer xsamples\" times \"integer ysamples\" is the number of samples of each pixel"),
    ("Sampler", &[], &["samples", "spp", "samplecount", "samplesperpixel", "count", "nsamples", "aasamples"], "pixelsamples", ""),
    ("Sampler", &[], &["seed"], "", "the option --seed of lookat sets the seed"),
    // Integrator
    ("Integrator", &[], &["depth", "bounces", "maxbounces", "raydepth", "recursion", "maxraydepth"], "maxdepth", ""),
    ("Integrator", &[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
    ("Integrator", &[], &["rrdepth", "russianroulettedepth"], "", "roulette starts at the fifth surface; \"float rrthreshold\" 0 turns it off"),
    ("Integrator", &[], &["lightsampler"], "lightsamplestrategy", "lightsamplestrategy is \"uniform\", \"power\" or \"spatial\""),
    // Shape
    ("Shape", &["sphere", "disk", "cylinder", "cone", "paraboloid"], &["r", "rad", "size"], "radius", ""),
    ("Shape", &["sphere", "disk", "cylinder", "cone", "paraboloid"], &["diameter"], "radius", "radius is half the diameter"),
    ("Shape", &["sphere", "disk", "cylinder", "cone", "paraboloid", "hyperboloid"], &["center", "centre", "position", "origin", "location", "pos"], "", "the shape is at the origin: to move it, write Translate before the Shape"),
    ("Shape", &["cylinder", "paraboloid"], &["height", "length", "p0", "p1"], "", "\"float zmin\" and \"float zmax\" are its ends along z"),
    ("Shape", &["curve"], &["radius", "thickness", "widths", "r"], "width", "width is twice the radius"),
    ("Shape", &["trianglemesh", "plymesh", "loopsubdiv", "nurbs", "heightfield", "hyperboloid"], &["radius", "size", "scale"], "", "to change its size, write Scale before the Shape"),
    ("Shape", &["trianglemesh", "loopsubdiv", "curve", "nurbs"], &["vertices", "points", "positions", "vertex", "controlpoints", "pos"], "P", ""),
    ("Shape", &["trianglemesh", "loopsubdiv"], &["faces", "triangles", "index", "tris", "vertexindices", "faceindex"], "indices", ""),
    ("Shape", &["trianglemesh", "curve"], &["normals", "vertexnormals", "normal"], "N", ""),
    ("Shape", &["trianglemesh"], &["tangents", "tangent"], "S", ""),
    ("Shape", &["trianglemesh"], &["texcoords", "uvs", "texturecoordinates", "texcoord"], "uv", ""),
    ("Shape", &["trianglemesh"], &["file", "filename"], "", "Shape \"plymesh\" reads a mesh from a file"),
    ("Shape", &["plymesh"], &["file", "mesh", "path", "name"], "filename", ""),
    ("Shape", &["heightfield"], &["heights", "z"], "Pz", ""),
    ("Shape", &[], &["toworld", "transform", "matrix", "rotation", "translate", "flipnormals"], "", "to place the shape, write Translate, Rotate, Scale or Transform before the Shape; ReverseOrientation flips its normals"),
    ("Shape", &[], &["emission", "emit", "radiance", "emitter", "l", "intensity", "power", "strength", "light"], "", EMIT),
    ("Shape", &[], &["material", "bsdf", "shader", "color", "albedo", "diffuse", "basecolor", "roughness", "kd"], "", SURFACE),
    // Material
    ("Material", &["matte", "plastic", "substrate", "uber", "translucent"], &["albedo", "diffuse", "color", "colour", "reflectance", "basecolor", "diffusecolor", "diffusereflectance"], "Kd", ""),
    ("Material", &["mirror"], &["albedo", "color", "colour", "reflectance", "basecolor", "specular", "specularreflectance", "kd", "ks"], "Kr", ""),
    ("Material", &["glass"], &["color", "colour", "albedo", "basecolor", "transmittance", "transmission", "speculartransmittance", "tint", "kd"], "Kt", ""),
    ("Material", &["uber"], &["transmittance", "transmission", "speculartransmittance"], "Kt", ""),
    ("Material", &["glass", "uber"], &["specularreflectance", "reflection", "reflect", "mirror"], "Kr", ""),
    ("Material", &["glass"], &["specular"], "Kr", ""),
    ("Material", &["metal"], &["color", "colour", "albedo", "reflectance", "basecolor", "specular", "specularreflectance", "kd", "ks", "kr"], "", "the index of refraction defines a metal: for a reflectance r, write \"rgb eta\" [1 1 1] and \"rgb k\" with 2 sqrt(r / (1 - r)) in each channel"),
    ("Material", GLOSSY, &["specular", "specularcolor", "specularreflectance", "gloss", "reflection"], "Ks", ""),
    ("Material", &["glass", "uber"], &["ior", "intior", "n", "refraction", "refractionindex", "refractiveindex", "indexofrefraction", "etat"], "eta", ""),
    ("Material", &["metal"], &["ior", "n"], "eta", "the eta of a metal is a color or a spectrum, and k its absorption"),
    ("Material", &["plastic", "translucent"], &["ior", "eta", "index", "intior", "n"], "", "its index is always 1.5; \"uber\" has \"float eta\""),
    ("Material", &["matte", "mirror"], &["ior", "eta", "index"], "", "this material has no index of refraction; \"glass\", \"uber\" and \"metal\" have"),
    ("Material", &["matte"], &["roughness", "uroughness", "vroughness"], "", "the roughness of matte is \"float sigma\": the spread of its facets' slopes in degrees, from 0 to 90"),
    ("Material", &["mirror"], &["roughness", "uroughness", "vroughness"], "", "a mirror is smooth; \"metal\" has roughness"),
    ("Material", &["glass", "substrate"], &["roughness"], "", "write it twice, as \"float uroughness\" and \"float vroughness\""),
    ("Material", &["plastic", "metal", "uber", "translucent"], &["shininess", "exponent", "glossiness", "glossyroughness"], "", "\"float roughness\" goes from 0, which is smooth, to 1"),
    ("Material", &["glass", "substrate"], &["shininess", "exponent", "glossiness"], "", "\"float uroughness\" and \"float vroughness\" go from 0, which is smooth, to 1"),
    ("Material", &["uber"], &["alpha", "transparency"], "opacity", "opacity is the fraction of the surface that is opaque"),
    ("Material", &["mix"], &["bsdf1", "material1", "first", "tex1"], "namedmaterial1", ""),
    ("Material", &["mix"], &["bsdf2", "material2", "second", "tex2"], "namedmaterial2", ""),
    ("Material", &["mix"], &["weight", "fraction", "factor", "blend", "fac"], "amount", "amount is the share of namedmaterial1"),
    ("Material", &[], &["emission", "emit", "emissive", "emissioncolor", "radiance", "l", "ke", "power", "strength", "intensity"], "", EMIT),
    ("Material", &[], &["bump", "displacement", "heightmap"], "bumpmap", ""),
    ("Material", &[], &["normalmap", "normal"], "", NORMAL_MAP),
    ("Material", &[], &["alpha", "opacity", "mask", "transparency"], "", "\"texture alpha\" of Shape \"trianglemesh\" and \"plymesh\" cuts holes; \"uber\" has \"opacity\""),
    // LightSource
    ("LightSource", POINT_LIGHTS, &["l", "intensity", "color", "colour", "radiance", "emission", "emit"], "I", ""),
    ("LightSource", POINT_LIGHTS, &["power", "strength", "energy", "flux", "watts", "lumens"], "", "\"rgb I\" is the power divided by 4 pi, in each channel"),
    ("LightSource", &["distant", "infinite", "exinfinite"], &["i", "intensity", "color", "colour", "radiance", "irradiance", "emission", "emit"], "L", ""),
    ("LightSource", &["distant", "infinite", "exinfinite"], &["power", "strength", "energy", "illuminance"], "", "\"rgb L\" is the radiance, and \"rgb scale\" multiplies it"),
    ("LightSource", &["point", "spot", "distant"], &["position", "location", "origin", "pos", "eye", "center"], "from", ""),
    ("LightSource", &["spot", "distant"], &["target", "lookat", "look", "pointat"], "to", ""),
    ("LightSource", &["spot", "distant"], &["direction", "dir"], "", DIRECTION),
    ("LightSource", &["spot"], &["cutoffangle", "angle", "cutoff"], "coneangle", ""),
    ("LightSource", &["spot"], &["spotsize", "outerangle", "fov"], "coneangle", "coneangle is half of the angle of the cone, in degrees"),
    ("LightSource", &["spot"], &["conedelta", "penumbra"], "conedeltaangle", ""),
    ("LightSource", &["spot"], &["beamwidth", "innerangle", "spotblend", "falloff"], "", "\"float conedeltaangle\" is the angle inside the edge of the cone over which the light falls to 0"),
    ("LightSource", &["infinite", "exinfinite", "goniometric", "projection"], &["filename", "file", "map", "texture", "image", "imagefile", "bitmap"], "mapname", ""),
    ("LightSource", &["infinite", "exinfinite", "goniometric", "projection"], &["rotation", "toworld", "transform"], "", PLACE),
    ("LightSource", &["point", "spot"], &["radius", "size"], "", "this light is a point; for a light with a size, write a small sphere after AreaLightSource \"diffuse\""),
    ("LightSource", &["distant"], &["radius", "size", "angle"], "", "this light has a direction but no size; for a sun of any size, use LightSource \"infinite\" with a map"),
    // AreaLightSource
    ("AreaLightSource", &[], &["i", "radiance", "emission", "emit", "color", "colour", "intensity"], "L", ""),
    ("AreaLightSource", &[], &["power", "strength", "energy", "flux", "watts"], "", "\"rgb L\" is the power divided by pi and by the area of the shape; half of that with \"twosided\""),
    ("AreaLightSource", &[], &["radius", "size", "width", "height"], "", "the Shape that follows sets the size of the light"),
    ("AreaLightSource", &[], &["sides", "doublesided"], "twosided", ""),
    // Texture
    ("Texture", &["imagemap"], &["file", "image", "map", "mapname", "bitmap", "path", "texture"], "filename", ""),
    ("Texture", &["imagemap"], &["encoding", "srgb", "colorspace"], "", "\"bool gamma\" says whether the values are on the sRGB curve"),
    ("Texture", &["imagemap"], &["filter", "filtertype"], "", "\"bool trilinear\" \"true\" replaces the anisotropic filter"),
    ("Texture", &["imagemap"], &["wrapmode", "extension", "swrap", "repeat"], "wrap", ""),
    ("Texture", &["constant"], &["color", "colour", "rgb", "tex1"], "value", ""),
    ("Texture", &["checkerboard", "mix"], &["color0", "a", "even", "color1value"], "tex1", ""),
    ("Texture", &["checkerboard", "mix"], &["color1", "b", "odd", "color2"], "tex2", ""),
    ("Texture", &["mix"], &["factor", "fac", "weight", "alpha"], "amount", "amount is the share of tex2"),
    ("Texture", &["scale"], &["tex", "texture"], "tex1", ""),
    ("Texture", &["scale"], &["scale", "factor"], "tex2", ""),
    ("Texture", &[], &["uoffset", "offsetu"], "udelta", ""),
    ("Texture", &[], &["voffset", "offsetv"], "vdelta", ""),
    ("Texture", &[], &["scale", "uvscale", "tiling"], "", "\"float uscale\" and \"float vscale\" repeat it"),
    ("Texture", &[], &["toworld", "touv", "transform"], "", PLACE),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Directive;

    #[test]
    fn words_are_written_as_they_are_looked_up() {
        for (directive, _, words, name, advice) in [DIRECTIVES, TYPES, PARAMETERS].concat() {
            assert!(directive.is_empty() || Directive::KEYWORDS.contains(&directive), "{directive}");
            assert!(!name.is_empty() || !advice.is_empty(), "{words:?} lead nowhere");
            for word in words {
                assert!(
                    word.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit()),
                    "{word}"
                );
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
        assert!(directive_synonym("PointLight").is_some());
    }
}
