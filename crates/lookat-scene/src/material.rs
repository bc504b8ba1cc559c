//! `Material`: what surfaces are made of.

mod glass;
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

use crate::names::Names;
use crate::state::MaterialInstance;
use crate::texture::Texture;
use crate::texture::TextureParams;

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

/// A material.
#[derive(Debug, Clone)]
pub struct Material {
    /// How it scatters light.
    pub kind: MaterialKind,
    /// Height above the surface, in world units, that bends the shading normal (`bumpmap`).
    pub bump: Option<Texture<f64>>,
    /// What it asks of the surface.
    pub needs: Needs,
}

/// How a material scatters light. Shares of light are colors or textures; what is less than 0 counts as 0.
#[derive(Debug, Clone)]
pub enum MaterialKind {
    /// Diffuse.
    Matte(Matte),
    /// A diffuse base under a rough gloss.
    Plastic(Plastic),
    /// Diffuse and glossy, on both sides.
    Translucent(Translucent),
    /// A surface between dielectrics.
    Glass(Glass),
    /// A smooth mirror.
    Mirror(Mirror),
    /// A rough conductor.
    Metal(Box<Metal>),
    /// A diffuse base under a layer that reflects the more the flatter the light comes.
    Substrate(Substrate),
    /// Several of the others at once.
    Uber(Box<Uber>),
    /// Two materials in one.
    Mix(Mix),
    /// Nothing: light passes through, and shadow rays stop, as in pbrt-v3 (`"none"` and `""`).
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
        needs: Needs::NOTHING,
    };

    fn new(kind: MaterialKind, bump: Option<Texture<f64>>) -> Self {
        let needs = Needs::of(&kind, bump.as_ref());
        Material { kind, bump, needs }
    }
}

pub(crate) const NAMES: &[&str] = &[
    "matte",
    "plastic",
    "translucent",
    "glass",
    "mirror",
    "hair",
    "disney",
    "mix",
    "metal",
    "substrate",
    "uber",
    "subsurface",
    "kdsubsurface",
    "fourier",
    "none",
    "",
];

/// The named materials that a constructor may ask for.
pub(crate) type Named = Names<Rc<MaterialInstance>>;

/// pbrt-v3's MakeMaterial. An unknown type is an error; the material is then matte, as in pbrt-v3.
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
            // pbrt-v3 keeps the bumps of the first.
            let bump = mix.materials[0].bump.clone();
            return Material::new(MaterialKind::Mix(mix), bump);
        }
        "none" | "" => {
            params.finish();
            return Material::new(MaterialKind::None, None);
        }
        kind if NAMES.contains(&kind) => {
            let kind = stand_in::stand_in(params);
            // In pbrt-v3 hair has none.
            let bump = if params.kind() == "hair" { None } else { bump(params) };
            params.ignore_rest();
            return Material::new(kind, bump);
        }
        _ => {
            params.unknown_kind::<()>(NAMES);
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

fn bump(params: &mut TextureParams) -> Option<Texture<f64>> {
    // At height 0 everywhere nothing is bent.
    params.float_texture_if_given("bumpmap").filter(|bump| bump.constant() != Some(0.0))
}

/// A share of light. pbrt-v3 takes what is less than 0 for 0.
fn share(params: &mut TextureParams, name: &'static str, default: f32) -> Texture<Vec3> {
    let share = params.spectrum_texture(name, Vec3::splat(default));
    let Texture::Constant(color) = share else { return share };
    // A spectrum of shares up to 1 may be a color beyond it.
    if color.max_element() > 1.0 && params.was_rgb(name) {
        params.warn(
            name,
            &format!("{name} is more than 1: the surface gives back more light than it gets"),
            "colors go from 0 to 1; divide those that go to 255",
        );
    }
    // And it may have parts below 0.
    if color.min_element() < 0.0 && params.was_rgb(name) {
        params.warn(
            name,
            &format!("{name} is less than 0, and counts as 0, as in pbrt-v3"),
            "colors go from 0 to 1",
        );
    }
    Texture::Constant(color.max(Vec3::ZERO))
}

/// An index of refraction by either of its names; pbrt-v3 asks for `eta` first.
fn index_of_refraction(params: &mut TextureParams) -> Texture<f64> {
    let index = params.float_texture("index", 1.5);
    let eta = params.float_texture_if_given("eta").unwrap_or(index);
    let name = if params.was_taken("eta") { "eta" } else { "index" };
    match eta {
        Texture::Constant(eta) if eta <= 0.0 => {
            params.reject(name, "the index of refraction must be more than 0", None);
            Texture::Constant(1.5)
        }
        eta => eta,
    }
}
