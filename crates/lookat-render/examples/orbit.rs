//! Turns a camera around a mesh of a million triangles. The last line tells how long a new view takes, from the camera to a
//! picture with a sample in each pixel.
//!
//! ```text
//! cargo run --release -p lookat-render --example orbit
//! ```

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use lookat_render::glam::DVec3;
use lookat_render::scene::{Mesh, MeshError, Shape, Transform, load_str};
use lookat_render::{Prepared, Settings};

/// The size of the grid that becomes the mesh: two triangles in each of its cells.
const ROWS: usize = 708;
/// The views.
const VIEWS: usize = 360;

/// A ball with bumps.
fn ball() -> Result<Mesh, MeshError> {
    let vertex = |i: usize| {
        let (row, column) = (i / (ROWS + 1), i % (ROWS + 1));
        let (theta, phi) = (PI * row as f64 / ROWS as f64, TAU * column as f64 / ROWS as f64);
        let radius = 1.0 + 0.03 * (20.0 * theta).sin() * (20.0 * phi).sin();
        let (sin, cos) = theta.sin_cos();
        (radius * DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)).to_array()
    };
    let cell = |i: usize| {
        let a = (i / ROWS * (ROWS + 1) + i % ROWS) as i32;
        let (b, c, d) = (a + 1, a + ROWS as i32 + 1, a + ROWS as i32 + 2);
        [a, c, b, b, c, d]
    };
    let vertices: Vec<_> = (0..(ROWS + 1) * (ROWS + 1)).map(vertex).collect();
    Mesh::new(vertices, (0..ROWS * ROWS).flat_map(cell).collect::<Vec<_>>())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = r#"LookAt 3 0 1  0 0 0  0 0 1
        Camera "perspective" "float fov" 50 Integrator "directlighting"
        Film "image" "integer xresolution" 128 "integer yresolution" 96
        Sampler "sobol" "integer pixelsamples" 1
        WorldBegin
        LightSource "distant" "point from" [1 1 2] LightSource "infinite" "rgb L" [.3 .3 .3]
        Shape "sphere"
        WorldEnd"#;
    let mut scene = load_str(text).scene.ok_or("the scene has errors")?;
    let mesh = ball()?;
    println!("{} triangles", mesh.triangles());
    Arc::make_mut(&mut scene.world).primitives[0].shape = Shape::TriangleMesh(Arc::new(mesh));

    let started = Instant::now();
    let mut prepared = Prepared::new(&scene);
    println!("the world is prepared in {:.0} ms", started.elapsed().as_secs_f64() * 1e3);

    let mut view = scene.view;
    let mut times: Vec<f64> = Vec::new();
    let mut moves = 0;
    for number in 0..VIEWS {
        let (sin, cos) = (TAU * number as f64 / VIEWS as f64).sin_cos();
        let started = Instant::now();
        let look_at = Transform::look_at(DVec3::new(3.0 * cos, 3.0 * sin, 1.0), DVec3::ZERO, DVec3::Z);
        view.camera.world_from_camera = look_at?.inverse();
        let preparation = prepared.look(&view.camera);
        let rendered = prepared.render(&view, &Settings::default(), &|_| ControlFlow::Continue(()));
        times.push(started.elapsed().as_secs_f64() * 1e3);
        assert_eq!(rendered.statistics.least, 1);
        moves += u32::from(preparation.as_millis() > 0);
    }
    times.sort_by(f64::total_cmp);
    println!("{VIEWS} views; the origin moved {moves} times");
    println!("median {:.1} ms, p99 {:.1} ms", times[VIEWS / 2], times[VIEWS * 99 / 100]);
    Ok(())
}
