//! The body of a PLY file: the rows of its elements.

use std::io::Read;

use super::header::{Element, Format, Header, Kind, Scalar};
use super::source::{Ascii, Binary, Fault, Source};
use super::stream::Stream;
use super::{PlyError, PlyMesh};

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
            "vertex" => read_vertices(&mut source, element, &mut mesh)?,
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
    Skip(Kind),
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
            Kind::One(scalar) => Some((index, scalar)),
            Kind::List { .. } => None,
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

fn read_vertices<S: Source>(source: &mut S, element: &Element, mesh: &mut PlyMesh) -> Result<(), PlyError> {
    let plan = plan_vertices(element)?;
    let count = element.count.min(MOST_RESERVED) as usize;
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

/// The index of the vertex list property of faces, and the types of its count and items.
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
    mesh.indices.reserve_exact(3 * element.count.min(MOST_RESERVED) as usize);
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
                // The diagonal and corner order of pbrt-v3.
                mesh.indices.extend([a, b, c, d, a, c]);
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
fn in_range<const N: usize>(face: [i64; N], vertex_count: u64) -> Result<[i32; N], Fault> {
    // A negative index becomes a huge one. There are at most `i32::MAX` vertices.
    match face.iter().find(|&&corner| corner as u64 >= vertex_count) {
        None => Ok(face.map(|corner| corner as i32)),
        Some(corner) => {
            Err(Fault::Bad(format!("refers to vertex {corner}, but there are {vertex_count} vertices")))
        }
    }
}
