//! Meshes in PLY files, each file read once.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lookat_image::Charge;
use lookat_syntax::{Diagnostic, Text};

use crate::Transform;
use crate::cache::KeptMesh;
use crate::files::Files;
use crate::mesh::{Mesh, note_flat, place};
use crate::params::Params;
use crate::ply::{self, Oddities, PlyError, PlyMesh};

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
    pub fn mesh(
        &mut self,
        params: &mut Params,
        name: &Text,
        world_from_object: Transform,
    ) -> Option<Arc<Mesh>> {
        let first = params.first_path(name);
        let left = self.left.get_mut(&first).map_or(0, |left| {
            *left = left.saturating_sub(1);
            *left
        });
        let (path, file, known) = match self.known.remove(&first) {
            Some((path, mesh, charge)) => {
                params.warn_of_path(name, &path);
                (path, None, Some((mesh, charge)))
            }
            None => {
                let (path, file) = params.open(name)?;
                (path, Some(file), None)
            }
        };
        let key = params.mesh_file_key(&path, &world_from_object);
        let kept = key.as_ref().and_then(|key| params.kept_mesh(key));
        let keep = |path, mesh, charge| {
            if left > 0 {
                self.known.insert(first, (path, mesh, charge));
            }
        };
        if let Some(kept) = kept {
            if let Some((mesh, charge)) = known {
                keep(path, mesh, charge);
            }
            tell(params, name, &kept.oddities, kept.mesh.triangles());
            params.reserve("filename", kept.mesh.bytes())?.keep();
            note_flat(params, "filename", kept.flat, kept.mesh.triangles());
            return Some(kept.mesh);
        }
        let mesh = match known {
            Some((mesh, charge)) => {
                keep(path, mesh.clone(), charge);
                mesh
            }
            None => {
                let mesh = report(params, name, &path, ply::read(file?, params.memory()))?;
                // A file that does not fit into memory twice is read again.
                if left > 0
                    && let Ok(charge) = params.memory().reserve(mesh.bytes() as u64)
                {
                    keep(path, mesh.clone(), charge);
                }
                mesh
            }
        };
        let PlyMesh { positions, normals, uvs, indices, oddities } = mesh;
        tell(params, name, &oddities, indices.len() / 3);
        let mesh = Mesh { positions, indices, normals, uvs, ..Mesh::default() };
        let mesh = Arc::new(place(params, mesh, world_from_object)?);
        let flat = mesh.without_area();
        if let (Some(reuse), Some(key)) = (params.reuse(), key) {
            reuse.keep_mesh(key, KeptMesh { mesh: mesh.clone(), flat, oddities });
        }
        note_flat(params, "filename", flat, mesh.triangles());
        Some(mesh)
    }

    /// Reports a file that cannot be opened, or that has a wrong header. Reads no more.
    pub fn check_header(params: &mut Params, name: &Text) {
        if let Some((path, file)) = params.open(name) {
            // Faces are not counted.
            let oddities = report(params, name, &path, ply::check_header(file));
            oddities.iter().for_each(|oddities| tell(params, name, oddities, 0));
        }
    }
}

/// Reports faces that are left out, data after the last face, and what pbrt-v3 does not read.
fn tell(params: &mut Params, name: &Text, oddities: &Oddities, triangles: usize) {
    let Oddities { other_faces, goes_on, is_vertex_index, is_zipped } = *oddities;
    if is_zipped {
        let message = format!("pbrt-v3 cannot read {}, which is compressed", name.value);
        params.warn("filename", &message, "unpack it with gunzip");
    }
    if is_vertex_index {
        let message = format!(
            "pbrt-v3 draws nothing of {}: its faces have `vertex_index`, not `vertex_indices`",
            name.value
        );
        params.warn("filename", &message, "write `vertex_indices` in the header of the file");
    }
    if other_faces > 0 {
        let message = format!(
            "{} has faces that do not have 3 or 4 corners; number of skipped faces: {other_faces}{}",
            name.value,
            if triangles == 0 { ", and no face remains" } else { "" }
        );
        params.warn("filename", &message, "split them into triangles; pbrt-v3 skips them, too");
    }
    if goes_on {
        let message = format!("{} contains more data than its header declares", name.value);
        let help = "the rest is ignored, as in pbrt-v3; check the counts in the header";
        params.warn("filename", &message, help);
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
