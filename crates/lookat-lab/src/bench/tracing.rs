//! Rays on one thread, and building trees.

use glam::{DVec2, DVec3};
use lookat_render::{ElementId, Probe, Ray};
use lookat_scene::Scene;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::meshes::{body_scene, sphere_scene};
use super::table::{BenchRow, BenchTable, Cell, in_turn, timed};
use crate::stability::random::direction;

/// Camera rays across and down.
const SIDE: usize = 400;

/// Rays of one kind.
struct Batch {
    rays: Vec<Ray>,
    /// Asks only whether something is in the way.
    is_shadow: bool,
}

/// The tables of both meshes.
pub(super) fn tables(rounds: usize) -> Vec<BenchTable> {
    let scenes = [("body", body_scene()), ("sphere", sphere_scene())];
    let rows = scenes.iter().map(|(name, scene)| rays(name, scene, rounds));
    let rays = BenchTable {
        name: "tracing",
        title: "rays on one thread, in millions per second".into(),
        columns: vec!["primary", "diffuse", "random", "shadow"],
        rows: rows.collect(),
    };
    let build = BenchTable {
        name: "building",
        title: "scene preparation, in millions of triangles per second".into(),
        columns: vec!["one thread", "all threads", "times as fast"],
        rows: scenes.iter().map(|(name, scene)| building(name, scene, rounds)).collect(),
    };
    vec![rays, build]
}

fn rays(name: &str, scene: &Scene, rounds: usize) -> BenchRow {
    let probe = Probe::new(scene);
    let batches = batches(&probe);
    let rates = in_turn(rounds, batches.len(), |batch| rate(&probe, &batches[batch]));
    let name = format!("{name}, {} triangles", triangles(scene));
    BenchRow { name, cells: rates.into_iter().map(Cell::of).collect() }
}

fn triangles(scene: &Scene) -> usize {
    let meshes = scene.world.primitives.iter().filter_map(|primitive| match &primitive.shape {
        lookat_scene::Shape::TriangleMesh(mesh) => Some(mesh.triangles()),
        _ => None,
    });
    meshes.sum()
}

/// Million rays a second.
fn rate(probe: &Probe, batch: &Batch) -> f64 {
    let hits = |ray: &&Ray| if batch.is_shadow { probe.occluded(ray) } else { probe.nearest(ray).is_some() };
    let (seconds, _) = timed(|| batch.rays.iter().filter(hits).count());
    batch.rays.len() as f64 / seconds / 1e6
}

/// Rays from the camera, one through each pixel; from where they meet
/// something, in random directions by the cosine, and to a light above; and anywhere among all that they meet.
fn batches(probe: &Probe) -> [Batch; 4] {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let corner = |at: usize| DVec2::new((at % SIDE) as f64, (at / SIDE) as f64);
    let through = |film| probe.camera_ray(film * (400.0 / SIDE as f64), DVec2::splat(0.5));
    let primary: Vec<Ray> = (0..SIDE * SIDE).map(|at| through(corner(at) + 0.5)).collect();
    let (mut diffuse, mut low, mut high) = (Vec::new(), DVec3::INFINITY, DVec3::NEG_INFINITY);
    for ray in &primary {
        let Some(hit) = probe.nearest(ray) else { continue };
        let point = probe.point(ray, &hit);
        let n = if point.n.dot(ray.d) > 0.0 { -point.n } else { point.n };
        let d = (n + direction(&mut random)).normalize_or(n);
        (low, high) = (low.min(point.p), high.max(point.p));
        diffuse.push(probe.leave(ray, &hit, d));
    }
    let anywhere = |_| {
        let share = DVec3::from_array(std::array::from_fn(|_| random.random::<f64>()));
        Ray::new(low + (high - low) * share, direction(&mut random))
    };
    let random_rays = (0..primary.len()).map(anywhere).collect();
    let light = DVec3::new(0.5 * (low.x + high.x), high.y + 0.1 * (high.y - low.y), 0.5 * (low.z + high.z));
    let shadow = diffuse.iter().map(|ray| to_light(ray, light)).collect();
    [(primary, false), (diffuse, false), (random_rays, false), (shadow, true)]
        .map(|(rays, is_shadow)| Batch { rays, is_shadow })
}

fn to_light(from: &Ray, light: DVec3) -> Ray {
    let to_light = light - from.o;
    let distance = to_light.length();
    Ray { d: to_light / distance, t_max: distance * 0.999, target: ElementId::NONE, ..*from }
}

/// Trees on one thread and on all.
fn building(name: &str, scene: &Scene, rounds: usize) -> BenchRow {
    let count = triangles(scene) as f64;
    let rate = |threads| {
        let build = || timed(|| Probe::new(scene)).0;
        let seconds = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool.install(build),
            Err(_) => build(),
        };
        count / seconds / 1e6
    };
    let rates = in_turn(rounds, 2, |all| rate(if all == 1 { 0 } else { 1 }));
    let ratios = rates[0].iter().zip(&rates[1]).map(|(one, all)| all / one);
    let cells = vec![Cell::of(rates[0].clone()), Cell::of(rates[1].clone()), Cell::of(ratios)];
    BenchRow { name: format!("{name}, {count} triangles"), cells }
}
