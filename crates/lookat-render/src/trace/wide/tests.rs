use std::array::from_fn;

use fearless_simd::{Level, Simd};
use glam::{DVec3, Vec3A};

use super::slabs::FusedSlabs;
use super::*;
use crate::bvh::{Node, within_box};
use crate::frame::Bounds;
use crate::number::side_by_side;
use crate::ray::Ray;
use crate::testing::{cases, levels, noise, scene};
use crate::trace::Tree;
use crate::trace::tests::Batch;

const LAMP: &str = "AttributeBegin AreaLightSource \"diffuse\" Translate 0 0 2 Shape \"trianglemesh\"
    \"integer indices\" [0 1 2 0 2 3] \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] AttributeEnd";

/// A wavy field of `n` x `n` vertices.
fn field_shape(n: usize) -> String {
    let heights: Vec<String> = (0..n * n)
        .map(|at| [at % n, at / n].map(|x| x as f64))
        .map(|[x, y]| format!("{:.4}", 0.1 * (0.7 * x).sin() * (0.4 * y).cos()))
        .collect();
    format!(
        "Shape \"heightfield\" \"integer nu\" {n} \"integer nv\" {n} \"float Pz\" [{}]",
        heights.join(" ")
    )
}

/// A wavy field under a lamp, with shapes on it.
fn field(shapes: &str) -> lookat_scene::Scene {
    scene(&format!(
        "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin {LAMP} {} {shapes} WorldEnd",
        field_shape(40)
    ))
}

/// Traces a case with the instructions of `simd`, and checks it. Returns the number of hits.
fn check<S: Simd>(simd: S, scene: &Traceable, tracer: &mut WideTracer, case: usize) -> usize {
    let tree = Tree { scene };
    let leaving = |ray: &Ray| match ray.leaving_place {
        Hit::NO_PLACE => tree.number(ray.leaving),
        place => f64::from(place),
    };
    let batch = Batch::new(scene, case, leaving);
    let mut hits = HitColumns::new();
    hits.clear();
    let beyond = tracer.nearest(simd, scene, &batch.rays, batch.active, &mut hits);
    let (occluded, also_beyond) = tracer.occluded(simd, scene, &batch.rays, batch.active, true);
    assert_eq!(beyond, also_beyond);
    for (at, ray) in batch.all.iter().enumerate() {
        assert_eq!(beyond >> at & 1 == 1, batch.active >> at & 1 == 1 && ray.o.abs().max_element() > 1e23);
    }
    Batch { active: batch.active & !beyond, ..batch }
        .check(simd, scene, &hits, occluded, |hits, lane| tree.hit(hits, lane))
}

/// What rays hit side by side has the same bits as what each hits among all elements, one by one.
#[test]
fn rays_hit_side_by_side_what_they_hit_alone() {
    let quadrics =
        "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .2 Translate .6 .6 0
         Shape \"sphere\" \"float radius\" .1 AttributeEnd Shape \"cylinder\" \"float radius\" .3 Translate .1 .2 .3
         Shape \"sphere\" \"float radius\" .3 Shape \"disk\" Shape \"cone\" Shape \"sphere\" \"float radius\" .25
         Shape \"curve\" \"point P\" [-1 0 0 -.3 .5 0 .3 -.5 0 1 0 0] \"float width\" .1";
    // Bends, ends of width 0, a point, and a part that is turned back.
    let curve = |kind: &str, points: &str, widths: &str| {
        format!("Shape \"curve\" \"string type\" \"{kind}\" \"point P\" [{points}] {widths}")
    };
    let (wide, thin) = ("\"float width\" .2", "\"float width0\" .1 \"float width1\" 0");
    let (bend, back) = ("-1 0 .2 -.3 1.5 .3 .3 -1.5 0 1 0 .1", "0 0 .1 1 0 .1 1 0 .3 0 .1 .3");
    let curves = &format!(
        "{} {} {} {} {} ObjectBegin \"o\" {} {} ObjectEnd Translate .3 .2 .4 Scale .5 -1 2 {}
         ObjectInstance \"o\" Rotate 40 1 2 3 ObjectInstance \"o\"",
        curve("flat", bend, wide),
        curve("cylinder", bend, thin),
        curve("cylinder", back, wide),
        curve("ribbon", bend, "\"float width\" .2 \"normal N\" [0 0 1 0 1 0]"),
        curve("flat", ".5 .5 .5 .5 .5 .5 .5 .5 .5 .5 .5 .5001", wide),
        curve("flat", back, thin),
        curve("flat", bend, thin),
        curve("flat", "0 0 0 0 1 0 0 1 0 1 1 0 1 2 .3 2 2 .1 2 1 0", thin)
    );
    // In one place, in planes of axes, so that their boxes are flat.
    let disks = "Shape \"disk\" \"float radius\" 2 Shape \"disk\" \"float radius\" 1.5 Shape \"sphere\" \"float radius\" .3
         Shape \"sphere\" \"float radius\" .3 Translate 0 0 1e-8 Shape \"disk\" \"float radius\" 1 Rotate 90 0 1 0
         Shape \"disk\" \"float radius\" 2 Shape \"disk\" \"float radius\" 2";
    let square = "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0]";
    let twice = &format!(
        "Translate 0 0 .05 {square} \"integer indices\" [0 1 2 0 2 3] {square} \"integer indices\" [1 2 0 2 3 0]"
    );
    let instances = &format!("ObjectBegin \"one\" Shape \"disk\" \"float radius\" .3 ObjectEnd
        ObjectBegin \"two\" {square} \"integer indices\" [1 2 0 2 3 0] ObjectEnd
        Translate .5 .5 .3 ObjectInstance \"one\" Rotate 30 1 2 3 ObjectInstance \"two\" Scale .5 .5 .5 ObjectInstance \"two\"");
    let object = field_shape(12);
    let objects = &format!("Texture \"holes\" \"float\" \"checkerboard\" \"float tex1\" 0 \"float tex2\" 1 \"float uscale\" 7
        \"float vscale\" 7 ObjectBegin \"a\" {object} Shape \"sphere\" \"float radius\" .2 {square} \"integer indices\" [0 1 2 0 2 3]
        \"float uv\" [0 0 1 0 1 1 0 1] \"texture alpha\" \"holes\" ObjectEnd ObjectBegin \"b\" {object} ObjectEnd
        Translate .1 .1 .1 ObjectInstance \"a\" ObjectInstance \"b\" Rotate 20 1 2 3 Scale 1 .5 2 ObjectInstance \"a\" Translate .1 .2 .1
        ObjectInstance \"a\" Translate .1 .2 .1 ObjectInstance \"b\" Scale 1e-6 1e-6 1e-6 ObjectInstance \"a\"");
    let holes = &format!("Texture \"holes\" \"float\" \"checkerboard\" \"float tex1\" 0 \"float tex2\" 1 \"float uscale\" 7
        \"float vscale\" 7 Translate 0 0 .1 {square} \"integer indices\" [0 1 2 0 2 3] \"float uv\" [0 0 1 0 1 1 0 1]
        \"texture alpha\" \"holes\" Translate 0 0 .01 {square} \"integer indices\" [0 1 2 0 2 3] \"float shadowalpha\" 0");
    let far = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-1e12 -1e12 -1 1e12 -1e12 -1 0 1e12 -1]";
    let moving = &format!("ObjectBegin \"a\" {object} Shape \"sphere\" \"float radius\" .2 ActiveTransform EndTime Rotate 90 1 1 0
        ActiveTransform All Shape \"disk\" \"float radius\" .3 ObjectEnd Translate .1 .1 .1
        ActiveTransform EndTime Rotate 170 1 2 3 Scale 1 .5 2 Translate .3 -.2 .5 ActiveTransform All ObjectInstance \"a\"
        ActiveTransform StartTime Scale -1 1 1 ActiveTransform EndTime Scale 1 -1 .1 ActiveTransform All ObjectInstance \"a\"
        Shape \"cylinder\" \"float radius\" .3");
    let cases = cases(40);
    for shapes in ["", quadrics, curves, disks, twice, instances, objects, holes, far, moving] {
        let mut scene = crate::Prepared::new(&field(shapes)).traceable;
        let (mut met, mut tracer) = (0, WideTracer::new());
        for level in levels() {
            scene.level = level;
            for case in 0..cases {
                side_by_side!(level, simd => met += check(simd, &scene, &mut tracer, case));
            }
        }
        assert!(met > 10 * cases, "{met}");
    }
}

/// The bits of the boxes of a node that a ray meets, with the instructions of a level.
fn meet(level: Level, ray: &Ray, node: &Node, t_max: f32) -> u32 {
    side_by_side!(level, simd => {
        let rounded = |v: DVec3| v.as_vec3().to_array().map(|x| splat_f32(simd, x));
        let planes = node.planes.iter().flatten().flatten().filter(|plane| plane.is_finite());
        let reach = planes.fold(ray.o.abs().max_element() as f32, |reach, plane| reach.max(plane.abs()));
        let mut slabs = FusedSlabs::new();
        slabs.set(LANES, rounded(ray.o), rounded(ray.d), splat_f32(simd, 2.0 * reach));
        slabs.meet(simd, LANES + 3, node, t_max).1
    })
}

/// The fused test in `f32` says yes wherever the exact one in `f64` does, and seldom else: boxes of all sizes, flat ones, rays from far
/// away and from close by, along axes, nearly along axes, in the planes of sides, and small boxes beside large ones.
#[test]
fn no_box_that_is_met_is_left_out() {
    let (mut met, mut extra) = (0, 0);
    for case in 0..60_000 {
        let size = 10_f64.powi(case as i32 % 13 - 6);
        let point = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2)) * size;
        let boxes: [Bounds; WIDTH] = from_fn(|at| {
            let k = 1.0 + at as f64;
            let (p, q) = (point(k), point(k + 0.5));
            match (case % 3, at) {
                // Ground that reaches far.
                (_, 7) => Bounds::new(
                    p.min(q) - 1e7 * size,
                    p.max(q).with_z(p.z) + DVec3::new(1e7, 1e7, 0.0) * size,
                ),
                // Flat, or as thin as rounding.
                (0, _) => Bounds::new(p.min(q), p.max(q).with_x(p.x.min(q.x))),
                _ => Bounds::new(p.min(q), p.max(q)),
            }
        });
        let planes = |axis: usize| [boxes.map(|own| own.min[axis]), boxes.map(|own| own.max[axis])];
        let node = Node { planes: [planes(0), planes(1), planes(2)], children: [Child::EMPTY; WIDTH] };
        let aim = boxes[case % 7];
        let target =
            Vec3A::select(Vec3A::splat(noise(case, 8.3) as f32).cmpgt(Vec3A::ZERO), aim.min, aim.max)
                .as_dvec3();
        let o = point(9.0) * [1.0, 1e3, 1e-3][case % 7 % 3];
        let along = [DVec3::X, DVec3::Y, DVec3::Z][case % 3];
        let tilt = point(6.6) / size * 10_f64.powi(-(case as i32 % 20));
        let (o, d) = match case % 5 {
            // Along an axis, in the planes of sides.
            0 => (target - along * size, along),
            // Nearly so.
            1 => (target - (along + tilt) * size, (along + tilt).normalize()),
            _ => (o, (target - o).normalize()),
        };
        // In the space of an object, directions have any length.
        let length = if case % 4 == 0 { 10_f64.powi(case as i32 % 59 - 29) } else { 1.0 };
        let ray = Ray::new(o, d * length);
        let t_max = [f32::INFINITY, (size / length) as f32][case % 2];
        let is_met = |own: &Bounds| {
            let (low, high) = own.corners();
            within_box(ray.o, ray.d.recip(), low, high, 0.0).is_some_and(|near| near <= f64::from(t_max))
        };
        let exact: u32 = boxes.iter().zip(0..).map(|(own, lane)| u32::from(is_met(own)) << lane).sum();
        for level in levels() {
            let hits = meet(level, &ray, &node, t_max);
            assert_eq!(exact & !hits, 0, "{ray:?} {t_max} {boxes:?}");
            extra += (hits & !exact).count_ones();
        }
        met += exact.count_ones();
    }
    assert!(met > 60_000 && extra < met * levels().len() as u32 / 10, "{met} {extra}");
}
