//! Indices of refraction in pictures.

use std::collections::HashSet;
use std::sync::Arc;

use super::{Evidence, warn};
use crate::report::Report;
use crate::{Material, MaterialKind, Texture, Varying};

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let mut known = HashSet::new();
    evidence.drawn.iter().for_each(|primitive| check(&primitive.material, &mut known, report));
}

/// Warns of values that are an error as a constant.
fn check(material: &Arc<Material>, known: &mut HashSet<*const Material>, report: &mut Report) {
    if let MaterialKind::Mix(mix) = &material.kind {
        mix.materials.iter().for_each(|part| check(part, known, report));
    }
    let Some(Texture::Varying(node)) = material.kind.index() else { return };
    let (Varying::ImageMap(image), Some(at)) = (&node.texture, material.span) else { return };
    if known.insert(Arc::as_ptr(material)) && image.map.texels().iter().any(|index| *index <= 0.0) {
        let message =
            "the picture of the index of refraction has values of 0 or less: they are used as 0.001";
        warn(report, at, message, "use a picture of values above 0, such as 1.5 for glass");
    }
}
