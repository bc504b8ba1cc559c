//! Meshes that emit light, where pbrt-v3 differs.

use super::{Evidence, warn};
use crate::Shape;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    for (primitive, emission, at) in evidence.shape_lights() {
        let Shape::TriangleMesh(mesh) = &primitive.shape else { continue };
        if primitive.reverse_orientation && !emission.two_sided {
            if !mesh.normals.is_empty() {
                let message = "pbrt-v3 shows this reversed mesh glowing on one side but sends its light from the other, the side of \"N\"";
                warn(report, at, message, "remove ReverseOrientation: \"N\" decides the side that emits");
            } else if !mesh.tangents.is_empty() {
                let message = "pbrt-v3 lets this mesh with \"S\" glow as if it had no ReverseOrientation, but sends its light from the reversed side";
                let help = "remove \"S\", or swap two corners of each triangle instead of ReverseOrientation";
                warn(report, at, message, help);
            }
        }
        if primitive.cutout.as_ref().is_some_and(|cutout| cutout.alpha.is_some()) {
            let help = "delete the triangles in the holes instead of hiding them with \"alpha\"";
            warn(report, at, "pbrt-v3 lights the surroundings from the holes of this mesh, too", help);
        }
    }
}
