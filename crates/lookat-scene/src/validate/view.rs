//! Whether a view keeps the promises of a scene.

use super::{Faults, NO_TRANSFORM, has_samples};
use crate::film::{MAX_SIDE, SCALE_RANGE};
use crate::filter::{ALPHA_RANGE, MITCHELL_RANGE, RADIUS_RANGE, TAU_RANGE};
use crate::integrator::LARGEST_DEPTH;
use crate::{
    Camera, Film, Filter, FilterKind, Integrator, Lens, MAX_PIXELS, MAX_SAMPLES, Projection, Sampler,
    SamplerKind, View,
};

/// Adds the promises that a view breaks.
pub(super) fn view_faults(view: &View, found: &mut Faults) {
    found.check(view.camera.world_from_camera.in_range(), "view.camera.world_from_camera", NO_TRANSFORM);
    found.check(is_camera(&view.camera), "view.camera", "its numbers are out of range");
    found.check(is_film(&view.film), "view.film", "its size, crop window or limits are out of range");
    found.check(is_filter(&view.filter), "view.filter", "its numbers are out of range");
    found.check(
        is_sampler(&view.sampler),
        "view.sampler",
        "there are no samples, too many, or not as many as cells",
    );
    found.check(is_integrator(&view.integrator), "view.integrator", "its numbers are out of range");
}

fn is_integrator(integrator: &Integrator) -> bool {
    let is_depth = |depth: u32| depth <= LARGEST_DEPTH as u32;
    match *integrator {
        Integrator::Path { max_depth, roulette_threshold, .. } => {
            is_depth(max_depth) && roulette_threshold.is_finite()
        }
        Integrator::DirectLighting { max_depth, .. } => is_depth(max_depth),
        Integrator::AmbientOcclusion { samples, .. } => has_samples(samples),
    }
}

fn is_length(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

fn is_camera(camera: &Camera) -> bool {
    let has_angle = match camera.projection {
        Projection::Perspective { fov } => fov > 0.0 && fov < 180.0,
        Projection::Orthographic { .. } | Projection::Environment => true,
    };
    let size = camera.screen.max - camera.screen.min;
    let has_lens = |lens: Lens| is_length(lens.radius) && is_length(lens.focal_distance);
    has_angle && size.is_finite() && size.x != 0.0 && size.y != 0.0 && camera.lens.is_none_or(has_lens)
}

fn is_sampler(sampler: &Sampler) -> bool {
    let has_cells = match sampler.kind {
        SamplerKind::Stratified { cells: [across, down], .. } => {
            across > 0 && across.checked_mul(down).is_some_and(|cells| cells >= sampler.samples_per_pixel)
        }
        SamplerKind::Random | SamplerKind::Sobol { .. } => true,
    };
    has_cells && (1..=MAX_SAMPLES).contains(&sampler.samples_per_pixel)
}

fn is_film(film: &Film) -> bool {
    let (crop, [width, height]) = (film.crop, film.resolution);
    let has_pixels = crop.x0 < crop.x1 && crop.x1 <= width && crop.y0 < crop.y1 && crop.y1 <= height;
    let has_size = width.max(height) <= MAX_SIDE && crop.area() <= MAX_PIXELS;
    has_pixels && has_size && SCALE_RANGE.contains(film.scale) && film.max_sample_luminance > 0.0
}

fn is_filter(filter: &Filter) -> bool {
    let has_shape = match filter.kind {
        FilterKind::Box | FilterKind::Triangle => true,
        FilterKind::Gaussian { alpha } => ALPHA_RANGE.contains(alpha),
        FilterKind::Mitchell { b, c } => [b, c].iter().all(|x| MITCHELL_RANGE.contains(*x)),
        FilterKind::Sinc { tau } => TAU_RANGE.contains(tau),
    };
    has_shape && filter.radius.to_array().iter().all(|x| RADIUS_RANGE.contains(*x))
}
