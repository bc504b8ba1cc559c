//! Meshes from files, which are in memory already.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use lookat_scene::load_opened;

use super::bench_table::{BenchTable, Column};
use super::meshes::{as_ply, as_text, sphere};
use crate::text_scene::around_eye;
use crate::timed;

/// The name of a file, its bytes, and the scene, which is that file or names it.
type File = (&'static str, Arc<[u8]>, Arc<[u8]>);

/// The same mesh as three files.
pub(super) fn table(rounds: usize) -> BenchTable {
    let mesh = sphere();
    let triangles = mesh.triangles();
    let lit = |shape: &str| -> Arc<[u8]> {
        around_eye(&format!("LightSource \"infinite\" {shape}")).into_bytes().into()
    };
    let (text, named) = (lit(&as_text(&mesh)), lit("Shape \"plymesh\" \"string filename\" \"mesh.ply\""));
    let ply = |name, binary| -> File { (name, as_ply(&mesh, binary).into(), named.clone()) };
    let files =
        [("text of the scene", text.clone(), text), ply("PLY, as text", false), ply("PLY, binary", true)];
    // Megabytes, triangles and seconds.
    let columns: [Column<[f64; 3]>; 4] = [
        ("MB", |[size, ..], _| *size),
        ("s", |[.., seconds], _| *seconds),
        ("MB/s", |[size, _, seconds], _| size / seconds),
        ("million triangles/s", |[_, triangles, seconds], _| triangles / seconds / 1e6),
    ];
    let title = format!("a mesh of {triangles} triangles, from memory to a scene");
    let names = files.iter().map(|file| file.0.into()).collect();
    BenchTable::measured(("reading", title), &columns, names, rounds, |file| {
        [files[file].1.len() as f64 / 1e6, triangles as f64, seconds(&files[file], triangles)]
    })
}

/// # Panics
///
/// If the mesh is not all there.
fn seconds((name, bytes, scene): &File, triangles: usize) -> f64 {
    let open = |path: &Path| -> std::io::Result<Box<dyn std::io::Read>> {
        let bytes = if path.extension().is_some() { bytes } else { scene };
        Ok(Box::new(Cursor::new(bytes.clone())))
    };
    let (seconds, loaded) = timed(|| load_opened(Path::new("scene"), &open, &Default::default()));
    let memory = loaded.scene.map_or(0, |scene| scene.world.memory().meshes);
    assert!(memory >= triangles * 12, "{name}: {:?}", loaded.diagnostics);
    seconds
}
