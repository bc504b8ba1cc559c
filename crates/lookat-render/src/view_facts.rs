//! Facts about what a view shows, from a few thousand probe rays.

mod enclosure;
mod lights;
mod shapes;

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use lookat_scene::{PixelBounds, View};
use rayon::prelude::*;

use crate::camera::CameraRays;
use crate::pick::depth;
use crate::prepare::Prepared;
use crate::ray::Ray;
use crate::surface::Surface;
use crate::traceable::Traceable;
pub use lights::{LightFacts, LightPlace};
pub use shapes::{Flat, ShapeFacts};

/// Probe rays of a view: places of the crop window, evenly distributed.
const PROBES: u32 = 4096;
/// The steps of the R2 sequence (Roberts 2018).
const R2: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
/// The most surfaces without a material that a probe ray passes.
const MOST_PASSED: usize = 100;

/// What a view shows. Positions are in world space, depths are z in camera space.
#[derive(Debug, Clone)]
pub struct ViewFacts {
    /// The eye: the middle of the lens of a perspective camera, the middle of the window of an orthographic one.
    pub eye: DVec3,
    /// Two opposite corners of the box around all shapes. `None` without shapes.
    pub bounds: Option<[DVec3; 2]>,
    /// The shapes of the world and the instances of objects: all that probe rays hit, and up to 4096 in all.
    pub shapes: Vec<ShapeFacts>,
    /// The share of the picture that shows shapes that emit no light.
    pub shape_share: f64,
    /// The share that shows shapes that emit light.
    pub emitter_share: f64,
    /// The share that shows no shape.
    pub sky_share: f64,
    /// The depths at which probe rays see something, sorted.
    pub depths: Vec<f64>,
    /// The depth at the middle of the picture. `None` if nothing is there.
    pub center_depth: Option<f64>,
    /// The number in `shapes` of the smallest closed shape around the eye.
    pub inside: Option<usize>,
    /// The lights of the world.
    pub lights: Vec<LightFacts>,
}

impl ViewFacts {
    /// The median of the depths. `None` if nothing is seen.
    pub fn median_depth(&self) -> Option<f64> {
        spread(&self.depths).map(|[_, median, _]| median)
    }
}

/// A point that a probe ray has hit.
struct Seen<'s> {
    ray: Ray,
    surface: Surface<'s>,
    depth: f64,
}

impl Prepared {
    /// Facts about a view of this world. A view from another cell prepares the world again.
    pub fn facts(&mut self, view: &View) -> ViewFacts {
        self.look(&view.camera);
        self.facts_unmoved(view)
    }

    /// The same without preparing the world again. From another cell, coordinates are rounded otherwise.
    pub fn facts_unmoved(&self, view: &View) -> ViewFacts {
        let (traceable, camera) = (&self.traceable, self.camera(view));
        let probe = |film: DVec2| seen(traceable, view, &camera, film);
        let probes: Vec<Option<Seen>> =
            (0..PROBES).into_par_iter().map(|i| probe(place(view.film.crop, i))).collect();
        let mut shapes = Numbered::new(traceable);
        let mut of_shape: Vec<Vec<&Seen>> = vec![Vec::new(); shapes.all.len()];
        for seen in probes.iter().flatten() {
            let number = shapes.number(shapes::key(seen.surface.element));
            of_shape.resize_with(shapes.all.len(), Vec::new);
            of_shape[number].push(seen);
        }
        for (shape, seen) in shapes.all.iter_mut().zip(&of_shape) {
            shape.see(seen, traceable.origin);
        }
        let hits: Vec<&Seen> = probes.iter().flatten().collect();
        let emitters = hits.iter().filter(|seen| seen.surface.primitive.emission.is_some()).count();
        let share = |count: usize| count as f64 / f64::from(PROBES);
        let crop = view.film.crop;
        let middle = DVec2::new(f64::from(crop.x0 + crop.x1), f64::from(crop.y0 + crop.y1)) * 0.5;
        let (low, high) = traceable.world.bvh.bounds.corners();
        ViewFacts {
            eye: camera.eye + traceable.origin,
            bounds: (low.x <= high.x).then(|| [low, high].map(|corner| corner + traceable.origin)),
            shape_share: share(hits.len() - emitters),
            emitter_share: share(emitters),
            sky_share: share(PROBES as usize - hits.len()),
            depths: sorted(hits.iter().map(|seen| seen.depth).collect()),
            center_depth: probe(middle).map(|seen| seen.depth),
            inside: enclosure::around(traceable, camera.eye, None).map(|key| shapes.number(key)),
            lights: lights::facts(self, &hits, |key| shapes.number(key)),
            shapes: shapes.all,
        }
    }
}

/// Shapes, found by their keys.
struct Numbered<'s> {
    traceable: &'s Traceable,
    all: Vec<ShapeFacts>,
    numbers: HashMap<(u32, u32), usize>,
}

impl<'s> Numbered<'s> {
    fn new(traceable: &'s Traceable) -> Self {
        let all = shapes::measured(traceable);
        let numbers = all.iter().enumerate().map(|(number, shape)| (shape.key, number)).collect();
        Numbered { traceable, all, numbers }
    }

    /// The number of a shape that a ray has hit. It is added if it is new.
    fn number(&mut self, key: (u32, u32)) -> usize {
        *self.numbers.entry(key).or_insert_with(|| {
            self.all.extend(ShapeFacts::new(self.traceable, key));
            self.all.len() - 1
        })
    }
}

/// The surface that a camera ray through the middle of the lens sees.
fn seen<'s>(traceable: &'s Traceable, view: &View, camera: &CameraRays, film: DVec2) -> Option<Seen<'s>> {
    let mut ray = camera.ray(film, DVec2::splat(0.5));
    for _ in 0..MOST_PASSED {
        let hit = traceable.nearest(&ray)?;
        let surface = Surface::new(traceable, &ray, &hit);
        if !traceable.is_passed(&hit) || surface.primitive.emission.is_some() {
            let depth = depth(view, surface.p - camera.eye);
            return Some(Seen { ray, surface, depth });
        }
        ray = surface.leave(ray.d);
    }
    None
}

/// The `i`-th place of the R2 sequence in a crop window, in pixels.
fn place(crop: PixelBounds, i: u32) -> DVec2 {
    let size = DVec2::new(f64::from(crop.width()), f64::from(crop.height()));
    DVec2::new(f64::from(crop.x0), f64::from(crop.y0)) + (R2 * f64::from(i + 1)).fract() * size
}

fn sorted(mut numbers: Vec<f64>) -> Vec<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers
}

/// The least, the median and the largest of sorted numbers.
fn spread(numbers: &[f64]) -> Option<[f64; 3]> {
    Some([*numbers.first()?, numbers[numbers.len() / 2], *numbers.last()?])
}
