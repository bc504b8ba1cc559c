//! Triangle meshes in the PLY format, read as the shape `plymesh` of pbrt-v3 reads them.
//!
//! A PLY file is a text header that names elements and their properties, and a body with their values in text
//! or binary. Only `vertex` and `face` matter here; whatever else the header announces is stepped over.
//!
//! Files come from anywhere, so nothing is taken on trust: memory grows with the bytes that are there, not with the
//! counts that the header promises.

mod body;
mod header;
mod source;
mod stream;

use std::fmt;
use std::io::{self, Read};

use flate2::read::MultiGzDecoder;
use lookat_image::MemoryBudget;

use header::{Element, Format, Header};
use stream::Stream;

/// The most bytes that a compressed file may unpack to.
const INFLATED_LIMIT: u64 = 4 << 30;

/// A triangle mesh in the space of its file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlyMesh {
    /// One position per vertex, all finite.
    pub positions: Vec<[f64; 3]>,
    /// One shading normal per vertex, all finite and of any length; empty if the file has none.
    pub normals: Vec<[f64; 3]>,
    /// One texture coordinate per vertex, all finite; empty if the file has none.
    pub uvs: Vec<[f64; 2]>,
    /// Three indices into `positions` per triangle, all in range. Empty if no face is a triangle or a quad.
    pub indices: Vec<i32>,
    /// How many faces are neither triangles nor quads. They are left out, as in pbrt-v3.
    pub other_faces: usize,
    /// Whether the file goes on after what its header counts. That is left out, as in pbrt-v3.
    pub goes_on: bool,
}

/// Why a PLY file cannot be read, in words for its user. Vertices, faces and bytes are counted from 0, as in
/// the file, and lines from 1, as in editors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlyError(pub String);

impl fmt::Display for PlyError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for PlyError {}

/// Reads the mesh from a PLY file, piece by piece: ascii or binary in either byte order, plain or gzipped.
///
/// Quads become two triangles. Normals and texture coordinates are read if all their properties are there.
/// It is an error if the file is malformed or cut short, has no vertices or no faces, refers to a vertex that does not
/// exist, or has a value that is not finite.
///
/// # Errors
///
/// Those of `file`.
pub fn read(mut file: impl Read, memory: &MemoryBudget) -> io::Result<Result<PlyMesh, PlyError>> {
    let mut magic = Vec::new();
    file.by_ref().take(2).read_to_end(&mut magic)?;
    let zipped = magic == [0x1f, 0x8b];
    let file = io::Cursor::new(magic).chain(file);
    if zipped {
        return Ok(read_zipped(file, INFLATED_LIMIT, memory));
    }
    let mut stream = Stream::new(file);
    let mesh = read_stream(&mut stream, memory);
    stream.error().map_or(Ok(mesh), Err)
}

/// Reads gzip data. The size that the data claims for itself is not looked at: it may be wrong.
fn read_zipped(file: impl Read, limit: u64, memory: &MemoryBudget) -> Result<PlyMesh, PlyError> {
    let mut stream = Stream::new(MultiGzDecoder::new(file).take(limit + 1));
    let mesh = read_stream(&mut stream, memory);
    // The check sum is at the end.
    let size = stream.skip_all();
    if let Some(error) = stream.error() {
        return Err(PlyError(format!("the gzip data is damaged or cut short ({error})")));
    }
    if size > limit {
        return Err(PlyError(format!("the gzip data unpacks to more than {limit} bytes")));
    }
    mesh.map_err(|error| PlyError(format!("in the unpacked data: {error}")))
}

fn read_stream(stream: &mut Stream<impl Read>, memory: &MemoryBudget) -> Result<PlyMesh, PlyError> {
    let header = header::parse(stream)?;
    let mesh = read_body(&header, stream, memory).map_err(|error| {
        // What the file cannot hold explains everything else.
        let available = stream.skip_all() - header.size;
        header
            .elements
            .iter()
            .find_map(|element| broken_promise(&header, element, available))
            .unwrap_or(error)
    })?;
    Ok(PlyMesh { goes_on: stream.goes_on(), ..mesh })
}

fn read_body(
    header: &Header,
    stream: &mut Stream<impl Read>,
    memory: &MemoryBudget,
) -> Result<PlyMesh, PlyError> {
    for (name, plural) in [("vertex", "vertices"), ("face", "faces")] {
        if header.elements.iter().all(|element| element.name != name || element.count == 0) {
            return Err(PlyError(format!("the PLY file has no {plural}")));
        }
    }
    match header.elements.iter().find_map(too_many) {
        Some(error) => Err(error),
        None => {
            let bytes = header.elements.iter().map(most_bytes).fold(0, u64::saturating_add);
            memory.check(bytes).map_err(|shortage| PlyError(format!("the mesh is too large: {shortage}")))?;
            body::read(header, stream)
        }
    }
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

/// The error for a count that the file cannot hold, or that is too large.
fn broken_promise(header: &Header, element: &Element, available: u64) -> Option<PlyError> {
    // The last value of a text needs no space after it, hence the extra byte.
    let (size, room) = match header.format {
        Format::Ascii => (2 * element.properties.len(), available + 1),
        _ => (element.binary_size(), available),
    };
    if element.count.saturating_mul(size as u64) > room {
        let promise = element.promise();
        return Some(PlyError(format!("{promise}, but the file has only {available} bytes after it")));
    }
    too_many(element)
}

/// The error for more vertices than there are indices.
fn too_many(element: &Element) -> Option<PlyError> {
    let most = i32::MAX;
    (element.name == "vertex" && element.count > most as u64)
        .then(|| PlyError(format!("{}, but at most {most} can be indexed", element.promise())))
}

/// A word of the file for an error message: short and printable whatever it is.
fn quote(word: &[u8]) -> String {
    let (shown, dots) = if word.len() > 32 { (&word[..32], "...") } else { (word, "") };
    format!("`{}{dots}`", String::from_utf8_lossy(shown).escape_debug())
}

#[cfg(test)]
mod tests;
