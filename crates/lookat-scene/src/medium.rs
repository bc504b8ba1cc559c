//! `MakeNamedMedium`: participating media, which lookat does not render. Only their names count.

use lookat_syntax::ParamType;

use crate::params::value::Floats;
use crate::schema::{Key, Keys, Kind, Unit};

const COMMON: Keys = &[
    &Key::string("type", "the type").required(),
    &Key::color("sigma_a", 1.0, "the absorption coefficient, per unit of length")
        .default_words("0.0011 0.0024 0.014"),
    &Key::color("sigma_s", 1.0, "the scattering coefficient, per unit of length")
        .default_words("2.55 3.21 3.77"),
    &Key::string("preset", "a measured medium, such as \"Wholemilk\", instead of coefficients"),
    &Key::float("g", 0.0, "the asymmetry of scattering, from -1 (back) to 1 (forward)"),
    &Key::float("scale", 1.0, "a factor of both coefficients"),
];

/// The types, which the parameter "string type" gives.
pub(crate) const KINDS: &[Kind] = &[
    Kind::new("homogeneous", "a medium with the same density everywhere", &[])
        .ignoring(&[COMMON])
        .instead("empty space"),
    Kind::new("heterogeneous", "a medium whose density varies in a box", &[])
        .ignoring(&[
            COMMON,
            &[
                &Key::integer("nx", 1, "the number of densities along x"),
                &Key::integer("ny", 1, "the number of densities along y"),
                &Key::integer("nz", 1, "the number of densities along z"),
                &Key::point("p0", [0.0; 3], "a corner of the box of densities").unit(Unit::ObjectSpace),
                &Key::point("p1", [1.0; 3], "the opposite corner").unit(Unit::ObjectSpace),
                &Key::new("density", ParamType::Float, Floats, "nx times ny times nz densities, x fastest")
                    .required(),
            ],
        ])
        .instead("empty space"),
];
