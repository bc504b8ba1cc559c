//! Whether materials keep the promises of a scene.

use glam::Vec3;

use super::texture::is_texture;
use crate::{AnyTexture, Material, MaterialKind, Mix, Texture};

/// True if the textures of a material, and of the parts of a mix, have numbers in range and are not too many.
pub(super) fn has_textures(material: &Material) -> bool {
    let is_right = |texture: &AnyTexture| match texture {
        AnyTexture::Number(texture) => is_texture(texture),
        AnyTexture::Color(texture) => is_texture(texture),
    };
    let parts = match material.kind() {
        MaterialKind::Mix(mix) => &mix.materials[..],
        _ => &[],
    };
    material.kind().textures().iter().all(is_right)
        && material.bump().is_none_or(is_texture)
        && parts.iter().all(|part| has_textures(part))
}

/// True if it has not too many parts, and its parts no more: then they can be visited.
pub(super) fn is_bounded(material: &Material) -> bool {
    !matches!(material.kind(), MaterialKind::Mix(mix) if mix.parts() > Mix::MOST)
}

/// True if reflectances and indices of refraction that are constant are in range, and so are the parts of a mix.
pub(super) fn is_material(material: &Material) -> bool {
    let share = |texture: &Texture<Vec3>| texture.constant().is_none_or(|color| color.min_element() >= 0.0);
    match material.kind() {
        MaterialKind::Matte(m) => share(&m.kd),
        MaterialKind::Plastic(m) => share(&m.kd) && share(&m.ks),
        MaterialKind::Translucent(m) => [&m.kd, &m.ks, &m.reflect, &m.transmit].into_iter().all(share),
        MaterialKind::Glass(m) => {
            share(&m.kr) && share(&m.kt) && m.eta.constant().is_none_or(|eta| eta > 0.0)
        }
        MaterialKind::Mirror(m) => share(&m.kr),
        MaterialKind::Substrate(m) => share(&m.kd) && share(&m.ks),
        MaterialKind::Uber(m) => [&m.kd, &m.ks, &m.kr, &m.kt, &m.opacity].into_iter().all(share),
        MaterialKind::Mix(m) => {
            let is_surface = |part: &Material| !matches!(part.kind(), MaterialKind::None);
            m.materials.iter().all(|part| is_surface(part) && is_material(part))
        }
        MaterialKind::Metal(_) | MaterialKind::None => true,
    }
}
