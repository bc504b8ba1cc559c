//! `MakeNamedMedium`: participating media, which lookat does not render. Only their names count.

use lookat_syntax::ParamType;

use crate::params::value::{Color, Floats, Name};
use crate::schema::{Key, Keys, Kind, Unit};

const ABSORPTION: Key<Color> = Key::color("sigma_a", 1.0, "the absorption coefficient, per unit of length")
    .not_rendered()
    .default_words("0.0011 0.0024 0.014");
const SCATTERING: Key<Color> = Key::color("sigma_s", 1.0, "the scattering coefficient, per unit of length")
    .not_rendered()
    .default_words("2.55 3.21 3.77");
const PRESET: Key<Name> =
    Key::string("preset", "a measured medium, such as \"Wholemilk\", instead of coefficients").not_rendered();
const G: Key<f64> =
    Key::float("g", 0.0, "the asymmetry of scattering, from -1 (back) to 1 (forward)").not_rendered();
const SCALE: Key<f64> = Key::float("scale", 1.0, "a factor of both coefficients").not_rendered();
const NX: Key<i32> = Key::integer("nx", 1, "the number of densities along x").not_rendered();
const NY: Key<i32> = Key::integer("ny", 1, "the number of densities along y").not_rendered();
const NZ: Key<i32> = Key::integer("nz", 1, "the number of densities along z").not_rendered();
const P0: Key<[f64; 3]> =
    Key::point("p0", [0.0; 3], "a corner of the box of densities").unit(Unit::ObjectSpace).not_rendered();
const P1: Key<[f64; 3]> =
    Key::point("p1", [1.0; 3], "the opposite corner").unit(Unit::ObjectSpace).not_rendered();
const DENSITY: Key<Floats> =
    Key::new("density", ParamType::Float, Floats, "nx times ny times nz densities, x fastest")
        .required()
        .not_rendered();

const TYPE: Key<Name> = Key::string("type", "the type").required().not_rendered();

const COMMON: Keys = &[&TYPE, &ABSORPTION, &SCATTERING, &PRESET, &G, &SCALE];

/// The types, which the parameter "string type" gives.
pub(crate) const KINDS: &[Kind] = &[
    Kind::new("homogeneous", "a medium with the same density everywhere", &[COMMON]).instead("empty space"),
    Kind::new(
        "heterogeneous",
        "a medium whose density varies in a box",
        &[COMMON, &[&NX, &NY, &NZ, &P0, &P1, &DENSITY]],
    )
    .instead("empty space"),
];
