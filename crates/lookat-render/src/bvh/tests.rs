use fearless_simd::{Level, Simd};
use glam::{DVec3, Vec3A};

use super::build::Tree;
use super::*;
use crate::bvh::slabs;
use crate::number::{side_by_side, splat_f32};
use crate::ray::Ray;
use crate::testing::{levels, noise};

fn slabs_of<S: Simd>(simd: S, ray: &Ray) -> Slabs<S> {
    let rounded = |v: DVec3| v.as_vec3().to_array().map(|x| splat_f32(simd, x));
    SlabRays::new(simd, rounded(ray.o), rounded(ray.d)).one(simd, 0)
}

/// Which boxes of a node a ray may meet, and from where on.
fn meet(level: Level, ray: &Ray, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
    side_by_side!(level, simd => slabs_of(simd, ray).meet(simd, node, t_max))
}

/// True if it meets a box, in `f64`.
fn meets(ray: &Ray, bounds: Bounds, t_max: f64) -> bool {
    let (low, high) = bounds.corners();
    let (near, far) = slabs(ray.o, ray.d.recip(), low, high, t_max);
    near <= far
}

fn node(boxes: &[Bounds]) -> Node {
    let at = |lane: usize| boxes.get(lane).copied().unwrap_or(Bounds::EMPTY);
    let planes = |axis: usize| {
        [[0, 1, 2, 3, 4, 5, 6, 7].map(|i| at(i).min[axis]), [0, 1, 2, 3, 4, 5, 6, 7].map(|i| at(i).max[axis])]
    };
    Node { planes: [planes(0), planes(1), planes(2)], children: [Child::EMPTY; WIDTH] }
}

#[test]
fn a_ray_in_the_plane_of_a_side_meets_the_box() {
    let bounds = Bounds { min: Vec3A::ZERO, max: Vec3A::ONE };
    let node = node(&[bounds]);
    let hits = |ray: &Ray| {
        levels().into_iter().map(|level| meet(level, ray, &node, f32::INFINITY).0).collect::<Vec<_>>()
    };
    for x in [0.0, 1.0] {
        for zero in [0.0, -0.0] {
            let ray = Ray::new(DVec3::new(x, 0.5, -1.0), DVec3::new(zero, 0.0, 1.0));
            assert!(hits(&ray).iter().all(|hits| *hits == 1), "{x} {zero}");
            assert!(meets(&ray, bounds, f64::INFINITY), "{x} {zero}");
        }
    }
    let outside = Ray::new(DVec3::new(2.0, 0.5, -1.0), DVec3::Z);
    assert!(hits(&outside).iter().all(|hits| *hits == 0));
}

/// The test in `f32` says yes wherever that in `f64` does, and seldom else; with any instructions it is the same to the bit.
#[test]
fn no_box_that_is_met_is_left_out() {
    let (mut met, mut extra, levels) = (0, 0, levels());
    for case in 0..20_000 {
        let size = 10_f64.powi(case as i32 % 13 - 6);
        let point = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2)) * size;
        let boxes = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|k| {
            let (p, q) = (point(k), point(k + 0.5));
            // Flat, or as thin as rounding.
            let q = if case % 3 == 0 { DVec3::new(p.x, q.y, q.z) } else { q };
            Bounds::new(p.min(q), p.max(q))
        });
        let node = node(&boxes);
        // Aimed at a corner, and sometimes along an axis.
        let target = boxes[case % 6].min.as_dvec3();
        let o = point(9.0) * [1.0, 1e3, 1e-3][case % 7 % 3];
        let d = if case % 5 == 0 { DVec3::Z } else { (target - o).normalize() };
        let ray = Ray::new(if case % 5 == 0 { target - d * size } else { o }, d);
        let t_max = [f32::INFINITY, size as f32][case % 2];
        let bit = |(bounds, lane): (&Bounds, u32)| u32::from(meets(&ray, *bounds, f64::from(t_max))) << lane;
        let exact: u32 = boxes.iter().zip(0..).map(bit).sum();
        let of_levels: Vec<_> = levels.iter().map(|level| meet(*level, &ray, &node, t_max)).collect();
        let (hits, near) = of_levels[0];
        assert_eq!(exact & !hits, 0, "{ray:?} {boxes:?}");
        assert!(near.iter().all(|near| *near >= 0.0));
        assert!(
            of_levels
                .iter()
                .all(|(own, enter)| *own == hits && enter.map(f32::to_bits) == near.map(f32::to_bits))
        );
        met += exact.count_ones();
        extra += (hits & !exact).count_ones();
    }
    assert!(met > 20_000 && extra < met / 10, "{met} {extra}");
}

fn leaves<const ANY: bool>(bvh: &Bvh, ray: &Ray) -> Vec<Leaf> {
    let (level, mut leaves) = (Level::new(), Vec::new());
    bvh.traverse::<ANY, u8>(
        &[],
        f64::INFINITY,
        |node, t_max| meet(level, ray, node, t_max),
        |leaf| {
            leaves.push(leaf);
            Some(f64::INFINITY)
        },
    );
    leaves
}

/// The numbers of the triangles in each block.
fn in_blocks(tree: &Tree, references: &[Reference]) -> Vec<Vec<u32>> {
    let mut triangles = references.iter().filter(|it| it.is_triangle()).map(Reference::number);
    let blocks = tree.blocks.iter().map(|length| triangles.by_ref().take(usize::from(*length)).collect());
    blocks.collect()
}

/// Also in a tree large enough to be built by several threads, and with elements of both kinds.
#[test]
fn every_box_that_a_ray_meets_is_visited() {
    let count = 40_000;
    let bounds: Vec<Bounds> = (0..count)
        .map(|i| DVec3::new(noise(i, 1.1), noise(i, 2.3), noise(i, 3.7)) * 10.0)
        .map(|low| Bounds::new(low, low + 0.5))
        .collect();
    let reference = |(i, bounds): (usize, &Bounds)| match i % 3 {
        0 => Reference::non_triangle(*bounds, i as u32),
        _ => Reference::triangle(*bounds, i as u32),
    };
    let mut references: Vec<Reference> = bounds.iter().enumerate().map(reference).collect();
    let tree = build(&mut references);
    assert!(tree.blocks.iter().all(|length| (1..=WIDTH).contains(&usize::from(*length))));
    let in_block = in_blocks(&tree, &references);
    for (o, d) in [(DVec3::splat(-20.0), DVec3::ONE), (DVec3::new(3.0, 2.0, 30.0), DVec3::NEG_Z)] {
        let ray = Ray::new(o, d.normalize());
        let mut visited = vec![0; count];
        let found = leaves::<false>(&tree.bvh, &ray);
        let mut unordered = leaves::<true>(&tree.bvh, &ray);
        assert_eq!(unordered.len(), found.len());
        unordered.retain(|leaf| !found.contains(leaf));
        assert!(unordered.is_empty(), "{unordered:?}");
        for leaf in found {
            match leaf {
                Leaf::NonTriangle(number) => visited[number] += 1,
                Leaf::Block(block) => {
                    in_block[block].iter().for_each(|number| visited[*number as usize] += 1)
                }
            }
        }
        assert!(visited.iter().all(|times| *times <= 1));
        let met = |i: &usize| meets(&ray, bounds[*i], f64::INFINITY);
        assert!((0..count).filter(met).all(|i| visited[i] == 1));
        assert!((0..count).filter(met).count() > 10);
    }
}

/// No bin beyond those that are looked at, whatever the middles are apart.
#[test]
fn elements_as_far_apart_as_f32_goes_are_in_their_boxes() {
    for far in [1e30_f64, 1.8e38, 2e38, 3e38, 1e39] {
        let places = [-1.0, 0.0, 0.002, 0.004, 1.0].map(|x| DVec3::new(x * far, 0.0, 0.0));
        let bounds = places.map(|p| Bounds::new(p, p + far * 0.01));
        let mut references: Vec<Reference> =
            (0..).zip(&bounds).map(|(i, bounds)| Reference::non_triangle(*bounds, i)).collect();
        let tree = build(&mut references);
        for (number, place) in places.iter().enumerate() {
            let ray = Ray::new(*place + far * 0.005 - DVec3::Z * far * 0.1, DVec3::Z);
            assert!(leaves::<false>(&tree.bvh, &ray).contains(&Leaf::NonTriangle(number)), "{far} {number}");
        }
    }
}

#[test]
fn elements_that_cannot_be_told_apart_make_a_shallow_tree() {
    for same in [
        Bounds { min: Vec3A::ONE, max: Vec3A::splat(2.0) },
        Bounds::new(DVec3::splat(-1e300), DVec3::splat(1e300)),
    ] {
        let reference =
            |i| if i % 2 == 0 { Reference::non_triangle(same, i) } else { Reference::triangle(same, i) };
        let mut references: Vec<Reference> = (0..100_000).map(reference).collect();
        let tree = build(&mut references);
        let seen: usize = leaves::<false>(&tree.bvh, &Ray::new(DVec3::splat(1.5), DVec3::X))
            .into_iter()
            .map(|leaf| if let Leaf::Block(block) = leaf { usize::from(tree.blocks[block]) } else { 1 })
            .sum();
        assert_eq!(seen, 100_000);
    }
}
