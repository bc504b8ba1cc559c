//! Which triangles are neighbours.

/// No triangle.
const NONE: u32 = u32::MAX;

/// Triangles that know their neighbours. The edge `k` of a triangle runs from corner `k` to the next one.
pub(super) struct Topology {
    /// The vertices of each triangle.
    pub faces: Vec<[u32; 3]>,
    /// The triangle across each edge, or [`NONE`].
    neighbors: Vec<[u32; 3]>,
    /// The last triangle of each vertex, or [`NONE`].
    starts: Vec<u32>,
}

/// Why triangles are no surface with two sides. A slot is the place of an index in the list of all, an edge that of its
/// first corner.
#[derive(Debug, PartialEq)]
pub(super) enum Fault {
    /// A triangle has a vertex twice.
    Corner { slot: usize },
    /// The third triangle at an edge.
    Crowded { slot: usize, first: usize },
    /// An edge that runs the same way in both its triangles.
    Reversed { slot: usize, first: usize },
}

/// The corners of a triangle in turn.
pub(super) fn next(corner: usize) -> usize {
    (corner + 1) % 3
}

fn previous(corner: usize) -> usize {
    (corner + 2) % 3
}

impl Topology {
    /// Of triangles between vertices up to a number; finds what is wrong first.
    pub fn new(faces: Vec<[u32; 3]>, vertices: usize) -> Result<Topology, Fault> {
        let mut starts = vec![NONE; vertices];
        for (at, face) in faces.iter().enumerate() {
            if let Some(k) = (0..3).rev().find(|k| face[..*k].contains(&face[*k])) {
                return Err(Fault::Corner { slot: 3 * at + k });
            }
            face.iter().for_each(|vertex| starts[*vertex as usize] = at as u32);
        }
        let mut neighbors = vec![[NONE; 3]; faces.len()];
        // The first fault in the order of the list, whatever the order of edges.
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

    /// The neighbours of a vertex in turn, and whether they are all around it. Where the winding is against the clock, they
    /// come with it; those of a vertex on a boundary against it, from one end of the boundary to the other.
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
        // At one end of the boundary: back to the other.
        ring.drain(..ring.len().saturating_sub(1));
        while face != NONE {
            let corner = previous(self.corner(face, vertex));
            ring.push(self.faces[face as usize][corner]);
            face = self.neighbors[face as usize][corner];
        }
        false
    }

    /// The corner of a triangle across each of its edges, in the neighbour there.
    pub fn across(&self, face: usize, edge: usize) -> Option<u32> {
        let other = self.neighbors[face][edge];
        let at = (other != NONE).then(|| self.corner(other, self.faces[face][edge]))?;
        // The edge runs the other way there, so its first corner comes last.
        Some(self.faces[other as usize][next(at)])
    }

    /// Each triangle in four: those at its corners in turn, and the one between them. Old vertices keep their numbers;
    /// those of edges follow in the order in which triangles come to them.
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

    /// Whether [`Topology::split`] meets the edge here for the first time.
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
        // The child of the neighbour at an edge that has the given corner.
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

/// The vertices of all edges, the lower one first, with their slots; sorted.
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

/// What is wrong with an edge that triangles share, and where.
fn fault_of(same: &[([u32; 2], usize)], faces: &[[u32; 3]]) -> Option<(usize, Fault)> {
    let from = |slot: usize| faces[slot / 3][slot % 3];
    match *same {
        [(_, first), _, (_, slot), ..] => Some((slot, Fault::Crowded { slot, first })),
        [(_, first), (_, slot)] if from(first) == from(slot) => Some((slot, Fault::Reversed { slot, first })),
        _ => None,
    }
}
