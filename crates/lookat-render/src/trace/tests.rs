use fearless_simd::{Simd, prelude::*};
use glam::{DVec2, DVec3};
use lookat_scene::Shape;

use super::rays::{HitColumns, Hits, OneRay, RayColumns};
use crate::columns::MOST;
use crate::curved::Curved;
use crate::number::LANES;
use crate::prepare::Prepared;
use crate::ray::{ElementId, Hit, Ray};
use crate::surface::Surface;
use crate::testing::{levels, noise, scene};
use crate::traceable::{NonTriangle, Traceable};

/// Instances of one shape alone have no tree of their own: what is met is the same.
#[test]
fn single_shapes_are_met_in_instances() {
    let curve = "Shape \"curve\" \"point P\" [-1 0 0 -.3 .5 0 .3 -.5 0 1 0 0] \"float width\" .3 \"integer splitdepth\" 0";
    for (shape, placed) in [
        ("Shape \"disk\"", "Rotate 40 1 2 0"),
        ("Shape \"cylinder\"", "Scale 2 1 .5 Rotate 70 1 0 1"),
        (curve, ""),
    ] {
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
            ObjectBegin \"one\" {shape} ObjectEnd Translate .2 0 3 {placed} ObjectInstance \"one\"
            Translate 0 0 -1 ObjectInstance \"one\" WorldEnd"
        ));
        for level in levels() {
            let mut traceable = Prepared::new(&scene).traceable;
            traceable.level = level;
            let mut met = 0;
            for case in 0..2000 {
                let d = DVec3::new(noise(case, 1.1), noise(case, 2.3), 2.0).normalize();
                let t_max = if case % 3 == 0 { 3.0 } else { f64::INFINITY };
                let ray = Ray { t_max, ..Ray::new(DVec3::ZERO, d) };
                let name = |hit: Hit| (hit.element, hit.t.to_bits());
                let hit = traceable.nearest(&ray).map(name);
                assert_eq!(hit, traceable.nearest_by_all(&ray).map(name), "{shape} {ray:?}");
                assert_eq!(traceable.occluded(&ray), hit.is_some());
                met += u32::from(hit.is_some());
            }
            assert!(met > 20, "{shape} {met}");
        }
    }
}

/// Triangles with the same place, in the world and in instances, and of the same number in two objects: what a ray leaves is
/// told from all of them.
#[test]
fn a_ray_leaves_one_triangle_of_many_with_its_place() {
    let triangle = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-1 -1 0 1 -1 0 0 1 0]";
    let scene = scene(&format!(
        "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
        ObjectBegin \"a\" {triangle} ObjectEnd ObjectBegin \"b\" {triangle} ObjectEnd {triangle}
        Translate 0 0 1 ObjectInstance \"a\" Translate 0 0 1 ObjectInstance \"a\"
        Translate 0 0 1 ObjectInstance \"b\" Translate 0 0 1 {triangle} WorldEnd"
    ));
    for level in levels() {
        let mut traceable = Prepared::new(&scene).traceable;
        traceable.level = level;
        for (start, d) in [(-1.0, DVec3::Z), (5.0, DVec3::NEG_Z)] {
            let mut ray = Ray::new(DVec3::new(0.1, 0.1, start), d);
            let mut met = Vec::new();
            while let Some(hit) = traceable.nearest(&ray) {
                assert!(traceable.occluded(&ray) && traceable.nearest_by_all(&ray).is_some());
                let surface = Surface::new(&traceable, &ray, &hit);
                assert!((surface.p.z - start - d.z * (met.len() as f64 + 1.0)).abs() < 1e-9);
                met.push(hit.element);
                ray = surface.spawn_ray(d);
            }
            assert!(!traceable.occluded(&ray));
            assert_eq!(met.len(), 5, "{met:?}");
        }
    }
}

/// What `f32` alone tells is in the way, is so in `f64`: from surfaces to others, which are left out, to what is just before
/// them, and to places in space. Among triangles of all sizes, in the world and in an instance, and with duplicates, some with holes.
#[test]
fn shadows_are_those_of_f64() {
    let mut mesh = String::from("Shape \"trianglemesh\" \"integer indices\" [");
    (0..3 * 300).for_each(|at| mesh += &format!("{at} "));
    mesh += "] \"point P\" [";
    for at in 0..300 {
        let size = 10_f64.powi(at as i32 % 4 - 3);
        let vector = |k: f64| DVec3::new(noise(at, k), noise(at, k + 0.3), noise(at, k + 0.7));
        let middle = vector(1.1);
        for corner in [2.3, 3.1, 4.7] {
            let p = middle + vector(corner) * size;
            mesh += &format!("{} {} {} ", p.x, p.y, p.z);
        }
    }
    mesh += "]";
    let scene = scene(&format!(
        "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
        Texture \"h\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4
        ObjectBegin \"a\" {mesh} ObjectEnd {mesh} {mesh}
        Translate -.7 .3 -.2 {mesh} \"texture alpha\" \"h\" Translate .2 .5 -.4 {mesh} \"float shadowalpha\" 0
        Translate 1 .2 .1 Scale 2 .5 1 Rotate 30 1 2 3 ObjectInstance \"a\" WorldEnd"
    ));
    let at = |level| {
        let mut traceable = Prepared::new(&scene).traceable;
        traceable.level = level;
        traceable
    };
    let of_levels: Vec<Traceable> = levels().into_iter().map(at).collect();
    let traceable = &of_levels[0];
    let vector = |i: usize, k: f64| DVec3::new(noise(i, k), noise(i, k + 0.3), noise(i, k + 0.7));
    let surface = |i: usize| {
        let ray = Ray::new(vector(i, 6.1) * 3.0, (vector(i, 7.3) - vector(i, 6.1) * 3.0).normalize());
        traceable.nearest(&ray).map(|hit| Surface::new(traceable, &ray, &hit))
    };
    let mut counts = [0; 2];
    for case in 0..20_000 {
        let (Some(from), Some(to)) = (surface(case), surface(case + 20_000)) else { continue };
        let between = to.p - from.p;
        let distance = between.length();
        if distance < 1e-6 {
            continue;
        }
        let t_max = distance - from.magnitude.max(to.magnitude) * 2_f64.powi(-38);
        let (target, t_max) = match case % 3 {
            0 => (to.element, t_max),
            1 => (ElementId::NONE, t_max * (1.0 - 1e-9)),
            _ => (ElementId::NONE, t_max * 1.5),
        };
        let ray = Ray { t_max, target, ..from.spawn_ray(between / distance) };
        let occluded = traceable.occluded_by_all(&ray);
        assert!(of_levels.iter().all(|traceable| traceable.occluded(&ray) == occluded), "{ray:?}");
        counts[usize::from(occluded)] += 1;
    }
    assert!(counts.iter().all(|count| *count > 1_000), "{counts:?}");
}

/// Rays of all kinds: along axes and in planes, at vertices and edges, short ones, those that leave a triangle or a curved shape, those that go
/// to a light or a point, which may be on a curved shape, and some out of the range of `f32`.
fn ray(scene: &Traceable, i: usize) -> Ray {
    let vector = |k: f64| DVec3::new(noise(i, k), noise(i, k + 0.3), noise(i, k + 0.7));
    let triangles = &scene.world.triangles;
    let place = i * 7919 % triangles.len();
    let triangle = &triangles[place];
    let [p, q, r] = triangle.corners;
    let target = match i % 4 {
        0 => p,
        1 => p + (q - p) * noise(i, 9.0).abs(),
        _ => vector(2.0) * 0.5 + 0.5,
    };
    let o = vector(4.0) * DVec3::new(1.0, 1.0, 2.0);
    let o = match i % 77 {
        0 => o * 1e24,
        1 => o * 1e9,
        at if at % 11 == 0 => o.with_z(0.0),
        _ => o,
    };
    let d = (target - o).normalize_or(DVec3::Z);
    let d = match i % 13 {
        0 => DVec3::Z * d.z.signum(),
        1 => DVec3::new(d.x, 0.0, d.z).normalize_or(DVec3::X),
        2 => DVec3::new(-0.0, d.y, 1e-30).normalize_or(DVec3::X),
        _ => d,
    };
    let mut ray = Ray { time: noise(i, 3.7).abs(), ..Ray::new(o, d) };
    if i.is_multiple_of(3) {
        ray.t_max = (target - o).length() * [1.0, 0.999, 3.0][i % 9 / 3];
    }
    if i.is_multiple_of(5) {
        (ray.o, ray.leaving_place) = ((p + q + r) / 3.0, place as u32);
        ray.leaving = ElementId { instance: ElementId::WORLD, ..ElementId::NONE };
    }
    let curved: Vec<(u32, &Curved)> = scene
        .world
        .non_triangles
        .iter()
        .filter_map(|other| match *other {
            NonTriangle::Curved { primitive, shape } => Some((primitive, &scene.curved[shape as usize])),
            _ => None,
        })
        .collect();
    let on_curved = |k: f64| {
        let (primitive, shape) = *curved.get(i * 31 % curved.len().max(1))?;
        let own = shape.sample(DVec2::new(noise(i, k).abs(), noise(i, k + 0.2).abs()));
        Some((shape.placed(own).0, ElementId { instance: ElementId::WORLD, primitive, index: 0 }))
    };
    if let Some((p, element)) = on_curved(7.7).filter(|_| i % 15 == 5) {
        (ray.o, ray.leaving_place, ray.leaving) = (p, Hit::NO_PLACE, element);
    }
    if let Some((p, _)) = on_curved(8.8).filter(|_| i.is_multiple_of(21)) {
        ray.d = (p - ray.o).normalize_or(DVec3::Z);
        ray.t_max = (p - ray.o).length();
    }
    if i % 8 == 3 {
        // Leaves whatever curve it would hit.
        let hit = scene
            .nearest_by_all(&ray)
            .filter(|hit| matches!(scene.primitive(hit.element.primitive).shape, Shape::Curve(_)));
        if let Some(hit) = hit.filter(|hit| hit.element.instance == ElementId::WORLD) {
            (ray.o, ray.leaving_place, ray.leaving) = (ray.at(hit.t), Hit::NO_PLACE, hit.element);
            ray.d = vector(1.7).normalize_or(DVec3::Z);
        }
    }
    if i.is_multiple_of(7) {
        ray.target = ElementId::POINT_LIGHT;
        if !i.is_multiple_of(2) {
            // The ray does not go beyond its target.
            let [a, b] = [noise(i, 5.5).abs(), noise(i, 6.5).abs()];
            let end = p + (q - p) * a + (r - p) * ((1.0 - a) * b);
            ray.d = (end - ray.o).normalize_or(DVec3::Z);
            ray.t_max = (end - ray.o).length() * [1.0, 0.999][i / 14 % 2];
            ray.target = triangle.element(ElementId::WORLD);
        }
    }
    ray
}

/// Rays that are traced together.
pub(super) struct Batch {
    pub all: Vec<Ray>,
    pub rays: RayColumns,
    /// Bits of those that count.
    pub active: u64,
}

impl Batch {
    /// The rays of a case. `leaving`: the number of the element that a ray leaves.
    pub fn new(scene: &Traceable, case: usize, leaving: impl Fn(&Ray) -> f64) -> Self {
        let all: Vec<Ray> = (0..MOST).map(|k| ray(scene, case * MOST + k)).collect();
        let (mut rays, mut active) = (RayColumns::new(), 0);
        for (at, ray) in all.iter().enumerate() {
            let Ray { o, d, t_max, target, time, .. } = *ray;
            let (leaving, leaving_instance) = (leaving(ray), ElementId::WORLD);
            let target = scene.labels.of(target);
            rays.set(at, &OneRay { o, d, t_max, leaving, leaving_instance, target, time });
            active |= u64::from(at % LANES < [LANES, 5, 0][(case + at / LANES) % 3]) << at;
        }
        Batch { all, rays, active }
    }

    /// Checks each ray against all elements. Returns the number of hits. `hit`: one of eight hits.
    pub fn check<S: Simd>(
        &self,
        simd: S,
        scene: &Traceable,
        hits: &HitColumns,
        occluded: u64,
        hit: impl Fn(&Hits<S>, usize) -> Hit,
    ) -> usize {
        let mut met = 0;
        for (at, ray) in self.all.iter().enumerate() {
            let (hits, lane) = (hits.eight(simd, at / LANES * LANES), at % LANES);
            if self.active >> at & 1 == 0 {
                assert!(hits.element[lane] < 0.0 && occluded >> at & 1 == 0);
                continue;
            }
            let name =
                |hit: Hit| (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits), hit.place);
            let own = (hits.element[lane] >= 0.0).then(|| hit(&hits, lane));
            assert_eq!(own.map(name), scene.nearest_by_all(ray).map(name), "{ray:?}");
            assert_eq!(own.is_some_and(|hit| scene.emits(&hit)), hits.emits.to_bitmask() >> lane & 1 == 1);
            assert_eq!(occluded >> at & 1 == 1, scene.occluded_by_all(ray), "{ray:?}");
            met += usize::from(own.is_some());
        }
        met
    }
}
