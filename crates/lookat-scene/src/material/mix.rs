//! `Material "mix"`: two materials in one (materials/mixmat.cpp).

use std::sync::Arc;

use glam::Vec3;
use lookat_syntax::Diagnostic;

use super::{Material, MaterialKind, Named, share};
use crate::elsewhere::Kind;
use crate::texture::{Texture, TextureParams};

/// Two materials in one.
#[derive(Debug, Clone)]
pub struct Mix {
    /// What is mixed (`namedmaterial1`, `namedmaterial2`); neither is [`MaterialKind::None`].
    pub materials: [Arc<Material>; 2],
    /// The share of the first; the second has the rest, if any (`amount`, default 0.5).
    pub amount: Texture<Vec3>,
    /// How many materials it comes to, where parts are mixes themselves.
    pub count: u32,
}

/// Mixes of mixes of mixes: with twice the work at each step, a short file would take forever.
const MOST: u32 = 100;

pub(super) fn mix(params: &mut TextureParams, named: &Named) -> Mix {
    let materials = ["namedmaterial1", "namedmaterial2"].map(|name| part(params, name, named));
    let amount = share(params, "amount", 0.5);
    let count = materials.iter().map(|part| count(part)).sum();
    if count > MOST {
        let help = "a material that two parameters name counts twice, and so do those that it names";
        params.reject("", format!("this material is made of more than {MOST} others"), Some(help));
        let materials = [0, 1].map(|_| Arc::new(Material::DEFAULT));
        return Mix { materials, amount, count: 2 };
    }
    Mix { materials, amount, count }
}

/// How many materials one comes to.
pub(super) fn count(material: &Material) -> u32 {
    match &material.kind {
        MaterialKind::Mix(mix) => mix.count,
        _ => 1,
    }
}

/// One of the two. In error it is matte, as in pbrt-v3.
fn part(params: &mut TextureParams, parameter: &'static str, named: &Named) -> Arc<Material> {
    let Some(name) = params.string(parameter) else {
        let help = "it names a material that MakeNamedMaterial has defined";
        params.missing(parameter, &format!("a mix of materials needs {parameter}"), help);
        return Arc::new(Material::DEFAULT);
    };
    match named.get(&name.value).map(|instance| instance.material.clone()) {
        Some(material) if !matches!(material.kind, MaterialKind::None) => return material,
        Some(_) => {
            let message =
                format!("\"{}\" is no surface: it cannot be mixed with another material", name.value);
            let help = "\"uber\" with an opacity, or an alpha texture of the shape, makes holes";
            params.error(Diagnostic::error(name.span, message).help(help));
        }
        None => params.undefined(Kind::Material, &name, named.keys()),
    }
    Arc::new(Material::DEFAULT)
}
