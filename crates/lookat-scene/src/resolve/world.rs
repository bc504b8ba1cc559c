//! Materials, textures, lights and shapes.

use std::rc::Rc;
use std::sync::Arc;

use lookat_syntax::{Diagnostic, Entity, Param, ParamType, Text, Values};

use super::Resolver;
use crate::material::MaterialInstance;
use crate::mesh::cutout;
use crate::params::Params;
use crate::resolve::GraphicsState;
use crate::shape::Geometry;
use crate::symbols::{SymbolId, SymbolKind};
use crate::{Material, MaterialKind, Medium, Primitive, Shape, light, material, medium, shape, texture};

impl Resolver<'_> {
    pub(super) fn material(&mut self, entity: Entity, keyword: &'static str) -> MaterialInstance {
        // A copy takes no more memory than it needs.
        let kept = entity.clone();
        let params = Params::new(keyword, entity, &self.files, &mut self.report);
        let params = &mut params.with_textures(&self.state.textures);
        if self.state.materials.get(params.kind()).is_some() && !params.is_known_kind(material::KINDS) {
            let help = format!("to use the named material, write NamedMaterial \"{}\"", params.kind());
            let message = format!("there is no material of type \"{}\"", params.kind());
            params.reject("", message, Some(&help));
            params.ignore_rest();
            return MaterialInstance { known: None, ..MaterialInstance::default() };
        }
        let mut material = material::material(params, &self.state.materials, &mut self.tables);
        material.span = Some(kept.name.span);
        let known = params.known().map(|known| match self.known_parameters.get(known) {
            Some(shared) => shared.clone(),
            None => {
                let shared: Rc<[_]> = known.into();
                self.known_parameters.insert(shared.clone());
                shared
            }
        });
        let definitions = kept.params.iter().map(|param| self.definition(param, known.as_deref()));
        let has_any = definitions.clone().any(|definition| definition.is_some());
        let definitions = if has_any { definitions.collect() } else { Vec::new() };
        MaterialInstance { material: Arc::new(material), known, definitions, entity: Some(kept) }
    }

    /// The definition, at this point, of the texture or material that a parameter of a material names.
    fn definition(&self, param: &Param, known: Option<&[(&'static str, ParamType)]>) -> Option<SymbolId> {
        let Values::Strings(names) = &param.values.value else { return None };
        let (parameter, name) = (param.name.value.as_str(), &names.first()?.value);
        let GraphicsState { materials, textures, .. } = &self.state;
        match param.ty {
            ParamType::Texture if known?.contains(&(parameter, ParamType::Float)) => {
                textures.float.symbol(name)
            }
            ParamType::Texture => textures.spectrum.symbol(name),
            // Of a mix.
            ParamType::String if parameter.starts_with("namedmaterial") => materials.symbol(name),
            _ => None,
        }
    }

    /// Defines a named material. Its type is a parameter.
    pub(super) fn make_named_material(&mut self, entity: Entity) {
        let name = entity.name.clone();
        let params = &mut Params::new("MakeNamedMaterial", entity, &self.files, &mut self.report);
        let kind = material::named_type(params);
        let params = params.take_rest(|_| true);
        let kind = kind.unwrap_or_else(|| Text { value: "matte".into(), span: name.span });
        let mut instance = self.material(Entity { name: kind, params }, "Material");
        if let Some(material) = Arc::get_mut(&mut instance.material) {
            material.name = Some(name.value.clone());
        }
        if self.state.materials.get(&name.value).is_some() {
            self.facts.redefined.push((SymbolKind::Material, name.value.clone(), name.span));
        }
        self.state.materials.define(&name, Rc::new(instance), &mut self.report);
    }

    /// Defines a medium. Its type is a parameter.
    pub(super) fn make_named_medium(&mut self, entity: Entity) {
        let name = entity.name.clone();
        let params = &mut Params::new("MakeNamedMedium", entity, &self.files, &mut self.report);
        let kind = medium::named_type(params);
        let params = params.take_rest(|_| true);
        let ctm = match kind.as_ref().is_some_and(|kind| kind.value == "heterogeneous") {
            true => self.placing("medium", name.span),
            false => *self.state.ctm.start,
        };
        let medium = kind.and_then(|kind| {
            let entity = Entity { name: kind, params };
            let params = &mut Params::new("MakeNamedMedium", entity, &self.files, &mut self.report);
            medium::medium(params, ctm)
        });
        if self.definitions.media.get(&name.value).is_some() {
            self.facts.redefined.push((SymbolKind::Medium, name.value.clone(), name.span));
        }
        let number = medium.map(|medium| {
            self.draft.media.push(Medium { name: Some(name.value.clone()), ..medium });
            self.draft.media.len() as u32 - 1
        });
        self.definitions.media.define(&name, number, &mut self.report);
    }

    pub(super) fn texture(&mut self, name: Text, value: Text, entity: Entity) {
        let is_in_space = matches!(&entity.name.value[..], "fbm" | "marble" | "windy" | "wrinkled")
            || entity.params.iter().any(|param| match (&param.name.value[..], &param.values.value) {
                ("mapping", Values::Strings(names)) => {
                    names.iter().any(|name| matches!(&name.value[..], "spherical" | "cylindrical"))
                }
                ("dimension", Values::Integers(numbers)) => numbers.contains(&3),
                _ => false,
            });
        let ctm = match is_in_space {
            true => self.placing("texture", entity.name.span),
            false => *self.state.ctm.start,
        };
        let (textures, pictures) = (&self.state.textures, &mut self.draft.pictures);
        let is_float = value.value == "float";
        let known = if is_float {
            textures.float.get(&name.value).is_some()
        } else {
            textures.spectrum.get(&name.value).is_some()
        };
        if known {
            self.facts.redefined.push((textures.spectrum.kind(), name.value.clone(), name.span));
        }
        let params = Params::new("Texture", entity, &self.files, &mut self.report);
        let params = &mut params.with_textures(textures);
        // A texture may use its own predecessor of the same name.
        let (float, spectrum) = match value.value.as_str() {
            "float" => (Some(texture::texture(params, ctm, pictures)), None),
            "spectrum" | "color" => (None, Some(texture::texture(params, ctm, pictures))),
            other => {
                let error = Diagnostic::error(value.span, format!("unknown texture value type \"{other}\""))
                    .help("the value types are \"float\" and \"spectrum\" (also spelled \"color\")");
                params.error(error);
                // Define the name even after an error.
                (Some(None), Some(None))
            }
        };
        let textures = &mut self.state.textures;
        if let Some(made) = float {
            textures.float.define(&name, made, &mut self.report);
        }
        if let Some(made) = spectrum {
            textures.spectrum.define(&name, made, &mut self.report);
        }
    }

    pub(super) fn light_source(&mut self, entity: Entity) {
        if self.draft.open.is_some() {
            let message = "a LightSource is not part of an object: it shines once, from where it is defined, and ObjectInstance does not copy it";
            let help = "move it before ObjectBegin; pbrt-v3 renders the same picture";
            self.report.push(Diagnostic::warning(entity.name.span, message).help(help));
        }
        let at = entity.name.span;
        let world_from_light = match &entity.name.value[..] {
            "infinite" | "exinfinite" => self.of_light_directions(false, at),
            "distant" => self.of_light_directions(true, at),
            _ => self.placing("light", at),
        };
        let params = &mut Params::new("LightSource", entity, &self.files, &mut self.report);
        if let Some(light) = light::light(params, world_from_light, &mut self.draft.pictures) {
            self.draft.lights.push(light);
            self.facts.lights.push(at);
        }
    }

    pub(super) fn shape(&mut self, mut entity: Entity) -> Result<(), Box<Diagnostic>> {
        let name = entity.name.clone();
        self.need_affine(name.span);
        let motion = self.motion(name.span)?;
        // A shape that moves is made in its own space.
        let ctm = if motion.is_some() { Arc::default() } else { self.state.ctm.start.clone() };
        let renewing = MaterialInstance::renewing(&entity.params).map(|param| param.name.clone());
        let mesh_key = self.files.mesh_key(&entity, &ctm).filter(|_| !self.report.partial);
        let kept = mesh_key.as_ref().and_then(|key| self.files.kept_mesh(key));
        if kept.is_none() {
            self.files.read_lists(&mut entity.params);
        }
        let params = Params::new("Shape", entity, &self.files, &mut self.report);
        let params = &mut params.with_textures(&self.state.textures);
        params.mesh_key = mesh_key;
        let cutout = match params.kind() {
            "trianglemesh" | "plymesh" => cutout(params),
            _ => None,
        };
        let geometry = shape::shape(params, kept, &ctm);
        let is_made = geometry.is_some();
        let shape = match geometry {
            Some(Geometry::PlyFile(name)) => {
                let meshes = &mut self.draft.meshes;
                let mesh = params.without_rejection(|params| meshes.mesh(params, &name, *ctm));
                mesh.map(Shape::TriangleMesh)
            }
            Some(Geometry::Shape(shape)) => Some(shape),
            None => None,
        };
        let overriding = params.take_rest(|param| self.state.material.takes(param));
        if !(params.finish() && is_made) {
            return Ok(());
        }
        let emission = self.state.emission.clone().filter(|_| motion.is_none());
        if let Some(own) = self.state.emission.as_ref().filter(|_| motion.is_some()) {
            self.facts.emissions.retain(|at| Some(*at) != own.span);
            let message = "a shape that moves does not emit light, as in pbrt-v3";
            let warning = Diagnostic::warning(name.span, message);
            let warning =
                own.span.into_iter().fold(warning, |all, at| all.related(at, "this emission is ignored"));
            self.report
                .push(warning.help("move the AreaLightSource into a block with shapes that stand still"));
        }
        let material = self.material_for_shape(overriding, renewing.as_ref());
        let is_boundary = matches!(material.kind, MaterialKind::None) && emission.is_none();
        let knows_media = self.resolved.as_ref().is_some_and(|resolved| resolved.passes_boundaries);
        let medium = Some(self.state.medium).filter(|it| knows_media && it.inside != it.outside);
        if is_boundary && knows_media && medium.is_none() {
            self.facts.passed.get_or_insert(name.span);
            return Ok(());
        }
        let Some(shape) = shape else { return Ok(()) };
        if cutout.as_ref().is_some_and(|cutout| cutout.shadow_alpha.is_some()) {
            self.facts.shadow_alpha.get_or_insert(name.span);
        }
        let primitive = Primitive {
            shape,
            span: Some(name.span),
            reverse_orientation: self.state.reverse_orientation,
            mirrored: ctm.swaps_handedness(),
            material,
            cutout,
            emission,
            medium,
        };
        self.draft.add(primitive, motion);
        Ok(())
    }

    /// The current material, with parameters replaced by the shape. `renewing`: the parameter for which it is made again.
    pub(super) fn material_for_shape(
        &mut self,
        overriding: Vec<Param>,
        renewing: Option<&Text>,
    ) -> Arc<Material> {
        let current = self.state.material.clone();
        let is_replaced = |param: &Param| overriding.iter().any(|over| over.name.value == param.name.value);
        let mut is_renewed = false;
        if let (Some(entity), Some(renewing)) = (&current.entity, renewing) {
            for (param, before) in entity.params.iter().zip(&current.definitions) {
                let now = self.definition(param, current.known.as_deref());
                if let (Some(before), Some(now), false) = (before, now, is_replaced(param))
                    && *before != now
                {
                    is_renewed = true;
                    self.note_renewed(renewing, *before, now);
                }
            }
        }
        if overriding.is_empty() && !is_renewed {
            return current.material.clone();
        }
        let mut entity = match (&current.entity, overriding.first()) {
            (Some(entity), _) => entity.clone(),
            (None, Some(first)) => {
                Entity { name: Text { value: "matte".into(), span: first.span() }, params: Vec::new() }
            }
            (None, None) => return current.material.clone(),
        };
        entity.params.retain(|param| !is_replaced(param));
        let is_own = overriding.is_empty();
        entity.params.extend(overriding);
        let mut made = self.material(entity, "Material").material;
        if let Some(material) = Arc::get_mut(&mut made).filter(|_| is_own) {
            material.name = current.material.name.clone();
        }
        made
    }

    /// Notes that a shape uses another definition than its material.
    fn note_renewed(&mut self, renewing: &Text, before: SymbolId, now: SymbolId) {
        let symbols = &self.report.symbols;
        let (before, now) = (&symbols[before], &symbols[now]);
        let what = if now.kind == SymbolKind::Material { "material" } else { "texture" };
        let message = format!(
            "\"{}\" makes the material again, with the last definition of {what} \"{}\"",
            renewing.value, now.name
        );
        let help =
            format!("as in pbrt-v3; to keep the first definition, give the two {what}s different names");
        let mut note = Diagnostic::note_at(renewing.span, message).help(help);
        for (at, text) in
            [(before.definition, "the Material uses this one"), (now.definition, "the shape uses this one")]
        {
            note = at.into_iter().fold(note, |note, at| note.related(at, text));
        }
        self.report.push(note);
    }
}
