//! `PixelFilter`: the reconstruction filter.

use glam::DVec2;

use crate::params::Params;

/// A separable reconstruction filter. It is zero beyond its radius (`xwidth`, `ywidth`, in pixels, from 0.001 to
/// 100).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// The radius along x and y, in pixels.
    pub radius: DVec2,
    /// The filter function.
    pub kind: FilterKind,
}

/// A filter function of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

pub(crate) const NAMES: &[&str] = &["box", "triangle", "gaussian", "mitchell", "sinc"];

pub(crate) fn filter(params: &mut Params) -> Option<Filter> {
    let (width, kind) = match params.kind() {
        "box" => (0.5, FilterKind::Box),
        "triangle" => (2.0, FilterKind::Triangle),
        "gaussian" => (2.0, FilterKind::Gaussian { alpha: params.float("alpha", 2.0) }),
        "mitchell" => {
            let (b, c) = (params.float("B", 1.0 / 3.0), params.float("C", 1.0 / 3.0));
            (2.0, FilterKind::Mitchell { b, c })
        }
        "sinc" => (4.0, FilterKind::Sinc { tau: params.float("tau", 3.0) }),
        _ => return params.unknown_kind(NAMES),
    };
    // Outside these ranges the filter is zero everywhere, or loses precision.
    let mut within = |name: &'static str, value: f64, from: f64, to: f64| {
        if !(from..=to).contains(&value) {
            params.reject(name, format!("{name} must be from {from} to {to}"), None);
        }
    };
    match kind {
        FilterKind::Gaussian { alpha } => within("alpha", alpha, 1e-6, 1e4),
        FilterKind::Sinc { tau } => within("tau", tau, 0.1, 1000.0),
        FilterKind::Mitchell { b, c } => {
            within("B", b, -100.0, 100.0);
            within("C", c, -100.0, 100.0);
        }
        FilterKind::Box | FilterKind::Triangle => {}
    }
    let mut side = |name| {
        let radius = params.float(name, width);
        if !(1e-3..=100.0).contains(&radius) {
            params.reject(name, format!("{name} must be from 0.001 to 100 pixels"), None);
        }
        radius
    };
    let radius = DVec2::new(side("xwidth"), side("ywidth"));
    params.finish().then_some(Filter { radius, kind })
}
