//! `subsurface` and `kdsubsurface` as a diffuse surface under the gloss of the dielectric: its color is the diffuse reflectance
//! of a half space of the medium.

use glam::Vec3;
use lookat_syntax::{Diagnostic, nearest};

use super::diffusion::{diffuse_transmittance, reflectance};
use super::media::{MEDIA, Medium};
use super::{MaterialKind, Roughness, constant_color, glossy, gray, share};
use crate::texture::{Texture, TextureParams};

/// `kdsubsurface`: `Kd` is the reflectance.
pub(super) fn of_color(params: &mut TextureParams) -> MaterialKind {
    let kd = share(params, "Kd", 0.5);
    let eta = index(params);
    under_gloss(params, kd, eta)
}

/// `subsurface`: the coefficients, or a named medium, give the reflectance.
pub(super) fn of_coefficients(params: &mut TextureParams) -> MaterialKind {
    let medium = named_medium(params);
    let g = if medium.is_some() { 0.0 } else { params.float("g", 0.0).clamp(-1.0, 1.0) };
    let [absorption, scattering] = medium
        .map(|medium| [medium.absorption, medium.scattering])
        .unwrap_or([[0.0011, 0.0024, 0.014], [2.55, 3.21, 3.77]]);
    let absorption = constant_color(params, "sigma_a", Vec3::from_array(absorption));
    let scattering = constant_color(params, "sigma_s", Vec3::from_array(scattering));
    // A scale of both coefficients leaves the reflectance as it is.
    params.float("scale", 1.0);
    let eta = index(params);
    let channel =
        |a: f32, s: f32| if s > 0.0 { reflectance((s / (a + s)).into(), g, eta) as f32 } else { 0.0 };
    let [a, s] = [absorption.to_array(), scattering.to_array()];
    let kd = Vec3::from_array([0, 1, 2].map(|at| channel(a[at], s[at])));
    under_gloss(params, Texture::Constant(kd), eta)
}

fn named_medium(params: &mut TextureParams) -> Option<&'static Medium> {
    let name = params.string("name").filter(|name| !name.value.is_empty())?;
    let medium = MEDIA.iter().find(|medium| medium.name == name.value);
    if medium.is_none() {
        let message =
            "there is no measured medium of this name: the default coefficients are used, as in pbrt-v3";
        let warning = Diagnostic::warning(name.span, message);
        params.push(match nearest(&name.value, MEDIA.iter().map(|medium| medium.name)) {
            Some(near) => {
                warning.help(format!("did you mean \"{near}\"?")).fix(name.span, format!("\"{near}\""))
            }
            None => warning.help("docs/supported.md lists the names; sigma_a and sigma_s give other media"),
        });
    }
    medium
}

fn index(params: &mut TextureParams) -> f64 {
    let eta = params.float("eta", 1.33);
    if eta > 0.0 {
        return eta;
    }
    params.reject("eta", "the index of refraction must be above 0", None);
    1.33
}

/// The diffuse color, as light leaves it through the surface, under the surface's own reflection.
fn under_gloss(params: &mut TextureParams, color: Texture<Vec3>, eta: f64) -> MaterialKind {
    let [kr, kt] = ["Kr", "Kt"].map(|name| share(params, name, 1.0));
    let roughness = Roughness::of_two(params, 0.0);
    let is_zero = |width: &Texture<f64>| width.constant() == Some(0.0);
    let is_smooth = is_zero(&roughness.u) && roughness.v.as_ref().is_some_and(is_zero);
    let factor = Texture::product([gray(diffuse_transmittance(eta) as f32), kt]);
    let kd = Texture::product([factor, color]);
    let mut uber = glossy(kd, kr, roughness, eta);
    if is_smooth {
        (uber.kr, uber.ks) = (uber.ks, gray(0.0));
    }
    MaterialKind::Uber(Box::new(uber))
}
