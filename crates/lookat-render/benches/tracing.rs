//! Single rays against a field of hills: `cargo bench -p lookat-render`.

use std::fmt::Write;
use std::path::Path;
use std::sync::LazyLock;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{DVec2, DVec3};
use lookat_render::{Prepared, Ray, Scene};

/// Vertices of the field on each side.
const FIELD: usize = 200;
/// Rays of one call, on each side of the picture.
const SIDE: usize = 64;

static SCENE: LazyLock<Scene> = LazyLock::new(|| {
    let mut heights = String::new();
    for at in 0..FIELD * FIELD {
        let [x, y] = [at % FIELD, at / FIELD].map(|i| i as f64 * 0.4);
        let _ = write!(heights, "{:.4} ", 0.03 * (x.sin() * y.cos() + (3.1 * x + y).sin() * 0.3));
    }
    let text = format!(
        "LookAt 0.5 0 0.8 0.5 0.5 0 0 1 0 Camera \"perspective\" \"float fov\" 45
         Film \"image\" \"integer xresolution\" {SIDE} \"integer yresolution\" {SIDE}
         Sampler \"sobol\" Integrator \"path\" WorldBegin LightSource \"infinite\"
         Shape \"heightfield\" \"integer nu\" {FIELD} \"integer nv\" {FIELD} \"float Pz\" [{heights}] WorldEnd"
    );
    let loaded =
        lookat_render::scene::load(Path::new("field"), &|_| Ok(text.clone().into()), &Default::default());
    loaded.scene.expect("the scene is right")
});

fn main() {
    divan::main();
}

fn camera_rays(prepared: &Prepared) -> Vec<Ray> {
    let pixel = |at: usize| DVec2::new((at % SIDE) as f64 + 0.5, (at / SIDE) as f64 + 0.5);
    let camera = prepared.camera(&SCENE.view);
    (0..SIDE * SIDE).map(|at| camera.ray(pixel(at), DVec2::splat(0.5))).collect()
}

/// From where camera rays meet the field, to a light above it.
fn shadow_rays(prepared: &Prepared) -> Vec<Ray> {
    let light = DVec3::new(0.2, 0.3, 1.0) - prepared.origin();
    let leave = |ray: &Ray| {
        let surface = prepared.surface(ray, &prepared.nearest(ray)?);
        let to_light = light - surface.p;
        Some(Ray { t_max: to_light.length(), ..surface.spawn_ray(to_light.normalize()) })
    };
    camera_rays(prepared).iter().filter_map(leave).collect()
}

#[divan::bench]
fn nearest(bencher: Bencher) {
    trace(bencher, camera_rays, |prepared, ray| prepared.nearest(ray).is_some());
}

#[divan::bench]
fn occluded(bencher: Bencher) {
    trace(bencher, shadow_rays, |prepared, ray| prepared.occluded(ray));
}

/// Counts the rays that meet something.
fn trace(bencher: Bencher, rays: fn(&Prepared) -> Vec<Ray>, meets: impl Fn(&Prepared, &Ray) -> bool) {
    let prepared = Prepared::new(&SCENE);
    let rays = rays(&prepared);
    bencher
        .counter(ItemsCount::new(rays.len()))
        .bench_local(|| rays.iter().filter(|ray| meets(&prepared, black_box(ray))).count());
}

/// From the scene to the tree.
#[divan::bench(sample_count = 20)]
fn build(bencher: Bencher) {
    let triangles = 2 * (FIELD - 1) * (FIELD - 1);
    bencher.counter(ItemsCount::new(triangles)).bench_local(|| Prepared::new(black_box(&SCENE)).origin());
}
