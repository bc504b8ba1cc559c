//! Ambient occlusion, as pbrt-v3's AOIntegrator.

use std::f64::consts::PI;

use glam::Vec3;
use lookat_scene::MaterialKind;

use super::{FirstHit, MAX_PASSED, Tracer};
use crate::frame::Frame;
use crate::sampler::SampleStream;
use crate::surface::Surface;
use crate::warp::{
    square_to_cosine_hemisphere, square_to_uniform_hemisphere, square_to_uniform_hemisphere_pdf,
};

/// Pi times the share of the sky that the surface sees, weighed by the cosine.
pub(crate) fn li(
    tracer: &mut Tracer,
    first: &FirstHit,
    stream: &mut SampleStream,
    cosine: bool,
    samples: u32,
) -> Vec3 {
    let Some(surface) = first_material(tracer, first) else { return Vec3::ZERO };
    let n = if surface.n.dot(first.ray.d) > 0.0 { -surface.n } else { surface.n };
    let frame = Frame::from_z(n);
    let mut sum = 0.0;
    for k in 0..samples {
        let u = stream.nested_2d(samples, k);
        let local = if cosine { square_to_cosine_hemisphere(u) } else { square_to_uniform_hemisphere(u) };
        // The cosine over the density by solid angle.
        let value = if cosine { PI } else { local.z / square_to_uniform_hemisphere_pdf() };
        if !tracer.occluded(&surface.leave(frame.to_world(local))) {
            sum += value;
        }
    }
    Vec3::splat((sum / f64::from(samples)) as f32)
}

/// The nearest surface that has a material.
fn first_material<'s>(tracer: &mut Tracer<'s>, first: &FirstHit) -> Option<Surface<'s>> {
    let (mut ray, mut found) = (*first.ray, first.hit.copied());
    for _ in 0..MAX_PASSED {
        let surface = tracer.surface(&ray, &found?);
        if !matches!(surface.primitive.material.kind(), MaterialKind::None) {
            return Some(surface);
        }
        ray = surface.leave(ray.d);
        found = tracer.nearest(&ray);
    }
    None
}
