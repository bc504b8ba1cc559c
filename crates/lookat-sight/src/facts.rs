//! Facts about what a view shows, from a few thousand camera rays: shapes, depths, closed shapes around the eye, and lights.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::TAU;

use lookat_render::{CameraRays, Irradiance, LightPlace, Prepared, Ray, ShapeId, Surface, r2_sequence};
use lookat_scene::glam::{DVec2, DVec3, Vec3};
use lookat_scene::syntax::Span;
use lookat_scene::{Light, MaterialKind, View};
use rayon::prelude::*;

use crate::media::WrongSide;

/// Camera rays of a view: places of the crop window, evenly distributed.
const PROBES: usize = 4096;
/// The most surfaces without a material that a camera ray passes through.
const MOST_PASSED: usize = 1000;
/// The most shapes that are measured unless they are seen.
const MOST_SHAPES: usize = 4096;

/// Facts about a view. Positions are in world space, depths are z in camera space.
#[derive(Clone)]
pub struct ViewFacts {
    /// The eye: the middle of the lens of a perspective camera, the middle of the window of an orthographic one.
    pub eye: DVec3,
    /// Two opposite corners of the box around all shapes. `None` without shapes.
    pub bounds: Option<[DVec3; 2]>,
    /// The shapes of the world and the instances of objects: all that camera rays hit, and up to 4096 in all.
    pub shapes: Vec<ShapeFacts>,
    /// The share of the picture that shows shapes that emit no light.
    pub shape_share: f64,
    /// The share that shows shapes that emit light.
    pub emitter_share: f64,
    /// The share that shows no shape.
    pub sky_share: f64,
    /// The depths at which camera rays see something, sorted.
    pub depths: Vec<f64>,
    /// The depth at the middle of the picture. `None` if nothing is there.
    pub center_depth: Option<f64>,
    /// The number in `shapes` of the smallest closed shape around the eye.
    pub inside: Option<usize>,
    /// The lights of the world. Empty if there are too many.
    pub lights: Vec<LightFacts>,
    /// A boundary of media that is the wrong way round.
    pub wrong_side: Option<WrongSide>,
}

/// A shape of the world, or an instance of an object.
#[derive(Clone)]
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
}

/// A plane: a point of it, and its unit normal on the side of the eye.
#[derive(Clone, Copy)]
pub struct Flat {
    pub p: DVec3,
    pub n: DVec3,
}

/// A light, and what it gives to the surfaces in view.
#[derive(Clone)]
pub struct LightFacts {
    /// The position of the light, or the middle of its box. `None` for lights without a position.
    pub position: Option<DVec3>,
    /// Its irradiance on what is in view.
    pub irradiance: Irradiance,
    /// Where it reaches no surface, the number in [`ViewFacts::shapes`] of the opaque shape around the light.
    pub inside: Option<usize>,
}

/// A point that a camera ray has hit.
struct ProbeHit<'p> {
    /// Facing the eye.
    surface: Surface<'p>,
    depth: f64,
    /// True if it emits light towards the eye.
    glows: bool,
}

impl ViewFacts {
    /// Facts about a view of a world. If the camera is far from the origin of coordinates, rounding is coarser: see
    /// [`Prepared::look`].
    pub fn new(prepared: &Prepared, view: &View) -> ViewFacts {
        let (camera, crop) = (prepared.camera(view), view.film.crop);
        let low = DVec2::new(f64::from(crop.x0), f64::from(crop.y0));
        let size = DVec2::new(f64::from(crop.width()), f64::from(crop.height()));
        let hits: Vec<ProbeHit> = (0..PROBES)
            .into_par_iter()
            .filter_map(|i| ProbeHit::new(prepared, &camera, low + r2_sequence(i) * size))
            .collect();
        let mut shapes = Shapes::new(prepared);
        let mut hits_of: Vec<Vec<&ProbeHit>> = Vec::new();
        for hit in &hits {
            let number = shapes.number(hit.surface.element.shape());
            hits_of.resize_with(shapes.all.len(), Vec::new);
            hits_of[number].push(hit);
        }
        for (shape, hits) in shapes.all.iter_mut().zip(&hits_of) {
            shape.add_hits(hits, prepared.origin());
        }
        let emitters = hits.iter().filter(|hit| hit.surface.primitive.emission.is_some()).count();
        let inside = enclosing_shape(prepared, camera.eye, None).map(|shape| shapes.number(shape));
        let surfaces: Vec<Surface> = hits.iter().map(|hit| hit.surface).collect();
        let lights = prepared.irradiance(&surfaces).into_iter();
        let lights = lights.map(|irradiance| LightFacts::new(prepared, irradiance, &mut shapes)).collect();
        ViewFacts {
            eye: camera.eye + prepared.origin(),
            bounds: prepared.bounds(),
            shape_share: share(hits.len() - emitters),
            emitter_share: share(emitters),
            sky_share: share(PROBES - hits.len()),
            depths: sorted_depths(&hits),
            center_depth: ProbeHit::new(prepared, &camera, low + size * 0.5).map(|hit| hit.depth),
            inside,
            lights,
            wrong_side: WrongSide::find(
                prepared,
                (0..PROBES).map(|i| surfaces_along(prepared, &camera, low + r2_sequence(i) * size)),
            ),
            shapes: shapes.all,
        }
    }

    /// The median of the depths. `None` if nothing is seen.
    pub fn median_depth(&self) -> Option<f64> {
        spread(&self.depths).map(|[_, median, _]| median)
    }
}

impl<'p> ProbeHit<'p> {
    /// What a camera ray through the middle of the lens sees: the first surface that has a material or emits light.
    fn new(prepared: &'p Prepared, camera: &CameraRays, film: DVec2) -> Option<ProbeHit<'p>> {
        let (ray, surface) = surfaces_along(prepared, camera, film).find(|(_, surface)| {
            let primitive = surface.primitive;
            primitive.emission.is_some() || !matches!(primitive.material.kind(), MaterialKind::None)
        })?;
        let (depth, glows) = (camera.depth(surface.p), surface.le(-ray.d) != Vec3::ZERO);
        Some(ProbeHit { surface: surface.facing(ray.d), depth, glows })
    }
}

/// The surfaces along a camera ray through the middle of the lens, each with the ray that hits it.
fn surfaces_along<'p>(
    prepared: &'p Prepared,
    camera: &CameraRays,
    film: DVec2,
) -> impl Iterator<Item = (Ray, Surface<'p>)> {
    let mut ray = camera.ray(film, DVec2::splat(0.5));
    let next = move || {
        let surface = prepared.surface(&ray, &prepared.nearest(&ray)?);
        let beyond = surface.spawn_ray(ray.d);
        Some((std::mem::replace(&mut ray, beyond), surface))
    };
    std::iter::from_fn(next).take(MOST_PASSED)
}

/// The share of the picture that so many camera rays are.
fn share(rays: usize) -> f64 {
    rays as f64 / PROBES as f64
}

fn sorted_depths<'h, 'p: 'h>(hits: impl IntoIterator<Item = &'h ProbeHit<'p>>) -> Vec<f64> {
    let mut depths: Vec<f64> = hits.into_iter().map(|hit| hit.depth).collect();
    depths.sort_by(f64::total_cmp);
    depths
}

/// The least, the median and the largest of sorted numbers.
fn spread(numbers: &[f64]) -> Option<[f64; 3]> {
    Some([*numbers.first()?, numbers[numbers.len() / 2], *numbers.last()?])
}

/// Shapes, found by their ids.
struct Shapes<'p> {
    prepared: &'p Prepared,
    all: Vec<ShapeFacts>,
    numbers: HashMap<ShapeId, usize>,
}

impl<'p> Shapes<'p> {
    /// The shapes of a world, or as many of them as are measured at most.
    fn new(prepared: &'p Prepared) -> Self {
        let mut shapes = Shapes { prepared, all: Vec::new(), numbers: HashMap::new() };
        let every = prepared.shape_ids().count().div_ceil(MOST_SHAPES).max(1);
        for id in prepared.shape_ids().step_by(every) {
            if let Some(shape) = ShapeFacts::new(prepared, id) {
                shapes.numbers.insert(id, shapes.all.len());
                shapes.all.push(shape);
            }
        }
        shapes
    }

    /// The number of a shape that a ray has hit. It is added if it is new.
    fn number(&mut self, id: ShapeId) -> usize {
        *self.numbers.entry(id).or_insert_with(|| {
            self.all.extend(ShapeFacts::new(self.prepared, id));
            self.all.len() - 1
        })
    }
}

impl ShapeFacts {
    /// `None` for a mesh without area, which cannot be seen.
    fn new(prepared: &Prepared, id: ShapeId) -> Option<ShapeFacts> {
        Some(ShapeFacts {
            span: prepared.primitive(id).span,
            bounds: prepared.shape_bounds(id)?,
            is_emitter: prepared.primitive(id).emission.is_some(),
            is_opaque: is_opaque(prepared, id),
            share: 0.0,
            glows: false,
            depths: None,
            flat: None,
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

    /// Adds what camera rays have seen of it.
    fn add_hits(&mut self, hits: &[&ProbeHit], origin: DVec3) {
        self.share = share(hits.len());
        self.glows = hits.iter().any(|hit| hit.glows);
        self.depths = spread(&sorted_depths(hits.iter().copied()));
        let Some(first) = hits.first().map(|hit| hit.surface) else { return };
        let is_in_plane = |hit: &&ProbeHit| {
            let off = (hit.surface.p - first.p).dot(first.n).abs();
            hit.surface.n.dot(first.n).abs() > 1.0 - 1e-9 && off <= 1e-6 * self.size()
        };
        let is_flat = hits.iter().all(is_in_plane);
        self.flat = is_flat.then(|| Flat { p: first.p + origin, n: first.n });
    }
}

/// True if no light passes the surface of a shape.
fn is_opaque(prepared: &Prepared, id: ShapeId) -> bool {
    fn stops_light(material: &MaterialKind) -> bool {
        match material {
            MaterialKind::Matte(_)
            | MaterialKind::Metal(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Plastic(_)
            | MaterialKind::Substrate(_)
            | MaterialKind::Subsurface(_) => true,
            MaterialKind::Mix(mix) => mix.materials.iter().all(|material| stops_light(material.kind())),
            MaterialKind::Disney(disney) => {
                disney.thin.is_none() && disney.spec_trans.constant() == Some(0.0)
            }
            MaterialKind::Fourier(_)
            | MaterialKind::Glass(_)
            | MaterialKind::Hair(_)
            | MaterialKind::None
            | MaterialKind::Translucent(_)
            | MaterialKind::Uber(_) => false,
        }
    }
    let primitive = prepared.primitive(id);
    primitive.cutout.is_none() && stops_light(primitive.material.kind())
}

impl LightFacts {
    fn new(prepared: &Prepared, irradiance: Irradiance, shapes: &mut Shapes) -> LightFacts {
        let (own, position) = match irradiance.light {
            LightPlace::Light(number) => (None, position(&prepared.world().lights[number])),
            LightPlace::Primitive(number) => {
                let own = ShapeId::Primitive(number as u32);
                (Some(own), prepared.shape_bounds(own).map(|[low, high]| (low + high) * 0.5))
            }
        };
        let around = |p: DVec3| enclosing_shape(prepared, p - prepared.origin(), own);
        let inside = position.filter(|_| !irradiance.reaches).and_then(around);
        let inside = inside.filter(|id| is_opaque(prepared, *id)).map(|id| shapes.number(id));
        LightFacts { position, irradiance, inside }
    }
}

/// The position of a light, if it has one.
fn position(light: &Light) -> Option<DVec3> {
    match light {
        Light::Point { position, .. } => Some(*position),
        Light::Spot { world_from_light, .. }
        | Light::Goniometric { world_from_light, .. }
        | Light::Projection { world_from_light, .. } => Some(world_from_light.point(DVec3::ZERO)),
        Light::Distant { .. } | Light::Infinite { .. } | Light::Environment { .. } => None,
    }
}

/// Rays in all directions.
const RAYS: u32 = 64;
/// The most surfaces along a ray.
const MOST_HITS: usize = 64;

/// The closed shape around a point, relative to the origin: the one that rays in all directions meet an odd number of times, and of
/// several the one that they leave first. `except` does not count.
fn enclosing_shape(prepared: &Prepared, p: DVec3, except: Option<ShapeId>) -> Option<ShapeId> {
    // Of each shape how many rays meet it an odd number of times, and the sum of the distances at which they do first.
    let mut odd: BTreeMap<ShapeId, (u32, f64)> = BTreeMap::new();
    for i in 0..RAYS {
        let mut met: BTreeMap<ShapeId, (u32, f64)> = BTreeMap::new();
        let mut ray = Ray::new(p, direction(i));
        for _ in 0..MOST_HITS {
            let Some(hit) = prepared.nearest(&ray) else { break };
            let surface = prepared.surface(&ray, &hit);
            met.entry(hit.element.shape()).or_insert((0, surface.p.distance(p))).0 += 1;
            ray = surface.spawn_ray(ray.d);
        }
        for (id, (count, distance)) in met {
            if Some(id) != except && count % 2 == 1 {
                let (rays, distances) = odd.entry(id).or_default();
                *rays += 1;
                *distances += distance;
            }
        }
        // Most points are outside of everything.
        if odd.values().all(|(rays, _)| *rays <= i) {
            return None;
        }
    }
    let closed = odd.into_iter().filter(|(_, (rays, _))| *rays == RAYS);
    // Of equals, the first.
    closed.min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b)).map(|(id, _)| id)
}

/// Directions that cover the sphere evenly (a Fibonacci lattice).
fn direction(i: u32) -> DVec3 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(RAYS);
    (DVec2::from_angle(TAU * GOLDEN * f64::from(i)) * (1.0 - z * z).sqrt()).extend(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_shapes_in_one_place_the_first_is_around() {
        let boxes = "Shape \"trianglemesh\" \"point P\" [-1 -1 -1 3 -1 -1 -1 3 -1 -1 -1 3]
            \"integer indices\" [0 2 1 0 1 3 0 3 2 1 2 3]"
            .repeat(4);
        let text = format!(
            "Sampler \"sobol\" Integrator \"path\" Film \"image\" Camera \"perspective\"
            WorldBegin Translate 9 9 9 {boxes} WorldEnd"
        );
        let prepared = Prepared::new(&lookat_scene::load_str(&text).scene.unwrap());
        let p = DVec3::splat(9.0) - prepared.origin();
        assert_eq!(enclosing_shape(&prepared, p, None), Some(ShapeId::Primitive(0)));
    }
}
