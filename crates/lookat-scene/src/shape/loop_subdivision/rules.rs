//! The subdivision and limit masks (Loop, "Smooth Subdivision Surfaces Based on Triangles", 1987; PBR 3.8).

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::topology::{Topology, next};

/// The positions after one level: old vertices, then edge vertices.
pub(super) fn refined(topology: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
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
