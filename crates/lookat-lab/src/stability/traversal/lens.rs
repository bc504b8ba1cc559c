//! Stripes out of focus, whose picture is known: four dimensions, two of the pixel and two of the lens.

use glam::DVec2;
use lookat_scene::{Sampler, SamplerKind, Scene};

use crate::text_scene::scene;

/// Pixels on a side.
pub(super) const SIDE: u32 = 16;

/// The depth of the stripes, twice the focal distance of 1.
const DEPTH: f64 = 2.0;

/// The radius of the lens, and of the blur at that depth: the width of a pixel there.
const LENS: f64 = 0.1;

/// Half the film on the plane of depth one.
const HALF: f64 = 0.4;

/// Stripes are so wide, and as far from each other, that pixels see one edge at most, and most see one.
const WIDTH: f64 = 0.4;

/// The normal of the edges.
fn across() -> DVec2 {
    DVec2::from_angle(0.4)
}

/// The picture is 1 on the stripes and 0 between them.
pub(super) fn edge() -> Scene {
    // One mesh, so that there is one light, and black, so that nothing else is seen.
    let points: String = (-4..4).map(stripe).collect();
    let quad = |at: usize| format!("{} {} {} {} {} {} ", at, at + 1, at + 2, at, at + 2, at + 3);
    let indices: String = (0..8).map(|number| quad(4 * number)).collect();
    scene(&format!(
        "Camera \"perspective\" \"float fov\" {} \"float lensradius\" {LENS} \"float focaldistance\" 1
         Film \"image\" \"integer xresolution\" {SIDE} \"integer yresolution\" {SIDE}
         Sampler \"sobol\" Integrator \"directlighting\" WorldBegin Material \"matte\" \"rgb Kd\" [0 0 0]
         AreaLightSource \"diffuse\" \"bool twosided\" \"true\"
         Shape \"trianglemesh\" \"integer indices\" [{indices}] \"point P\" [{points}] WorldEnd",
        2.0 * HALF.atan().to_degrees()
    ))
}

/// The corners of a stripe, much longer than the film.
fn stripe(number: i32) -> String {
    let (n, along) = (across(), across().perp() * 100.0);
    let low = n * (2.0 * f64::from(number) * WIDTH);
    let high = low + n * WIDTH;
    let points = [low - along, high - along, high + along, low + along];
    points.iter().map(|p| format!("{} {} {DEPTH} ", p.x, p.y)).collect()
}

/// The place of a pixel's lower left corner, on the plane of depth one: x to the right, y up.
fn corner(pixel: [u32; 2]) -> DVec2 {
    let step = 2.0 * HALF / f64::from(SIDE);
    DVec2::new(-HALF + f64::from(pixel[0]) * step, HALF - f64::from(pixel[1] + 1) * step)
}

/// Whether the ray through a place of the pixel and of the unit disk meets a stripe.
pub(super) fn is_bright(pixel: [u32; 2], film: DVec2, on_disk: DVec2) -> bool {
    let place = corner(pixel) + film * (2.0 * HALF / f64::from(SIDE));
    let lens = on_disk * LENS;
    // The ray passes the plane of focus at the place, at any point of the lens.
    ((lens + (place - lens) * DEPTH).dot(across()) / WIDTH).rem_euclid(2.0) < 1.0
}

/// The share of the rays of a pixel that do: over the film by the midpoint rule, over the lens in closed form.
pub(super) fn share(pixel: [u32; 2]) -> f64 {
    const N: u32 = 64;
    let (from, step) = (corner(pixel), 2.0 * HALF / f64::from(SIDE));
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(N) * step;
    let part = |x: u32, y: u32| blurred((from + DVec2::new(at(x), at(y))).dot(across()) * DEPTH);
    let sum: f64 = (0..N).flat_map(|y| (0..N).map(move |x| part(x, y))).sum();
    sum / f64::from(N * N)
}

/// The share of the lens that sees stripes, through the center of which the point at `s` across the stripes is seen.
fn blurred(s: f64) -> f64 {
    let blur = LENS * (DEPTH - 1.0);
    let first = ((s - blur) / (2.0 * WIDTH)).floor();
    let stripe = |number: f64| {
        let low = 2.0 * number * WIDTH;
        disk_below((low + WIDTH - s) / blur) - disk_below((low - s) / blur)
    };
    stripe(first) + stripe(first + 1.0)
}

/// The share of the unit disk where a coordinate is less than `x`.
fn disk_below(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / std::f64::consts::PI
}

/// Pixels that are neither wholly bright nor wholly dark, with their shares.
pub(super) fn mixed() -> Vec<([u32; 2], f64)> {
    let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| [x, y]));
    pixels.map(|pixel| (pixel, share(pixel))).filter(|(_, share)| (0.02..0.98).contains(share)).collect()
}

/// The scene with another sampler.
pub(super) fn sampled(scene: &Scene, kind: SamplerKind, samples: u32) -> Scene {
    let mut scene = scene.clone();
    scene.view.sampler = Sampler { kind, samples_per_pixel: 1 }.with_samples(samples);
    scene
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::stability::random::in_cube;

    /// Against random film and lens points.
    #[test]
    fn share_is_the_mean_of_what_is_bright() {
        let mut random = Pcg64Mcg::seed_from_u64(6);
        for (pixel, share) in mixed().into_iter().step_by(17) {
            let (mut bright, mut all) = (0, 0);
            while all < 20_000 {
                let (film, lens) =
                    (in_cube(&mut random).truncate() * 0.5 + 0.5, in_cube(&mut random).truncate());
                if lens.length() < 1.0 {
                    all += 1;
                    bright += i32::from(is_bright(pixel, film, lens));
                }
            }
            let mean = f64::from(bright) / f64::from(all);
            assert!((mean - share).abs() < 0.015, "{pixel:?}: {mean} {share}");
        }
    }
}
