//! The body of a PLY file: the rows of its elements, in text or binary.

use std::io::Read;

use lookat_syntax::{decimal, digits};

use crate::mesh::{Mesh, VertexShading};
use crate::ply::header::{Element, Format, Header, PropertyType, Scalar};
use crate::ply::stream::{LONGEST, Stream};
use crate::ply::{PlyError, PlyMesh, quote};

/// The most rows to reserve memory for before reading them.
const MOST_RESERVED: u64 = 1 << 20;

/// Reads the body.
pub fn read(header: &Header, stream: &mut Stream<impl Read>) -> Result<PlyMesh, PlyError> {
    match header.format {
        Format::Ascii => read_elements(header, Ascii(stream)),
        Format::BinaryLittleEndian => read_elements(header, Binary::<_, false>(stream)),
        Format::BinaryBigEndian => read_elements(header, Binary::<_, true>(stream)),
    }
}

fn read_elements(header: &Header, mut source: impl Source) -> Result<PlyMesh, PlyError> {
    let vertex_count = header.elements.iter().find(|element| element.name == "vertex").map_or(0, |e| e.count);
    let mut mesh = PlyMesh::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(&mut source, element, &mut mesh.mesh)?,
            "face" => read_faces(&mut source, element, vertex_count, &mut mesh)?,
            _ => skip_rows(&mut source, element)?,
        }
    }
    Ok(mesh)
}

/// Runs `row` for each row of the element, and adds the place to its fault.
fn for_rows<S: Source>(
    source: &mut S,
    element: &Element,
    mut row: impl FnMut(&mut S) -> Result<(), RowError>,
) -> Result<(), PlyError> {
    for index in 0..element.count {
        let start = source.position();
        if let Err(fault) = row(source) {
            let subject = format!("{} {index}", element.noun());
            return Err(PlyError(match fault {
                RowError::End => format!("the file ends inside {subject} of {}", element.count),
                RowError::Bad(text) => format!("{}: {subject} {text}", source.location(start)),
            }));
        }
    }
    Ok(())
}

/// Checks that the properties of an element suffice for a mesh.
pub fn check(element: &Element) -> Result<(), PlyError> {
    match element.name.as_str() {
        "vertex" => plan_vertices(element).map(drop),
        "face" => find_corners(element).map(drop),
        _ => Ok(()),
    }
}

fn skip_rows<S: Source>(source: &mut S, element: &Element) -> Result<(), PlyError> {
    // Rows without properties take no bytes, so their number has no limit.
    if element.properties.is_empty() {
        return Ok(());
    }
    for_rows(source, element, |source| {
        element.properties.iter().try_for_each(|property| source.skip_property(property.kind))
    })
}

/// The use of a vertex property.
enum VertexStep {
    /// The channel in x y z, nx ny nz, u v.
    Channel(usize, Scalar),
    Skip(PropertyType),
}

/// The vertex properties and their channels.
struct VertexPlan {
    steps: Vec<VertexStep>,
    has_normals: bool,
    has_uvs: bool,
}

/// The names of texture coordinates in the order in which pbrt-v3 tries them.
const UV_NAMES: [[&str; 2]; 4] =
    [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

fn plan_vertices(element: &Element) -> Result<VertexPlan, PlyError> {
    let mut steps: Vec<_> =
        element.properties.iter().map(|property| VertexStep::Skip(property.kind)).collect();
    let number = |name: &str| {
        let index = element.find(name)?;
        match element.properties[index].kind {
            PropertyType::One(scalar) => Some((index, scalar)),
            PropertyType::List { .. } => None,
        }
    };
    // Only complete groups are used.
    let mut assign = |names: &[&str], first_channel: usize| {
        let found = names.iter().map(|name| number(name)).collect::<Option<Vec<_>>>();
        let Some(found) = found else { return false };
        for (channel, (index, scalar)) in (first_channel..).zip(found) {
            steps[index] = VertexStep::Channel(channel, scalar);
        }
        true
    };
    const POSITION: [&str; 3] = ["x", "y", "z"];
    if !assign(&POSITION, 0) {
        let missing = POSITION.iter().filter(|name| number(name).is_none());
        let missing: Vec<String> = missing.map(|name| format!("`{name}`")).collect();
        return Err(PlyError(format!("the vertices have no number {}", missing.join(" and "))));
    }
    let has_normals = assign(&["nx", "ny", "nz"], 3);
    let has_uvs = UV_NAMES.iter().any(|names| assign(names, 6));
    Ok(VertexPlan { steps, has_normals, has_uvs })
}

fn read_vertices<S: Source>(source: &mut S, element: &Element, mesh: &mut Mesh) -> Result<(), PlyError> {
    let plan = plan_vertices(element)?;
    let count = element.count.min(MOST_RESERVED) as usize;
    mesh.positions.to_mut().reserve_exact(count);
    let mut shading = VertexShading::default();
    shading.normals.to_mut().reserve_exact(if plan.has_normals { count } else { 0 });
    shading.uvs.to_mut().reserve_exact(if plan.has_uvs { count } else { 0 });
    for_rows(source, element, |source| {
        let mut row = [0.0; 8];
        for step in &plan.steps {
            match *step {
                VertexStep::Channel(channel, scalar) => row[channel] = source.real(scalar)?,
                VertexStep::Skip(kind) => source.skip_property(kind)?,
            }
        }
        push_vertex(&plan, row, mesh, &mut shading)
    })?;
    *mesh = std::mem::take(mesh).with_shading(shading);
    Ok(())
}

/// Adds a vertex, if it is finite.
#[inline]
fn push_vertex(
    plan: &VertexPlan,
    row: [f64; 8],
    mesh: &mut Mesh,
    shading: &mut VertexShading,
) -> Result<(), RowError> {
    let [x, y, z, nx, ny, nz, u, v] = row;
    mesh.positions.to_mut().push(finite([x, y, z], "position")?);
    if plan.has_normals {
        shading.normals.to_mut().push(finite([nx, ny, nz], "normal")?);
    }
    if plan.has_uvs {
        shading.uvs.to_mut().push(finite([u, v], "texture coordinate")?);
    }
    Ok(())
}

#[inline]
fn finite<const N: usize>(values: [f64; N], what: &str) -> Result<[f64; N], RowError> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(values);
    }
    Err(RowError::Bad(format!("has the {what} {values:?}, which is not finite")))
}

/// The index of the vertex list property of faces, and the types of its count and items.
fn find_corners(element: &Element) -> Result<(usize, Scalar, Scalar), PlyError> {
    let index = element.find("vertex_indices").or_else(|| element.find("vertex_index"));
    let Some((index, PropertyType::List { count, item })) = index.map(|i| (i, element.properties[i].kind))
    else {
        return Err(PlyError("the faces have no list property `vertex_indices`".into()));
    };
    if !item.is_integer() {
        return Err(PlyError("the list `vertex_indices` of the faces has no integer type".into()));
    }
    Ok((index, count, item))
}

fn read_faces<S: Source>(
    source: &mut S,
    element: &Element,
    vertex_count: u64,
    mesh: &mut PlyMesh,
) -> Result<(), PlyError> {
    let (corners, count, item) = find_corners(element)?;
    mesh.mesh.indices.to_mut().reserve_exact(3 * element.count.min(MOST_RESERVED) as usize);
    let (before, after) = (&element.properties[..corners], &element.properties[corners + 1..]);
    for_rows(source, element, |source| {
        before.iter().try_for_each(|property| source.skip_property(property.kind))?;
        match source.length(count)? {
            3 => {
                let face = source.integers::<3>(item)?;
                mesh.mesh.indices.to_mut().extend(in_range(face, vertex_count)?);
            }
            4 => {
                let face = source.integers::<4>(item)?;
                let [a, b, c, d] = in_range(face, vertex_count)?;
                // The diagonal and corner order of pbrt-v3.
                mesh.mesh.indices.to_mut().extend([a, b, c, d, a, c]);
            }
            length => {
                source.skip(item, length)?;
                mesh.oddities.other_faces += 1;
            }
        }
        after.iter().try_for_each(|property| source.skip_property(property.kind))
    })
}

/// The corners of a face as indices, if all vertices exist.
#[inline]
fn in_range<const N: usize>(face: [i64; N], vertex_count: u64) -> Result<[i32; N], RowError> {
    // A negative index becomes a huge one. There are at most `i32::MAX` vertices.
    match face.iter().find(|&&corner| corner as u64 >= vertex_count) {
        None => Ok(face.map(|corner| corner as i32)),
        Some(corner) => {
            Err(RowError::Bad(format!("refers to vertex {corner}, but there are {vertex_count} vertices")))
        }
    }
}

/// The reason why a row is unreadable.
pub enum RowError {
    /// The file ends inside the row.
    End,
    /// Another reason, as a text to follow "vertex 3".
    Bad(String),
}

/// A source of numbers in the body.
pub trait Source {
    /// The bytes read so far, including the header.
    fn position(&self) -> u64;

    /// The line or the byte of a fault in the row that starts at `row_start`.
    fn location(&self, row_start: u64) -> String;

    /// The next number.
    fn real(&mut self, scalar: Scalar) -> Result<f64, RowError>;

    /// The next `N` numbers of an integer type.
    fn integers<const N: usize>(&mut self, scalar: Scalar) -> Result<[i64; N], RowError>;

    /// Skips numbers.
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), RowError>;

    /// The next number as the length of a list.
    #[inline]
    fn length(&mut self, scalar: Scalar) -> Result<u64, RowError> {
        let [length] = self.integers(scalar)?;
        u64::try_from(length).map_err(|_| RowError::Bad(format!("has a list of {length} values")))
    }

    /// Skips a property.
    fn skip_property(&mut self, kind: PropertyType) -> Result<(), RowError> {
        match kind {
            PropertyType::One(scalar) => self.skip(scalar, 1),
            PropertyType::List { count, item } => {
                let length = self.length(count)?;
                self.skip(item, length)
            }
        }
    }
}

/// Words between white space. Line ends have no other meaning, as in pbrt-v3.
pub struct Ascii<'s, R>(pub &'s mut Stream<R>);

impl<R: Read> Ascii<'_, R> {
    /// The bytes in memory after white space.
    #[inline(always)]
    fn rest(&mut self) -> &[u8] {
        let rest = self.0.rest();
        let blanks = rest.iter().position(|byte| !byte.is_ascii_whitespace());
        let count = blanks.unwrap_or(rest.len());
        self.0.step(count);
        self.0.rest()
    }

    fn word(&mut self) -> Result<&[u8], RowError> {
        while self.rest().is_empty() {
            if !self.0.more() {
                return Err(RowError::End);
            }
        }
        Ok(self.0.until(u8::is_ascii_whitespace))
    }

    /// Reads a number in any form that Rust accepts.
    #[cold]
    fn number<T: std::str::FromStr>(&mut self, wanted: &str) -> Result<T, RowError> {
        let word = self.word()?;
        // A word of the longest length may continue.
        let whole = Some(word).filter(|word| word.len() < LONGEST);
        let parsed = whole.and_then(|word| std::str::from_utf8(word).ok()?.parse().ok());
        parsed.ok_or_else(|| RowError::Bad(format!("has {} in place of {wanted}", quote(word))))
    }
}

/// True if a word ends after `length` bytes. False at the end of a piece, where this is unknown.
#[inline]
fn ends(rest: &[u8], length: usize) -> bool {
    rest.get(length).is_some_and(u8::is_ascii_whitespace)
}

impl<R: Read> Source for Ascii<'_, R> {
    fn position(&self) -> u64 {
        self.0.position()
    }

    fn location(&self, _row_start: u64) -> String {
        format!("line {}", 1 + self.0.lines())
    }

    #[inline]
    fn real(&mut self, _scalar: Scalar) -> Result<f64, RowError> {
        let rest = self.rest();
        match decimal(rest) {
            Some((value, length)) if ends(rest, length) => {
                self.0.step(length);
                Ok(value)
            }
            _ => self.number("a number"),
        }
    }

    #[inline]
    fn integers<const N: usize>(&mut self, _scalar: Scalar) -> Result<[i64; N], RowError> {
        let mut integers = [0; N];
        for value in &mut integers {
            let rest = self.rest();
            *value = match digits(rest) {
                // 18 digits fit the type.
                (value, length @ 1..=18) if ends(rest, length) => {
                    self.0.step(length);
                    value as i64
                }
                _ => self.number("an integer")?,
            };
        }
        Ok(integers)
    }

    fn skip(&mut self, _scalar: Scalar, count: u64) -> Result<(), RowError> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }
}

/// Binary numbers, most significant byte first if `BIG`.
pub struct Binary<'s, R, const BIG: bool>(pub &'s mut Stream<R>);

impl<R: Read, const BIG: bool> Source for Binary<'_, R, BIG> {
    fn position(&self) -> u64 {
        self.0.position()
    }

    fn location(&self, row_start: u64) -> String {
        format!("byte {row_start}")
    }

    #[inline]
    fn real(&mut self, scalar: Scalar) -> Result<f64, RowError> {
        self.0.take(scalar.size()).map(|bytes| decode_real::<BIG>(scalar, bytes)).ok_or(RowError::End)
    }

    #[inline]
    fn integers<const N: usize>(&mut self, scalar: Scalar) -> Result<[i64; N], RowError> {
        let size = scalar.size();
        let bytes = self.0.take(N * size).ok_or(RowError::End)?;
        Ok(decode_integers::<BIG, N>(scalar, bytes))
    }

    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), RowError> {
        let size = count.checked_mul(scalar.size() as u64);
        size.is_some_and(|size| self.0.skip(size)).then_some(()).ok_or(RowError::End)
    }
}

/// The first `N` bytes, least significant first.
#[inline]
fn little_endian<const BIG: bool, const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut word = [0; N];
    word.copy_from_slice(&bytes[..N]);
    if BIG {
        word.reverse();
    }
    word
}

#[inline]
fn decode_integers<const BIG: bool, const N: usize>(scalar: Scalar, bytes: &[u8]) -> [i64; N] {
    match scalar {
        Scalar::I8 => decode_all::<BIG, N, _>(bytes, |word| i8::from_le_bytes(word).into()),
        Scalar::U8 => decode_all::<BIG, N, _>(bytes, |word| u8::from_le_bytes(word).into()),
        Scalar::I16 => decode_all::<BIG, N, _>(bytes, |word| i16::from_le_bytes(word).into()),
        Scalar::U16 => decode_all::<BIG, N, _>(bytes, |word| u16::from_le_bytes(word).into()),
        Scalar::I32 => decode_all::<BIG, N, _>(bytes, |word| i32::from_le_bytes(word).into()),
        Scalar::U32 => decode_all::<BIG, N, _>(bytes, |word| u32::from_le_bytes(word).into()),
        // Unreachable: the header rejects counts and indices of these types.
        Scalar::F32 | Scalar::F64 => [0; N],
    }
}

#[inline]
fn decode_all<const BIG: bool, const N: usize, const SIZE: usize>(
    bytes: &[u8],
    decode: impl Fn([u8; SIZE]) -> i64,
) -> [i64; N] {
    std::array::from_fn(|at| decode(little_endian::<BIG, SIZE>(&bytes[at * SIZE..])))
}

#[inline]
fn decode_real<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> f64 {
    match scalar {
        Scalar::F32 => f64::from(f32::from_le_bytes(little_endian::<BIG, 4>(bytes))),
        Scalar::F64 => f64::from_le_bytes(little_endian::<BIG, 8>(bytes)),
        integer => decode_integers::<BIG, 1>(integer, bytes)[0] as f64,
    }
}
