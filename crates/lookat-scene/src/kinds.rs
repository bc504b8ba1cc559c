//! All types of all directives.

use crate::schema::Kind;
use crate::{
    accelerator, camera, film, filter, integrator, light, material, medium, sampler, shape, texture,
};

/// Every type, by directive.
pub fn kinds() -> impl Iterator<Item = &'static Kind> {
    let options = [camera::KINDS, film::KINDS, filter::KINDS, sampler::KINDS, integrator::KINDS];
    let surfaces = [accelerator::KINDS, shape::KINDS, material::KINDS, NAMED_MATERIALS];
    let others = [light::KINDS, light::AREA_KINDS, texture::KINDS, medium::KINDS];
    options.into_iter().chain(surfaces).chain(others).flatten()
}

/// The types of materials with a name, which a parameter of MakeNamedMaterial gives.
const NAMED_MATERIALS: &[Kind] = &{
    let mut kinds = [material::KINDS[0]; material::KINDS.len()];
    let mut index = 0;
    while index < kinds.len() {
        kinds[index] = material::KINDS[index].of("MakeNamedMaterial", &[&material::TYPE]);
        index += 1;
    }
    kinds
};

#[cfg(test)]
mod tests;
