//! Meshes in PLY files, each file read once.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use lookat_image::Charge;
use lookat_syntax::{Diagnostic, Text};

use crate::Transform;
use crate::files::Files;
use crate::mesh::{Mesh, finish};
use crate::params::Params;
use crate::ply::{self, PlyError, PlyMesh};

/// The PLY files of a scene.
#[derive(Default)]
pub(crate) struct PlyFiles {
    /// The uses of each file that are left, by the first path tried.
    left: HashMap<PathBuf, usize>,
    /// Files with uses left: the path found, and the mesh in the space of the file.
    known: HashMap<PathBuf, (PathBuf, PlyMesh, Charge)>,
}

impl PlyFiles {
    /// Announces a use of a file.
    pub fn expect(&mut self, files: &Files, name: &Text) {
        *self.left.entry(files.beside(&name.value, name.span)).or_default() += 1;
    }

    /// The mesh in a file, in world space. Reports an error and returns `None` without one.
    pub fn mesh(&mut self, params: &mut Params, name: &Text, world_from_object: Transform) -> Option<Mesh> {
        let mesh = self.file(params, name)?;
        if mesh.other_faces > 0 {
            let message = format!(
                "{} has faces that do not have 3 or 4 corners; number of skipped faces: {}{}",
                name.value,
                mesh.other_faces,
                if mesh.indices.is_empty() { ", and no face remains" } else { "" }
            );
            params.warn("filename", &message, "split them into triangles; pbrt-v3 skips them, too");
        }
        if mesh.goes_on {
            let message = format!("{} contains more data than its header declares", name.value);
            let help = "the rest is ignored, as in pbrt-v3; check the counts in the header";
            params.warn("filename", &message, help);
        }
        let PlyMesh { positions, normals, uvs, indices, .. } = mesh;
        finish(params, Mesh { positions, indices, normals, uvs, ..Mesh::default() }, world_from_object)
    }

    /// Reports a file that cannot be opened, or that has a wrong header. Reads no more.
    pub fn check_header(params: &mut Params, name: &Text) {
        if let Some((path, file)) = params.open(name) {
            report(params, name, &path, ply::check_header(file));
        }
    }

    /// The contents of a file. Keeps a copy if it has uses left.
    fn file(&mut self, params: &mut Params, name: &Text) -> Option<PlyMesh> {
        let first = params.first_path(name);
        let left = self.left.get_mut(&first).map_or(0, |left| {
            *left = left.saturating_sub(1);
            *left
        });
        if let Some((path, mesh, charge)) = self.known.remove(&first) {
            params.warn_of_path(name, &path);
            if left > 0 {
                self.known.insert(first, (path, mesh.clone(), charge));
            }
            return Some(mesh);
        }
        let (path, file) = params.open(name)?;
        let mesh = report(params, name, &path, ply::read(file, params.memory()))?;
        // A file that does not fit into memory twice is read again.
        if left > 0
            && let Ok(charge) = params.memory().reserve(mesh.bytes() as u64)
        {
            self.known.insert(first, (path, mesh.clone(), charge));
        }
        Some(mesh)
    }
}

/// What was read. Reports an error.
fn report<T>(
    params: &mut Params,
    name: &Text,
    path: &Path,
    read: io::Result<Result<T, PlyError>>,
) -> Option<T> {
    match read {
        Ok(Ok(read)) => return Some(read),
        Ok(Err(error)) => {
            params.error(Diagnostic::error(name.span, format!("{}: {error}", path.display())));
        }
        Err(error) => params.unreadable(name, path, &error),
    }
    None
}
