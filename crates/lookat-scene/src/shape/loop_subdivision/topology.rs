//! The adjacency of triangles.

/// No triangle.
const NONE: u32 = u32::MAX;

/// Triangles with their neighbors. Edge `k` of a triangle runs from corner `k` to the next.
pub(super) struct Topology {
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
pub(super) enum Fault {
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
    pub fn new(faces: Vec<[u32; 3]>, vertices: usize) -> Result<Topology, Fault> {
        let mut starts = vec![NONE; vertices];
        for (at, face) in faces.iter().enumerate() {
            if let Some(k) = (0..3).rev().find(|k| face[..*k].contains(&face[*k])) {
                return Err(Fault::Corner { slot: 3 * at + k });
            }
            face.iter().for_each(|vertex| starts[*vertex as usize] = at as u32);
        }
        let mut neighbors = vec![[NONE; 3]; faces.len()];
        // The first fault in the order of the list, not in the order of edges.
        let mut fault: Option<(usize, Fault)> = None;
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

    /// True if [`Topology::split`] meets the edge here for the first time.
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
fn fault_of(same: &[([u32; 2], usize)], faces: &[[u32; 3]]) -> Option<(usize, Fault)> {
    let from = |slot: usize| faces[slot / 3][slot % 3];
    match *same {
        [(_, first), _, (_, slot), ..] => Some((slot, Fault::Crowded { slot, first })),
        [(_, first), (_, slot)] if from(first) == from(slot) => Some((slot, Fault::Reversed { slot, first })),
        _ => None,
    }
}
