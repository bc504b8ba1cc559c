//! Pictures whose pixels are known in closed form.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use lookat_scene::Scene;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::stability::random::between;
use crate::text_scene::{at, emitting, film, matte, quad, quads, scene, sphere, two_sided};

/// A scene, and its picture.
#[derive(Debug, Clone)]
pub struct Known {
    /// The scene.
    pub scene: Scene,
    /// Red, green and blue of each pixel, row by row.
    pub values: Vec<[f64; 3]>,
}

/// The normal of the edges of stripes.
fn across() -> DVec2 {
    DVec2::from_angle(0.4)
}

/// The width of stripes in pixels: more than pixels reach across them.
const WIDTH: f64 = 3.0;

/// The share of a unit square, centered at 0, where a coordinate across the edges is less than `t`.
fn square_below(t: f64) -> f64 {
    let n = across();
    let (a, b) = (n.x.abs().max(n.y.abs()), n.x.abs().min(n.y.abs()));
    // The sum of two uniform numbers, of widths a and b: a trapezoid. Integrated from the left.
    let ramp = |x: f64| x.max(0.0).powi(2) / (2.0 * a * b);
    let from_left = t + 0.5 * (a + b);
    (ramp(from_left) - ramp(from_left - a) - ramp(from_left - b) + ramp(from_left - a - b)).clamp(0.0, 1.0)
}

/// The share of the unit disk where a coordinate is less than `x`.
fn disk_below(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / PI
}

/// Centers of pixels in pixels, x to the right, y up, 0 in the middle.
fn centers(side: u32) -> impl Iterator<Item = DVec2> {
    let half = f64::from(side) / 2.0;
    let at = move |i: u32| f64::from(i) + 0.5 - half;
    (0..side).flat_map(move |y| (0..side).map(move |x| DVec2::new(at(x), -at(y))))
}

/// An orthographic camera that sees one unit in each pixel; or a perspective one, at a distance of 1, with a lens.
fn camera(side: u32, has_lens: bool) -> String {
    let half = f64::from(side) / 2.0;
    let view = if has_lens {
        format!("\"perspective\" \"float fov\" 90 \"float lensradius\" {LENS} \"float focaldistance\" {half}")
    } else {
        format!("\"orthographic\" \"float screenwindow\" [-{half} {half} -{half} {half}]")
    };
    let (film, black) = (film([side; 2]), matte(0.0));
    format!("Camera {view} {film} Integrator \"directlighting\" WorldBegin {black}")
}

/// Stripes `number` to the next of that color: one mesh, at that depth, in pixels.
fn stripes(side: u32, depth: f64, color: [f64; 3], numbers: impl Iterator<Item = i32>) -> String {
    let (n, along) = (across(), across().perp() * f64::from(side) * 4.0);
    let corners = numbers.flat_map(|number| {
        let low = n * (f64::from(number) * WIDTH);
        let high = low + n * WIDTH;
        [low - along, high - along, high + along, low + along].map(|p| p.extend(depth))
    });
    two_sided(color, &quads(&corners.collect::<Vec<_>>()))
}

/// Numbers of the stripes that a picture can show, and lenses can see.
fn numbers(side: u32) -> std::ops::Range<i32> {
    let reach = (f64::from(side) / WIDTH) as i32 + 4;
    -reach..reach
}

/// The share of each stripe near a place, where `below` is the share of what is seen from there below an edge.
fn shares(side: u32, s: f64, reach: f64, below: impl Fn(f64) -> f64) -> impl Iterator<Item = (i32, f64)> {
    let first = ((s - reach) / WIDTH).floor() as i32;
    let last = ((s + reach) / WIDTH).floor() as i32;
    let (first, last) = (first.max(numbers(side).start), last.min(numbers(side).end - 1));
    let edge = move |number: i32| f64::from(number) * WIDTH - s;
    (first..=last).map(move |number| (number, below(edge(number + 1)) - below(edge(number))))
}

/// The value of a pixel that sees stripes by their shares: every second one is white, the others black.
fn white(stripes: impl Iterator<Item = (i32, f64)>) -> [f64; 3] {
    // Rounding may leave less than nothing of a share.
    [stripes.filter(|(number, _)| number % 2 == 0).map(|(_, share)| share.max(0.0)).sum(); 3]
}

/// Sharp edges of white stripes on black: two dimensions.
pub fn edges(side: u32) -> Known {
    let text = camera(side, false)
        + &stripes(side, 1.0, [1.0; 3], numbers(side).filter(|n| n % 2 == 0))
        + "WorldEnd";
    let pixel = |center: DVec2| white(shares(side, center.dot(across()), 1.0, square_below));
    let values = centers(side).map(pixel).collect();
    Known { scene: scene(&text), values }
}

/// The radius of the lens. A pixel is one unit wide in focus, two on the stripes, and is blurred there by as much.
const LENS: f64 = 1.0;

/// White stripes on black out of focus, at twice the focal distance: four dimensions.
pub fn lens(side: u32) -> Known {
    let half = f64::from(side) / 2.0;
    let text = camera(side, true)
        + &stripes(side, 2.0 * half, [1.0; 3], numbers(2 * side).filter(|number| number % 2 == 0))
        + "WorldEnd";
    let pixel = |center: DVec2| {
        const N: u32 = 48;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(N) - 0.5;
        let places = (0..N).flat_map(|y| (0..N).map(move |x| DVec2::new(at(x), at(y))));
        let weight = 1.0 / f64::from(N * N);
        let parts = places.flat_map(|place| {
            let s = 2.0 * (center + place).dot(across());
            shares(2 * side, s, LENS, |t| disk_below(t / LENS)).map(move |(n, share)| (n, share * weight))
        });
        white(parts)
    };
    let values = centers(side).map(pixel).collect();
    Known { scene: scene(&text), values }
}

/// One point of a floor under a large sphere light, in all pixels: smooth, two dimensions.
pub fn plain(side: u32) -> Known {
    let text = format!(
        "LookAt 2 0.5 0  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 1e-6
         {} Integrator \"directlighting\" WorldBegin {}{}{} WorldEnd",
        film([side; 2]),
        emitting([1.0; 3], &at(DVec3::Y * 4.0, &sphere(4.0 * 0.5_f64.sqrt()))),
        matte(0.5),
        quad(DVec3::ZERO, DVec3::X * 9.0, DVec3::Z * 9.0)
    );
    Known { scene: scene(&text), values: vec![[0.25; 3]; (side * side) as usize] }
}

/// Radiance 1, and in a thousandth of each pixel, somewhere, 100.
pub fn fireflies(side: u32) -> Known {
    const SHARE: f64 = 1e-3;
    let mut random = Pcg64Mcg::seed_from_u64(13);
    let size = SHARE.sqrt();
    let dots = centers(side).flat_map(|center| {
        let mut place = || between(&mut random, -0.5, 0.5 - size);
        let low = center + DVec2::new(place(), place());
        [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|corner| (low + corner * size).extend(1.0))
    });
    let dots = two_sided([100.0; 3], &quads(&dots.collect::<Vec<_>>()));
    let far = f64::from(side);
    let ground = two_sided([1.0; 3], &quad(2.0 * DVec3::Z, far * DVec3::X, far * DVec3::Y));
    let scene = scene(&format!("{}{ground}{dots}WorldEnd", camera(side, false)));
    Known { scene, values: vec![[1.0 + 99.0 * SHARE; 3]; (side * side) as usize] }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use lookat_scene::Sampler;

    use super::*;
    use crate::coverage::{Stratum, judge};

    /// The value of a pixel: colors by their shares.
    fn mix(parts: impl Iterator<Item = ([f64; 3], f64)>) -> [f64; 3] {
        // Rounding may leave less than nothing of a share.
        parts.fold([0.0; 3], |mean, (color, share)| [0, 1, 2].map(|c| mean[c] + share.max(0.0) * color[c]))
    }

    /// The same in colors: red, green and blue have their edges apart.
    fn tinted(side: u32) -> Known {
        const COLORS: [[f64; 3]; 5] =
            [[0.9, 0.1, 0.1], [0.0, 0.8, 0.0], [0.2, 0.2, 0.9], [1.0, 1.0, 1.0], [0.05, 0.4, 0.6]];
        let color = |number: i32| number.rem_euclid(5) as usize;
        let mut text = camera(side, false);
        for (at, rgb) in COLORS.into_iter().enumerate() {
            text += &stripes(side, 1.0, rgb, numbers(side).filter(|number| color(*number) == at));
        }
        let pixel = |center: DVec2| {
            let parts = shares(side, center.dot(across()), 1.0, square_below);
            mix(parts.map(|(number, share)| (COLORS[color(number)], share)))
        };
        let values = centers(side).map(pixel).collect();
        Known { scene: scene(&(text + "WorldEnd")), values }
    }

    /// A floor under a white sky beside a long black wall: the sky that it sees. Six dimensions.
    fn wall(side: u32) -> Known {
        // The wall stands at x = 0, two units high; the film is parallel to the floor, from 0.2 to 1.8 before the wall.
        const HEIGHT: f64 = 2.0;
        let text = format!(
            "LookAt 1 1 0  1 0 0  0 0 1 Camera \"orthographic\" \"float screenwindow\" [-0.8 0.8 -0.8 0.8]
             Film \"image\" \"integer xresolution\" {side} \"integer yresolution\" {side} Integrator \"directlighting\"
             WorldBegin LightSource \"infinite\" \"rgb L\" [2 2 2]
             Material \"matte\" \"rgb Kd\" [0 0 0]
             Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [0 -1 -1e5 0 -1 1e5 0 {HEIGHT} 1e5 0 {HEIGHT} -1e5]
             Material \"matte\" \"rgb Kd\" [0.5 0.5 0.5]
             Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 0 -9 9 0 -9 9 0 9 -9 0 9] WorldEnd"
        );
        let step = 1.6 / f64::from(side);
        // The mean over a pixel, of half of one plus the cosine of the angle of the wall's top.
        let integral = |x: f64| 0.5 * (x + x.hypot(HEIGHT));
        let value = |center: DVec2| {
            let x = 1.0 + center.x * step;
            [(integral(x + 0.5 * step) - integral(x - 0.5 * step)) / step; 3]
        };
        let values: Vec<_> = centers(side).map(value).collect();
        Known { scene: scene(&text), values }
    }

    /// Against the mean of many samples.
    #[test]
    fn pictures_are_as_they_are_said_to_be() {
        let all = [edges(12), tinted(12), lens(12), wall(12), plain(12), fireflies(12)];
        for (number, known) in all.into_iter().enumerate() {
            let mut scene = known.scene;
            scene.view.sampler = Sampler { kind: lookat_scene::SamplerKind::SOBOL, samples_per_pixel: 4096 };
            let image =
                lookat_render::render(&scene, &Default::default(), &|_| ControlFlow::Continue(())).image;
            let (mut sum, mut most) = (0.0, 0.0_f64);
            let rgb = image.rgb().unwrap_or_default();
            for (found, value) in rgb.iter().zip(&known.values) {
                let errors = [0, 1, 2].map(|c| f64::from(found[c]) - value[c]);
                sum += errors.iter().sum::<f64>() / (3.0 * rgb.len() as f64);
                most = errors.into_iter().fold(most, |most, error| most.max(error.abs()));
            }
            // Noise, and its mean; a hundred times as much where samples are a hundred times as bright.
            let brightest = if number == 5 { 100.0 } else { 1.0 };
            assert!(most < 0.008 * brightest, "{number}: {most}");
            assert!(sum.abs() < 0.0005 * brightest, "{number}: {sum}");
        }
    }

    /// As many pixels as promised are within the target, at 99 %, of each kind of picture that keeps its promise.
    #[test]
    fn targets_are_reached() {
        let target = lookat_render::TargetError { relative: 0.1, confidence: 0.95 };
        let all = [edges(60), tinted(60), lens(60), wall(60), plain(60)];
        for (number, known) in all.into_iter().enumerate() {
            let (pixels, _) = judge(&known, target, 1);
            let [share, bound] = Stratum::count(&pixels, |_| true).coverage();
            assert!(share >= 0.95 && bound >= 0.94, "{number}: {share}, at least {bound}");
        }
    }
}
