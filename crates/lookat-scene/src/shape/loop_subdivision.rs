//! `Shape "loopsubdiv"`: a Loop subdivision surface (PBR 3.8).

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use lookat_syntax::Diagnostic;

use crate::Transform;
use crate::mesh::{INDICES, Mesh, POSITIONS, VertexShading, check_indices, finish};
use crate::params::Params;
use crate::params::value::Name;
use crate::schema::{Effect, Key, Kind, Range};

/// Measured bytes for each subdivided triangle: the mesh, its adjacency, and the previous level.
const TRIANGLE_BYTES: u64 = 80;

const N_LEVELS: Key<i32> = levels("nlevels", "how often each triangle becomes four");
const LEVELS: Key<i32> =
    levels("levels", "another name of nlevels, with precedence").default_words("nlevels");
const SCHEME: Key<Name> =
    Key::string("scheme", "the subdivision scheme").default_words("\"loop\"").effect(Effect::NoEffect);

const fn levels(name: &'static str, meaning: &'static str) -> Key<i32> {
    Key::integer(name, 3, meaning).within(Range::at_least(0.0))
}

pub(super) const KIND: Kind = Kind::new(
    "loopsubdiv",
    "a Loop subdivision surface",
    &[&[&N_LEVELS, &LEVELS, &INDICES, &POSITIONS, &SCHEME]],
);

/// pbrt-v3's CreateLoopSubdiv.
pub(crate) fn loop_subdivision(params: &mut Params, world_from_object: Transform) -> Option<Mesh> {
    // The name in old files has precedence.
    let range = if params.given("levels") { Range::ALL } else { N_LEVELS.range };
    let default = params.take(&Key { range, ..N_LEVELS });
    let levels = params.take(&Key { default, ..LEVELS });
    params.replaced_by("nlevels", &["levels"]);
    let indices = params.take(&INDICES);
    let positions = params.take(&POSITIONS);
    // The only scheme is "loop".
    params.take(&SCHEME);
    let control = Mesh { indices: indices?.into(), positions: positions?.into(), ..Mesh::default() };
    check_indices(params, &control);
    if !params.usable() {
        return None;
    }
    let levels = levels as u32;
    check_levels(params, levels, control.triangles() as u64)?;
    let faces = (0..control.triangles()).map(|index| control.triangle(index).map(|v| v as u32)).collect();
    match Topology::new(faces, control.positions.len()) {
        Ok(topology) => {
            let positions = control.positions.iter().copied().map(DVec3::from).collect();
            finish(params, smooth(topology, positions, levels), world_from_object)
        }
        Err(fault) => {
            report(params, &control, fault);
            None
        }
    }
}

fn check_levels(params: &mut Params, levels: u32, faces: u64) -> Option<()> {
    let name = if params.was_taken("levels") { "levels" } else { "nlevels" };
    let triangles = |levels: u32| faces.saturating_mul(4_u64.saturating_pow(levels));
    let bytes = |levels: u32| triangles(levels).saturating_mul(TRIANGLE_BYTES);
    let memory = &params.files.memory;
    let is_indexed = |levels: u32| triangles(levels) <= i32::MAX as u64;
    let check = |levels: u32| {
        if is_indexed(levels) {
            memory.reserve(bytes(levels)).map(drop).map_err(|shortage| {
                format!("{levels} levels make {} triangles from {faces}: {shortage}", triangles(levels))
            })
        } else {
            Err(format!("{levels} levels make more than {} triangles from {faces}, the limit", i32::MAX))
        }
    };
    if let Err(message) = check(levels) {
        // No mesh can have more levels: each makes four triangles of one.
        let fewer = (0..levels.min(16)).rev().find(|fewer| check(*fewer).is_ok());
        let help = fewer.map(|fewer| format!("{name} can be at most {fewer}"));
        params.reject(name, message, help.as_deref());
    }
    params.usable().then_some(())
}

/// Reports a control mesh that is not an orientable manifold. pbrt-v3 fails on these in various ways.
fn report(params: &mut Params, control: &Mesh, fault: NotManifold) {
    let at = |params: &Params, slot: usize| params.value_place("indices", slot);
    let vertex = |slot: usize| control.indices[slot];
    let next = |slot: usize| slot - slot % 3 + (slot + 1) % 3;
    let error = match fault {
        NotManifold::Corner { slot } => {
            let message = format!("a triangle has vertex {} twice", vertex(slot));
            Diagnostic::error(at(params, slot), message).help("delete the triangle")
        }
        NotManifold::Crowded { slot, first } => {
            let (a, b) = (vertex(slot), vertex(next(slot)));
            let message = format!("the edge from vertex {a} to vertex {b} has more than two triangles");
            Diagnostic::error(at(params, slot), message)
                .related(at(params, first), "the first of them")
                .help("give each of two touching sheets its own vertices")
        }
        NotManifold::Reversed { slot, first } => {
            let (a, b) = (vertex(slot), vertex(next(slot)));
            let message = format!(
                "two triangles have the edge from vertex {a} to vertex {b} in the same direction, so they face opposite sides"
            );
            Diagnostic::error(at(params, slot), message)
                .related(at(params, first), "the other one")
                .help("swap two indices of one triangle, so that neighbors have the same orientation")
        }
    };
    params.error(error);
}

/// The limit surface as triangles, with vertices and normals on the limit surface.
fn smooth(mut topology: Topology, mut positions: Vec<DVec3>, levels: u32) -> Mesh {
    for _ in 0..levels {
        positions = refined(&topology, &positions);
        topology = topology.split();
    }
    let positions = limit(&topology, &positions);
    let normals = normals(&topology, &positions);
    let normals = normals.into_iter().map(DVec3::into).collect();
    let mesh = Mesh {
        positions: positions.into_iter().map(DVec3::into).collect(),
        indices: topology.faces.as_flattened().iter().map(|vertex| *vertex as i32).collect(),
        ..Mesh::default()
    };
    mesh.with_shading(VertexShading { normals, ..VertexShading::default() })
}

// The subdivision and limit masks (Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987; PBR 3.8).

/// The positions after one level: old vertices, then edge vertices.
fn refined(topology: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
    let mut refined = weighed(topology, positions, beta, 1.0 / 8.0);
    for (face, corners) in topology.faces.iter().enumerate() {
        for edge in (0..3).filter(|edge| topology.is_first(face, *edge)) {
            let p = |vertex: u32| positions[vertex as usize];
            let ends = p(corners[edge]) + p(corners[next(edge)]);
            let own = p(corners[next(next(edge))]);
            refined.push(match topology.across(face, edge) {
                Some(across) => ends * (3.0 / 8.0) + (own + p(across)) * (1.0 / 8.0),
                None => ends * 0.5,
            });
        }
    }
    refined
}

/// The limit positions of the vertices.
pub(super) fn limit(topology: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
    weighed(topology, positions, |valence| 1.0 / (valence + 3.0 / (8.0 * beta(valence))), 1.0 / 5.0)
}

/// The weight of each neighbor of an inner vertex.
fn beta(valence: f64) -> f64 {
    if valence == 3.0 { 3.0 / 16.0 } else { 3.0 / (8.0 * valence) }
}

/// Moves each vertex toward its neighbors. A boundary vertex uses only its two boundary neighbors.
fn weighed(
    topology: &Topology,
    positions: &[DVec3],
    inner: impl Fn(f64) -> f64,
    boundary: f64,
) -> Vec<DVec3> {
    let mut ring = Vec::new();
    let mut moved = |(vertex, p): (usize, &DVec3)| {
        let closed = topology.ring(vertex as u32, &mut ring);
        let neighbor = |at: usize| positions[ring[at] as usize];
        match ring.len() {
            0 => *p,
            valence if closed => {
                let weight = inner(valence as f64);
                let sum: DVec3 = (0..valence).map(neighbor).sum();
                *p * (1.0 - valence as f64 * weight) + sum * weight
            }
            valence => *p * (1.0 - 2.0 * boundary) + (neighbor(0) + neighbor(valence - 1)) * boundary,
        }
    };
    positions.iter().enumerate().map(&mut moved).collect()
}

/// The normals of the limit surface at its vertices, not normalized, on the side where the winding is clockwise.
pub(super) fn normals(topology: &Topology, limit: &[DVec3]) -> Vec<DVec3> {
    let mut ring = Vec::new();
    let mut around: Vec<DVec3> = Vec::new();
    let mut normal = |(vertex, p): (usize, &DVec3)| {
        let closed = topology.ring(vertex as u32, &mut ring);
        around.clear();
        // Relative to the vertex: the masks sum to 0, so this loses no precision.
        around.extend(ring.iter().map(|neighbor| limit[*neighbor as usize] - p));
        let (s, t) = if closed { inner_tangents(&around) } else { boundary_tangents(&around) };
        s.cross(t)
    };
    limit.iter().enumerate().map(&mut normal).collect()
}

fn inner_tangents(ring: &[DVec3]) -> (DVec3, DVec3) {
    let angle = |at: usize| TAU * at as f64 / ring.len() as f64;
    let along = |weight: fn(f64) -> f64| ring.iter().enumerate().map(|(at, p)| *p * weight(angle(at))).sum();
    (along(libm::cos), along(libm::sin))
}

/// The tangents along the boundary and away from it.
fn boundary_tangents(ring: &[DVec3]) -> (DVec3, DVec3) {
    let [first, .., last] = *ring else { return (DVec3::ZERO, DVec3::ZERO) };
    let inward = match *ring {
        [a, b] => a + b,
        [_, b, _] => b,
        [a, b, c, d] => -a + b * 2.0 + c * 2.0 - d,
        _ => {
            let theta = PI / (ring.len() - 1) as f64;
            let weight = |k: usize| (2.0 * libm::cos(theta) - 2.0) * libm::sin(k as f64 * theta);
            let inner: DVec3 = (1..ring.len() - 1).map(|k| ring[k] * weight(k)).sum();
            -((first + last) * libm::sin(theta) + inner)
        }
    };
    (last - first, inward)
}

/// No triangle.
const NONE: u32 = u32::MAX;

/// Triangles with their neighbors. Edge `k` of a triangle runs from corner `k` to the next.
pub(crate) struct Topology {
    /// The vertices of each triangle.
    pub faces: Vec<[u32; 3]>,
    /// The triangle across each edge, or [`NONE`].
    neighbors: Vec<[u32; 3]>,
    /// The last triangle of each vertex, or [`NONE`].
    starts: Vec<u32>,
}

/// The reason why triangles are not an orientable manifold. A slot is an index into the list of vertex indices; the
/// slot of an edge is its first corner.
#[derive(Debug, PartialEq)]
pub(super) enum NotManifold {
    /// A triangle uses a vertex twice.
    Corner { slot: usize },
    /// An edge has a third triangle.
    Crowded { slot: usize, first: usize },
    /// An edge has the same direction in both its triangles.
    Reversed { slot: usize, first: usize },
}

/// The next corner of a triangle.
pub(super) fn next(corner: usize) -> usize {
    (corner + 1) % 3
}

fn previous(corner: usize) -> usize {
    (corner + 2) % 3
}

impl Topology {
    /// Builds the adjacency of triangles. Returns the first fault.
    pub fn new(faces: Vec<[u32; 3]>, vertices: usize) -> Result<Topology, NotManifold> {
        let mut starts = vec![NONE; vertices];
        for (at, face) in faces.iter().enumerate() {
            if let Some(k) = (0..3).rev().find(|k| face[..*k].contains(&face[*k])) {
                return Err(NotManifold::Corner { slot: 3 * at + k });
            }
            for vertex in face {
                starts[*vertex as usize] = at as u32;
            }
        }
        let mut neighbors = vec![[NONE; 3]; faces.len()];
        // The first fault in the order of the list, not in the order of edges.
        let mut fault: Option<(usize, NotManifold)> = None;
        for same in edges(&faces).chunk_by(|a, b| a.0 == b.0) {
            match fault_of(same, &faces) {
                Some(found) if fault.as_ref().is_none_or(|(slot, _)| found.0 < *slot) => fault = Some(found),
                Some(_) => {}
                None => {
                    if let [(_, one), (_, other)] = *same {
                        neighbors[one / 3][one % 3] = (other / 3) as u32;
                        neighbors[other / 3][other % 3] = (one / 3) as u32;
                    }
                }
            }
        }
        match fault {
            Some((_, fault)) => Err(fault),
            None => Ok(Topology { faces, neighbors, starts }),
        }
    }

    /// Collects the neighbors of a vertex in order; true if they surround it. For counterclockwise triangles the
    /// order is clockwise around an inner vertex, and counterclockwise from one boundary end to the other around a
    /// boundary vertex.
    pub fn ring(&self, vertex: u32, ring: &mut Vec<u32>) -> bool {
        ring.clear();
        let start = self.starts[vertex as usize];
        let mut face = start;
        while face != NONE {
            let corner = self.corner(face, vertex);
            ring.push(self.faces[face as usize][next(corner)]);
            let across = self.neighbors[face as usize][corner];
            if across == start {
                return true;
            }
            if across == NONE {
                break;
            }
            face = across;
        }
        // At one end of the boundary, continue from the other.
        ring.drain(..ring.len().saturating_sub(1));
        while face != NONE {
            let corner = previous(self.corner(face, vertex));
            ring.push(self.faces[face as usize][corner]);
            face = self.neighbors[face as usize][corner];
        }
        false
    }

    /// The opposite corner of the neighbor across an edge.
    pub fn across(&self, face: usize, edge: usize) -> Option<u32> {
        let other = self.neighbors[face][edge];
        let at = (other != NONE).then(|| self.corner(other, self.faces[face][edge]))?;
        // The edge has the opposite direction in the neighbor, so its first corner comes last.
        Some(self.faces[other as usize][next(at)])
    }

    /// Splits each triangle into four: one at each corner, then the middle one. Old vertices keep their numbers; edge
    /// vertices follow in the order of first use.
    pub fn split(&self) -> Topology {
        let mut starts: Vec<u32> = (0..self.starts.len() as u32).map(|v| self.start_of_child(v)).collect();
        let mut middles: Vec<[u32; 3]> = Vec::with_capacity(self.faces.len());
        for face in 0..self.faces.len() {
            let own = [0, 1, 2].map(|edge| {
                self.known_middle(face, edge, &middles).unwrap_or_else(|| {
                    starts.push(4 * face as u32 + 3);
                    starts.len() as u32 - 1
                })
            });
            middles.push(own);
        }
        let faces = (0..self.faces.len()).flat_map(|face| self.children(face, middles[face])).collect();
        let neighbors = (0..self.faces.len()).flat_map(|face| self.children_neighbors(face)).collect();
        Topology { faces, neighbors, starts }
    }

    /// True if this triangle is the first of the edge, in the order of [`Topology::split`].
    pub fn is_first(&self, face: usize, edge: usize) -> bool {
        let other = self.neighbors[face][edge];
        other == NONE || other as usize > face
    }

    fn corner(&self, face: u32, vertex: u32) -> usize {
        self.faces[face as usize].iter().position(|v| *v == vertex).unwrap_or(0)
    }

    fn start_of_child(&self, vertex: u32) -> u32 {
        let start = self.starts[vertex as usize];
        if start == NONE { NONE } else { 4 * start + self.corner(start, vertex) as u32 }
    }

    fn known_middle(&self, face: usize, edge: usize, middles: &[[u32; 3]]) -> Option<u32> {
        let other = self.neighbors[face][edge];
        (!self.is_first(face, edge)).then(|| {
            let corner = self.corner(other, self.faces[face][edge]);
            middles[other as usize][previous(corner)]
        })
    }

    fn children(&self, face: usize, middles: [u32; 3]) -> [[u32; 3]; 4] {
        let [a, b, c] = self.faces[face];
        let [ab, bc, ca] = middles;
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    }

    fn children_neighbors(&self, face: usize) -> [[u32; 3]; 4] {
        let child = |at: usize| 4 * face as u32 + at as u32;
        // The child of the neighbor across an edge that contains the corner.
        let beyond = |edge: usize, corner: usize| {
            let other = self.neighbors[face][edge];
            if other == NONE { NONE } else { 4 * other + self.corner(other, self.faces[face][corner]) as u32 }
        };
        [
            [beyond(0, 0), child(3), beyond(2, 0)],
            [beyond(0, 1), beyond(1, 1), child(3)],
            [child(3), beyond(1, 2), beyond(2, 2)],
            [child(1), child(2), child(0)],
        ]
    }
}

/// All edges as sorted vertex pairs with their slots, in sorted order.
fn edges(faces: &[[u32; 3]]) -> Vec<([u32; 2], usize)> {
    let edge = |slot: usize| {
        let face = faces[slot / 3];
        let (a, b) = (face[slot % 3], face[next(slot % 3)]);
        ([a.min(b), a.max(b)], slot)
    };
    let mut edges: Vec<([u32; 2], usize)> = (0..3 * faces.len()).map(edge).collect();
    edges.sort_unstable();
    edges
}

/// The fault of a shared edge, and its slot.
fn fault_of(same: &[([u32; 2], usize)], faces: &[[u32; 3]]) -> Option<(usize, NotManifold)> {
    let from = |slot: usize| faces[slot / 3][slot % 3];
    match *same {
        [(_, first), _, (_, slot), ..] => Some((slot, NotManifold::Crowded { slot, first })),
        [(_, first), (_, slot)] if from(first) == from(slot) => {
            Some((slot, NotManifold::Reversed { slot, first }))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];

    fn subdivided(faces: &[[u32; 3]], positions: &[DVec3], levels: u32) -> Mesh {
        let Ok(topology) = Topology::new(faces.to_vec(), positions.len()) else { panic!("no surface") };
        smooth(topology, positions.to_vec(), levels)
    }

    /// However far it is subdivided, the control vertices of a closed mesh end at the same points. (On a boundary they
    /// do not: pbrt-v3's mask there, 1/5, is not quite that of the limit, 1/6.)
    #[test]
    fn the_limit_does_not_depend_on_the_levels() {
        let corners = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y, DVec3::new(0.3, 0.2, 1.5)];
        let coarse = subdivided(&TETRAHEDRON, &corners, 3);
        let fine = subdivided(&TETRAHEDRON, &corners, 4);
        assert_eq!(fine.triangles(), 1024);
        for (p, q) in coarse.positions.iter().zip(fine.positions.iter()) {
            assert!(DVec3::from(*p).distance(DVec3::from(*q)) < 1e-12);
        }
    }

    /// A flat triangulation stays in its plane, with all normals against the winding, as in pbrt-v3.
    #[test]
    fn a_plane_stays_a_plane() {
        let positions: Vec<DVec3> =
            (0..16).map(|i| DVec3::new((i % 4) as f64, (i / 4) as f64, 5.0)).collect();
        let square = |at: u32| [[at, at + 1, at + 5], [at, at + 5, at + 4]];
        let faces: Vec<[u32; 3]> = [0, 1, 2, 4, 5, 6, 8, 9, 10].into_iter().flat_map(square).collect();
        let mesh = subdivided(&faces, &positions, 2);
        assert!(mesh.positions.iter().all(|p| (p[2] - 5.0).abs() < 1e-12));
        assert!(mesh.normals().iter().all(|n| DVec3::from(*n).normalize().distance(-DVec3::Z) < 1e-12));
        // The rule of the boundary takes no notice of the inside: the middle of a side stays on it.
        assert!(mesh.positions.iter().all(|p| p[0] >= -1e-12 && p[0] <= 3.0 + 1e-12));
    }

    /// The limit of a vertex with three neighbors: 2/5 of it and 1/5 of each of them.
    #[test]
    fn a_corner_of_a_tetrahedron_ends_where_the_mask_says() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = subdivided(&TETRAHEDRON, &corners, 0);
        assert!(DVec3::from(mesh.positions[0]).distance(DVec3::splat(0.2)) < 1e-15);
        // The winding is inward, so the normals are outward.
        let (p, n) = (DVec3::from(mesh.positions[0]), DVec3::from(mesh.normals()[0]));
        assert!((p - DVec3::splat(0.25)).dot(n) > 0.0);
    }

    #[test]
    fn what_is_no_surface_is_told_where() {
        let fault = |faces: &[[u32; 3]]| Topology::new(faces.to_vec(), 6).err();
        assert_eq!(fault(&TETRAHEDRON), None);
        // A flap has its back for a neighbor.
        assert_eq!(fault(&[[0, 1, 2], [0, 2, 1]]), None);
        assert_eq!(fault(&[[0, 1, 2], [3, 4, 3]]), Some(NotManifold::Corner { slot: 5 }));
        assert_eq!(
            fault(&[[0, 1, 2], [1, 0, 3], [4, 0, 1]]),
            Some(NotManifold::Crowded { slot: 7, first: 0 })
        );
        assert_eq!(fault(&[[0, 1, 2], [0, 1, 3]]), Some(NotManifold::Reversed { slot: 3, first: 0 }));
    }

    /// Two fans that meet in one vertex: the last decides about it, as in pbrt-v3; vertices without triangles stay.
    #[test]
    fn fans_at_one_vertex_and_lone_vertices_are_harmless() {
        let at = |k: f64| DVec3::new(k.cos(), k.sin(), 0.3 * k);
        let positions: Vec<DVec3> = (0..6).map(|i| at(f64::from(i))).collect();
        let mesh = subdivided(&[[0, 1, 2], [0, 3, 4]], &positions, 1);
        assert_eq!(mesh.triangles(), 8);
        assert_eq!(mesh.positions[5], positions[5].to_array());
        let expected = positions[0] * 0.65 + (positions[3] + positions[4]) * 0.175;
        assert!(DVec3::from(mesh.positions[0]).distance(expected) < 1e-15);
    }
}
