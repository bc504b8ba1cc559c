//! Words for `Material`.

use super::{EMIT, OLDER, Table};

const NORMAL_MAP: &str = "pbrt-v3 has no normal maps; \"texture bumpmap\" is a height";
const GLOSSY: &[&str] = &["plastic", "substrate", "uber", "translucent"];

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
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
        (&["mix"], &["weight", "fraction", "factor", "blend", "fac"], "amount", "amount is the fraction of namedmaterial1"),
        (&[], &["emission", "emit", "emissive", "emissioncolor", "radiance", "l", "ke", "power", "strength", "intensity"], "", EMIT),
        (&[], &["bump", "displacement", "heightmap"], "bumpmap", ""),
        (&[], &["normalmap", "normal"], "", NORMAL_MAP),
        (&[], &["alpha", "opacity", "mask", "transparency"], "", "\"texture alpha\" of Shape \"trianglemesh\" and \"plymesh\" cuts holes; \"uber\" has \"opacity\""),
    ],
};
