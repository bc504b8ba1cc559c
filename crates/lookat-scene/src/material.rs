//! `Material`: what surfaces are made of.

use glam::Vec3;

use crate::params::Params;

/// A material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Material {
    /// Diffuse, by Lambert or, where `sigma` is not zero, by Oren and Nayar.
    Matte {
        /// Reflected share of light, linear RGB, at least 0 (`Kd`, default 0.5).
        kd: Vec3,
        /// Spread of the slopes of the facets, in degrees from 0 to 90 (`sigma`, default 0).
        sigma: f64,
    },
    /// A smooth mirror.
    Mirror {
        /// Reflected share of light, linear RGB, at least 0 (`Kr`, default 0.9).
        kr: Vec3,
    },
    /// Smooth glass: a surface that reflects and refracts as Fresnel's equations say.
    Glass {
        /// Factor of reflected light, linear RGB, at least 0 (`Kr`, default 1).
        kr: Vec3,
        /// Factor of light that passes, linear RGB, at least 0 (`Kt`, default 1).
        kt: Vec3,
        /// Index of refraction behind the surface by that before it, where its normal points; more than 0 (`eta` or
        /// `index`, default 1.5).
        eta: f64,
    },
    /// Nothing: light passes through, and shadow rays stop, as in pbrt-v3 (`"none"` and `""`).
    None,
}

impl Material {
    /// The material of shapes before any `Material` directive.
    pub const DEFAULT: Material = Material::Matte { kd: Vec3::splat(0.5), sigma: 0.0 };
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

/// Those that have a diffuse color of that name.
const HAVE_KD: &[&str] = &["matte", "plastic", "translucent", "substrate", "uber", "kdsubsurface"];

/// pbrt-v3's MakeMaterial. An unknown type is an error; the material is then matte, as in pbrt-v3.
pub(crate) fn material(params: &mut Params) -> Material {
    let material = match params.kind() {
        "matte" => matte(params),
        "mirror" => mirror(params),
        "glass" => glass(params),
        "none" | "" => Material::None,
        kind if NAMES.contains(&kind) => {
            let stand_in = if HAVE_KD.contains(&kind) { "matte with its Kd" } else { "grey matte" };
            let message = format!("Material \"{kind}\" is not rendered yet; {stand_in} stands in for it");
            // pbrt-v3's defaults of Kd.
            let default = if ["plastic", "translucent", "uber"].contains(&kind) { 0.25 } else { 0.5 };
            params.unsupported(message);
            let kd = params.spectrum_texture("Kd", Vec3::splat(default));
            params.ignore_rest();
            Material::Matte { kd: kd.max(Vec3::ZERO), sigma: 0.0 }
        }
        _ => {
            params.unknown_kind::<()>(NAMES);
            params.ignore_rest();
            Material::DEFAULT
        }
    };
    params.finish();
    material
}

fn matte(params: &mut Params) -> Material {
    let kd = share(params, "Kd", 0.5);
    let sigma = params.float_texture("sigma", 0.0);
    bump(params);
    Material::Matte { kd, sigma: sigma.clamp(0.0, 90.0) }
}

fn mirror(params: &mut Params) -> Material {
    let kr = share(params, "Kr", 0.9);
    bump(params);
    Material::Mirror { kr }
}

fn glass(params: &mut Params) -> Material {
    let (kr, kt) = (share(params, "Kr", 1.0), share(params, "Kt", 1.0));
    let index = params.float_texture("index", 1.5);
    let eta = params.float_texture("eta", index);
    if eta <= 0.0 {
        params.reject("eta", "the index of refraction must be more than 0", None);
    }
    let rough = ["uroughness", "vroughness"].map(|name| params.float_texture(name, 0.0));
    params.bool("remaproughness", true);
    if rough != [0.0; 2] {
        params.unsupported("rough glass is not rendered yet; smooth glass stands in for it".into());
    }
    bump(params);
    Material::Glass { kr, kt, eta: if eta > 0.0 { eta } else { 1.5 } }
}

/// A share of light. pbrt-v3 takes what is less than 0 for 0.
fn share(params: &mut Params, name: &'static str, default: f32) -> Vec3 {
    let share = params.spectrum_texture(name, Vec3::splat(default));
    if share.max_element() > 1.0 {
        params.warn(
            name,
            &format!("{name} is more than 1: the surface gives back more light than it gets"),
            "colors go from 0 to 1; divide those that go to 255",
        );
    }
    share.max(Vec3::ZERO)
}

fn bump(params: &mut Params) {
    let given = params.given("bumpmap");
    params.texture("bumpmap");
    params.float("bumpmap", 0.0);
    if given {
        params.unsupported("bumpmap is not rendered yet".into());
    }
}
