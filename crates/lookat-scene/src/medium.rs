//! `MakeNamedMedium`: participating media, which absorb and scatter light (PBR 11).

pub(crate) mod measured;

use glam::Vec3;
use lookat_syntax::{Diagnostic, ParamType, Text};

use crate::Transform;
use crate::color;
use crate::medium::measured::{MeasuredMedium, MediumName, measured};
use crate::params::Params;
use crate::params::value::{Color, Floats, Name, ParamValue};
use crate::schema::{Key, Keys, Kind, Range, Unit};

/// A participating medium. Its coefficients are linear RGB per unit of length of the world, each at least 0 and at most 1e18.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Its name in `MakeNamedMedium`. `None` for a medium made in code.
    pub name: Option<String>,
    /// The absorption coefficient where the density is 1 (`sigma_a` times `scale`).
    pub absorption: Vec3,
    /// The scattering coefficient where the density is 1 (`sigma_s` times `scale`).
    pub scattering: Vec3,
    /// The asymmetry of the phase function of Henyey and Greenstein: the mean cosine between the directions before and after
    /// scattering, above -1 and below 1 (`g`, default 0).
    pub asymmetry: f64,
    /// How dense the medium is.
    pub density: Density,
}

impl Medium {
    /// True if all numbers are in their ranges.
    pub(crate) fn is_valid(&self) -> bool {
        let is_coefficient = |color: Vec3| color.min_element() >= 0.0 && color::is_in_range(color);
        let is_density = |value: &f32| (0.0..=color::LARGEST).contains(&f64::from(*value));
        let is_grid = |grid: &DensityGrid| {
            let count = grid.resolution.iter().try_fold(1, |count: usize, cells| count.checked_mul(*cells));
            count == Some(grid.values.len())
                && grid.values.iter().all(is_density)
                && grid.grid_from_world.in_range()
        };
        is_coefficient(self.absorption)
            && is_coefficient(self.scattering)
            && self.asymmetry.abs() < 1.0
            && match &self.density {
                Density::Uniform => true,
                Density::Grid(grid) => is_grid(grid),
            }
    }

    /// Its memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        match &self.density {
            Density::Uniform => size_of::<Medium>(),
            Density::Grid(grid) => size_of::<Medium>() + size_of_val(&grid.values[..]),
        }
    }
}

/// The density of a medium in space.
#[derive(Debug, Clone, PartialEq)]
pub enum Density {
    /// 1 everywhere (`homogeneous`).
    Uniform,
    /// Interpolated between the values of a grid (`heterogeneous`).
    Grid(Box<DensityGrid>),
}

/// Densities at the centers of the cells of a box, trilinear between them, and 0 outside of the box. Beyond the outermost centers the values
/// fall to 0 half a cell outside of the box, as in pbrt-v3.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityGrid {
    /// The number of cells along x, y and z (`nx`, `ny`, `nz`, default 1).
    pub resolution: [usize; 3],
    /// The densities, x fastest, each at least 0 (`density`).
    pub values: Vec<f32>,
    /// From the world to the space where the box goes from 0 to 1 along each axis (from `p0`, default 0 0 0, and `p1`, default 1 1 1).
    pub grid_from_world: Transform,
}

pub(crate) const TYPE: Key<Name> = Key::string("type", "the type of the medium").required();
const SIGMA_A: Key<Color> = coefficient_of(
    "sigma_a",
    [0.0011, 0.0024, 0.014],
    "the absorption coefficient, per unit of length of the world",
);
const SIGMA_S: Key<Color> = coefficient_of(
    "sigma_s",
    [2.55, 3.21, 3.77],
    "the scattering coefficient, per unit of length of the world",
);
const PRESET: Key<MediumName> =
    measured("preset", "the measured medium whose coefficients, per millimeter, are the defaults");
const G: Key<f64> = Key::float("g", 0.0, "the asymmetry of scattering, from back (-1) to forward (1)")
    .within(Range::between(-1.0, 1.0));
const SCALE: Key<f64> =
    Key::float("scale", 1.0, "a factor of both coefficients").within(Range::at_least(0.0));

const RESOLUTION: [Key<i32>; 3] = [
    cells("nx", "the number of densities along x"),
    cells("ny", "the number of densities along y"),
    cells("nz", "the number of densities along z"),
];
const P0: Key<[f64; 3]> =
    Key::point("p0", [0.0; 3], "a corner of the box of densities").unit(Unit::ObjectSpace);
const P1: Key<[f64; 3]> = Key::point("p1", [1.0; 3], "the opposite corner").unit(Unit::ObjectSpace);
const DENSITY: Key<Floats> =
    Key::new("density", ParamType::Float, Floats, "nx times ny times nz densities, x fastest").required();

const fn coefficient_of(name: &'static str, default: [f32; 3], meaning: &'static str) -> Key<Color> {
    Key::new(name, ParamType::Rgb, Color(Vec3::from_array(default)), meaning)
}

const fn cells(name: &'static str, meaning: &'static str) -> Key<i32> {
    Key::integer(name, 1, meaning).within(Range::at_least(1.0))
}

const COMMON: Keys = &[&SIGMA_A, &SIGMA_S, &PRESET, &G, &SCALE];
const GRID: Keys = &[&RESOLUTION[0], &RESOLUTION[1], &RESOLUTION[2], &P0, &P1, &DENSITY];

/// The types, which the parameter "string type" gives.
pub(crate) const KINDS: &[Kind] = &[
    Kind::new("homogeneous", "a medium with the same density everywhere", &[COMMON]),
    Kind::new("heterogeneous", "a medium whose density varies in a box", &[COMMON, GRID]),
];

/// The type of a named medium, which is a parameter.
pub(crate) fn named_type(params: &mut Params) -> Option<Text> {
    let kind = Name::take(&TYPE, params);
    let message = format!("medium \"{}\" has no type", params.kind());
    params.missing(TYPE.name, &message, "add \"string type\" \"homogeneous\"");
    kind
}

/// pbrt-v3's MakeMedium.
pub(crate) fn medium(params: &mut Params, world_from_medium: Transform) -> Option<Medium> {
    if !params.is_known_kind(KINDS) {
        return params.reject_unknown_type(KINDS);
    }
    let measured = MeasuredMedium::take(params, &PRESET);
    let scale = params.take(&SCALE) as f32;
    let absorption = coefficient(params, SIGMA_A, measured.map(|medium| medium.absorption), scale);
    let scattering = coefficient(params, SIGMA_S, measured.map(|medium| medium.scattering), scale);
    let asymmetry = params.take(&G);
    let density = match params.kind() {
        "heterogeneous" => grid(params, world_from_medium).map(|grid| Density::Grid(Box::new(grid))),
        _ => Some(Density::Uniform),
    };
    let is_usable = params.finish();
    density.filter(|_| is_usable).map(|density| Medium {
        name: None,
        absorption,
        scattering,
        asymmetry,
        density,
    })
}

/// A coefficient of 0 or more. `measured`: its default.
fn coefficient(params: &mut Params, key: Key<Color>, measured: Option<Vec3>, scale: f32) -> Vec3 {
    let given = params.take(&Key { default: measured.map_or(key.default, Color), ..key });
    if params.was_of_type(key.name, &[ParamType::Rgb]) && given.min_element() < 0.0 {
        params.reject(key.name, format!("{} is negative", key.name), Some("write coefficients of 0 or more"));
    }
    // Spectra outside of the sRGB gamut have negative components.
    let coefficient = given.max(Vec3::ZERO) * scale;
    if !color::is_in_range(coefficient) {
        let message = format!("{} times scale is too large; the limit is {:e}", key.name, color::LARGEST);
        params.reject(key.name, message, Some("write a smaller coefficient or scale"));
    }
    coefficient
}

fn grid(params: &mut Params, world_from_medium: Transform) -> Option<DensityGrid> {
    let resolution = RESOLUTION.map(|key| params.take(&key));
    let [p0, p1] = [P0, P1].map(|key| {
        let corner = params.take(&key);
        params.check_range(key.name, &corner.to_array());
        corner
    });
    let values = Floats::take(&DENSITY, params);
    let help = "add \"float density\" [...]: nx times ny times nz densities, x fastest";
    params.missing(DENSITY.name, "a heterogeneous medium needs density", help);
    let values = values?;
    let count = resolution.iter().map(|cells| i64::from(*cells)).try_fold(1, i64::checked_mul);
    if params.usable() && count != Some(values.len() as i64) {
        let [nx, ny, nz] = resolution;
        let message =
            format!("density has {} values, not nx times ny times nz = {nx} x {ny} x {nz}", values.len());
        let help = "write a value for each cell, or the numbers of cells that the values are for";
        params.reject(DENSITY.name, message, Some(help));
    }
    if let Some(at) = values.iter().position(|value| !(..=color::LARGEST).contains(value)) {
        let place = params.value_place(DENSITY.name, at);
        let message = format!("a density of {}: densities are from 0 to {:e}", values[at], color::LARGEST);
        params.error(Diagnostic::error(place, message).help("write a smaller number"));
    }
    if let Some(at) = values.iter().position(|value| *value < 0.0) {
        let place = params.value_place(DENSITY.name, at);
        let message = format!("a density of {} counts as 0", values[at]);
        params.report.push(Diagnostic::warning(place, message).help("write 0 where the medium is not"));
    }
    let size = p1 - p0;
    let Some(box_from_grid) = Transform::scale(size) else {
        if params.usable() {
            params.reject(
                P1.name,
                "p0 and p1 are corners of a box without volume",
                Some("move p1 along all axes"),
            );
        }
        return None;
    };
    let world_from_grid = world_from_medium * Transform::translate(p0) * box_from_grid;
    if !world_from_grid.in_range() {
        params.reject(
            P0.name,
            "the box of densities is out of the range of computation",
            Some("write a larger or nearer box"),
        );
    }
    params.reserve(DENSITY.name, values.len() * size_of::<f32>())?.keep();
    let values = values.into_iter().map(|value| value.max(0.0) as f32).collect();
    let resolution = resolution.map(|cells| cells as usize);
    params.usable().then(|| DensityGrid { resolution, values, grid_from_world: world_from_grid.inverse() })
}

#[cfg(test)]
mod tests {
    use crate::load_str;

    /// The errors and warnings about a medium.
    fn found(medium: &str) -> Vec<String> {
        let text = format!(
            "Film \"image\" Sampler \"sobol\" Camera \"perspective\" Integrator \"volpath\" WorldBegin
            LightSource \"infinite\" MakeNamedMedium \"fog\" {medium}
            MediumInterface \"fog\" \"\" Material \"\" Shape \"sphere\" WorldEnd"
        );
        load_str(&text).diagnostics.into_iter().map(|diagnostic| diagnostic.message).collect()
    }

    const GRID: &str = "\"string type\" \"heterogeneous\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1";

    #[test]
    fn media_of_pbrt_are_right() {
        for medium in [
            "\"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] \"float scale\" .1 \"float g\" -.5",
            "\"string type\" \"homogeneous\" \"string preset\" \"Wholemilk\" \"spectrum sigma_s\" [400 1 700 2]",
            &format!("{GRID} \"float density\" [0 1] \"point p0\" [1 1 1] \"point p1\" [0 0 0]"),
        ] {
            assert_eq!(found(medium), [""; 0], "{medium}");
        }
    }

    #[test]
    fn wrong_media_are_reported() {
        let of = |rest: &str| format!("\"string type\" \"homogeneous\" {rest}");
        let in_grid = |rest: &str| format!("{GRID} {rest}");
        for (medium, expected) in [
            (String::new(), "medium \"fog\" has no type"),
            ("\"string type\" \"homogenous\"".into(), "homogenous"),
            (of("\"float g\" 1"), "g must be above -1 and below 1"),
            (of("\"float scale\" -1"), "scale must be at least 0"),
            (of("\"rgb sigma_a\" [1 -1 1]"), "sigma_a is negative"),
            (of("\"rgb sigma_s\" [1e15 1 1] \"float scale\" 1e9"), "sigma_s times scale is too large"),
            (of("\"string preset\" \"Wholemilc\""), "there is no measured medium of this name"),
            (of("\"float nx\" 1"), "nx"),
            (in_grid(""), "a heterogeneous medium needs density"),
            (
                in_grid("\"float density\" [0 1 2]"),
                "density has 3 values, not nx times ny times nz = 2 x 1 x 1",
            ),
            (in_grid("\"float density\" [0 -1]"), "a density of -1"),
            (in_grid("\"float density\" [0 1] \"point p1\" [1 1 0]"), "corners of a box without volume"),
            (in_grid("\"float density\" [0 1] \"integer nz\" 0"), "nz must be at least 1"),
            (
                in_grid(
                    "\"float density\" [0 1] \"integer nx\" 2000000000 \"integer ny\" 2000000000 \"integer nz\" 2000000000",
                ),
                "density has 2 values",
            ),
        ] {
            let found = found(&medium);
            assert!(found.iter().any(|message| message.contains(expected)), "{medium}: {found:?}");
        }
    }
}
