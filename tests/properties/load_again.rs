//! Scenes that are loaded again are the same as scenes that are loaded alone, after any change.

use std::cell::RefCell;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Cursor, Read};
use std::ops::ControlFlow;
use std::path::Path;

use lookat_render::{Settings, render};
use lookat_scene::{
    FilmOverride, LoadCache, LoadOptions, Loaded, Scene, Shape, Stamp, View, load_again, load_opened,
};

/// Scenes with each feature that a cache keeps between loads: included files, meshes, pictures, spectra, textures, materials, objects
/// and errors.
const SCENES: [&str; 30] = [
    "pbrt-scenes/coordinate-systems",
    "pbrt-scenes/cornell-glossy",
    "pbrt-scenes/first",
    "pbrt-scenes/gallery/clockwork",
    "pbrt-scenes/gallery/dandelion",
    "pbrt-scenes/gallery/ringed-planet",
    "pbrt-scenes/gallery/still-life",
    "pbrt-scenes/lights/goniometric",
    "pbrt-scenes/lights/infinite-map",
    "pbrt-scenes/lights/spectra",
    "pbrt-scenes/materials/mix",
    "pbrt-scenes/materials/on-shapes",
    "pbrt-scenes/meshes",
    "pbrt-scenes/object-instances",
    "pbrt-scenes/shapes/curve",
    "pbrt-scenes/shapes/heightfield",
    "pbrt-scenes/shapes/nurbs",
    "pbrt-scenes/shapes/subdivided",
    "pbrt-scenes/textures/alpha",
    "pbrt-scenes/textures/imagemap",
    "pbrt-scenes/textures/procedural",
    "tests/diagnostics/block/crossed-deep",
    "tests/diagnostics/include/errors-in-order",
    "tests/diagnostics/include/lfs-pointers",
    "tests/diagnostics/include/missing-all",
    "tests/diagnostics/include/open-block",
    "tests/diagnostics/include/valid",
    "tests/diagnostics/many/parameters",
    "tests/diagnostics/ply/valid",
    "tests/diagnostics/texture/nested",
];

/// A hash of the arrays of all meshes.
fn hash_of_arrays(scene: &Scene) -> u64 {
    let mut hasher = DefaultHasher::new();
    for primitive in scene.world.shapes() {
        let Shape::TriangleMesh(mesh) = &primitive.shape else { continue };
        mesh.indices().hash(&mut hasher);
        let uvs = mesh.uvs().as_flattened();
        let numbers = [mesh.positions(), mesh.normals(), mesh.tangents()].map(|it| it.as_flattened());
        for number in numbers.into_iter().chain([uvs]).flatten() {
            number.to_bits().hash(&mut hasher);
        }
    }
    hasher.finish()
}

/// Everything that loading gives. A large scene is a hash of its arrays.
fn result(loaded: &Loaded) -> [String; 4] {
    let Loaded { scene, diagnostics, symbols, places, output, inputs, placement, .. } = loaded;
    let rest = (symbols, places, output, inputs, placement, loaded.can_keep_going, &loaded.override_error);
    let memory = scene.as_ref().map(|scene| scene.world.memory()).unwrap_or_default();
    let world = match scene {
        Some(scene) if memory.meshes + memory.picture_bytes >= 100_000 => {
            format!("{memory:?} {:?} {:x}", scene.world.bounds(), hash_of_arrays(scene))
        }
        _ => format!("{scene:?}"),
    };
    // A scene prints without the texels of its pictures, so a render stands for them.
    let texels = scene.as_ref().filter(|_| memory.pictures > 0).map(|scene| {
        let view = View { sampler: scene.view.sampler.with_samples(1), ..scene.view.clone() };
        let scene = Scene { view, ..scene.clone() };
        render(&scene, &Settings::default(), &|_| ControlFlow::Continue(())).image.channels
    });
    [format!("{diagnostics:?}"), world, format!("{texels:?}"), format!("{rest:?}")]
}

fn check(path: &Path) {
    let text = RefCell::new(std::fs::read(path).unwrap());
    let open = |file: &Path| -> io::Result<Box<dyn Read>> {
        match file == path {
            true => Ok(Box::new(Cursor::new(text.borrow().clone()))),
            false => Ok(Box::new(lookat_image::open_file(file)?)),
        }
    };
    let stamp = |file: &Path| {
        let found = std::fs::metadata(file).ok().filter(|_| file != path)?;
        Some(Stamp { modified: found.modified().ok(), length: found.len(), number: 0 })
    };
    let film = FilmOverride { resolution: Some([16, 16]), ..FilmOverride::default() };
    let options = LoadOptions { max_memory: Some(1_000_000_000), film, ..LoadOptions::default() };
    let mut cache = LoadCache::default();
    let mut check = |what: &str| {
        let alone = result(&load_opened(path, &open, &options));
        let again = result(&load_again(path, &open, &mut cache, &stamp, &options));
        assert!(alone == again, "{} {what}\n{}\n{}", path.display(), alone[0], again[0]);
    };
    let whole = text.borrow().clone();
    check("first");
    check("again");
    let lines: Vec<&[u8]> = whole.split_inclusive(|byte| *byte == b'\n').collect();
    for part in 0..4 {
        // Without a line, and back.
        let (before, after) = lines.split_at(part * lines.len() / 4);
        *text.borrow_mut() = [before, after.get(1..).unwrap_or_default()].concat().concat();
        check("without a line");
        *text.borrow_mut() = [before, &[b"# edited\n".as_slice()], after].concat().concat();
        check("with a comment");
    }
}

#[test]
fn scenes_are_the_same_when_they_are_loaded_again() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    SCENES.iter().for_each(|name| check(&root.join(name).with_extension("pbrt")));
}
