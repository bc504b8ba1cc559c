//! Types of other versions of pbrt.

/// True for types introduced by pbrt-v4.
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
