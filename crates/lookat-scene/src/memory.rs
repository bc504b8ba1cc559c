//! Memory of a world.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use lookat_image::{MipMap, Texel};

use crate::{
    AnyTexture, Light, Material, MaterialKind, Object, Primitive, Shape, Texture, Value, Varying, World,
};

/// The memory of a world. Shared arrays count once.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Memory {
    /// Bytes of the shapes without their meshes, also of objects.
    pub shapes: usize,
    /// Bytes of the instances.
    pub instances: usize,
    /// Bytes of the meshes.
    pub meshes: usize,
    /// The number of pictures. A file read with two settings counts twice.
    pub pictures: usize,
    /// Bytes of the pictures, including MIP levels.
    pub picture_bytes: usize,
}

impl World {
    /// The objects with instances in the world, each once.
    pub fn objects(&self) -> Vec<&Arc<Object>> {
        let mut objects: Vec<&Arc<Object>> = Vec::new();
        let mut known = HashSet::new();
        for instance in &self.instances {
            if known.insert(Arc::as_ptr(&instance.object)) {
                objects.push(&instance.object);
            }
        }
        objects
    }

    /// All shapes, including shapes of instanced objects.
    pub fn shapes(&self) -> impl Iterator<Item = &Primitive> {
        let of_objects = self.objects().into_iter().flat_map(|object| &object.primitives);
        self.primitives.iter().chain(of_objects)
    }

    /// The memory of the world.
    pub fn memory(&self) -> Memory {
        let mut found = Found::default();
        self.shapes().for_each(|primitive| found.primitive(primitive));
        for light in &self.lights {
            match light {
                Light::Environment { map, .. } | Light::Goniometric { map, .. } => found.picture(map),
                Light::Projection { map: Some(map), .. } => found.picture(map),
                _ => {}
            }
        }
        Memory {
            shapes: self.shapes().map(shape_bytes).sum(),
            instances: size_of_val(&self.instances[..]),
            meshes: found.meshes.values().sum(),
            pictures: found.pictures.len(),
            picture_bytes: found.pictures.values().sum(),
        }
    }
}

fn shape_bytes(primitive: &Primitive) -> usize {
    let array = match &primitive.shape {
        Shape::Curve(curve) => size_of_val(&curve.segments[..]),
        _ => 0,
    };
    size_of::<Primitive>() + array
}

/// Bytes by address.
#[derive(Default)]
struct Found {
    meshes: HashMap<usize, usize>,
    pictures: HashMap<usize, usize>,
    materials: HashSet<usize>,
}

impl Found {
    fn primitive(&mut self, primitive: &Primitive) {
        if let Shape::TriangleMesh(mesh) = &primitive.shape {
            self.meshes.insert(Arc::as_ptr(mesh).addr(), mesh.bytes());
        }
        if let Some(cutout) = &primitive.cutout {
            cutout.alpha.iter().chain(&cutout.shadow_alpha).for_each(|alpha| self.texture(alpha));
        }
        self.material(&primitive.material);
    }

    fn material(&mut self, material: &Arc<Material>) {
        if !self.materials.insert(Arc::as_ptr(material).addr()) {
            return;
        }
        material.bump.iter().for_each(|bump| self.texture(bump));
        for texture in material.kind.textures() {
            match texture {
                AnyTexture::Number(texture) => self.texture(texture),
                AnyTexture::Color(texture) => self.texture(texture),
            }
        }
        if let MaterialKind::Mix(mix) = &material.kind {
            mix.materials.iter().for_each(|part| self.material(part));
        }
    }

    fn texture<T: Value>(&mut self, texture: &Texture<T>) {
        let Texture::Varying(node) = texture else { return };
        if let Varying::ImageMap(image) = &node.texture {
            self.picture(&image.map);
        }
        let (parts, weight) = node.texture.parts();
        parts.into_iter().for_each(|part| self.texture(part));
        weight.into_iter().for_each(|weight| self.texture(weight));
    }

    fn picture<T: Texel>(&mut self, map: &Arc<MipMap<T>>) {
        self.pictures.insert(Arc::as_ptr(map).addr(), map.bytes());
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{Instance, LoadOptions, Memory, Primitive, load};

    fn memory(world: &str) -> Memory {
        let text = format!(
            "Film \"image\" Sampler \"sobol\" Camera \"perspective\" Integrator \"path\" WorldBegin
            LightSource \"infinite\" {world} WorldEnd"
        );
        let read = |path: &Path| match path.extension() {
            Some(_) => Ok(pfm()),
            None => Ok(text.clone().into()),
        };
        load(Path::new("x"), &read, &LoadOptions::default()).scene.unwrap().world.memory()
    }

    /// A gray picture of 2 x 2 pixels.
    fn pfm() -> Vec<u8> {
        [b"Pf\n2 2\n-1\n".as_slice(), &[0; 16]].concat()
    }

    const TRIANGLE: &str =
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 1 1 0 1 0 1 1]";

    #[test]
    fn what_is_shared_counts_once() {
        let one = 3 * 24 + 3 * 4;
        assert_eq!(memory(&TRIANGLE.repeat(2)).meshes, 2 * one);
        let object = format!("ObjectBegin \"a\" {TRIANGLE} ObjectEnd");
        let copies = "ObjectInstance \"a\" ".repeat(3);
        let copied = memory(&format!("{object} {copies}"));
        assert_eq!((copied.meshes, copied.instances), (one, 3 * size_of::<Instance>()));
        assert_eq!(memory(&object).meshes, 0);
    }

    #[test]
    fn pictures_are_found_in_textures_of_textures_and_in_cutouts() {
        let map = |name: &str, kind: &str, more: &str| {
            format!("Texture \"{name}\" \"{kind}\" \"imagemap\" \"string filename\" \"a.pfm\" {more} ")
        };
        // Four texels and their mean.
        let of_numbers = map("n", "float", "");
        let cut = format!("{of_numbers} {TRIANGLE} \"texture alpha\" \"n\"");
        let one = size_of::<Primitive>();
        let with_cut = Memory { shapes: one, meshes: 84, pictures: 1, picture_bytes: 5 * 4, instances: 0 };
        assert_eq!(memory(&cut), with_cut);
        let of_colors = map("c", "spectrum", "");
        let scaled = "Texture \"s\" \"spectrum\" \"scale\" \"texture tex1\" \"c\" \"rgb tex2\" [.1 .2 .3]
            Material \"plastic\" \"texture Ks\" \"s\" \"texture Kd\" \"c\"";
        let found = memory(&format!("{of_colors} {scaled} Shape \"sphere\" {cut}"));
        assert_eq!(found, Memory { shapes: 2 * one, pictures: 2, picture_bytes: 5 * 4 + 5 * 12, ..with_cut });
    }
}
