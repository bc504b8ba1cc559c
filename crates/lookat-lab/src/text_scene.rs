//! Scenes from text.

use std::ops::ControlFlow;
use std::path::Path;

use glam::{DMat4, DVec3};
use lookat_render::{CameraRays, Prepared};
use lookat_scene::{Loaded, Scene};

/// What is read of a scene text.
pub(crate) fn load(text: &str) -> Loaded {
    lookat_scene::load(Path::new("case.pbrt"), &|_| Ok(text.into()), &Default::default())
}

/// A scene that must be right.
///
/// # Panics
///
/// If it has errors.
pub(crate) fn scene(text: &str) -> Scene {
    let loaded = load(text);
    loaded.scene.unwrap_or_else(|| panic!("{:?}: {text}", loaded.diagnostics))
}

/// The world of a scene, in which rays can be traced, and the rays of its camera.
pub(crate) struct PreparedScene {
    pub world: Prepared,
    pub camera: CameraRays,
}

/// Prepares a scene that must be right.
pub(crate) fn prepared(text: &str) -> PreparedScene {
    let scene = scene(text);
    let world = Prepared::new(&scene);
    PreparedScene { camera: world.camera(&scene.view), world }
}

/// The pixels of a scene's picture, rendered on so many threads; 0 for all.
pub(crate) fn render(scene: &Scene, threads: usize) -> Vec<[f32; 3]> {
    let settings = lookat_render::Settings { threads, ..Default::default() };
    lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image.rgb().unwrap_or_default()
}

/// The green channel of a scene's picture, rendered on all threads.
pub(crate) fn green(scene: &Scene, seed: u64) -> Vec<f64> {
    let settings = lookat_render::Settings { seed, ..Default::default() };
    let image = lookat_render::render(scene, &settings, &|_| ControlFlow::Continue(())).image;
    image.rgb().unwrap_or_default().iter().map(|pixel| f64::from(pixel[1])).collect()
}

/// The text of a world seen from a place.
pub(crate) fn seen_from(eye: DVec3, world: &str) -> String {
    format!("Translate {} {}", xyz(-eye), around_eye(world))
}

/// The text of a world seen from its origin.
pub(crate) fn around_eye(world: &str) -> String {
    let view = "Camera \"perspective\" Integrator \"path\" Sampler \"sobol\" Film \"image\"";
    format!("{view} WorldBegin {world} WorldEnd")
}

/// The directive for a film of this width and height.
pub(crate) fn film([width, height]: [u32; 2]) -> String {
    format!("Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" {height}")
}

/// The text of a world on a square film.
pub(crate) fn pictured(camera: &str, side: u32, samples: u32, integrator: &str, world: &str) -> String {
    let film = film([side; 2]);
    format!(
        "{camera} {film} Sampler \"sobol\" \"integer pixelsamples\" {samples} Integrator \"{integrator}\"
         WorldBegin {world} WorldEnd"
    )
}

/// The text of a point or vector. Numbers are written so that they are read as they are.
pub(crate) fn xyz(p: DVec3) -> String {
    p.to_array().map(|x| format!("{x:?}")).join(" ")
}

/// The directive for a transformation.
pub(crate) fn transform(matrix: &DMat4) -> String {
    format!("ConcatTransform [{}]", matrix.to_cols_array().map(|x| format!("{x:?}")).join(" "))
}

/// Directives in a block of their own.
pub(crate) fn block(directives: &str) -> String {
    format!("AttributeBegin {directives} AttributeEnd\n")
}

/// Directives in a block of their own, moved to a place.
pub(crate) fn at(p: DVec3, directives: &str) -> String {
    block(&format!("Translate {} {directives}", xyz(p)))
}

/// The text of a sphere around the origin.
pub(crate) fn sphere(radius: f64) -> String {
    format!("Shape \"sphere\" \"float radius\" {radius:e}\n")
}

/// A matte material with the same reflectance in all channels.
pub(crate) fn matte(reflectance: f64) -> String {
    format!("Material \"matte\" \"rgb Kd\" {}\n", rgb([reflectance; 3]))
}

/// The value of a color parameter.
pub(crate) fn rgb(color: [f64; 3]) -> String {
    format!("[{}]", xyz(color.into()))
}

/// A shape that emits on its front, in a block of its own.
pub(crate) fn emitting(radiance: [f64; 3], shape: &str) -> String {
    block(&format!("AreaLightSource \"diffuse\" \"rgb L\" {} {shape}", rgb(radiance)))
}

/// A surface that emits on both sides, in a block of its own.
pub(crate) fn two_sided(radiance: [f64; 3], surface: &str) -> String {
    let light = "AreaLightSource \"diffuse\" \"bool twosided\" \"true\" \"rgb L\"";
    block(&format!("{light} {} {surface}", rgb(radiance)))
}

/// The text of a mesh.
pub(crate) fn mesh(points: &[DVec3], faces: &[[usize; 3]]) -> String {
    let points: Vec<String> = points.iter().map(|p| xyz(*p)).collect();
    let indices: Vec<String> = faces.iter().flatten().map(usize::to_string).collect();
    let (points, indices) = (points.join("  "), indices.join(" "));
    format!("Shape \"trianglemesh\" \"point P\" [{points}] \"integer indices\" [{indices}]\n")
}

/// The text of triangles that share no corners.
pub(crate) fn triangles(points: &[DVec3]) -> String {
    mesh(points, &(0..points.len() / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect::<Vec<_>>())
}

/// The text of quadrilaterals, four corners each.
pub(crate) fn quads(points: &[DVec3]) -> String {
    let faces = (0..points.len() / 4).map(|i| 4 * i).flat_map(|i| [[i, i + 1, i + 2], [i, i + 2, i + 3]]);
    mesh(points, &faces.collect::<Vec<_>>())
}

/// The corners of a square around a point, or of a parallelogram, by two vectors from the point to the middles of its sides.
pub(crate) fn square(middle: DVec3, across: DVec3, up: DVec3) -> [DVec3; 4] {
    [middle - across - up, middle + across - up, middle + across + up, middle - across + up]
}

/// The text of the quadrilateral of [`square`].
pub(crate) fn quad(middle: DVec3, across: DVec3, up: DVec3) -> String {
    quads(&square(middle, across, up))
}

/// A square grid of points, row by row, and the triangles between them. `point` gets the column and the row.
pub(crate) fn grid(side: usize, mut point: impl FnMut(usize, usize) -> DVec3) -> String {
    let row = side + 1;
    let points: Vec<DVec3> = (0..row * row).map(|i| point(i % row, i / row)).collect();
    let cells = (0..side * row).filter(|i| i % row < side);
    let faces = cells.flat_map(|i| [[i, i + 1, i + row + 1], [i, i + row + 1, i + row]]);
    mesh(&points, &faces.collect::<Vec<_>>())
}

/// A corner of a box: a bit of `which` for each axis, set on the high side.
pub(crate) fn corner(low: [f64; 3], high: [f64; 3], which: usize) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|axis| if which >> axis & 1 == 0 { low[axis] } else { high[axis] }))
}

/// The sides of a box.
pub(crate) fn cube(low: [f64; 3], high: [f64; 3]) -> String {
    let sides = [0, 1, 3, 2, 4, 5, 7, 6, 0, 1, 5, 4, 2, 3, 7, 6, 0, 2, 6, 4, 1, 3, 7, 5];
    quads(&sides.map(|which| corner(low, high, which)))
}

/// The beginning of a PLY file of triangles.
pub(crate) fn ply_header(format: &str, vertices: usize, faces: usize) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\n\
         property float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}
