//! `Material "mix"`: two materials in one (materials/mixmat.cpp).

use std::sync::Arc;

use glam::Vec3;
use lookat_syntax::Diagnostic;

use super::{Material, MaterialKind, Named};
use crate::params::Params;
use crate::texture::Texture;

/// Two materials in one.
#[derive(Debug, Clone)]
pub struct Mix {
    /// What is mixed (`namedmaterial1`, `namedmaterial2`); neither is [`MaterialKind::None`].
    pub materials: [Arc<Material>; 2],
    /// The share of the first, used from 0 to 1 (`amount`, default 0.5).
    pub amount: Texture<Vec3>,
}

pub(super) fn mix(params: &mut Params, named: &Named) -> Mix {
    let materials = ["namedmaterial1", "namedmaterial2"].map(|name| part(params, name, named));
    Mix { materials, amount: params.spectrum_texture("amount", Vec3::splat(0.5)) }
}

/// One of the two. In error it is matte, as in pbrt-v3.
fn part(params: &mut Params, parameter: &'static str, named: &Named) -> Arc<Material> {
    let Some(name) = params.string(parameter) else {
        let help = "it names a material that MakeNamedMaterial has defined";
        params.missing(parameter, &format!("a mix of materials needs {parameter}"), help);
        return Arc::new(Material::DEFAULT);
    };
    match named(&name.value) {
        Some(material) if !matches!(material.kind, MaterialKind::None) => material,
        Some(_) => {
            let message =
                format!("\"{}\" is no surface: it cannot be mixed with another material", name.value);
            let help = "\"uber\" with an opacity, or an alpha texture of the shape, makes holes";
            params.error(Diagnostic::error(name.span, message).help(help));
            Arc::new(Material::DEFAULT)
        }
        None => {
            let message = format!("there is no named material \"{}\"", name.value);
            params.error(
                Diagnostic::error(name.span, message).help("MakeNamedMaterial defines one before this"),
            );
            Arc::new(Material::DEFAULT)
        }
    }
}
