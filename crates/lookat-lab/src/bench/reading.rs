//! Meshes from files, which are in memory already.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use lookat_scene::load_opened;

use super::meshes::{as_ply, as_text, sphere};
use super::table::{BenchRow, BenchTable, Cell, in_turn, timed};
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
    let seconds = in_turn(rounds, files.len(), |file| seconds(&files[file], triangles));
    let row = |(file, seconds): (&File, &Vec<f64>)| {
        let size = file.bytes.len() as f64 / 1e6;
        let of = |value: &dyn Fn(f64) -> f64| Cell::of(seconds.iter().map(|seconds| value(*seconds)));
        let cells = vec![
            of(&|_| size),
            of(&|seconds| seconds),
            of(&|seconds| size / seconds),
            of(&|seconds| triangles as f64 / seconds / 1e6),
        ];
        BenchRow { name: file.name.into(), cells }
    };
    BenchTable {
        name: "reading",
        title: format!("a mesh of {triangles} triangles, from memory to a scene"),
        columns: vec!["MB", "s", "MB/s", "million triangles/s"],
        rows: files.iter().zip(&seconds).map(row).collect(),
    }
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
