//! Puts loaded pictures in place of their stand-ins.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};

use crate::picture::Pictures;
use crate::texture::{Node, Parameter};
use crate::{Light, Material, MaterialKind, Primitive, Texture, Varying};

/// Replaces pictures. What was shared stays shared.
pub(crate) struct Fill<'p> {
    pictures: &'p Pictures,
    materials: Shared<Material>,
    numbers: Shared<Node<f64>>,
    colors: Shared<Node<Vec3>>,
}

/// Values with stand-ins and what replaces them, by address. The values with stand-ins are kept, so that no other value
/// gets their address.
type Shared<T> = HashMap<usize, [Arc<T>; 2]>;

/// A value of textures that are filled.
trait Filled: Parameter {
    /// The textures with these values whose pictures are loaded.
    fn filled<'f>(fill: &'f mut Fill) -> &'f mut Shared<Node<Self>>;
}

impl Filled for f64 {
    fn filled<'f>(fill: &'f mut Fill) -> &'f mut Shared<Node<f64>> {
        &mut fill.numbers
    }
}

impl Filled for Vec3 {
    fn filled<'f>(fill: &'f mut Fill) -> &'f mut Shared<Node<Vec3>> {
        &mut fill.colors
    }
}

impl<'p> Fill<'p> {
    pub fn new(pictures: &'p Pictures) -> Self {
        Fill { pictures, materials: HashMap::new(), numbers: HashMap::new(), colors: HashMap::new() }
    }

    pub fn primitive(&mut self, primitive: &mut Primitive) {
        self.material(&mut primitive.material);
        if let Some(cutout) = &mut primitive.cutout {
            cutout.alpha.iter_mut().chain(&mut cutout.shadow_alpha).for_each(|alpha| self.texture(alpha));
        }
    }

    /// Replaces the picture of a light. A light whose picture cannot be read shines without it, as in pbrt-v3.
    pub fn light(&mut self, light: &mut Light) {
        match light {
            Light::Environment { map, scale, samples, .. } => match self.pictures.colors.loaded(map) {
                Some(loaded) => *map = loaded,
                None => *light = Light::Infinite { radiance: *scale, samples: *samples },
            },
            Light::Goniometric { map, world_from_light, intensity } => {
                match self.pictures.colors.loaded(map) {
                    Some(loaded) => *map = loaded,
                    None => {
                        let position = world_from_light.point(DVec3::ZERO);
                        *light = Light::Point { position, intensity: *intensity };
                    }
                }
            }
            Light::Projection { map, half_size, .. } => {
                *map = map.as_ref().and_then(|map| self.pictures.colors.loaded(map));
                let aspect = map.as_ref().map_or(1.0, |map| {
                    let [width, height] = map.picture_size().map(|side| side as f64);
                    width / height
                });
                *half_size *= DVec2::new(aspect.max(1.0), aspect.recip().max(1.0));
            }
            Light::Point { .. } | Light::Spot { .. } | Light::Distant { .. } | Light::Infinite { .. } => {}
        }
    }

    fn material(&mut self, material: &mut Arc<Material>) {
        let address = Arc::as_ptr(material).addr();
        if let Some([_, filled]) = self.materials.get(&address) {
            *material = filled.clone();
            return;
        }
        let mut filled = Material::clone(material);
        let (colors, numbers) = filled.kind.textures_mut();
        colors.into_iter().for_each(|texture| self.texture(texture));
        numbers.into_iter().chain(&mut filled.bump).for_each(|texture| self.texture(texture));
        if let MaterialKind::Mix(mix) = &mut filled.kind {
            mix.materials.iter_mut().for_each(|part| self.material(part));
        }
        let before = std::mem::replace(material, Arc::new(filled));
        self.materials.insert(address, [before, material.clone()]);
    }

    fn texture<T: Filled>(&mut self, texture: &mut Texture<T>) {
        let Texture::Varying(node) = texture else { return };
        let address = Arc::as_ptr(node).addr();
        if let Some([_, filled]) = T::filled(self).get(&address) {
            *node = filled.clone();
            return;
        }
        let mut filled = Node::clone(node);
        self.varying(&mut filled.texture);
        let before = std::mem::replace(node, Arc::new(filled));
        let filled = node.clone();
        T::filled(self).insert(address, [before, filled]);
    }

    fn varying<T: Filled>(&mut self, varying: &mut Varying<T>) {
        if let Varying::ImageMap(image) = varying {
            // Without its file, the gray stand-in stays, as in pbrt-v3.
            let loaded = T::pictures(self.pictures).loaded(&image.map);
            loaded.into_iter().for_each(|loaded| image.map = loaded);
        }
        let (parts, weight) = varying.parts_mut();
        parts.into_iter().for_each(|part| self.texture(part));
        weight.into_iter().for_each(|weight| self.texture(weight));
    }
}
