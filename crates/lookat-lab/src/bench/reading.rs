//! Meshes from files, which are in memory already.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use lookat_scene::load_opened;

use super::meshes::{as_ply, as_text, sphere};
use super::table::{BenchTable, Column, timed};
use crate::text_scene::around_eye;

/// A file that is read.
struct File {
    name: &'static str,
    bytes: Arc<[u8]>,
    /// The scene, which is that file or names it.
    scene: Arc<[u8]>,
}

/// The same mesh as three files.
pub(super) fn table(rounds: usize) -> BenchTable {
    let mesh = sphere();
    let triangles = mesh.triangles();
    let files = files(&mesh);
    // Megabytes, triangles and seconds.
    let columns: [Column<[f64; 3]>; 4] = [
        ("MB", |[size, ..], _| *size),
        ("s", |[.., seconds], _| *seconds),
        ("MB/s", |[size, _, seconds], _| size / seconds),
        ("million triangles/s", |[_, triangles, seconds], _| triangles / seconds / 1e6),
    ];
    let title = format!("a mesh of {triangles} triangles, from memory to a scene");
    let names = files.iter().map(|file| file.name.into()).collect();
    BenchTable::measured(("reading", title), &columns, names, rounds, |file| {
        [files[file].bytes.len() as f64 / 1e6, triangles as f64, seconds(&files[file], triangles)]
    })
}

fn files(mesh: &lookat_scene::Mesh) -> Vec<File> {
    let lit = |shape: &str| around_eye(&format!("LightSource \"infinite\" {shape}"));
    let text: Arc<[u8]> = lit(&as_text(mesh)).into_bytes().into();
    let named: Arc<[u8]> = lit("Shape \"plymesh\" \"string filename\" \"mesh.ply\"").into_bytes().into();
    let ply = |name, binary| File { name, bytes: as_ply(mesh, binary).into(), scene: named.clone() };
    vec![
        File { name: "text of the scene", bytes: text.clone(), scene: text },
        ply("PLY, as text", false),
        ply("PLY, binary", true),
    ]
}

/// # Panics
///
/// If the mesh is not all there.
fn seconds(file: &File, triangles: usize) -> f64 {
    let open = |path: &Path| -> std::io::Result<Box<dyn std::io::Read>> {
        let bytes = if path.extension().is_some() { &file.bytes } else { &file.scene };
        Ok(Box::new(Cursor::new(bytes.clone())))
    };
    let (seconds, loaded) = timed(|| load_opened(Path::new("scene"), &open, &Default::default()));
    let memory = loaded.scene.map_or(0, |scene| scene.world.memory().meshes);
    assert!(memory >= triangles * 12, "{}: {:?}", file.name, loaded.diagnostics);
    seconds
}
