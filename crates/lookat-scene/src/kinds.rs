//! All types of all directives.

use std::sync::LazyLock;

use crate::schema::{Keys, Kind};
use crate::{camera, film, filter, integrator, light, material, medium, options, sampler, shape, texture};

/// Every type, by directive.
pub fn kinds() -> impl Iterator<Item = &'static Kind> {
    KINDS.iter()
}

static KINDS: LazyLock<Vec<Kind>> = LazyLock::new(|| {
    // A parameter gives the type of a named material, and of a medium.
    const TYPE: Keys = &[&material::TYPE];
    const MEDIUM_TYPE: Keys = &[&medium::TYPE];
    let kinds: [(&str, &[Kind], Keys); 13] = [
        ("Camera", camera::KINDS, &[]),
        ("Film", film::KINDS, &[]),
        ("PixelFilter", filter::KINDS, &[]),
        ("Sampler", sampler::KINDS, &[]),
        ("Integrator", integrator::KINDS, &[]),
        ("Accelerator", options::KINDS, &[]),
        ("Shape", shape::KINDS, &[]),
        ("Material", material::KINDS, &[]),
        ("MakeNamedMaterial", material::KINDS, TYPE),
        ("LightSource", light::KINDS, &[]),
        ("AreaLightSource", light::AREA_KINDS, &[]),
        ("Texture", texture::KINDS, &[]),
        ("MakeNamedMedium", medium::KINDS, MEDIUM_TYPE),
    ];
    let of = |(directive, kinds, first): (_, &'static [Kind], _)| {
        kinds.iter().map(move |kind| kind.of(directive, first))
    };
    kinds.into_iter().flat_map(of).collect()
});

#[cfg(test)]
mod tests;
