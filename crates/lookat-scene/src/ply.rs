//! Triangle meshes in the PLY format, as read by the shape `plymesh` of pbrt-v3.
//!
//! A PLY file has a text header that declares elements and their properties, and a body with their values in text or
//! binary. This module reads `vertex` and `face`, and skips other elements.
//!
//! Files are untrusted: memory grows with the bytes in the file, not with the counts in the header.

mod body;
mod header;
mod stream;

use std::collections::HashMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::MultiGzDecoder;
use lookat_image::{Charge, MemoryBudget};
use lookat_syntax::{Diagnostic, Text};

use crate::Transform;
use crate::cache::KeptMesh;
use crate::files::Files;
use crate::mesh::{Mesh, Oddities, note_flat, to_world_space};
use crate::params::Params;
use crate::ply::header::{Element, Format, Header};
use crate::ply::stream::Stream;

/// The largest unpacked size of a compressed file, in bytes.
const INFLATED_LIMIT: u64 = 4 << 30;

/// A triangle mesh in the space of the file. Its numbers are finite and its indices in range.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlyMesh {
    /// No triangle if no face is a triangle or a quad.
    pub mesh: Mesh,
    /// What its author should know.
    pub oddities: Oddities,
}

/// The reason why a PLY file is unreadable, as a message. It counts vertices, faces and bytes from 0, as in the file,
/// and lines from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PlyError(pub String);

/// Streams a mesh from a PLY file: ascii or binary in either byte order, plain or gzipped.
///
/// A quad becomes two triangles. Normals and texture coordinates are read if all their properties exist. A malformed
/// or truncated file is an error, and so are a file without vertices or faces, an index out of range, and a value
/// that is not finite.
///
/// # Errors
///
/// The errors of `file`.
pub fn read(file: impl Read, memory: &MemoryBudget) -> io::Result<Result<PlyMesh, PlyError>> {
    let (file, is_zipped) = opened(file)?;
    if is_zipped {
        return Ok(read_zipped(file, INFLATED_LIMIT, memory));
    }
    let mut stream = Stream::new(file);
    let mesh = read_stream(&mut stream, memory);
    stream.error().map_or(Ok(mesh), Err)
}

/// Reads the header of a PLY file, and checks that it declares a mesh. Reads nothing after it.
///
/// # Errors
///
/// The errors of `file`.
pub fn check_header(file: impl Read) -> io::Result<Result<Oddities, PlyError>> {
    let (file, is_zipped) = opened(file)?;
    if is_zipped {
        let mut stream = Stream::new(MultiGzDecoder::new(file).take(INFLATED_LIMIT));
        let checked = header::parse(&mut stream).and_then(|header| check(&header));
        let checked = checked.map(|oddities| Oddities { is_zipped, ..oddities });
        return Ok(unzipped(checked, stream.error()));
    }
    let mut stream = Stream::new(file);
    let header = header::parse(&mut stream).and_then(|header| check(&header));
    stream.error().map_or(Ok(header), Err)
}

/// The file from its start, and true if it is compressed.
fn opened(mut file: impl Read) -> io::Result<(impl Read, bool)> {
    let mut magic = Vec::new();
    file.by_ref().take(2).read_to_end(&mut magic)?;
    let is_zipped = magic == [0x1f, 0x8b];
    Ok((io::Cursor::new(magic).chain(file), is_zipped))
}

/// Reads gzip data. Ignores the declared size, which may be wrong.
fn read_zipped(file: impl Read, limit: u64, memory: &MemoryBudget) -> Result<PlyMesh, PlyError> {
    let mut stream = Stream::new(MultiGzDecoder::new(file).take(limit + 1));
    let mesh = read_stream(&mut stream, memory);
    // The checksum is at the end.
    let size = stream.skip_all();
    let error = stream.error();
    if error.is_none() && size > limit {
        return Err(PlyError(format!("the gzip data unpacks to more than {limit} bytes")));
    }
    let mut mesh = unzipped(mesh, error)?;
    mesh.oddities.is_zipped = true;
    Ok(mesh)
}

/// The result of reading unpacked data, or the error of unpacking.
fn unzipped<T>(read: Result<T, PlyError>, error: Option<io::Error>) -> Result<T, PlyError> {
    match error {
        Some(error) => Err(PlyError(format!("the gzip data is damaged or cut short ({error})"))),
        None => read.map_err(|error| PlyError(format!("in the unpacked data: {error}"))),
    }
}

fn read_stream(stream: &mut Stream<impl Read>, memory: &MemoryBudget) -> Result<PlyMesh, PlyError> {
    let header = header::parse(stream)?;
    let oddities = check(&header)?;
    let bytes = header.elements.iter().map(most_bytes).fold(0, u64::saturating_add);
    let charge = memory.reserve(bytes);
    let refused = |shortage| PlyError(format!("the mesh is too large: {shortage}"));
    let read = charge.map_err(refused).and_then(|_charge| body::read(&header, stream));
    let mut mesh = read.map_err(|error| {
        // A count that does not fit the file explains other errors.
        let available = stream.skip_all() - header.size;
        header
            .elements
            .iter()
            .find_map(|element| broken_promise(&header, element, available))
            .unwrap_or(error)
    })?;
    let other_faces = mesh.oddities.other_faces;
    mesh.oddities = Oddities { other_faces, goes_on: stream.goes_on(), ..oddities };
    Ok(mesh)
}

/// Checks that a header declares a mesh, and tells what is odd about it.
fn check(header: &Header) -> Result<Oddities, PlyError> {
    for (name, plural) in [("vertex", "vertices"), ("face", "faces")] {
        if header.elements.iter().all(|element| element.name != name || element.count == 0) {
            return Err(PlyError(format!("the PLY file has no {plural}")));
        }
    }
    const MOST: u64 = i32::MAX as u64;
    let is_long = |element: &&Element| element.name == "vertex" && element.count > MOST;
    if let Some(element) = header.elements.iter().find(is_long) {
        return Err(PlyError(format!("{}, but at most {MOST} can be indexed", element.promise())));
    }
    header.elements.iter().try_for_each(body::check)?;
    let is_other = |element: &Element| element.name == "face" && element.find("vertex_indices").is_none();
    Ok(Oddities { is_vertex_index: header.elements.iter().any(is_other), ..Oddities::default() })
}

/// The most that the rows of an element take in memory: a position, a normal and coordinates, or the corners of a quad.
fn most_bytes(element: &Element) -> u64 {
    let row = match element.name.as_str() {
        "vertex" if element.find("nx").is_some() => 24 + 24 + 16,
        "vertex" => 24 + 16,
        "face" => 6 * 4,
        _ => 0,
    };
    element.count.saturating_mul(row)
}

/// The error for a count that does not fit the file.
fn broken_promise(header: &Header, element: &Element, available: u64) -> Option<PlyError> {
    // The extra byte: the last value of a text needs no space after it.
    let (size, room) = match header.format {
        Format::Ascii => (2 * element.properties.len(), available + 1),
        _ => (element.binary_size(), available),
    };
    (element.count.saturating_mul(size as u64) > room).then(|| {
        let promise = element.promise();
        PlyError(format!("{promise}, but the file has only {available} bytes after it"))
    })
}

/// A word of the file for an error message, shortened and printable.
fn quote(word: &[u8]) -> String {
    let (shown, dots) = if word.len() > 32 { (&word[..32], "...") } else { (word, "") };
    format!("`{}{dots}`", String::from_utf8_lossy(shown).escape_debug())
}

/// The PLY files of a scene.
#[derive(Default)]
pub(crate) struct PlyFiles {
    /// True to check only headers.
    pub fast: bool,
    /// The number of uses of files that were only checked, because `fast` is set.
    pub unread: usize,
    /// The files used so far, by the first path tried: the path found, and the mesh in the space of the file from the second use on.
    known: HashMap<PathBuf, (PathBuf, Option<(PlyMesh, Charge)>)>,
}

impl PlyFiles {
    /// The mesh in a file, in world space. Reports an error and returns `None` without one.
    pub fn mesh(
        &mut self,
        params: &mut Params,
        name: &Text,
        world_from_object: Transform,
    ) -> Option<Arc<Mesh>> {
        if self.fast {
            self.unread += 1;
            if let Some((path, file)) = params.file(name, Files::open_named)
                && let Some(oddities) = ok_or_report(params, name, &path, check_header(file))
            {
                // Faces are not counted.
                report_oddities(params, name, &oddities, 0);
            }
            return Some(Arc::new(Mesh::unread()));
        }
        let first = params.files.beside(&name.value, name.span);
        let (path, file, known) = match self.known.get(&first) {
            Some((path, Some((mesh, _)))) => {
                params.warn_of_path(name, path);
                (path.clone(), None, Some(mesh))
            }
            _ => {
                let (path, file) = params.file(name, Files::open_named)?;
                (path, Some(file), None)
            }
        };
        let key = params.files.mesh_file_key(&path, &world_from_object);
        if let Some(kept) = key.as_ref().and_then(|key| params.files.kept_mesh(key)) {
            report_oddities(params, name, &kept.oddities, kept.mesh.triangles());
            params.reserve("filename", kept.mesh.bytes())?.keep();
            note_flat(params, "filename", kept.flat, kept.mesh.triangles());
            return Some(kept.mesh);
        }
        let mesh = match known {
            Some(mesh) => mesh.clone(),
            None => {
                let mesh = ok_or_report(params, name, &path, read(file?, &params.files.memory))?;
                // Most files are used once. One that does not fit into memory twice is read again.
                let is_again = self.known.contains_key(&first);
                let charge =
                    is_again.then(|| params.files.memory.reserve(mesh.mesh.bytes() as u64).ok()).flatten();
                self.known.insert(first, (path, charge.map(|charge| (mesh.clone(), charge))));
                mesh
            }
        };
        let PlyMesh { mesh, oddities } = mesh;
        report_oddities(params, name, &oddities, mesh.triangles());
        let mesh = Arc::new(to_world_space(params, mesh, world_from_object)?);
        let flat = mesh.without_area();
        if let (Some(reuse), Some(key)) = (params.files.reuse, key) {
            reuse.keep_mesh(key, KeptMesh { mesh: mesh.clone(), flat, oddities });
        }
        note_flat(params, "filename", flat, mesh.triangles());
        Some(mesh)
    }
}

/// Reports faces that are left out, data after the last face, and what pbrt-v3 does not read.
fn report_oddities(params: &mut Params, name: &Text, oddities: &Oddities, triangles: usize) {
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

/// The result of reading. Reports an error and returns `None`.
fn ok_or_report<T>(
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

#[cfg(test)]
mod tests;
