//! Materials as a scene writes them.

use std::sync::Arc;

use lookat_syntax::{Entity, Param, ParamType};

use super::Material;
use crate::params::class;

/// A material with its source, because a shape may replace its parameters.
pub(crate) struct MaterialInstance {
    pub material: Arc<Material>,
    /// Its type and parameters as written.
    pub entity: Option<Entity>,
    /// The names and types of its parameters. `None` after an error in its type.
    pub known: Option<Vec<(&'static str, ParamType)>>,
}

impl MaterialInstance {
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
