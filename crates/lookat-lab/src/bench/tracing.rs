//! Rays on one thread, and building trees.

use glam::{DVec2, DVec3};
use lookat_render::{ElementId, Prepared, Ray};
use lookat_scene::{Scene, View};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bench_table::{BenchTable, Column};
use super::meshes::{body_scene, sphere_scene};
use crate::stability::random::direction;
use crate::timed;

/// Camera rays across and down.
const SIDE: usize = 400;

/// Rays of one kind, and whether they ask only if something is in the way.
type Batch = (Vec<Ray>, bool);

/// The tables of both meshes.
pub(super) fn tables(rounds: usize) -> Vec<BenchTable> {
    let scenes = [("body", body_scene()), ("sphere", sphere_scene())];
    let names =
        || scenes.iter().map(|(name, scene)| format!("{name}, {} triangles", triangles(scene))).collect();
    let prepared = scenes.each_ref().map(|(_, scene)| Prepared::new(scene));
    let batches = [0, 1].map(|mesh| batches(&prepared[mesh], &scenes[mesh].1.view));
    let rays: [Column<[f64; 4]>; 4] = [
        ("primary", |rates, _| rates[0]),
        ("diffuse", |rates, _| rates[1]),
        ("random", |rates, _| rates[2]),
        ("shadow", |rates, _| rates[3]),
    ];
    let title = "rays on one thread, in millions per second".into();
    let rays = BenchTable::measured(("tracing", title), &rays, names(), rounds, |mesh| {
        batches[mesh].each_ref().map(|batch| rate(&prepared[mesh], batch))
    });
    let building: [Column<[f64; 2]>; 3] = [
        ("one thread", |[one, _], _| *one),
        ("all threads", |[_, all], _| *all),
        ("times as fast", |[one, all], _| all / one),
    ];
    let title = "scene preparation, in millions of triangles per second".into();
    let building = BenchTable::measured(("building", title), &building, names(), rounds, |mesh| {
        [1, 0].map(|threads| building_rate(&scenes[mesh].1, threads))
    });
    vec![rays, building]
}

fn triangles(scene: &Scene) -> usize {
    let meshes = scene.world.primitives.iter().filter_map(|primitive| match &primitive.shape {
        lookat_scene::Shape::TriangleMesh(mesh) => Some(mesh.triangles()),
        _ => None,
    });
    meshes.sum()
}

/// Million rays a second.
fn rate(prepared: &Prepared, (rays, is_shadow): &Batch) -> f64 {
    let hits = |ray: &&Ray| if *is_shadow { prepared.occluded(ray) } else { prepared.nearest(ray).is_some() };
    let (seconds, _) = timed(|| rays.iter().filter(hits).count());
    rays.len() as f64 / seconds / 1e6
}

/// Rays from the camera, one through each pixel; from where they meet
/// something, in random directions by the cosine, and to a light above; and anywhere among all that they meet.
fn batches(prepared: &Prepared, view: &View) -> [Batch; 4] {
    let camera = prepared.camera(view);
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let corner = |at: usize| DVec2::new((at % SIDE) as f64, (at / SIDE) as f64);
    let through = |film| camera.ray(film * (400.0 / SIDE as f64), DVec2::splat(0.5));
    let primary: Vec<Ray> = (0..SIDE * SIDE).map(|at| through(corner(at) + 0.5)).collect();
    let (mut diffuse, mut low, mut high) = (Vec::new(), DVec3::INFINITY, DVec3::NEG_INFINITY);
    for ray in &primary {
        let Some(hit) = prepared.nearest(ray) else { continue };
        let point = prepared.surface(ray, &hit).facing(ray.d);
        let d = (point.n + direction(&mut random)).normalize_or(point.n);
        (low, high) = (low.min(point.p), high.max(point.p));
        diffuse.push(point.spawn_ray(d));
    }
    let anywhere = |_| {
        let share = DVec3::from_array(std::array::from_fn(|_| random.random::<f64>()));
        Ray::new(low + (high - low) * share, direction(&mut random))
    };
    let random_rays = (0..primary.len()).map(anywhere).collect();
    let light = DVec3::new(0.5 * (low.x + high.x), high.y + 0.1 * (high.y - low.y), 0.5 * (low.z + high.z));
    let to_light = |ray: &Ray| {
        let distance = ray.o.distance(light);
        Ray { d: (light - ray.o) / distance, t_max: distance * 0.999, target: ElementId::NONE, ..*ray }
    };
    let shadow = diffuse.iter().map(to_light).collect();
    [(primary, false), (diffuse, false), (random_rays, false), (shadow, true)]
}

/// Million triangles a second of preparing a scene on so many threads; 0 is one for each processor.
fn building_rate(scene: &Scene, threads: usize) -> f64 {
    let build = || timed(|| Prepared::new(scene)).0;
    let seconds = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(build),
        Err(_) => build(),
    };
    triangles(scene) as f64 / seconds / 1e6
}
