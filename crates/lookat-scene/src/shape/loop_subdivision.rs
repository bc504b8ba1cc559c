//! `Shape "loopsubdiv"`: a Loop subdivision surface (PBR 3.8).

mod rules;
mod topology;

use glam::DVec3;
use lookat_syntax::Diagnostic;

use crate::Transform;
use crate::mesh::{INDICES, Mesh, POSITIONS, check_indices, finish};
use crate::params::Params;
use crate::schema::{Effect, Key, Kind, Name, Range};
use topology::{Fault, Topology};

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
    "Shape",
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
    let control = match (indices, positions) {
        (Some(indices), Some(positions)) => Mesh { indices, positions, ..Mesh::default() },
        (None, _) => {
            let help = "add \"integer indices\" [...] with three vertices for each triangle";
            params.missing("indices", "a loopsubdiv needs indices", help);
            return None;
        }
        (_, None) => {
            let help = "add \"point P\" [...] with the vertices of the control mesh";
            params.missing("P", "a loopsubdiv needs P", help);
            return None;
        }
    };
    check_indices(params, &control);
    if !params.usable() {
        return None;
    }
    let levels = levels as u32;
    check_levels(params, levels, control.triangles() as u64)?;
    let faces = (0..control.triangles()).map(|index| control.triangle(index).map(|v| v as u32)).collect();
    match Topology::new(faces, control.positions.len()) {
        Ok(topology) => {
            let positions = control.positions.into_iter().map(DVec3::from).collect();
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
    let memory = params.memory();
    let is_indexed = |levels: u32| triangles(levels) <= i32::MAX as u64;
    let check = |levels: u32| match is_indexed(levels) {
        true => memory.reserve(bytes(levels)).map(drop).map_err(|shortage| {
            format!("{levels} levels make {} triangles from {faces}: {shortage}", triangles(levels))
        }),
        false => {
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
fn report(params: &mut Params, control: &Mesh, fault: Fault) {
    let at = |params: &Params, slot: usize| params.value_place("indices", slot);
    let vertex = |slot: usize| control.indices[slot];
    let next = |slot: usize| slot - slot % 3 + (slot + 1) % 3;
    let error = match fault {
        Fault::Corner { slot } => {
            let message = format!("a triangle has vertex {} twice", vertex(slot));
            Diagnostic::error(at(params, slot), message).help("delete the triangle")
        }
        Fault::Crowded { slot, first } => {
            let (a, b) = (vertex(slot), vertex(next(slot)));
            let message = format!("the edge from vertex {a} to vertex {b} has more than two triangles");
            Diagnostic::error(at(params, slot), message)
                .related(at(params, first), "the first of them")
                .help("give each of two touching sheets its own vertices")
        }
        Fault::Reversed { slot, first } => {
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
        positions = rules::refined(&topology, &positions);
        topology = topology.split();
    }
    let positions = rules::limit(&topology, &positions);
    let normals = rules::normals(&topology, &positions);
    Mesh {
        positions: positions.into_iter().map(DVec3::into).collect(),
        indices: topology.faces.as_flattened().iter().map(|vertex| *vertex as i32).collect(),
        normals: normals.into_iter().map(DVec3::into).collect(),
        ..Mesh::default()
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
        for (p, q) in coarse.positions.iter().zip(&fine.positions) {
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
        assert!(mesh.normals.iter().all(|n| DVec3::from(*n).normalize().distance(-DVec3::Z) < 1e-12));
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
        let (p, n) = (DVec3::from(mesh.positions[0]), DVec3::from(mesh.normals[0]));
        assert!((p - DVec3::splat(0.25)).dot(n) > 0.0);
    }

    #[test]
    fn what_is_no_surface_is_told_where() {
        let fault = |faces: &[[u32; 3]]| Topology::new(faces.to_vec(), 6).err();
        assert_eq!(fault(&TETRAHEDRON), None);
        // A flap has its back for a neighbor.
        assert_eq!(fault(&[[0, 1, 2], [0, 2, 1]]), None);
        assert_eq!(fault(&[[0, 1, 2], [3, 4, 3]]), Some(Fault::Corner { slot: 5 }));
        assert_eq!(fault(&[[0, 1, 2], [1, 0, 3], [4, 0, 1]]), Some(Fault::Crowded { slot: 7, first: 0 }));
        assert_eq!(fault(&[[0, 1, 2], [0, 1, 3]]), Some(Fault::Reversed { slot: 3, first: 0 }));
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
