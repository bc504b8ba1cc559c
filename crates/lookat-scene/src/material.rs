//! `Material`: the scattering of surfaces.

mod glass;
mod instance;
mod keys;
mod kinds;
mod matte;
mod metal;
mod mirror;
mod mix;
mod needs;
mod plastic;
mod roughness;
mod stand_in;
mod substrate;
mod textures;
mod translucent;
mod uber;

use std::rc::Rc;

use glam::Vec3;
use lookat_syntax::{Span, Text};

use crate::names::Names;
use crate::params::Params;
use crate::schema::{Key, Kind, Name, names};
use crate::texture::{Texture, TextureParams};

pub use glass::Glass;
pub use matte::Matte;
pub use metal::Metal;
pub use mirror::Mirror;
pub use mix::Mix;
pub use needs::Needs;
pub use plastic::Plastic;
pub use roughness::Roughness;
pub use substrate::Substrate;
pub use textures::AnyTexture;
pub use translucent::Translucent;
pub use uber::Uber;

pub(crate) use instance::MaterialInstance;
pub(crate) use kinds::KINDS;

use keys::{bump, index_of_refraction, share};

/// A material.
#[derive(Debug, Clone)]
pub struct Material {
    pub(crate) kind: MaterialKind,
    pub(crate) bump: Option<Texture<f64>>,
    /// The type that its directive names. `None` for a material made in code.
    pub span: Option<Span>,
    /// The name that `MakeNamedMaterial` gives it.
    pub name: Option<String>,
    needs: Needs,
    /// How many materials it comes to, counting the parts of nested mixes.
    parts: u32,
}

/// The scattering of a material. Reflectances are colors or textures; negative values count as 0.
#[derive(Debug, Clone)]
pub enum MaterialKind {
    /// Diffuse.
    Matte(Matte),
    /// A diffuse base under a rough dielectric coating.
    Plastic(Plastic),
    /// Diffuse and glossy reflection and transmission.
    Translucent(Translucent),
    /// A boundary between dielectrics.
    Glass(Glass),
    /// A perfect mirror.
    Mirror(Mirror),
    /// A rough conductor.
    Metal(Box<Metal>),
    /// A diffuse base under a glossy coating with Fresnel reflection.
    Substrate(Substrate),
    /// Diffuse, glossy and specular lobes in one material.
    Uber(Box<Uber>),
    /// A blend of two materials.
    Mix(Mix),
    /// No surface: light passes through and shadow rays are blocked, as in pbrt-v3 (`"none"` and `""`).
    None,
}

impl Material {
    /// The material of shapes before any `Material` directive.
    pub const DEFAULT: Material = Material {
        kind: MaterialKind::Matte(Matte {
            kd: Texture::Constant(Vec3::splat(0.5)),
            sigma: Texture::Constant(0.0),
        }),
        bump: None,
        span: None,
        name: None,
        needs: Needs::NOTHING,
        parts: 1,
    };

    /// A material with this scattering, and a bump map if there is one: a displacement in world units that changes the shading
    /// normal.
    pub fn new(kind: MaterialKind, bump: Option<Texture<f64>>) -> Self {
        let needs = Needs::of(&kind, bump.as_ref());
        let parts = match &kind {
            MaterialKind::Mix(mix) => mix.parts(),
            _ => 1,
        };
        Material { kind, bump, span: None, name: None, needs, parts }
    }

    /// Its scattering.
    #[inline]
    pub fn kind(&self) -> &MaterialKind {
        &self.kind
    }

    /// The bump map (`bumpmap`).
    #[inline]
    pub fn bump(&self) -> Option<&Texture<f64>> {
        self.bump.as_ref()
    }

    /// The surface data that it needs.
    #[inline]
    pub fn needs(&self) -> Needs {
        self.needs
    }
}

pub(crate) const TYPE: Key<Name> = Key::string("type", "the type of the material").required();

/// The type of a named material, which is a parameter.
pub(crate) fn named_type(params: &mut Params) -> Option<Text> {
    let kind = params.take(&TYPE);
    if kind.is_none() {
        let message = format!("named material \"{}\" has no type", params.kind());
        params.missing(TYPE.name, &message, "add \"string type\" \"matte\"");
    }
    kind
}

/// The named materials.
pub(crate) type Named = Names<Rc<MaterialInstance>>;

/// pbrt-v3's MakeMaterial. An unknown type is an error and gives matte, as in pbrt-v3.
pub(crate) fn material(params: &mut TextureParams, named: &Named) -> Material {
    let kind = match params.kind() {
        "matte" => MaterialKind::Matte(matte::matte(params)),
        "plastic" => MaterialKind::Plastic(plastic::plastic(params)),
        "translucent" => MaterialKind::Translucent(translucent::translucent(params)),
        "glass" => MaterialKind::Glass(glass::glass(params)),
        "mirror" => MaterialKind::Mirror(mirror::mirror(params)),
        "metal" => MaterialKind::Metal(Box::new(metal::metal(params))),
        "substrate" => MaterialKind::Substrate(substrate::substrate(params)),
        "uber" => MaterialKind::Uber(Box::new(uber::uber(params))),
        "mix" => {
            let mix = mix::mix(params, named);
            params.finish();
            // pbrt-v3 uses the bump map of the first.
            let bump = mix.materials[0].bump.clone();
            return Material::new(MaterialKind::Mix(mix), bump);
        }
        "none" | "" => {
            params.finish();
            return Material::new(MaterialKind::None, None);
        }
        kind if names(KINDS).contains(&kind) => {
            let known = KINDS.iter().filter(|known| known.name == params.kind());
            let known: Vec<_> = known.flat_map(Kind::parameters).collect();
            let kind = stand_in::stand_in(params);
            // pbrt-v3's hair has no bump map.
            let bump = if params.kind() == "hair" { None } else { bump(params) };
            params.ignore(known.into_iter());
            params.finish();
            return Material::new(kind, bump);
        }
        _ => {
            params.unknown_kind::<()>(&names(KINDS));
            let kind = MaterialKind::Matte(matte::matte(params));
            let bump = bump(params);
            params.ignore_rest();
            return Material::new(kind, bump);
        }
    };
    let bump = bump(params);
    params.finish();
    Material::new(kind, bump)
}
