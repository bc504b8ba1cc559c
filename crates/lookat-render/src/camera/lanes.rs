//! Camera rays side by side.

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::{DVec2, DVec3};
use lookat_scene::{Lens, Projection};

use super::{CameraRays, around};
use crate::lanes::{LANES, Vec2x8, Vec3x8};
use crate::warp::lanes::square_to_disk;

/// What sends camera rays.
#[derive(Clone, Copy)]
pub(crate) struct Viewer<'v> {
    pub camera: &'v CameraRays,
    /// From one sample to the next, in pixels.
    pub spacing: f64,
}

/// Where camera rays of samples come from.
#[derive(Clone, Copy)]
pub(crate) struct Views<'v> {
    pub of: Viewer<'v>,
    /// Of each sample its place on the film, and what chooses the point on the lens.
    pub places: &'v [(DVec2, DVec2)],
    /// Which of the samples are side by side.
    pub samples: &'v [u16],
    /// Those of them whose rays have not passed anything, as bits.
    pub direct: u64,
}

impl Views<'_> {
    /// Origins and directions, of any length, of the neighbors of the rays to the right and below, through the same points of the lens.
    #[inline(always)]
    pub fn neighbors<S: Simd>(&self, simd: S) -> [(Vec3x8<S>, Vec3x8<S>); 2] {
        let mut places = [[0.0; LANES]; 4];
        for (lane, sample) in self.samples.iter().enumerate() {
            let (film, on_lens) = self.places[usize::from(*sample)];
            for (own, place) in places.iter_mut().zip([film.x, film.y, on_lens.x, on_lens.y]) {
                own[lane] = place;
            }
        }
        let [x, y, u, v]: [f64x8<S>; 4] = places.map(
            #[inline(always)]
            |places| places.simd_into(simd),
        );
        let Viewer { camera, spacing } = self.of;
        let lines = |film| camera.lines(simd, film, Some([u, v]));
        [lines([x + spacing, y]), lines([x, y + spacing])]
    }
}

impl CameraRays {
    /// Origins and directions of the rays that [`CameraRays::ray`] gives, to the bit.
    #[inline(always)]
    pub fn rays<S: Simd>(&self, simd: S, film: Vec2x8<S>, u: Option<Vec2x8<S>>) -> (Vec3x8<S>, Vec3x8<S>) {
        let (o, d) = self.lines(simd, film, u);
        (o, d.normalize())
    }

    /// The same with directions of any length.
    #[inline(always)]
    fn lines<S: Simd>(&self, simd: S, film: Vec2x8<S>, u: Option<Vec2x8<S>>) -> (Vec3x8<S>, Vec3x8<S>) {
        let (start, step, middle) = (self.start, self.step, self.film_middle);
        let [x, y] = film;
        let p = [start.x + step.x * (x - middle.x), start.y + step.y * (y - middle.y)];
        let (zero, one): (f64x8<S>, f64x8<S>) = (0.0.simd_into(simd), 1.0.simd_into(simd));
        let (o, d) = match (self.projection, self.lens.zip(u)) {
            (Projection::Environment, _) => {
                let mut d = Vec3x8::splat(simd, DVec3::ZERO);
                for lane in 0..LANES {
                    d.put(lane, around(DVec2::new(x[lane], y[lane]) / (self.film_middle * 2.0)));
                }
                (Vec3x8::splat(simd, DVec3::ZERO), d)
            }
            (Projection::Perspective { .. }, None) => {
                (Vec3x8::splat(simd, DVec3::ZERO), Vec3x8 { x: p[0], y: p[1], z: one })
            }
            (Projection::Perspective { .. }, Some((lens, u))) => through_lens([zero; 2], p, lens, u),
            (Projection::Orthographic { .. }, None) => {
                (Vec3x8 { x: p[0], y: p[1], z: zero }, Vec3x8::splat(simd, DVec3::Z))
            }
            (Projection::Orthographic { telecentric: true }, Some((lens, u))) => {
                through_lens(p, [zero; 2], lens, u)
            }
            (Projection::Orthographic { telecentric: false }, Some((lens, u))) => {
                let (x, y) = (p[0] + self.middle.x, p[1] + self.middle.y);
                let center = [(-self.middle.x).simd_into(simd), (-self.middle.y).simd_into(simd)];
                let focal = lens.focal_distance;
                through_lens(center, [x / focal, y / focal], lens, u)
            }
        };
        (Vec3x8::splat(simd, self.eye) + o.by(&self.world_from_camera), d.by(&self.world_from_camera))
    }
}

/// As [`super::through_lens`].
#[inline(always)]
fn through_lens<S: Simd>(
    center: Vec2x8<S>,
    slope: Vec2x8<S>,
    lens: Lens,
    u: Vec2x8<S>,
) -> (Vec3x8<S>, Vec3x8<S>) {
    let [x, y] = square_to_disk(u);
    let (x, y) = (x * lens.radius, y * lens.radius);
    let simd = x.token();
    let o = Vec3x8 { x: center[0] + x, y: center[1] + y, z: 0.0.simd_into(simd) };
    let focal = lens.focal_distance;
    if focal >= lens.radius {
        (o, Vec3x8 { x: slope[0] - x / focal, y: slope[1] - y / focal, z: 1.0.simd_into(simd) })
    } else {
        (o, Vec3x8 { x: slope[0] * focal - x, y: slope[1] * focal - y, z: focal.simd_into(simd) })
    }
}
