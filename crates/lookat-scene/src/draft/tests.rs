//! Loading of meshes and pictures.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use crate::{Instance, Light, LoadOptions, Loaded, MaterialKind, Shape, Texture, Varying, load};

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n";

/// Loads a world, and returns the files read, except for the scene.
fn loaded(world: &str, options: &LoadOptions) -> (Loaded, Vec<PathBuf>) {
    let text = format!(
        "Camera \"perspective\" Film \"image\" Sampler \"sobol\" Integrator \"path\" WorldBegin
        LightSource \"infinite\" {world} WorldEnd"
    );
    let files = RefCell::new(Vec::new());
    let read = |path: &Path| {
        if path == Path::new("a.pbrt") {
            return Ok(text.clone().into());
        }
        files.borrow_mut().push(path.to_owned());
        Ok(match path.to_str() {
            Some("a.ply") => PLY.into(),
            // A picture of 2 x 1 pixels.
            Some("a.pfm" | "b.pfm" | "c.pfm") => [b"Pf\n2 1\n-1\n".as_slice(), &[0; 8]].concat(),
            _ => Vec::new(),
        })
    };
    let loaded = load(Path::new("a.pbrt"), &read, options);
    (loaded, files.into_inner())
}

fn mesh(name: &str) -> String {
    format!("Shape \"plymesh\" \"string filename\" \"{name}\" ")
}

#[test]
fn a_mesh_file_is_placed_for_each_shape_and_kept_from_its_second_use_on() {
    let world = format!(
        "{} Translate 5 0 0 ObjectBegin \"o\" {0} {0} {0} ObjectEnd ObjectInstance \"o\"",
        mesh("a.ply")
    );
    let (loaded, files) = loaded(&world, &LoadOptions::default());
    assert_eq!(files, [Path::new("a.ply"); 2]);
    let world = loaded.scene.unwrap().world;
    let shapes = [&world.primitives[0], &world.instances[0].object.primitives[0]];
    let x = shapes.map(|primitive| match &primitive.shape {
        Shape::TriangleMesh(mesh) => mesh.positions[1][0],
        other => panic!("{other:?}"),
    });
    assert_eq!(x, [1.0, 6.0]);
}

#[test]
fn shapes_with_wrong_files_are_left_out() {
    let (bad, good) = (mesh("bad.ply"), mesh("a.ply"));
    let world =
        format!("{bad} {good} {bad} Shape \"sphere\" ObjectBegin \"o\" {bad} ObjectEnd ObjectInstance \"o\"");
    let keep_going = LoadOptions { keep_going: true, ..LoadOptions::default() };
    let (loaded, _) = loaded(&world, &keep_going);
    assert_eq!((loaded.diagnostics.len(), loaded.diagnostics[0].all_places().count()), (1, 3));
    let world = loaded.scene.unwrap().world;
    assert!(matches!(&world.primitives[0].shape, Shape::TriangleMesh(mesh) if mesh.positions.len() == 3));
    assert!(matches!(world.primitives[1].shape, Shape::Quadric(_)));
    assert!(world.primitives.len() == 2 && world.instances.is_empty());
}

#[test]
fn pictures_are_shared() {
    let texture = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.pfm\"
        Texture \"s\" \"spectrum\" \"scale\" \"texture tex1\" \"t\"
        Material \"matte\" \"texture Kd\" \"s\" Shape \"sphere\" Shape \"sphere\"
        Material \"mirror\" \"texture Kr\" \"t\" Shape \"sphere\"
        LightSource \"projection\" \"string mapname\" \"a.pfm\"";
    let (loaded, files) = loaded(texture, &LoadOptions::default());
    assert_eq!(files, [Path::new("a.pfm"); 2], "one read for each of two settings");
    let world = loaded.scene.unwrap().world;
    let [first, second, mirror] = &world.primitives[..] else { panic!("{world:?}") };
    assert!(Arc::ptr_eq(&first.material, &second.material));
    let MaterialKind::Matte(matte) = &first.material.kind else { panic!("{first:?}") };
    let MaterialKind::Mirror(mirror) = &mirror.material.kind else { panic!("{mirror:?}") };
    let (Texture::Varying(scale), Texture::Varying(image)) = (&matte.kd, &mirror.kr) else { panic!() };
    let Varying::Scale([Texture::Varying(scaled), _]) = &scale.texture else { panic!("{scale:?}") };
    assert!(Arc::ptr_eq(scaled, image));
    let Varying::ImageMap(image) = &image.texture else { panic!("{image:?}") };
    assert_eq!(image.map.picture_size(), [2, 1]);
    let Light::Projection { half_size, .. } = &world.lights[1] else { panic!("{:?}", world.lights) };
    assert!((half_size.x / half_size.y - 2.0).abs() < 1e-12);
}

#[test]
fn pictures_are_read_ahead_as_if_one_by_one() {
    let texture =
        |name: &str| format!("Texture \"{name}\" \"float\" \"imagemap\" \"string filename\" \"{name}\" ");
    let names = ["a.pfm", "bad.pfm", "b.pfm", "a.pfm", "none.txt", "c.pfm", "b.pfm"];
    let world = names.map(texture).concat();
    let [one, many] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (loaded, _) = pool.install(|| loaded(&world, &LoadOptions::default()));
        (loaded.diagnostics, loaded.inputs)
    });
    assert_eq!(one, many);
    assert_eq!(
        one.0.iter().filter(|diagnostic| diagnostic.severity == lookat_syntax::Severity::Error).count(),
        2
    );
}

/// As in pbrt-v3.
#[test]
fn a_wrong_picture_is_gray_on_a_surface_and_missing_in_a_light() {
    let world = "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"bad.pfm\" \"float scale\" 3
        Material \"matte\" \"texture sigma\" \"t\" Shape \"sphere\"
        LightSource \"infinite\" \"string mapname\" \"bad.pfm\"";
    let keep_going = LoadOptions { keep_going: true, ..LoadOptions::default() };
    let world = loaded(world, &keep_going).0.scene.unwrap().world;
    let MaterialKind::Matte(matte) = &world.primitives[0].material.kind else { panic!("{world:?}") };
    let Texture::Varying(node) = &matte.sigma else { panic!("{matte:?}") };
    let Varying::ImageMap(image) = &node.texture else { panic!("{node:?}") };
    assert!((image.map.mean() - 1.5).abs() < 1e-6);
    assert!(matches!(world.lights[1], Light::Infinite { .. }));
}

#[test]
fn a_fast_check_finds_no_darkness_in_what_it_does_not_read() {
    let world = format!("AreaLightSource \"diffuse\" {}", mesh("a.ply"));
    let fast = LoadOptions { fast: true, ..LoadOptions::default() };
    let (loaded, _) = loaded(&world, &fast);
    assert!(loaded.diagnostics.is_empty() && loaded.scene.is_none(), "{:?}", loaded.diagnostics);
    assert_eq!(loaded.unread, 1);
}

/// The instances of a world without errors.
fn instances(world: &str) -> Vec<Instance> {
    let (loaded, _) = loaded(world, &LoadOptions::default());
    loaded.scene.unwrap_or_else(|| panic!("{:?}", loaded.diagnostics)).world.instances.clone()
}

fn x_at(instance: &Instance, time: f64) -> f64 {
    let motion = instance.motion.as_ref().unwrap();
    motion.iter().rev().fold(DVec3::ZERO, |p, motion| motion.at(time).point(p)).x
}

#[test]
fn what_moves_is_an_instance() {
    let ball = "Shape \"sphere\"";
    let [moved] = &instances(&format!(
        "Translate 1 0 0 ActiveTransform EndTime Translate 4 0 0 ActiveTransform All {ball} ActiveTransform StartTime
         Translate 4 0 0 {ball}"
    ))[..] else {
        panic!("one of them stands still, as both times have the same transformation");
    };
    assert_eq!([0.0, 0.5, 1.0, 3.0].map(|time| x_at(moved, time)), [1.0, 3.0, 5.0, 5.0]);
    let [still, inner] = &instances(&format!(
        "ObjectBegin \"o\" {ball} ActiveTransform EndTime Translate 4 0 0 {ball} ObjectEnd
         Scale 2 1 1 ObjectInstance \"o\""
    ))[..] else {
        panic!("the object and what moves in it");
    };
    assert!(still.motion.is_none() && still.object.primitives.len() == 1);
    assert_eq!([0.0, 0.25, 1.0].map(|time| x_at(inner, time)), [0.0, 2.0, 8.0]);
    assert_eq!(inner.bounds([DVec3::NEG_ONE, DVec3::ONE])[1].x.round(), 10.0);
}

/// A coordinate system has both transformations, and blocks restore which of them change.
#[test]
fn names_and_blocks_keep_both_times() {
    let [moved, alike] = &instances(
        "AttributeBegin ActiveTransform EndTime Translate 2 0 0 CoordinateSystem \"c\" AttributeEnd
         Translate 9 0 0 AttributeBegin CoordSysTransform \"c\" Shape \"sphere\" AttributeEnd
         TransformBegin ActiveTransform EndTime TransformEnd Translate 1 0 0 Shape \"sphere\"
         CoordSysTransform \"c\" Translate 1 0 0 Shape \"sphere\"",
    )[..] else {
        panic!("one stands still");
    };
    assert_eq!(
        [x_at(moved, 0.0), x_at(moved, 1.0), x_at(alike, 0.0), x_at(alike, 1.0)],
        [0.0, 2.0, 1.0, 3.0]
    );
}
