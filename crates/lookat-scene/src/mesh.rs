//! `Shape "trianglemesh"` and `Shape "plymesh"`, and their alpha masks.

mod array;

use std::sync::Arc;

pub use array::MeshArray;
use glam::DVec3;
use lookat_syntax::{Diagnostic, ParamType};

use crate::Transform;
use crate::cache::KeptMesh;
use crate::params::Params;
use crate::params::value::{FloatTexture, Floats, Integers, Name, Pairs, Triples};
use crate::schema::{Effect, Key, Keys, Kind, Unit};
use crate::texture::Texture;
use crate::transform::{LARGEST, in_range};

/// Triangles with shared vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    pub(crate) positions: MeshArray<[f64; 3]>,
    pub(crate) indices: MeshArray<i32>,
    /// In a box, because many small meshes have none.
    pub(crate) shading: Option<Box<VertexShading>>,
}

/// What the vertices of a mesh have besides positions. Arrays are empty if the mesh has no such data.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct VertexShading {
    pub normals: MeshArray<[f64; 3]>,
    pub tangents: MeshArray<[f64; 3]>,
    pub uvs: MeshArray<[f64; 2]>,
}

/// Why arrays are no [`Mesh`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// The number of indices is no multiple of three.
    #[error("the number of indices is not a multiple of 3")]
    OddIndices,
    /// An index is negative, or not below the number of positions.
    #[error("an index is negative or not below the number of positions")]
    IndexOutOfRange,
    /// An array has fewer or more values than there are positions.
    #[error("an array does not have one value for each position")]
    WrongLength,
    /// A number is infinite or not a number, or one of a position, normal or tangent is beyond 1e50, where areas overflow.
    #[error("a number is not finite, or beyond 1e50")]
    NotFinite,
}

/// Parts of a file that are skipped, and properties that pbrt-v3 does not read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Oddities {
    /// The number of faces without 3 or 4 corners. They are skipped, as in pbrt-v3.
    pub other_faces: usize,
    /// True if the file has more data than its header declares. The rest is ignored, as in pbrt-v3.
    pub goes_on: bool,
    /// True if the corners of faces are called `vertex_index`. pbrt-v3 draws no face then.
    pub is_vertex_index: bool,
    /// True if the file is compressed. pbrt-v3 cannot read it.
    pub is_zipped: bool,
}

impl Mesh {
    /// A mesh of these vertex positions, with three vertex indices for each triangle.
    ///
    /// # Errors
    ///
    /// See [`MeshError`].
    pub fn new(
        positions: impl Into<MeshArray<[f64; 3]>>,
        indices: impl Into<MeshArray<i32>>,
    ) -> Result<Mesh, MeshError> {
        let (positions, indices) = (positions.into(), indices.into());
        let count = positions.len();
        if !indices.len().is_multiple_of(3) {
            return Err(MeshError::OddIndices);
        }
        if !indices.iter().all(|index| usize::try_from(*index).is_ok_and(|index| index < count)) {
            return Err(MeshError::IndexOutOfRange);
        }
        if !in_range(positions.as_flattened()) {
            return Err(MeshError::NotFinite);
        }
        Ok(Mesh { positions, indices, ..Mesh::default() })
    }

    /// The mesh with a shading normal for each vertex, of any length.
    ///
    /// # Errors
    ///
    /// See [`MeshError`].
    pub fn with_normals(mut self, normals: impl Into<MeshArray<[f64; 3]>>) -> Result<Mesh, MeshError> {
        let normals = normals.into();
        check_array(&normals, self.positions.len(), in_range)?;
        self.shading.get_or_insert_default().normals = normals;
        Ok(self)
    }

    /// The mesh with a shading tangent for each vertex, of any length.
    ///
    /// # Errors
    ///
    /// See [`MeshError`].
    pub fn with_tangents(mut self, tangents: impl Into<MeshArray<[f64; 3]>>) -> Result<Mesh, MeshError> {
        let tangents = tangents.into();
        check_array(&tangents, self.positions.len(), in_range)?;
        self.shading.get_or_insert_default().tangents = tangents;
        Ok(self)
    }

    /// The mesh with texture coordinates for each vertex.
    ///
    /// # Errors
    ///
    /// See [`MeshError`].
    pub fn with_uvs(mut self, uvs: impl Into<MeshArray<[f64; 2]>>) -> Result<Mesh, MeshError> {
        let uvs = uvs.into();
        check_array(&uvs, self.positions.len(), |uvs| uvs.iter().all(|x| x.is_finite()))?;
        self.shading.get_or_insert_default().uvs = uvs;
        Ok(self)
    }

    pub(crate) fn with_shading(self, shading: VertexShading) -> Mesh {
        let has_any = shading != VertexShading::default();
        Mesh { shading: has_any.then(|| Box::new(shading)), ..self }
    }

    /// Vertex positions in world space, or in the space of the containing object. Finite (`P`).
    #[inline]
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// Three vertex indices for each triangle, from 0 to one less than the number of positions (`indices`).
    #[inline]
    pub fn indices(&self) -> &[i32] {
        &self.indices
    }

    /// A shading normal for each vertex, of any length (`N`), or none.
    #[inline]
    pub fn normals(&self) -> &[[f64; 3]] {
        self.shading.as_ref().map_or(&[], |shading| &shading.normals)
    }

    /// A shading tangent for each vertex, of any length (`S`), or none.
    #[inline]
    pub fn tangents(&self) -> &[[f64; 3]] {
        self.shading.as_ref().map_or(&[], |shading| &shading.tangents)
    }

    /// Texture coordinates for each vertex (`uv` or `st`), or none.
    #[inline]
    pub fn uvs(&self) -> &[[f64; 2]] {
        self.shading.as_ref().map_or(&[], |shading| &shading.uvs)
    }

    /// The mesh in place of a file that is only checked: a triangle, because a mesh without triangles would be invisible.
    pub(crate) fn unread() -> Mesh {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Mesh { positions: positions.into(), indices: vec![0, 1, 2].into(), ..Mesh::default() }
    }

    /// The number of triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// The bytes of the arrays.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.positions[..])
            + size_of_val(&self.indices[..])
            + size_of_val(self.normals())
            + size_of_val(self.tangents())
            + size_of_val(self.uvs())
    }

    /// The three vertex indices of a triangle.
    #[inline]
    pub fn triangle(&self, index: usize) -> [usize; 3] {
        [0, 1, 2].map(|corner| self.indices[3 * index + corner] as usize)
    }

    /// True if a triangle has an area. Otherwise it is invisible.
    #[inline]
    pub fn has_area(&self, index: usize) -> bool {
        self.spans_area(self.triangle(index))
    }

    #[inline]
    fn spans_area(&self, corners: [usize; 3]) -> bool {
        let [a, b, c] = corners.map(|vertex| DVec3::from(self.positions[vertex]));
        (b - a).cross(c - a) != DVec3::ZERO
    }

    /// The number of triangles without an area.
    pub(crate) fn without_area(&self) -> usize {
        let triangles = self.indices.as_chunks().0.iter();
        triangles.filter(|corners| !self.spans_area(corners.map(|vertex| vertex as usize))).count()
    }

    /// Transforms the arrays from object space to world space, in place.
    fn transformed(mut self, transform: Transform) -> Self {
        if transform != Transform::IDENTITY {
            let mut none = VertexShading::default();
            for p in self.positions.to_mut() {
                *p = transform.point(DVec3::from(*p)).into();
            }
            let VertexShading { normals, tangents, .. } = self.shading.as_deref_mut().unwrap_or(&mut none);
            for n in normals.to_mut() {
                *n = transform.normal(DVec3::from(*n)).into();
            }
            for s in tangents.to_mut() {
                *s = transform.vector(DVec3::from(*s)).into();
            }
        }
        self
    }
}

fn check_array<const N: usize>(
    values: &[[f64; N]],
    count: usize,
    are_right: fn(&[f64]) -> bool,
) -> Result<(), MeshError> {
    if values.len() != count {
        return Err(MeshError::WrongLength);
    }
    if are_right(values.as_flattened()) { Ok(()) } else { Err(MeshError::NotFinite) }
}

pub(crate) const INDICES: Key<Integers> = Key::new(
    "indices",
    ParamType::Integer,
    Integers,
    "three vertices for each triangle, from 0 to the number of vertices - 1",
)
.required();
pub(crate) const POSITIONS: Key<Triples> =
    Key::new("P", ParamType::Point3, Triples, "the vertices").required().unit(Unit::ObjectSpace);
const NORMALS: Key<Triples> =
    Key::new("N", ParamType::Normal, Triples, "a shading normal for each vertex, of any length");
const TANGENTS: Key<Triples> =
    Key::new("S", ParamType::Vector3, Triples, "the direction along u for each vertex, of any length");
const UV: Key<Pairs> = texture_coordinate("uv", "the texture coordinates of each vertex, also as float");
const ST: Key<Pairs> = texture_coordinate("st", "another name of uv");
const FACE_INDICES: Key<Integers> =
    Key::new("faceIndices", ParamType::Integer, Integers, "the Ptex face of each triangle")
        .effect(Effect::NoEffect);
/// The file of pbrt-v3's CreatePLYMesh.
pub(crate) const FILE_NAME: Key<Name> = Key::string("filename", "the PLY file").required();

const fn texture_coordinate(name: &'static str, meaning: &'static str) -> Key<Pairs> {
    Key::new(name, ParamType::Point2, Pairs, meaning)
        .default_words("(0, 0), (1, 0), (1, 1) for each triangle")
}

pub(crate) const TRIANGLE_MESH: Kind = Kind::new(
    "trianglemesh",
    "triangles with shared vertices",
    &[&[&INDICES, &POSITIONS, &NORMALS, &TANGENTS, &UV, &ST], CUTOUT, &[&FACE_INDICES]],
);
pub(crate) const PLY_MESH: Kind =
    Kind::new("plymesh", "triangles and quads from a PLY file", &[&[&FILE_NAME], CUTOUT]);

/// pbrt-v3's CreateTriangleMeshShape. The lists of a mesh that an earlier load has made are empty.
pub(crate) fn triangle_mesh(
    params: &mut Params,
    kept: Option<KeptMesh>,
    world_from_object: Transform,
) -> Option<Arc<Mesh>> {
    let reported = params.reported();
    let indices = params.take(&INDICES);
    let positions = params.take(&POSITIONS);
    let (uv, uvs) = texture_coordinates(params);
    let mut shading = VertexShading {
        normals: params.take(&NORMALS).unwrap_or_default().into(),
        tangents: params.take(&TANGENTS).unwrap_or_default().into(),
        uvs: uvs.into(),
    };
    // Only Ptex uses face indices, and lookat does not support Ptex.
    params.take(&FACE_INDICES);
    if let Some(KeptMesh { mesh, flat, .. }) = kept {
        if !params.usable() {
            return None;
        }
        params.reserve("indices", mesh.bytes())?.keep();
        note_flat(params, "indices", flat, mesh.triangles());
        return Some(mesh);
    }
    let mesh = Mesh { indices: indices?.into(), positions: positions?.into(), shading: None };
    check_indices(params, &mesh);
    check_lengths(params, mesh.positions.len(), &shading, uv);
    shading.uvs.to_mut().truncate(mesh.positions.len());
    let mesh = mesh.with_shading(shading);
    let mesh = Arc::new(to_world_space(params, mesh, world_from_object)?);
    let flat = mesh.without_area();
    // Other messages are given when the mesh is made.
    if let (Some(reuse), Some(key)) = (params.files.reuse, params.mesh_key.take())
        && reported.is_some_and(|reported| params.reported() == Some(reported))
    {
        reuse.keep_mesh(key, KeptMesh { mesh: mesh.clone(), flat, oddities: Oddities::default() });
    }
    note_flat(params, "indices", flat, mesh.triangles());
    Some(mesh)
}

/// Transforms a mesh to world space. Reports coordinates out of range and triangles without an area.
pub(crate) fn finish(params: &mut Params, mesh: Mesh, world_from_object: Transform) -> Option<Mesh> {
    let mesh = to_world_space(params, mesh, world_from_object)?;
    // Surfaces with poles always have triangles without area.
    if params.kind() != "nurbs" {
        note_flat(params, "indices", mesh.without_area(), mesh.triangles());
    }
    Some(mesh)
}

/// Transforms a mesh to world space. Reports coordinates out of range.
pub(crate) fn to_world_space(params: &mut Params, mesh: Mesh, world_from_object: Transform) -> Option<Mesh> {
    if !params.usable() {
        return None;
    }
    let name = if params.kind() == "plymesh" { "filename" } else { "indices" };
    params.reserve(name, mesh.bytes())?.keep();
    let mesh = mesh.transformed(world_from_object);
    for (name, values) in [("P", mesh.positions()), ("N", mesh.normals()), ("S", mesh.tangents())] {
        if !in_range(values.as_flattened()) {
            let at = if params.kind() == "plymesh" { "filename" } else { name };
            params.reject(at, format!("{name} has values above {LARGEST:e} in world space"), None);
            return None;
        }
    }
    if mesh.indices.is_empty() && params.kind() != "plymesh" {
        params.warn("indices", "the mesh has no triangles", "each triangle takes three indices");
    }
    Some(mesh)
}

/// Reports triangles without an area at a parameter.
pub(crate) fn note_flat(params: &mut Params, name: &str, flat: usize, all: usize) {
    if flat > 0 {
        let noun = if all == 1 { "triangle" } else { "triangles" };
        let message = format!("skipped {flat} of {all} {noun}: zero area");
        params.note(name, &message, "their corners are collinear or coincide, so they are invisible");
    }
}

/// The indices of a grid of vertices stored in rows, with two triangles for each square.
pub(crate) fn grid(columns: usize, rows: usize) -> Vec<i32> {
    let squares = (1..rows).flat_map(|row| (1..columns).map(move |column| (row - 1) * columns + column - 1));
    let corners = |at: usize| [at, at + 1, at + columns + 1, at, at + columns + 1, at + columns];
    squares.flat_map(|at| corners(at).map(|vertex| vertex as i32)).collect()
}

/// The texture coordinates and their parameter name. There are two names and two types, tried in the order of
/// pbrt-v3.
fn texture_coordinates(params: &mut Params) -> (&'static str, Vec<[f64; 2]>) {
    let keys = [&UV, &ST];
    let pairs = keys.map(|key| Some((key.name, params.take(key)?)));
    // A name that also has pairs is reported like any name given with two types.
    let floats = keys.map(|Key { name, meaning, .. }| {
        if params.was_taken(name) {
            None
        } else {
            Some((*name, params.take(&Key::new(name, ParamType::Float, Floats, meaning))?))
        }
    });
    let mut given = pairs.iter().flatten().map(|it| it.0).chain(floats.iter().flatten().map(|it| it.0));
    let name = given.next().unwrap_or("uv");
    if let Some(other) = given.next() {
        params.replaced_by(other, &[name]);
    }
    if let Some((_, pairs)) = pairs.into_iter().flatten().next() {
        return (name, pairs);
    }
    let flat = floats.into_iter().flatten().next().map_or_else(Vec::new, |(_, flat)| flat);
    if !flat.len().is_multiple_of(2) {
        let message = format!("{name} takes pairs of numbers, found {} numbers", flat.len());
        params.warn(name, &message, "the last one is ignored, as in pbrt-v3");
    }
    (name, flat.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect())
}

/// Checks the indices: three for each triangle, each of an existing vertex.
pub(crate) fn check_indices(params: &mut Params, mesh: &Mesh) {
    let vertices = mesh.positions.len();
    if !mesh.indices.len().is_multiple_of(3) {
        let message = format!("a triangle has 3 vertices, but there are {} indices", mesh.indices.len());
        params.reject("indices", message, None);
    }
    // A negative index becomes a huge one.
    let beyond = |index: &i32| *index as u32 as usize >= vertices;
    if mesh.indices.iter().fold(false, |any, index| any | beyond(index))
        && let Some(at) = mesh.indices.iter().position(beyond)
    {
        let message = format!("index {} is out of range: there are {vertices} vertices", mesh.indices[at]);
        let largest = mesh.indices.iter().max().copied();
        let from_one =
            mesh.indices.iter().min() == Some(&1) && largest.is_some_and(|it| it as usize == vertices);
        let error = Diagnostic::error(params.value_place("indices", at), message).help(match vertices {
            0 => "P is empty".into(),
            _ if from_one => {
                "these indices count from 1, and pbrt counts from 0: subtract 1 from each".into()
            }
            _ => format!("use indices from 0 to {}", vertices - 1),
        });
        params.error(error);
    }
}

/// Checks the lengths of vertex arrays. `uv` is the name of the texture coordinates.
fn check_lengths(params: &mut Params, vertices: usize, shading: &VertexShading, uv: &'static str) {
    let mut check = |name: &str, length: usize| {
        if length != 0 && length != vertices {
            params.reject(
                name,
                format!("{name} has {length} values for {vertices} vertices"),
                Some("write one value for each vertex of P, in the same order"),
            );
        }
    };
    check("N", shading.normals.len());
    check("S", shading.tangents.len());
    // pbrt-v3 accepts surplus texture coordinates with a warning.
    let uvs = shading.uvs.len();
    if uvs < vertices {
        check(uv, uvs);
    } else if uvs > vertices {
        let message = format!("{uv} has {uvs} pairs for {vertices} vertices; the last are ignored");
        let help =
            "write one pair for each vertex of P, in the same order, not one for each corner of a triangle";
        params.warn(uv, &message, help);
    }
}

/// The alpha masks of a mesh.
#[derive(Debug, Clone)]
pub struct Cutout {
    /// The mesh has holes where this is 0 (`alpha`).
    pub alpha: Option<Texture<f64>>,
    /// Shadow rays pass where this is 0 (`shadowalpha`).
    pub shadow_alpha: Option<Texture<f64>>,
}

const ALPHA: Key<FloatTexture> =
    Key::float_texture("alpha", 1.0, "the mesh has holes where this is 0; other values are opaque");
const SHADOW_ALPHA: Key<FloatTexture> =
    Key::float_texture("shadowalpha", 1.0, "shadow rays pass where this is 0, and where alpha is 0");

const CUTOUT: Keys = &[&ALPHA, &SHADOW_ALPHA];

/// The alpha masks of a mesh, if given.
pub(crate) fn cutout(params: &mut Params) -> Option<Box<Cutout>> {
    let [alpha, shadow_alpha] = [&ALPHA, &SHADOW_ALPHA].map(|key| {
        // A constant other than 0 is opaque and needs no mask.
        Some(params.take(key)).filter(|alpha| alpha.constant().is_none_or(|alpha| alpha == 0.0))
    });
    (alpha.is_some() || shadow_alpha.is_some()).then(|| Box::new(Cutout { alpha, shadow_alpha }))
}
