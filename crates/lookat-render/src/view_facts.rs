//! Facts about what a view shows, from a few thousand probe rays: shapes, depths, closed shapes around the eye; and the shape at one
//! position of the picture.

mod lights;

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{MaterialKind, PixelBounds, Primitive, View, syntax::Span};
use rayon::prelude::*;

use crate::camera::CameraRays;
use crate::integrator::world::pass_interfaces;
use crate::prepare::{Prepared, corners_of_shape};
use crate::ray::{ElementId, Hit, Ray};
use crate::surface::Surface;
use crate::traceable::Traceable;
pub use lights::{LightFacts, LightPlace};

/// Probe rays of a view: places of the crop window, evenly distributed.
const PROBES: u32 = 4096;
/// The steps of the R2 sequence (Roberts 2018).
const R2: DVec2 = DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_3);

/// Facts about a view. Positions are in world space, depths are z in camera space.
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
struct ProbeHit<'s> {
    ray: Ray,
    surface: Surface<'s>,
    depth: f64,
}

impl Prepared {
    /// Facts about a view of this world. If the camera is far from the origin of coordinates, rounding is coarser: see
    /// [`Prepared::look`].
    pub fn facts(&self, view: &View) -> ViewFacts {
        let (traceable, camera) = (&self.traceable, self.camera(view));
        let probe = |film: DVec2| probe_hit(traceable, view, &camera, film);
        let probes: Vec<Option<ProbeHit>> =
            (0..PROBES).into_par_iter().map(|i| probe(place(view.film.crop, i))).collect();
        let mut shapes = Numbered::new(traceable);
        let mut of_shape: Vec<Vec<&ProbeHit>> = vec![Vec::new(); shapes.all.len()];
        for seen in probes.iter().flatten() {
            let number = shapes.number(key(seen.surface.element));
            of_shape.resize_with(shapes.all.len(), Vec::new);
            of_shape[number].push(seen);
        }
        for (shape, seen) in shapes.all.iter_mut().zip(&of_shape) {
            shape.add_hits(seen, traceable.origin);
        }
        let hits: Vec<&ProbeHit> = probes.iter().flatten().collect();
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
            inside: enclosing_shape(traceable, camera.eye, None).map(|key| shapes.number(key)),
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
        let all = measured(traceable);
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
fn probe_hit<'s>(
    traceable: &'s Traceable,
    view: &View,
    camera: &CameraRays,
    film: DVec2,
) -> Option<ProbeHit<'s>> {
    let mut ray = camera.ray(film, DVec2::splat(0.5));
    let mut found = traceable.nearest(&ray);
    let passes =
        |hit: &Hit| traceable.is_passed(hit) && traceable.primitive(hit.element.primitive).emission.is_none();
    pass_interfaces(traceable, &mut ray, &mut found, passes, |_, _| {});
    let surface = Surface::new(traceable, &ray, &found?);
    let depth = depth(view, surface.p - camera.eye);
    Some(ProbeHit { ray, surface, depth })
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

/// Rays in all directions.
const RAYS: u32 = 64;
/// The most surfaces along a ray.
const MOST_HITS: usize = 64;

/// The closed shape around a point, relative to the origin: the one that rays in all directions meet an odd number of times, and of
/// several the one that they leave first. `except` does not count.
fn enclosing_shape(traceable: &Traceable, p: DVec3, except: Option<(u32, u32)>) -> Option<(u32, u32)> {
    // Of each shape how many rays meet it an odd number of times, and the sum of the distances at which they do first.
    let mut odd: BTreeMap<(u32, u32), (u32, f64)> = BTreeMap::new();
    for i in 0..RAYS {
        let mut met: BTreeMap<(u32, u32), (u32, f64)> = BTreeMap::new();
        let mut ray = Ray::new(p, direction(i));
        for _ in 0..MOST_HITS {
            let Some(hit) = traceable.nearest(&ray) else { break };
            let surface = Surface::new(traceable, &ray, &hit);
            let distance = surface.p.distance(p);
            met.entry(key(surface.element)).or_insert((0, distance)).0 += 1;
            ray = surface.spawn_ray(ray.d);
        }
        let is_odd = |(key, (count, _)): &((u32, u32), (u32, f64))| Some(*key) != except && count % 2 == 1;
        for (key, (_, distance)) in met.into_iter().filter(is_odd) {
            let entry = odd.entry(key).or_default();
            *entry = (entry.0 + 1, entry.1 + distance);
        }
        // Most points are outside of everything.
        if odd.values().all(|(count, _)| *count <= i) {
            return None;
        }
    }
    let closed = odd.into_iter().filter(|(_, (count, _))| *count == RAYS);
    // Of equals, the first.
    closed.min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b)).map(|(key, _)| key)
}

/// Directions that cover the sphere evenly (a Fibonacci lattice).
fn direction(i: u32) -> DVec3 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(RAYS);
    let (sin, cos) = (libm::sin(TAU * GOLDEN * f64::from(i)), libm::cos(TAU * GOLDEN * f64::from(i)));
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * cos, radius * sin, z)
}

/// The most shapes that are measured unless they are seen.
const MOST: usize = 4096;

/// A shape of the world, or an instance of an object.
#[derive(Debug, Clone)]
pub struct ShapeFacts {
    /// The place of its directive. An instance has the place of the first shape of its object. `None` for a shape made in code.
    pub span: Option<Span>,
    /// Two opposite corners of its box.
    pub bounds: [DVec3; 2],
    /// True if the shape emits light.
    pub is_emitter: bool,
    /// True if no light passes its surface.
    pub is_opaque: bool,
    /// The share of the picture that shows it.
    pub share: f64,
    /// True if light that it emits is seen. It is not where only the back of a light is in view.
    pub glows: bool,
    /// The least, the median and the largest depth of what is seen of it.
    pub depths: Option<[f64; 3]>,
    /// The plane that holds all that is seen of it.
    pub flat: Option<Flat>,
    /// The numbers of its instance and of its first primitive.
    key: (u32, u32),
}

/// A plane: a point of it, and its unit normal on the side of the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flat {
    /// A point.
    pub p: DVec3,
    /// The normal.
    pub n: DVec3,
}

/// The key that identifies a shape: an instance as a whole, or the primitive of another shape.
fn key(element: ElementId) -> (u32, u32) {
    (element.instance, if element.instance == ElementId::WORLD { element.primitive } else { 0 })
}

/// The shapes of a world, or as many of them as are measured at most.
fn measured(traceable: &Traceable) -> Vec<ShapeFacts> {
    let (primitives, instances) = (traceable.source.primitives.len(), traceable.instances.len());
    let every = (primitives + instances).div_ceil(MOST).max(1);
    let of_world = (0..primitives as u32).map(|primitive| (ElementId::WORLD, primitive));
    let all = of_world.chain((0..instances as u32).map(|instance| (instance, 0)));
    all.step_by(every).filter_map(|key| ShapeFacts::new(traceable, key)).collect()
}

impl ShapeFacts {
    /// `None` for a mesh without area, which cannot be seen.
    fn new(traceable: &Traceable, key: (u32, u32)) -> Option<ShapeFacts> {
        let (instance, primitive) = key;
        let (number, bounds) = match traceable.instance(instance) {
            Some(placed) => {
                let group = &traceable.objects[placed.object];
                let (low, high) = placed.bounds(group.bvh.bounds).corners();
                (
                    traceable.first_of_objects[placed.object],
                    [low, high].map(|corner| corner + traceable.origin),
                )
            }
            None => (primitive, corners_of_shape(traceable.primitive(primitive))?),
        };
        let own = traceable.primitive(number);
        Some(ShapeFacts {
            span: own.span,
            bounds,
            is_emitter: own.emission.is_some(),
            is_opaque: own.cutout.is_none() && is_opaque(own.material.kind()),
            share: 0.0,
            glows: false,
            depths: None,
            flat: None,
            key,
        })
    }

    /// The largest side of its box.
    pub fn size(&self) -> f64 {
        (self.bounds[1] - self.bounds[0]).max_element()
    }

    /// True if the box of the shape is nearly flat.
    pub fn is_thin(&self) -> bool {
        (self.bounds[1] - self.bounds[0]).min_element() < 0.01 * self.size()
    }

    /// Adds what probe rays have seen of it.
    fn add_hits(&mut self, seen: &[&ProbeHit], origin: DVec3) {
        self.share = seen.len() as f64 / f64::from(PROBES);
        self.glows = seen.iter().any(|seen| seen.surface.le(-seen.ray.d) != Vec3::ZERO);
        self.depths = spread(&sorted(seen.iter().map(|seen| seen.depth).collect()));
        let Some(first) = seen.first() else { return };
        let n = first.surface.n * -first.surface.n.dot(first.ray.d).signum();
        let is_in_plane = |seen: &&&ProbeHit| {
            let off = (seen.surface.p - first.surface.p).dot(n).abs();
            seen.surface.n.dot(n).abs() > 1.0 - 1e-9 && off <= 1e-6 * self.size()
        };
        let is_flat = seen.iter().all(|seen| is_in_plane(&seen));
        self.flat = is_flat.then(|| Flat { p: first.surface.p + origin, n });
    }
}

/// True if no light passes a surface of this material.
fn is_opaque(material: &MaterialKind) -> bool {
    match material {
        MaterialKind::Matte(_)
        | MaterialKind::Metal(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Plastic(_)
        | MaterialKind::Substrate(_) => true,
        MaterialKind::Mix(mix) => mix.materials.iter().all(|material| is_opaque(material.kind())),
        _ => false,
    }
}

/// A shape at a place of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Picked<'p> {
    /// The shape, with the place of its directive. An instance gives a shape of its object.
    pub primitive: &'p Primitive,
    /// The point that is seen, in the world.
    pub p: DVec3,
    /// The unit normal there, on the side of the eye.
    pub n: DVec3,
    /// The z of the point in camera space: the focal distance at which it is sharp. Negative behind an environment camera.
    pub depth: f64,
}

impl Prepared {
    /// The shape that a view shows at `film`, in pixels from the top left corner of the full picture, through the middle of
    /// the lens. Surfaces without a material are seen, holes are not. `None` where there is nothing.
    pub fn pick(&self, view: &View, film: DVec2) -> Option<Picked<'_>> {
        let camera = self.camera(view);
        let ray = camera.ray(film, DVec2::splat(0.5));
        let hit = self.traceable.nearest(&ray)?;
        let Surface { p, n, primitive, .. } = Surface::new(&self.traceable, &ray, &hit);
        Some(Picked {
            primitive,
            p: p + self.traceable.origin,
            n: if n.dot(ray.d) > 0.0 { -n } else { n },
            depth: depth(view, p - camera.eye),
        })
    }
}

/// The z in camera space of a point, given relative to the eye.
pub(crate) fn depth(view: &View, from_eye: DVec3) -> f64 {
    view.camera.world_from_camera.inverse().vector(from_eye).z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::Prepared;
    use crate::ray::ElementId;
    use crate::testing::scene;
    use lookat_scene::load_str;

    #[test]
    fn of_shapes_in_one_place_the_first_is_around() {
        let boxes = "Shape \"trianglemesh\" \"point P\" [-1 -1 -1 3 -1 -1 -1 3 -1 -1 -1 3]
            \"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]"
            .repeat(4);
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" WorldBegin Translate 9 9 9 {boxes} WorldEnd"
        ));
        let traceable = Prepared::new(&scene).traceable;
        let p = DVec3::splat(9.0) - traceable.origin;
        assert_eq!(enclosing_shape(&traceable, p, None), Some((ElementId::WORLD, 0)));
    }

    #[test]
    fn shapes_are_picked_with_their_lines() {
        let loaded = load_str(
            "LookAt 0 0 -10 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 60 \"float lensradius\" 1
            Film \"image\" \"integer xresolution\" 60 \"integer yresolution\" 60 Sampler \"sobol\" Integrator \"path\" WorldBegin
            LightSource \"infinite\"
            ObjectBegin \"o\"
              Shape \"disk\"
            ObjectEnd Translate -2 0 0
            Shape \"sphere\"
            Translate 4 0 1 ObjectInstance \"o\" WorldEnd",
        );
        let scene = loaded.scene.unwrap();
        let prepared = Prepared::new(&scene);
        let pixels = 30.0 / 30_f64.to_radians().tan();
        let pick = |x: f64, z: f64| {
            let film = DVec2::new(30.0 + pixels * x / (10.0 + z), 30.0);
            let Picked { primitive, p, n, depth } = prepared.pick(&scene.view, film)?;
            assert!((n.z + 1.0).abs() < 0.1 && (p.x - x).abs() < 0.2, "{p} {n}");
            Some((loaded.sources.location(primitive.span.unwrap()).line, depth))
        };
        let (line, depth) = pick(-1.8, -1.0).unwrap();
        assert!(line == 7 && (depth - 9.0).abs() < 0.05, "{line} {depth}");
        let (line, depth) = pick(2.0, 1.0).unwrap();
        assert!(line == 5 && (depth - 11.0).abs() < 1e-9, "{line} {depth}");
        assert_eq!(pick(0.0, 0.0), None);
    }
}
