//! Materials, textures, lights and shapes.

use std::rc::Rc;
use std::sync::Arc;

use lookat_syntax::{Diagnostic, Entity, Param, ParamType, Text, Values};

use super::Resolver;
use crate::cutout::cutout;
use crate::elsewhere::Kind;
use crate::params::Params;
use crate::schema::names;
use crate::state::MaterialInstance;
use crate::texture::TextureParams;
use crate::undefined::undefined;
use crate::{Emission, Material, MaterialKind, Primitive, light, material, shape, texture};

impl Resolver<'_> {
    pub(super) fn material(&mut self, entity: Entity, keyword: &'static str) -> MaterialInstance {
        let params = &mut Params::new(keyword, entity.clone(), &self.files, &mut self.report);
        let params = &mut TextureParams::new(params, &self.definitions.textures);
        if self.definitions.materials.get(params.kind()).is_some()
            && !names(material::KINDS).contains(&params.kind())
        {
            let help = format!("to use the named material, write NamedMaterial \"{}\"", params.kind());
            let message = format!("there is no material of type \"{}\"", params.kind());
            params.reject("", message, Some(&help));
            params.ignore_rest();
            return MaterialInstance { material: Arc::new(Material::DEFAULT), known: None, entity: None };
        }
        let material = Arc::new(material::material(params, &self.definitions.materials));
        MaterialInstance { material, known: params.known(), entity: Some(entity) }
    }

    /// Defines a named material. Its type is a parameter.
    pub(super) fn make_named_material(&mut self, entity: Entity) -> Result<(), Box<Diagnostic>> {
        let Entity { name, mut params } = entity;
        let is_type = |param: &Param| param.name.value == "type" && param.ty == ParamType::String;
        let given = params.iter().rposition(is_type).map(|at| params.remove(at).values);
        let mut error = (given.is_none() && !self.report.partial).then(|| {
            Diagnostic::error(name.span, format!("named material \"{}\" has no type", name.value))
                .help("add \"string type\" \"matte\"")
        });
        let kind = given.and_then(|given| match given.value {
            Values::Strings(mut kinds) if kinds.len() == 1 => kinds.pop(),
            several => {
                let message = format!("the type takes 1 value, not {}", several.len());
                error = Some(Diagnostic::error(given.span, message));
                None
            }
        });
        let kind = kind.unwrap_or_else(|| Text { value: "matte".into(), span: name.span });
        let instance = self.material(Entity { name: kind, params }, "Material");
        if self.definitions.materials.get(&name.value).is_some() {
            self.note_again("material", &name.value, name.span);
        }
        self.report.define(Kind::Material, &name);
        self.definitions.materials.define(name.value.clone(), Rc::new(instance));
        error.map_or(Ok(()), |error| Err(Box::new(error)))
    }

    pub(super) fn named_material(&mut self, name: Text) {
        match self.definitions.materials.get(&name.value) {
            Some(instance) => self.state.material = instance.clone(),
            None => undefined(&mut self.report, Kind::Material, &name, self.definitions.materials.keys()),
        }
    }

    pub(super) fn texture(&mut self, name: Text, value: Text, entity: Entity) {
        self.texture_again(&name, &value);
        self.define_texture(name.clone(), &value, entity);
        // A texture may use its own predecessor of the same name.
        if let Some(kind) = Kind::of_texture(&value.value) {
            self.report.define(kind, &name);
        }
    }

    fn define_texture(&mut self, name: Text, value: &Text, entity: Entity) {
        let params = &mut Params::new("Texture", entity, &self.files, &mut self.report);
        let params = &mut TextureParams::new(params, &self.definitions.textures);
        match value.value.as_str() {
            "float" => {
                let made = texture::texture(params, self.state.ctm, &mut self.pictures);
                self.definitions.textures.float.define(name.value, made);
            }
            "spectrum" | "color" => {
                let made = texture::texture(params, self.state.ctm, &mut self.pictures);
                self.definitions.textures.spectrum.define(name.value, made);
            }
            other => {
                let error = Diagnostic::error(value.span, format!("unknown texture value type \"{other}\""))
                    .help("the value types are \"float\" and \"spectrum\" (also spelled \"color\")");
                params.error(error);
                // Define the name even after an error.
                let textures = &mut self.definitions.textures;
                textures.float.define(name.value.clone(), None);
                textures.spectrum.define(name.value, None);
            }
        }
    }

    /// Adds a note if a texture of this name and value type is already defined.
    fn texture_again(&mut self, name: &Text, value: &Text) {
        let textures = &self.definitions.textures;
        let known = match value.value.as_str() {
            "float" => textures.float.get(&name.value).is_some(),
            _ => textures.spectrum.get(&name.value).is_some(),
        };
        if known {
            self.note_again("texture", &name.value, name.span);
        }
    }

    /// Checks one side of a MediumInterface.
    pub(super) fn medium(&mut self, name: Text) {
        if self.media.contains(&name.value) {
            let message = "lookat does not render participating media: it renders empty space instead";
            self.report.unsupported(name.span, message.into());
        } else if !name.value.is_empty() {
            undefined(&mut self.report, Kind::Medium, &name, self.media.iter());
        }
    }

    pub(super) fn light_source(&mut self, entity: Entity) {
        if self.object.is_some() {
            let message = "a LightSource is not part of an object: it shines once, from where it is defined, and ObjectInstance does not copy it";
            let warning = Diagnostic::warning(entity.name.span, message);
            self.report.push(warning.help("move it before ObjectBegin; pbrt-v3 renders the same picture"));
        }
        let params = &mut Params::new("LightSource", entity, &self.files, &mut self.report);
        let light = light::light(params, self.state.ctm, &mut self.pictures);
        self.lights.extend(light);
    }

    pub(super) fn shape(&mut self, entity: Entity) {
        let name = entity.name.clone();
        let params = &mut Params::new("Shape", entity, &self.files, &mut self.report);
        let cutout = match params.kind() {
            "trianglemesh" | "plymesh" => cutout(&mut TextureParams::new(params, &self.definitions.textures)),
            _ => None,
        };
        let shape = shape::shape(params, self.state.ctm);
        let (overriding, unknown) = self.state.material.split(params.take_rest());
        params.put_back(unknown);
        params.finish();
        // Omit an incomplete shape.
        let Some(shape) = shape.filter(|_| !self.report.partial) else { return };
        if let Some(emission) = self.state.emission.as_ref().filter(|_| !shape.is_empty()) {
            self.idle_emissions.remove(&emission.span);
        }
        let material = self.material_for_shape(overriding);
        let emission = self.emission(&name);
        let is_boundary = matches!(material.kind, MaterialKind::None) && emission.is_none();
        if is_boundary && self.settled.as_ref().is_some_and(|settled| settled.passes_boundaries) {
            self.passed.get_or_insert(name.span);
            return;
        }
        if matches!(material.kind, MaterialKind::None)
            && self.settled.as_ref().is_some_and(|settled| settled.passes_boundaries)
        {
            let message = "pbrt-v3 lets shadow rays pass this emissive surface without a material, and finds its light by light samples only";
            let help = "write Material \"matte\" \"rgb Kd\" [0 0 0]: lookat and pbrt-v3 then agree";
            self.report.push(Diagnostic::warning(name.span, message).help(help));
        }
        let primitive = Primitive {
            shape,
            span: Some(name.span),
            reverse_orientation: self.state.reverse_orientation,
            mirrored: self.state.ctm.swaps_handedness(),
            material,
            cutout,
            emission,
        };
        self.warn_of_departures(&name, &primitive);
        match &mut self.object {
            Some(object) => object.primitives.push(primitive),
            None => self.primitives.push(primitive),
        }
    }

    /// The current material, with parameters replaced by the shape.
    pub(super) fn material_for_shape(&mut self, overriding: Vec<Param>) -> Arc<Material> {
        let current = self.state.material.clone();
        if overriding.is_empty() {
            return current.material.clone();
        }
        let span = overriding[0].span();
        let mut entity = current
            .entity
            .clone()
            .unwrap_or_else(|| Entity { name: Text { value: "matte".into(), span }, params: vec![] });
        entity.params.retain(|param| !overriding.iter().any(|over| over.name.value == param.name.value));
        entity.params.extend(overriding);
        self.material(entity, "Material").material
    }

    pub(super) fn emission(&mut self, shape: &Text) -> Option<Emission> {
        let emission = self.state.emission.as_ref()?.value;
        if self.object.is_some() {
            let message =
                "an emissive shape inside an object is visible but lights nothing: move it out of the object";
            self.report.unsupported(shape.span, message.into());
        } else if shape.value == "curve" {
            let message =
                "an emissive curve is visible but lights nothing: use a mesh or a quadric as a light";
            self.report.unsupported(shape.span, message.into());
        }
        Some(emission)
    }
}
