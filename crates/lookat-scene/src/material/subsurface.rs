//! `Material "subsurface"` and `"kdsubsurface"`: a smooth or rough boundary around a medium in which light scatters until it leaves
//! again nearby (materials/subsurface.cpp, materials/kdsubsurface.cpp).

use glam::Vec3;
use lookat_syntax::ParamType;

use crate::material::models::{Glass, REMAP, Roughness, along_each, gray, not_negative, reflectance};
use crate::medium::measured::{MeasuredMedium, MediumName, measured};
use crate::params::Params;
use crate::params::value::{ColorTexture, FloatTexture};
use crate::schema::{Key, Keys, Range};
use crate::texture::{Texture, product};

/// A boundary around a medium in which light scatters.
#[derive(Debug, Clone)]
pub struct Subsurface {
    /// The boundary. Its index is constant.
    pub surface: Glass,
    /// The index of refraction (`eta`, default 1.33).
    pub eta: f64,
    /// The mean cosine of scattering, -1 to 1 (`g`, default 0).
    pub g: f64,
    /// What the medium is made of.
    pub interior: Interior,
}

/// The scattering inside of a surface. Negative values count as 0.
#[derive(Debug, Clone)]
pub enum Interior {
    /// The absorption and the scattering coefficients, per unit of the world.
    Coefficients([Texture<Vec3>; 2]),
    /// The reflectance without the boundary, and the mean free path in units of the world.
    Color([Texture<Vec3>; 2]),
}

impl Interior {
    /// Both textures.
    pub fn colors(&self) -> &[Texture<Vec3>; 2] {
        match self {
            Interior::Coefficients(colors) | Interior::Color(colors) => colors,
        }
    }
}

const KD: Key<ColorTexture> =
    Key::color_texture("Kd", 0.5, "the share of the light below the surface that comes back to it");
const MFP: Key<ColorTexture> = Key::color_texture("mfp", 1.0, "the mean free path of light inside");
const NAME: Key<MediumName> = measured("name", "the measured medium that gives the coefficients");
const SIGMA_A: Key<ColorTexture> =
    coefficient("sigma_a", [0.0011, 0.0024, 0.014], "the absorption coefficient, per unit of the world");
const SIGMA_S: Key<ColorTexture> =
    coefficient("sigma_s", [2.55, 3.21, 3.77], "the scattering coefficient, per unit of the world");
const G: Key<f64> = Key::float("g", 0.0, "the asymmetry of scattering, clamped to -1 (back) to 1 (forward)");
const SCALE: Key<f64> = Key::float(
    "scale",
    1.0,
    "a factor of the coefficients: for a named medium, the millimeters in a unit of the world",
)
.within(Range::above(0.0));
const PATH_SCALE: Key<f64> =
    Key::float("scale", 1.0, "a factor of the mean free path").within(Range::above(0.0));
const ETA: Key<f64> = Key::float("eta", 1.33, "the index of refraction").within(Range::above(0.0));
const KR: Key<ColorTexture> = Key::color_texture("Kr", 1.0, "the factor of reflection at the surface");
const KT: Key<ColorTexture> = Key::color_texture("Kt", 1.0, "the factor of light that enters");
const ROUGHNESS: [Key<FloatTexture>; 2] = along_each(0.0);

const fn coefficient(name: &'static str, default: [f32; 3], meaning: &'static str) -> Key<ColorTexture> {
    Key::new(name, ParamType::Rgb, ColorTexture(Vec3::from_array(default)), meaning)
}

pub(in crate::material) const COLOR: Keys = &[&KD, &MFP, &G, &PATH_SCALE];
pub(in crate::material) const COEFFICIENTS: Keys = &[&NAME, &SIGMA_A, &SIGMA_S, &G, &SCALE];
pub(in crate::material) const SURFACE: Keys = &[&ETA, &KR, &KT, &ROUGHNESS[0], &ROUGHNESS[1], &REMAP];

/// `kdsubsurface`.
pub(super) fn of_color(params: &mut Params) -> Subsurface {
    let kd = reflectance(params, &KD);
    let mean_free_path = params.take(&MFP);
    let mean_free_path = not_negative(params, MFP.name, mean_free_path, "write paths above 0");
    let g = asymmetry(params);
    let scale = params.take(&PATH_SCALE);
    let mean_free_path = scaled(params, scale, mean_free_path);
    under_surface(params, g, Interior::Color([kd, mean_free_path]))
}

/// `subsurface`: the coefficients, or a named medium.
pub(super) fn of_coefficients(params: &mut Params) -> Subsurface {
    let medium = MeasuredMedium::take(params, &NAME);
    let of_medium = |key: Key<ColorTexture>, of: fn(&MeasuredMedium) -> Vec3| match medium {
        Some(medium) => Key { default: ColorTexture(of(medium)), ..key },
        None => key,
    };
    let absorption = params.take(&of_medium(SIGMA_A, |medium| medium.absorption));
    let scattering = params.take(&of_medium(SIGMA_S, |medium| medium.scattering));
    let [absorption, scattering] = [(SIGMA_A.name, absorption), (SIGMA_S.name, scattering)]
        .map(|(name, color)| not_negative(params, name, color, "write coefficients of 0 or more"));
    let g = if medium.is_some() {
        params.take(&G);
        params.unused(G.name, "the coefficients of named media are for scattering that is even", "delete g");
        0.0
    } else {
        asymmetry(params)
    };
    let scale = params.take(&SCALE);
    let coefficients = [absorption, scattering].map(|texture| scaled(params, scale, texture));
    under_surface(params, g, Interior::Coefficients(coefficients))
}

fn asymmetry(params: &mut Params) -> f64 {
    let g = params.take(&G);
    if g.abs() > 1.0 {
        let message = format!("{} is outside of -1 to 1: it is used as {}", G.name, g.signum());
        params.warn(G.name, &message, "write 0 for even scattering, and up to 1 for forward scattering");
    }
    g
}

fn scaled(params: &mut Params, scale: f64, texture: Texture<Vec3>) -> Texture<Vec3> {
    if scale == 1.0 { texture } else { product(params, [gray(scale as f32), texture]) }
}

fn under_surface(params: &mut Params, g: f64, interior: Interior) -> Subsurface {
    let eta = params.take(&ETA);
    let [kr, kt] = [&KR, &KT].map(|key| reflectance(params, key));
    let roughness = Roughness::of_two(params, &ROUGHNESS);
    let surface = Glass { kr, kt, eta: Texture::Constant(eta), roughness };
    Subsurface { surface, eta, g: g.clamp(-1.0, 1.0), interior }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::MaterialKind;

    /// The interior of a sphere after a directive.
    #[track_caller]
    fn interior(directive: &str) -> ([Vec3; 2], f64) {
        let scene = format!("WorldBegin\n{directive}\nShape \"sphere\"\nWorldEnd");
        let read = |_: &Path| Ok(scene.clone().into_bytes());
        let loaded = crate::load(Path::new("a.pbrt"), &read, &Default::default());
        match loaded.scene.unwrap().world.primitives[0].material.kind() {
            MaterialKind::Subsurface(of) => {
                (of.interior.colors().each_ref().map(|color| color.constant().unwrap()), of.g)
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn media_have_the_coefficients_of_their_names() {
        let (ketchup, g) =
            interior("Material \"subsurface\" \"string name\" \"Ketchup\" \"float g\" .8 \"float scale\" 10");
        let medium = MeasuredMedium::named("Ketchup").unwrap();
        assert_eq!((ketchup, g), ([medium.absorption * 10.0, medium.scattering * 10.0], 0.0));
        let (own, g) = interior(
            "Material \"subsurface\" \"string name\" \"Skin1\" \"rgb sigma_a\" [1 2 3] \"float g\" 1",
        );
        assert_eq!((own[0], g), (Vec3::new(1.0, 2.0, 3.0), 0.0));
        let (_, g) = interior("Material \"subsurface\" \"float g\" 7");
        assert_eq!(g, 1.0);
        let (kd, _) = interior("Material \"kdsubsurface\" \"rgb mfp\" [1 2 3] \"float scale\" .5");
        assert_eq!(kd, [Vec3::splat(0.5), Vec3::new(0.5, 1.0, 1.5)]);
    }
}
