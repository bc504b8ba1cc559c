//! The types of `Material`, as the schema lists them.

use super::{glass, keys, matte, metal, mirror, mix, plastic, stand_in, substrate, translucent, uber};
use crate::schema::{Keys, Kind};

const BUMP: Keys = &[&keys::BUMP];

const fn of(name: &'static str, meaning: &'static str, keys: &'static [Keys]) -> Kind {
    Kind::new("Material", name, meaning, keys)
}

pub(crate) const KINDS: &[Kind] = &[
    of("matte", "a diffuse surface", &[matte::KEYS, BUMP]).by_default(),
    of("plastic", "a diffuse base under a glossy coating", &[plastic::KEYS, BUMP]),
    of("translucent", "a thin surface that reflects and transmits", &[translucent::KEYS, BUMP]),
    of("glass", "smooth or rough glass", &[glass::KEYS, BUMP]),
    of("mirror", "a perfect mirror", &[mirror::KEYS, BUMP]),
    of("hair", "hair and fur", &[stand_in::hair::KEYS]).instead("matte of the same color"),
    of("disney", "the material of Disney's animation studio", &[stand_in::disney::KEYS, BUMP])
        .instead("uber, glass, translucent or their mix, of the same color and roughness"),
    of("mix", "a blend of two named materials", &[mix::KEYS]),
    of("metal", "a rough metal", &[metal::KEYS, BUMP]),
    of(
        "substrate",
        "a diffuse base under a coating that reflects more at grazing angles",
        &[substrate::KEYS, BUMP],
    ),
    of("uber", "diffuse, glossy and specular reflection, refraction and opacity in one", &[uber::KEYS, BUMP]),
    of(
        "subsurface",
        "subsurface scattering from coefficients",
        &[stand_in::subsurface::COEFFICIENTS, stand_in::subsurface::SURFACE, BUMP],
    )
    .instead("uber with the diffuse color of the coefficients"),
    of(
        "kdsubsurface",
        "subsurface scattering from the diffuse color",
        &[stand_in::subsurface::COLOR, stand_in::subsurface::SURFACE, BUMP],
    )
    .instead("uber with the same Kd and index"),
    of("fourier", "measured or simulated scattering from a file", &[stand_in::fourier::KEYS, BUMP])
        .instead("matte or translucent of the same mean color"),
    of("none", "no surface: camera rays and paths pass, shadow rays only with volpath, bdpt and mlt", &[]),
    of("", "the same as none", &[]),
];
