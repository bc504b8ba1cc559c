//! Meshes that emit light.

use super::Warn;
use crate::Mesh;

impl Warn<'_> {
    /// `is_reversed`: one side emits, under ReverseOrientation.
    pub(super) fn mesh_light(&mut self, mesh: &Mesh, is_reversed: bool) {
        if !is_reversed {
            return;
        }
        if !mesh.normals.is_empty() {
            self.push(
                "pbrt-v3 shows this reversed mesh glowing on one side but sends its light from the other, the side of \"N\"",
                "leave out ReverseOrientation: \"N\" decides the side that emits",
            );
        } else if !mesh.tangents.is_empty() {
            self.push(
                "pbrt-v3 lets this mesh with \"S\" glow as if it had no ReverseOrientation, but sends its light from the reversed side",
                "leave out \"S\", or exchange two corners of each triangle instead of ReverseOrientation",
            );
        }
    }

    pub(super) fn mesh_light_with_holes(&mut self) {
        self.push(
            "pbrt-v3 lights the surroundings from the holes of this mesh, too",
            "delete the triangles in the holes instead of hiding them with \"alpha\"",
        );
    }
}
