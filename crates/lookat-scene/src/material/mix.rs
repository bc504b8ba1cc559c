//! `Material "mix"`: a blend of two materials (materials/mixmat.cpp).

use std::sync::Arc;

use glam::Vec3;
use lookat_syntax::Diagnostic;

use super::{Material, MaterialKind, Named, share};
use crate::schema::{ColorTexture, Key, Keys, Name};
use crate::texture::{Texture, TextureParams};

/// A blend of two materials. It consists of at most 100, counting the parts of nested mixes.
#[derive(Debug, Clone)]
pub struct Mix {
    /// The two materials (`namedmaterial1`, `namedmaterial2`). Neither is [`MaterialKind::None`].
    pub materials: [Arc<Material>; 2],
    /// The weight of the first material. The second has the rest (`amount`, default 0.5).
    pub amount: Texture<Vec3>,
}

impl Mix {
    /// The most materials in nested mixes. Each level can double the work, so a short file could take forever.
    pub(crate) const MOST: u32 = 100;

    /// The number of materials, counting the parts of nested mixes.
    pub(crate) fn parts(&self) -> u32 {
        let [first, second] = &self.materials;
        first.parts.saturating_add(second.parts)
    }
}

const FIRST: Key<Name> =
    Key::string("namedmaterial1", "the name of the first material, whose bump map is used").required();
const SECOND: Key<Name> = Key::string("namedmaterial2", "the name of the second material").required();
const AMOUNT: Key<ColorTexture> = Key::color_texture("amount", 0.5, "the share of the first material");

pub(super) const KEYS: Keys = &[&FIRST, &SECOND, &AMOUNT];

pub(super) fn mix(params: &mut TextureParams, named: &Named) -> Mix {
    let materials = [&FIRST, &SECOND].map(|key| part(params, key, named));
    let amount = share(params, &AMOUNT);
    let mut mix = Mix { materials, amount };
    if mix.parts() > Mix::MOST {
        let help = "use fewer materials; a material named by two parameters counts twice, with all its parts";
        params.reject("", format!("this mix consists of more than {} materials", Mix::MOST), Some(help));
        mix.materials = [0, 1].map(|_| Arc::new(Material::DEFAULT));
    }
    mix
}

/// One of the two materials. After an error it is matte, as in pbrt-v3.
fn part(params: &mut TextureParams, key: &Key<Name>, named: &Named) -> Arc<Material> {
    let Some(name) = params.take(key) else {
        let parameter = key.name;
        let help = "write the name of a material that MakeNamedMaterial defines";
        params.missing(parameter, &format!("a mix of materials needs {parameter}"), help);
        return Arc::new(Material::DEFAULT);
    };
    let material = params.find(named, &name).map(|instance| instance.material.clone());
    let material = material.unwrap_or_else(|| Arc::new(Material::DEFAULT));
    if !matches!(material.kind, MaterialKind::None) {
        return material;
    }
    let message = format!("\"{}\" is not a surface: a mix cannot contain it", name.value);
    let help = "for holes, use \"uber\" with an opacity, or an alpha texture of the shape";
    params.error(Diagnostic::error(name.span, message).help(help));
    Arc::new(Material::DEFAULT)
}
