//! Types of other versions of pbrt, and of other programs.

/// Whether pbrt-v4 introduced the type.
pub(super) fn is_of_v4(keyword: &str, kind: &str) -> bool {
    let kinds: &[&str] = match keyword {
        "Shape" => &["bilinearmesh"],
        "Material" | "MakeNamedMaterial" => &[
            "coateddiffuse",
            "coatedconductor",
            "conductor",
            "dielectric",
            "diffuse",
            "diffusetransmission",
            "thindielectric",
            "interface",
        ],
        "Film" => &["rgb", "gbuffer", "spectral"],
        "Camera" => &["spherical"],
        "Sampler" => &["zsobol", "paddedsobol", "independent", "pmj02bn"],
        "Integrator" => &["simplepath", "simplevolpath", "lightpath", "randomwalk"],
        "Texture" => &["directionmix"],
        _ => &[],
    };
    kinds.contains(&kind)
}

/// Types of older versions, with what is nearest to them in pbrt-v3, if anything is.
const OLDER: &[(&str, &str, Option<&str>)] = &[
    ("Sampler", "bestcandidate", Some("halton")),
    ("Sampler", "adaptive", Some("halton")),
    ("Accelerator", "grid", Some("bvh")),
    ("Material", "shinymetal", Some("metal")),
    ("Material", "brushedmetal", Some("metal")),
    ("Material", "measured", None),
    ("Material", "bluepaint", None),
    ("Material", "clay", None),
    ("Material", "felt", None),
    ("Material", "primer", None),
    ("Material", "skin", None),
];

/// Whether a type is of an older version, and what is nearest to it.
pub(super) fn of_older(keyword: &str, kind: &str) -> Option<Option<&'static str>> {
    let keyword = if keyword == "MakeNamedMaterial" { "Material" } else { keyword };
    OLDER.iter().find(|(of, name, _)| (*of, *name) == (keyword, kind)).map(|(.., nearest)| *nearest)
}

/// Types as other programs call them, and as pbrt-v3 does.
const OTHERS: &[(&str, &str)] = &[
    ("envmap", "infinite"),
    ("environment", "infinite"),
    ("constant", "infinite"),
    ("directional", "distant"),
    ("sun", "distant"),
    ("lambertian", "matte"),
    ("lambert", "matte"),
    ("pathtracer", "path"),
    ("direct", "directlighting"),
];

/// The one of some types that another program calls so.
pub(super) fn of_other<'k>(kind: &str, known: &[&'k str]) -> Option<&'k str> {
    known.iter().copied().find(|known| OTHERS.contains(&(kind, known)))
}

/// Whether a parameter is known by a name elsewhere: at other lights, in other versions and other programs.
pub(super) fn is_other_name(given: &str, known: &str) -> bool {
    const NAMES: &[(&str, &str)] = &[
        ("L", "I"),
        ("I", "L"),
        ("radiance", "L"),
        ("intensity", "I"),
        ("filename", "mapname"),
        ("mapname", "filename"),
        ("ior", "eta"),
        ("conedelta", "conedeltaangle"),
        ("reflectance", "Kd"),
        ("diffuse", "Kd"),
        ("specular", "Ks"),
        ("index", "indices"),
        ("vertices", "P"),
        ("normals", "N"),
        ("xradius", "xwidth"),
        ("yradius", "ywidth"),
    ];
    NAMES.contains(&(given, known))
}
