//! Materials as a scene writes them.

use std::sync::Arc;

use lookat_syntax::{Entity, Param, ParamType, Values};

use super::Material;
use crate::params::class;
use crate::symbols::SymbolId;

/// A material with its source, because a shape may replace its parameters.
pub(crate) struct MaterialInstance {
    pub material: Arc<Material>,
    /// Its type and parameters as written.
    pub entity: Option<Entity>,
    /// The names and types of its parameters. `None` after an error in its type.
    pub known: Option<Vec<(&'static str, ParamType)>>,
    /// For each parameter the definition of the texture or material that it names.
    pub definitions: Vec<Option<SymbolId>>,
}

impl MaterialInstance {
    /// The parameter of a shape for which pbrt-v3 makes the material of the shape again, with the textures of that place: one that might
    /// be a material's (api.cpp, shapeMaySetMaterialParameters).
    pub fn renewing(params: &[Param]) -> Option<&Param> {
        params.iter().find(|Param { ty, name, values, .. }| {
            let geometry: &[&str] = match ty {
                ParamType::Texture => &["alpha", "shadowalpha"],
                ParamType::Float => &["radius"],
                ParamType::String => &["filename", "type", "scheme"],
                _ => &[],
            };
            // All numbers of a spectrum are one value.
            let is_one = match (ty, &values.value) {
                (ParamType::Texture, _) | (ParamType::Spectrum, Values::Numbers(_)) => true,
                (_, values) => values.len() == 1,
            };
            is_one && !geometry.contains(&name.value.as_str())
        })
    }

    /// Splits the parameters of a shape into material parameters and the rest.
    pub fn split(&self, params: Vec<Param>) -> (Vec<Param>, Vec<Param>) {
        let Some(known) = &self.known else { return (params, Vec::new()) };
        let is_known = |param: &Param| {
            known.iter().any(|(name, ty)| *name == param.name.value && class(*ty) == class(param.ty))
        };
        params.into_iter().partition(is_known)
    }
}

/// The material of shapes before any `Material` directive.
impl Default for MaterialInstance {
    fn default() -> Self {
        MaterialInstance {
            material: Arc::new(Material::DEFAULT),
            entity: None,
            definitions: Vec::new(),
            known: Some(vec![
                ("Kd", ParamType::Texture),
                ("Kd", ParamType::Rgb),
                ("sigma", ParamType::Texture),
                ("sigma", ParamType::Float),
                ("bumpmap", ParamType::Texture),
            ]),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::Vec3;

    use crate::{LoadOptions, MaterialKind, Texture, load};

    /// The Kd of each shape: of the last definition where pbrt-v3 makes the material again.
    #[test]
    fn shapes_make_their_material_again_as_in_pbrt() {
        let kd = |shape: &str, end: &str| {
            let text = format!(
                "Camera \"perspective\" Film \"image\" WorldBegin LightSource \"infinite\"
                 Texture \"f\" \"float\" \"constant\" Texture \"t\" \"color\" \"constant\" \"rgb value\" [1 0 0]
                 MakeNamedMaterial \"m\" \"string type\" \"matte\" \"texture Kd\" \"t\" \"float sigma\" 0
                 NamedMaterial \"m\" AttributeBegin Texture \"t\" \"float\" \"constant\"
                 Texture \"t\" \"color\" \"constant\" \"rgb value\" [0 1 0] {end} Shape {shape} WorldEnd"
            );
            let loaded = load(Path::new("a.pbrt"), &|_| Ok(text.clone().into()), &LoadOptions::default());
            let scene = loaded.scene.unwrap_or_else(|| panic!("{:?} {shape}", loaded.diagnostics));
            let material = &scene.world.primitives[0].material;
            assert_eq!(material.name.as_deref(), if shape.contains("sigma") { None } else { Some("m") });
            match material.kind() {
                MaterialKind::Matte(matte) => match matte.kd {
                    Texture::Constant(color) => color,
                    Texture::Varying(_) => panic!("{shape}"),
                },
                _ => panic!("{shape}"),
            }
        };
        let mesh = "\"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]";
        let [first, last] = [Vec3::X, Vec3::Y];
        for (shape, expected) in [
            ("\"sphere\"", first),
            ("\"sphere\" \"float radius\" 2", first),
            ("\"sphere\" \"float radius\" 2 \"float zmin\" -.5", last),
            ("\"sphere\" \"float phimax\" [360]", last),
            ("\"sphere\" \"float sigma\" 10", last),
            ("\"cylinder\" \"float radius\" 2", first),
            ("\"hyperboloid\" \"point p1\" [1 0 0]", last),
            ("\"curve\" \"string type\" \"flat\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]", first),
            ("\"curve\" \"float width\" 1 \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]", last),
            (mesh, first),
            (&format!("{mesh} \"texture alpha\" \"f\""), first),
            (&format!("{mesh} \"float alpha\" 1"), last),
            (&format!("{mesh} \"float uv\" [0 0 1 0 1 1]"), first),
        ] {
            assert_eq!(kd(shape, ""), expected, "{shape}");
            assert_eq!(kd(shape, "AttributeEnd"), first, "{shape}");
        }
    }
}
