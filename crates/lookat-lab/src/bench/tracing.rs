//! Rays on one thread, and building trees.

use glam::{DVec2, DVec3};
use lookat_render::{BUNDLE, ElementId, Precision, Probe, Ray};
use lookat_scene::Scene;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::meshes::{body_scene, sphere_scene};
use super::table::{Cell, Row, Table, in_turn, timed};

/// Camera rays across and down.
const SIDE: usize = 400;

const PRECISIONS: [(Precision, &str); 3] =
    [(Precision::Mixed, "f32 and f64"), (Precision::Double, "f64 alone"), (Precision::Single, "f32 alone")];

/// Rays of one kind.
struct Batch {
    rays: Vec<Ray>,
    way: Way,
}

/// How rays are traced.
enum Way {
    Nearest,
    /// Several together.
    NearestOf,
    /// Whether something is in the way, not what.
    Occluded,
}

/// The tables of both meshes.
pub(super) fn tables(rounds: usize) -> Vec<Table> {
    let scenes = [("body", body_scene()), ("sphere", sphere_scene())];
    let rows = scenes.iter().flat_map(|(name, scene)| rays(name, scene, rounds));
    let rays = Table {
        name: "tracing",
        title: "rays on one thread, in millions per second".into(),
        columns: vec!["primary", "in bundles", "diffuse", "random", "shadow"],
        rows: rows.collect(),
    };
    let build = Table {
        name: "building",
        title: "scene preparation, in millions of triangles per second".into(),
        columns: vec!["one thread", "all threads", "times as fast"],
        rows: scenes.iter().map(|(name, scene)| building(name, scene, rounds)).collect(),
    };
    vec![rays, build]
}

/// A row for each precision.
fn rays(name: &str, scene: &Scene, rounds: usize) -> Vec<Row> {
    let mut probe = Probe::new(scene);
    let batches = batches(&probe);
    let count = triangles(scene);
    let mut rates = PRECISIONS.map(|_| Vec::new());
    for _ in 0..rounds.max(1) {
        for ((precision, _), rates) in PRECISIONS.iter().zip(&mut rates) {
            // One tree serves all.
            probe = probe.with_precision(*precision);
            rates.push(batches.each_ref().map(|batch| rate(&probe, batch)));
        }
    }
    let cells = |rates: &Vec<[f64; 5]>| {
        (0..5).map(|batch| Cell::of(rates.iter().map(|rates| rates[batch]))).collect()
    };
    let rows = rates.iter().map(cells);
    let named = PRECISIONS.iter().map(|(_, precision)| format!("{name}, {count} triangles, {precision}"));
    named.zip(rows).map(|(name, cells)| Row { name, cells }).collect()
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
    let rays = &batch.rays;
    let (seconds, _) = match batch.way {
        Way::Nearest => timed(|| rays.iter().filter(|ray| probe.nearest(ray).is_some()).count()),
        Way::NearestOf => {
            let (bundles, _) = rays.as_chunks();
            timed(|| bundles.iter().map(|bundle| probe.nearest_of(bundle).iter().flatten().count()).sum())
        }
        Way::Occluded => timed(|| rays.iter().filter(|ray| probe.occluded(ray)).count()),
    };
    rays.len() as f64 / seconds / 1e6
}

/// Rays from the camera, one through each pixel, and several through each of some pixels; from where the first meet
/// something, in random directions by the cosine, and to a light above; and anywhere among all that they meet.
fn batches(probe: &Probe) -> [Batch; 5] {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let corner = |at: usize| DVec2::new((at % SIDE) as f64, (at / SIDE) as f64);
    let through = |film| probe.camera_ray(film * (400.0 / SIDE as f64), DVec2::splat(0.5));
    let primary: Vec<Ray> = (0..SIDE * SIDE).map(|at| through(corner(at) + 0.5)).collect();
    let bundle = |at| {
        let within = std::array::from_fn::<_, BUNDLE, _>(|_| DVec2::new(random.random(), random.random()));
        within.map(|within| through(corner(at) + within))
    };
    let bundles = (0..SIDE * SIDE).step_by(BUNDLE).flat_map(bundle).collect();
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
    [
        (primary, Way::Nearest),
        (bundles, Way::NearestOf),
        (diffuse, Way::Nearest),
        (random_rays, Way::Nearest),
        (shadow, Way::Occluded),
    ]
    .map(|(rays, way)| Batch { rays, way })
}

fn to_light(from: &Ray, light: DVec3) -> Ray {
    let to_light = light - from.o;
    let distance = to_light.length();
    Ray { d: to_light / distance, t_max: distance * 0.999, target: ElementId::NONE, ..*from }
}

/// A direction, all alike.
fn direction(random: &mut Pcg64Mcg) -> DVec3 {
    let z = 2.0 * random.random::<f64>() - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// Trees on one thread and on all.
fn building(name: &str, scene: &Scene, rounds: usize) -> Row {
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
    Row { name: format!("{name}, {count} triangles"), cells }
}
