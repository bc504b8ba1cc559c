//! `PixelFilter`: the reconstruction filter.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::params::Params;
use crate::schema::{Key, Kind, Range, Unit};

/// A separable reconstruction filter. It is zero beyond its radius (`xwidth`, `ywidth`, in pixels, from 0.001 to
/// 100).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Filter {
    /// The radius along x and y, in pixels.
    pub radius: DVec2,
    /// The filter function.
    pub kind: FilterKind,
}

/// A filter function of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum FilterKind {
    /// Constant. Default radius 0.5. The default filter of pbrt-v3.
    Box,
    /// Linear falloff. Default radius 2.
    Triangle,
    /// `exp(-alpha x^2) - exp(-alpha radius^2)`. Default radius 2.
    Gaussian {
        /// The rate of falloff, default 2.
        alpha: f64,
    },
    /// The filter of Mitchell and Netravali (1988). Default radius 2.
    Mitchell {
        /// The weight of blur, default 1/3.
        b: f64,
        /// The weight of ringing, default 1/3.
        c: f64,
    },
    /// Sinc windowed by Lanczos. Default radius 4.
    Sinc {
        /// The cycles of the sinc, default 3.
        tau: f64,
    },
}

impl Filter {
    /// The default of pbrt-v3.
    pub const BOX: Filter = Filter { radius: DVec2::splat(0.5), kind: FilterKind::Box };

    /// The number of pixels, across and down, by which a sample reaches beyond its own pixel.
    pub fn reach(&self) -> [u32; 2] {
        self.radius.to_array().map(|radius| (radius - 0.5).ceil().max(0.0) as u32)
    }

    /// True if its numbers are in their ranges.
    pub fn is_valid(&self) -> bool {
        let has_shape = match self.kind {
            FilterKind::Box | FilterKind::Triangle => true,
            FilterKind::Gaussian { alpha } => ALPHA_RANGE.contains(alpha),
            FilterKind::Mitchell { b, c } => [b, c].iter().all(|x| MITCHELL_RANGE.contains(*x)),
            FilterKind::Sinc { tau } => TAU_RANGE.contains(tau),
        };
        has_shape && self.radius.to_array().iter().all(|x| RADIUS_RANGE.contains(*x))
    }

    /// True if a sample may count for several pixels.
    pub fn shares_samples(&self) -> bool {
        self.reach() != [0, 0]
    }
}

const ALPHA_RANGE: Range = Range::from_to(1e-6, 1e4);
const TAU_RANGE: Range = Range::from_to(0.1, 1000.0);
const RADIUS_RANGE: Range = Range::from_to(1e-3, 100.0);
/// The largest radius, in pixels, without a warning: four times the largest default.
const WIDE: f64 = 16.0;
const ALPHA: Key<f64> = Key::float("alpha", 2.0, "how fast the filter falls off").within(ALPHA_RANGE);
const B: Key<f64> =
    Key::float("B", 1.0 / 3.0, "B of Mitchell and Netravali").within(MITCHELL_RANGE).default_words("1/3");
const C: Key<f64> =
    Key::float("C", 1.0 / 3.0, "C of Mitchell and Netravali").within(MITCHELL_RANGE).default_words("1/3");
const MITCHELL_RANGE: Range = Range::from_to(-100.0, 100.0);
const TAU: Key<f64> = Key::float("tau", 3.0, "the number of cycles of the sinc").within(TAU_RANGE);

// Outside this range the filter is zero everywhere, or loses precision.
const fn half_width(name: &'static str, default: f64) -> Key<f64> {
    let half = "half the width of the filter";
    Key::float(name, default, half).within(RADIUS_RANGE).unit(Unit::Pixels)
}

/// The half widths along x and y.
struct Sides(Key<f64>, Key<f64>);

const fn sides(default: f64) -> Sides {
    Sides(half_width("xwidth", default), half_width("ywidth", default))
}

const HALF: Sides = sides(0.5);
const TWO: Sides = sides(2.0);
const FOUR: Sides = sides(4.0);

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("box", "equal weights", &[&[&HALF.0, &HALF.1]]).by_default(),
    Kind::new("triangle", "weights that fall to 0 at the edge", &[&[&TWO.0, &TWO.1]]),
    Kind::new("gaussian", "a Gaussian that falls to 0 at the edge", &[&[&TWO.0, &TWO.1, &ALPHA]]),
    Kind::new("mitchell", "the cubic filter of Mitchell and Netravali", &[&[&TWO.0, &TWO.1, &B, &C]]),
    Kind::new("sinc", "a sinc with a Lanczos window", &[&[&FOUR.0, &FOUR.1, &TAU]]),
];

pub(crate) fn filter(params: &mut Params) -> Option<Filter> {
    let (sides, kind) = match params.kind() {
        "box" => (HALF, FilterKind::Box),
        "triangle" => (TWO, FilterKind::Triangle),
        "gaussian" => (TWO, FilterKind::Gaussian { alpha: params.take(&ALPHA) }),
        "mitchell" => (TWO, FilterKind::Mitchell { b: params.take(&B), c: params.take(&C) }),
        "sinc" => (FOUR, FilterKind::Sinc { tau: params.take(&TAU) }),
        _ => return params.reject_unknown_type(KINDS),
    };
    let radius = DVec2::new(params.take(&sides.0), params.take(&sides.1));
    for (name, radius) in [("xwidth", radius.x), ("ywidth", radius.y)] {
        if radius < 0.5 {
            let message =
                "samples between the pixels count for none: a pixel that no sample reaches is black";
            params.warn(name, message, "0.5 is half a pixel: the least with which all samples count");
        }
        if radius > WIDE {
            let message = format!(
                "{name} is half the width of the filter: {radius} pixels on each side of a pixel blur the picture and take long to render"
            );
            params.warn(name, &message, "write pixels; 0.5 to 4 are usual");
        }
    }
    params.finish().then_some(Filter { radius, kind })
}
