//! Meshes to measure with, and the scenes that they stand in.

use std::fmt::Write;
use std::sync::Arc;

use glam::DVec3;
use lookat_scene::{Mesh, Scene, Shape};

use crate::text_scene;

/// A closed surface around the origin, of `12 n^2` triangles: the faces of a cube, moved to `place` of their directions.
pub(super) fn closed(n: usize, place: impl Fn(DVec3) -> DVec3) -> Mesh {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for face in 0..6 {
        let first = positions.len();
        for at in 0..(n + 1) * (n + 1) {
            let [u, v] = [at % (n + 1), at / (n + 1)].map(|i| 2.0 * i as f64 / n as f64 - 1.0);
            // The second three faces look the other way.
            let corner = if face < 3 { DVec3::new(u, v, 1.0) } else { DVec3::new(v, u, -1.0) };
            let turned =
                [corner, DVec3::new(corner.z, corner.x, corner.y), DVec3::new(corner.y, corner.z, corner.x)];
            positions.push(place(turned[face % 3].normalize()).into());
        }
        let corner = |column: usize, row: usize| (first + row * (n + 1) + column) as i32;
        for at in 0..n * n {
            let (column, row) = (at % n, at / n);
            let [a, b] = [corner(column, row), corner(column + 1, row)];
            let [c, d] = [corner(column + 1, row + 1), corner(column, row + 1)];
            indices.extend([a, b, c, a, c, d]);
        }
    }
    Mesh::new(positions, indices).expect("a finite surface")
}

/// A sphere of a million triangles.
pub(super) fn sphere() -> Mesh {
    closed(289, |d| d)
}

/// A long body of 66 thousand triangles with bumps of many sizes, like that of an animal that was scanned.
pub(super) fn body() -> Mesh {
    closed(74, |d| {
        let bumps = |frequency: f64| {
            let p = d * frequency;
            (p.x + 1.3 * p.y).sin() * (p.y - 0.7 * p.z).sin() * (p.z + 0.4 * p.x).cos()
        };
        let radius = 1.0 + 0.25 * bumps(3.0) + 0.08 * bumps(9.0) + 0.02 * bumps(31.0);
        d * radius * DVec3::new(1.7, 0.9, 0.7)
    })
}

/// Two triangles: a square of that half size around a point, in the plane of two directions.
fn square(middle: DVec3, across: DVec3, up: DVec3) -> Mesh {
    let positions = text_scene::square(middle, across, up).map(Into::into);
    Mesh::new(positions.to_vec(), vec![0, 1, 2, 0, 2, 3]).expect("a finite square")
}

/// The body above a ground and before a wall.
pub(super) fn body_scene() -> Scene {
    let ground = square(DVec3::new(0.0, -1.0, 0.0), DVec3::X * 20.0, DVec3::Z * 20.0);
    let wall = square(DVec3::new(0.0, 0.0, 4.0), DVec3::X * 20.0, DVec3::Y * 20.0);
    scene(DVec3::new(1.0, 1.2, -5.0), vec![body(), ground, wall])
}

/// The sphere alone.
pub(super) fn sphere_scene() -> Scene {
    scene(DVec3::new(0.0, 0.0, -3.2), vec![sphere()])
}

/// Meshes that are seen from `eye` around the origin.
fn scene(eye: DVec3, meshes: Vec<Mesh>) -> Scene {
    let camera =
        format!("LookAt {} 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 40", text_scene::xyz(eye));
    let world = "LightSource \"infinite\" Shape \"sphere\"";
    let mut scene = text_scene::scene(&text_scene::pictured(&camera, 400, 16, "path", world));
    let world = Arc::make_mut(&mut scene.world);
    let one = world.primitives.remove(0);
    let shapes = meshes.into_iter().map(|mesh| Shape::TriangleMesh(Arc::new(mesh)));
    world.primitives = shapes.map(|shape| lookat_scene::Primitive { shape, ..one.clone() }).collect();
    scene
}

/// The mesh as a shape in a scene file.
pub(super) fn as_text(mesh: &Mesh) -> String {
    let (positions, corners) = lines(mesh, "");
    format!("Shape \"trianglemesh\" \"integer indices\" [{corners}] \"point P\" [{positions}]")
}

/// The positions of a mesh, and the corners of its triangles after a prefix, one in each line.
fn lines(mesh: &Mesh, prefix: &str) -> (String, String) {
    let (mut positions, mut corners) = (String::new(), String::new());
    for [x, y, z] in mesh.positions() {
        let _ = writeln!(positions, "{x:.7} {y:.7} {z:.7}");
    }
    for [a, b, c] in mesh.indices().as_chunks().0 {
        let _ = writeln!(corners, "{prefix}{a} {b} {c}");
    }
    (positions, corners)
}

/// The mesh as a PLY file.
pub(super) fn as_ply(mesh: &Mesh, binary: bool) -> Vec<u8> {
    let format = if binary { "binary_little_endian" } else { "ascii" };
    let header = text_scene::ply_header(format, mesh.positions().len(), mesh.triangles());
    if !binary {
        let (positions, corners) = lines(mesh, "3 ");
        return (header + &positions + &corners).into_bytes();
    }
    let mut bytes = header.into_bytes();
    mesh.positions().as_flattened().iter().for_each(|x| bytes.extend((*x as f32).to_le_bytes()));
    for corners in mesh.indices().chunks_exact(3) {
        bytes.push(3);
        corners.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The mesh of a scene that is the text of a shape, or names a file.
    fn read_back(shape: &str, file: &[u8]) -> Mesh {
        let text = format!(
            "Film \"image\" Sampler \"sobol\" Camera \"perspective\" Integrator \"path\" WorldBegin
             LightSource \"infinite\" {shape} WorldEnd"
        );
        let read =
            |path: &Path| Ok(if path.extension().is_some() { file.to_vec() } else { text.clone().into() });
        let scene = lookat_scene::load(Path::new("x"), &read, &Default::default()).scene.unwrap();
        match &scene.world.primitives[0].shape {
            Shape::TriangleMesh(mesh) => (**mesh).clone(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn all_files_hold_the_mesh() {
        let mesh = closed(3, |d| d * 2.0);
        let named = "Shape \"plymesh\" \"string filename\" \"a.ply\"";
        let files = [
            read_back(&as_text(&mesh), &[]),
            read_back(named, &as_ply(&mesh, false)),
            read_back(named, &as_ply(&mesh, true)),
        ];
        assert_eq!(mesh.triangles(), 12 * 9);
        for found in files {
            assert_eq!(found.indices(), mesh.indices());
            let pairs = found.positions().as_flattened().iter().zip(mesh.positions().as_flattened());
            assert!(
                found.positions().len() == mesh.positions().len()
                    && pairs.clone().all(|(a, b)| (a - b).abs() < 1e-6)
            );
        }
    }

    #[test]
    fn a_closed_mesh_has_no_holes() {
        use lookat_render::{Prepared, Ray};
        let mut scene = scene(DVec3::new(0.0, 0.0, -9.0), vec![body()]);
        scene.view.film.resolution = [8, 8];
        let prepared = Prepared::new(&scene);
        // From the middle to all sides.
        for at in 0..1000 {
            let angle = f64::from(at) * 2.4;
            let z = (f64::from(at) + 0.5) / 500.0 - 1.0;
            let d = DVec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z;
            assert!(prepared.nearest(&Ray::new(-prepared.origin(), d)).is_some(), "{d}");
        }
    }
}
