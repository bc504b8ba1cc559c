//! The body of a PLY file: the rows of its elements, in text or binary.

use super::header::{Element, Header, Kind, Scalar};
use super::{PlyError, PlyMesh, quote};

/// Why a row cannot be read.
enum Fault {
    /// The file ends in it.
    End,
    /// Anything else, said so that "vertex 3" can stand before it.
    Bad(String),
}

/// A position in the body from which numbers are read one after the other.
trait Source {
    /// Bytes read so far, with the header.
    fn position(&self) -> usize;

    /// The place in the file of a fault in the row that began at `row_start`.
    fn place(&self, row_start: usize) -> String;

    /// The next number.
    fn real(&mut self, scalar: Scalar) -> Result<f64, Fault>;

    /// The next `N` numbers, whose type is an integer type.
    fn integers<const N: usize>(&mut self, scalar: Scalar) -> Result<[i64; N], Fault>;

    /// Steps over numbers.
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Fault>;

    /// The next number as the length of a list.
    fn length(&mut self, scalar: Scalar) -> Result<u64, Fault> {
        let [length] = self.integers(scalar)?;
        u64::try_from(length).map_err(|_| Fault::Bad(format!("has a list of {length} values")))
    }

    /// Steps over a property.
    fn skip_property(&mut self, kind: Kind) -> Result<(), Fault> {
        match kind {
            Kind::One(scalar) => self.skip(scalar, 1),
            Kind::List { count, item } => {
                let length = self.length(count)?;
                self.skip(item, length)
            }
        }
    }
}

/// Words between white space. Line ends mean nothing more, as in pbrt-v3.
struct Ascii<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Ascii<'a> {
    fn word(&mut self) -> Result<&'a [u8], Fault> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace()).ok_or(Fault::End)?;
        let rest = &rest[start..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += start + length;
        Ok(&rest[..length])
    }

    fn number<T: std::str::FromStr>(&mut self, wanted: &str) -> Result<T, Fault> {
        let word = self.word()?;
        let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        parsed.ok_or_else(|| Fault::Bad(format!("has {} in place of {wanted}", quote(word))))
    }
}

impl Source for Ascii<'_> {
    fn position(&self) -> usize {
        self.at
    }

    fn place(&self, _row_start: usize) -> String {
        // Lines are counted only here, because most files have no fault.
        format!("line {}", 1 + self.bytes[..self.at].iter().filter(|&&byte| byte == b'\n').count())
    }

    fn real(&mut self, _scalar: Scalar) -> Result<f64, Fault> {
        self.number("a number")
    }

    fn integers<const N: usize>(&mut self, _scalar: Scalar) -> Result<[i64; N], Fault> {
        let mut integers = [0; N];
        for integer in &mut integers {
            *integer = self.number("an integer")?;
        }
        Ok(integers)
    }

    fn skip(&mut self, _scalar: Scalar, count: u64) -> Result<(), Fault> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }
}

/// Numbers in their binary form, the most significant byte first if `BIG`.
struct Binary<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    #[inline]
    fn take(&mut self, size: usize) -> Result<&'a [u8], Fault> {
        let taken = self.bytes[self.at..].get(..size).ok_or(Fault::End)?;
        self.at += size;
        Ok(taken)
    }
}

impl<const BIG: bool> Source for Binary<'_, BIG> {
    fn position(&self) -> usize {
        self.at
    }

    fn place(&self, row_start: usize) -> String {
        format!("byte {row_start}")
    }

    #[inline]
    fn real(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        self.take(scalar.size()).map(|bytes| decode_real::<BIG>(scalar, bytes))
    }

    #[inline]
    fn integers<const N: usize>(&mut self, scalar: Scalar) -> Result<[i64; N], Fault> {
        let size = scalar.size();
        let bytes = self.take(N * size)?;
        Ok(std::array::from_fn(|i| decode_integer::<BIG>(scalar, &bytes[i * size..])))
    }

    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Fault> {
        let size = count.checked_mul(scalar.size() as u64).and_then(|size| usize::try_from(size).ok());
        self.take(size.ok_or(Fault::End)?).map(drop)
    }
}

/// The first `N` bytes, the least significant one first.
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
fn decode_integer<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> i64 {
    match scalar {
        Scalar::I8 => i64::from(bytes[0] as i8),
        Scalar::U8 => i64::from(bytes[0]),
        Scalar::I16 => i64::from(i16::from_le_bytes(little_endian::<BIG, 2>(bytes))),
        Scalar::U16 => i64::from(u16::from_le_bytes(little_endian::<BIG, 2>(bytes))),
        Scalar::I32 => i64::from(i32::from_le_bytes(little_endian::<BIG, 4>(bytes))),
        Scalar::U32 => i64::from(u32::from_le_bytes(little_endian::<BIG, 4>(bytes))),
        // Not asked for: counts and indices of these types are refused beforehand.
        Scalar::F32 | Scalar::F64 => 0,
    }
}

#[inline]
fn decode_real<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> f64 {
    match scalar {
        Scalar::F32 => f64::from(f32::from_le_bytes(little_endian::<BIG, 4>(bytes))),
        Scalar::F64 => f64::from_le_bytes(little_endian::<BIG, 8>(bytes)),
        integer => decode_integer::<BIG>(integer, bytes) as f64,
    }
}

/// Reads a text body.
pub fn read_ascii(header: &Header, bytes: &[u8]) -> Result<PlyMesh, PlyError> {
    read(header, Ascii { bytes, at: header.size }, bytes.len())
}

/// Reads a binary body, the most significant byte first if `BIG`.
pub fn read_binary<const BIG: bool>(header: &Header, bytes: &[u8]) -> Result<PlyMesh, PlyError> {
    read(header, Binary::<BIG> { bytes, at: header.size }, bytes.len())
}

/// Reads all elements, up to `size` bytes.
fn read<S: Source>(header: &Header, mut source: S, size: usize) -> Result<PlyMesh, PlyError> {
    let vertex_count = header.elements.iter().find(|element| element.name == "vertex").map_or(0, |e| e.count);
    let mut mesh = PlyMesh::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(&mut source, element, &mut mesh)?,
            "face" => {
                // A triangle is four numbers of at least a byte, whatever the header promises.
                let most = (element.count as usize).min((size - source.position()) / 4);
                mesh.indices.reserve_exact(3 * most);
                read_faces(&mut source, element, vertex_count, &mut mesh)?;
            }
            _ => skip_rows(&mut source, element)?,
        }
    }
    Ok(mesh)
}

/// Runs `row` once per row of the element and gives its fault, if any, a place.
fn for_rows<S: Source>(
    source: &mut S,
    element: &Element,
    mut row: impl FnMut(&mut S) -> Result<(), Fault>,
) -> Result<(), PlyError> {
    for index in 0..element.count {
        let start = source.position();
        if let Err(fault) = row(source) {
            let subject = format!("{} {index}", element.noun());
            return Err(PlyError(match fault {
                Fault::End => format!("the file ends inside {subject} of {}", element.count),
                Fault::Bad(text) => format!("{}: {subject} {text}", source.place(start)),
            }));
        }
    }
    Ok(())
}

fn skip_rows<S: Source>(source: &mut S, element: &Element) -> Result<(), PlyError> {
    // Rows of nothing take no bytes, so there may be any number of them.
    if element.properties.is_empty() {
        return Ok(());
    }
    for_rows(source, element, |source| {
        element.properties.iter().try_for_each(|property| source.skip_property(property.kind))
    })
}

/// What becomes of a property of a vertex.
enum VertexStep {
    /// It is this one of x y z, nx ny nz, u v.
    Channel(usize, Scalar),
    Skip(Kind),
}

/// Which properties the vertices have and where they go.
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
    // Only a complete group of names is used.
    let mut assign = |names: &[&str], first_channel: usize| {
        let scalar = |&name: &&str| {
            let index = element.find(name)?;
            match element.properties[index].kind {
                Kind::One(scalar) => Some((index, scalar)),
                Kind::List { .. } => None,
            }
        };
        let Some(found) = names.iter().map(scalar).collect::<Option<Vec<_>>>() else { return false };
        for (channel, (index, scalar)) in (first_channel..).zip(found) {
            steps[index] = VertexStep::Channel(channel, scalar);
        }
        true
    };
    if !assign(&["x", "y", "z"], 0) {
        return Err(PlyError("the vertices lack one of the properties `x`, `y` and `z`".into()));
    }
    let has_normals = assign(&["nx", "ny", "nz"], 3);
    let has_uvs = UV_NAMES.iter().any(|names| assign(names, 6));
    Ok(VertexPlan { steps, has_normals, has_uvs })
}

fn read_vertices<S: Source>(source: &mut S, element: &Element, mesh: &mut PlyMesh) -> Result<(), PlyError> {
    let plan = plan_vertices(element)?;
    let count = element.count as usize;
    mesh.positions.reserve_exact(count);
    mesh.normals.reserve_exact(if plan.has_normals { count } else { 0 });
    mesh.uvs.reserve_exact(if plan.has_uvs { count } else { 0 });
    for_rows(source, element, |source| {
        let mut row = [0.0; 8];
        for step in &plan.steps {
            match *step {
                VertexStep::Channel(channel, scalar) => row[channel] = source.real(scalar)?,
                VertexStep::Skip(kind) => source.skip_property(kind)?,
            }
        }
        push_vertex(&plan, row, mesh)
    })
}

/// Adds a vertex, if it is finite.
#[inline]
fn push_vertex(plan: &VertexPlan, row: [f64; 8], mesh: &mut PlyMesh) -> Result<(), Fault> {
    let [x, y, z, nx, ny, nz, u, v] = row;
    mesh.positions.push(finite([x, y, z], "position")?);
    if plan.has_normals {
        mesh.normals.push(finite([nx, ny, nz], "normal")?);
    }
    if plan.has_uvs {
        mesh.uvs.push(finite([u, v], "texture coordinate")?);
    }
    Ok(())
}

#[inline]
fn finite<const N: usize>(values: [f64; N], what: &str) -> Result<[f64; N], Fault> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(values);
    }
    Err(Fault::Bad(format!("has the {what} {values:?}, which is not finite")))
}

/// The place of the list of a face's vertices, and the types of its count and its items.
fn find_corners(element: &Element) -> Result<(usize, Scalar, Scalar), PlyError> {
    let index = element.find("vertex_indices").or_else(|| element.find("vertex_index"));
    let Some((index, Kind::List { count, item })) = index.map(|i| (i, element.properties[i].kind)) else {
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
    let (before, after) = (&element.properties[..corners], &element.properties[corners + 1..]);
    for_rows(source, element, |source| {
        before.iter().try_for_each(|property| source.skip_property(property.kind))?;
        match source.length(count)? {
            3 => {
                let face = source.integers::<3>(item)?;
                mesh.indices.extend(in_range(face, vertex_count)?);
            }
            4 => {
                let face = source.integers::<4>(item)?;
                let [a, b, c, d] = in_range(face, vertex_count)?;
                // The diagonal and the corner orders of pbrt-v3.
                mesh.indices.extend([a, b, c, d, a, c]);
            }
            length => {
                source.skip(item, length)?;
                mesh.other_faces += 1;
            }
        }
        after.iter().try_for_each(|property| source.skip_property(property.kind))
    })
}

/// The corners of a face as indices, if all those vertices exist.
#[inline]
fn in_range<const N: usize>(face: [i64; N], vertex_count: u64) -> Result<[i32; N], Fault> {
    // A negative index becomes a huge one. There are at most `i32::MAX` vertices.
    match face.iter().find(|&&corner| corner as u64 >= vertex_count) {
        None => Ok(face.map(|corner| corner as i32)),
        Some(corner) => {
            Err(Fault::Bad(format!("refers to vertex {corner}, but there are {vertex_count} vertices")))
        }
    }
}
