//! `MakeNamedMedium`: participating media, which lookat does not render. Only their names count.

use lookat_syntax::ParamType;

use crate::schema::{Color, DefaultValue, Effect, Floats, Key, Keys, Kind, Name, Unit};

const fn unread<T: DefaultValue>(key: Key<T>) -> Key<T> {
    key.effect(Effect::NotRendered)
}

const ABSORPTION: Key<Color> =
    unread(Key::color("sigma_a", 1.0, "the absorption coefficient, per unit of length"))
        .default_words("0.0011 0.0024 0.014");
const SCATTERING: Key<Color> =
    unread(Key::color("sigma_s", 1.0, "the scattering coefficient, per unit of length"))
        .default_words("2.55 3.21 3.77");
const PRESET: Key<Name> =
    unread(Key::string("preset", "a measured medium, such as \"Wholemilk\", instead of coefficients"));
const G: Key<f64> =
    unread(Key::float("g", 0.0, "the asymmetry of scattering, from -1 (back) to 1 (forward)"));
const SCALE: Key<f64> = unread(Key::float("scale", 1.0, "a factor of both coefficients"));
const NX: Key<i32> = unread(Key::integer("nx", 1, "the number of densities along x"));
const NY: Key<i32> = unread(Key::integer("ny", 1, "the number of densities along y"));
const NZ: Key<i32> = unread(Key::integer("nz", 1, "the number of densities along z"));
const P0: Key<[f64; 3]> =
    unread(Key::point("p0", [0.0; 3], "a corner of the box of densities").unit(Unit::ObjectSpace));
const P1: Key<[f64; 3]> = unread(Key::point("p1", [1.0; 3], "the opposite corner").unit(Unit::ObjectSpace));
const DENSITY: Key<Floats> = unread(
    Key::new("density", ParamType::Float, Floats, "nx times ny times nz densities, x fastest").required(),
);

const TYPE: Key<Name> = unread(Key::string("type", "the type").required());

const COMMON: Keys = &[&TYPE, &ABSORPTION, &SCATTERING, &PRESET, &G, &SCALE];

/// The types, which the parameter "string type" gives.
pub(crate) const KINDS: &[Kind] = &[
    Kind::new("MakeNamedMedium", "homogeneous", "a medium with the same density everywhere", &[COMMON])
        .instead("empty space"),
    Kind::new(
        "MakeNamedMedium",
        "heterogeneous",
        "a medium whose density varies in a box",
        &[COMMON, &[&NX, &NY, &NZ, &P0, &P1, &DENSITY]],
    )
    .instead("empty space"),
];
