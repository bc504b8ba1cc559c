//! The interpreter: every directive changes the state as api.cpp of pbrt-v3 has it, or adds to the scene.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use glam::{DMat4, DVec3};
use lookat_syntax::{
    Diagnostic, Directive, Entity, EntityKind, FileId, Param, ParamType, Span, Statement, Text, Values,
    nearest,
};

use crate::files::Files;
use crate::load::{Loaded, Overrides};
use crate::options::{Options, Settled};
use crate::params::Params;
use crate::report::Report;
use crate::state::{GraphicsState, MaterialInstance, Open};
use crate::transform::{LARGEST, LookAtFault, Transform};
use crate::{Emission, Instance, Light, Object, Primitive, Scene, light, material, shape, texture};

/// Where a directive may stand.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    Options,
    World,
    /// After `WorldEnd`.
    Ended,
}

/// Reads directives one by one; [`Resolver::finish`] gives the scene.
pub(crate) struct Resolver<'a> {
    pub files: Files<'a>,
    pub report: Report,
    overrides: &'a Overrides,
    block: Block,
    world_begin: Option<Span>,
    /// Directives of the world that stand before it: their keywords and places.
    early: Vec<(&'static str, Span)>,
    state: GraphicsState,
    open: Vec<Open>,
    /// Directives that would close a block which a wrong one has closed already.
    forgiven: Vec<&'static str>,
    coordinate_systems: HashMap<String, Transform>,
    options: Options,
    settled: Option<Settled>,
    /// A transformation after `Camera`, which nothing has used yet.
    idle_transform: Option<Span>,
    primitives: Vec<Primitive>,
    instances: Vec<Instance>,
    lights: Vec<Light>,
    /// There is a light that is not rendered.
    dark_light: bool,
    /// The object that is being defined.
    object: Option<Object>,
    objects: BTreeMap<String, Arc<Object>>,
    media: Vec<String>,
}

impl<'a> Resolver<'a> {
    pub fn new(files: Files<'a>, overrides: &'a Overrides) -> Self {
        Resolver {
            files,
            report: Report::default(),
            overrides,
            block: Block::Options,
            world_begin: None,
            early: Vec::new(),
            state: GraphicsState::new(),
            open: Vec::new(),
            forgiven: Vec::new(),
            coordinate_systems: HashMap::new(),
            options: Options::default(),
            settled: None,
            idle_transform: None,
            primitives: Vec::new(),
            instances: Vec::new(),
            lights: Vec::new(),
            dark_light: false,
            object: None,
            objects: BTreeMap::new(),
            media: Vec::new(),
        }
    }

    /// One directive. What is wrong with it is reported, and the next one goes on.
    pub fn apply(&mut self, statement: Statement) {
        if !self.belongs_here(&statement) {
            return;
        }
        if let Err(error) = self.directive(statement) {
            self.report.push(*error);
        }
    }

    fn directive(&mut self, statement: Statement) -> Result<(), Box<Diagnostic>> {
        let at = statement.keyword;
        match statement.directive {
            Directive::Identity => self.state.ctm = Transform::IDENTITY,
            Directive::Translate(by) => self.concat(Transform::translate(by.into()), at)?,
            Directive::Scale(by) => self.concat(scale(by, &statement.span)?, at)?,
            Directive::Rotate([angle, axis @ ..]) => {
                self.concat(rotate(angle, axis, &statement.span)?, at)?
            }
            Directive::LookAt(points) => self.look_at(points, statement.span)?,
            Directive::Transform(m) => self.replace(matrix(&m, "Transform", &statement.span)?, at)?,
            Directive::ConcatTransform(m) => {
                self.concat(matrix(&m, "ConcatTransform", &statement.span)?, at)?
            }
            Directive::CoordinateSystem(name) => {
                self.idle_transform = None;
                self.coordinate_systems.insert(name.value, self.state.ctm);
            }
            Directive::CoordSysTransform(name) => self.coord_sys_transform(name)?,
            Directive::ActiveTransform(_) => self.motion(at, "ActiveTransform"),
            Directive::TransformTimes(_) => self.motion(at, "TransformTimes"),
            Directive::TransformBegin => {
                self.open.push(Open::Transform { saved: Box::new(self.state.ctm), at })
            }
            Directive::AttributeBegin => {
                self.open.push(Open::Attribute { saved: Box::new(self.state.clone()), at });
            }
            Directive::ObjectBegin(name) => self.object_begin(name, at)?,
            Directive::TransformEnd | Directive::AttributeEnd | Directive::ObjectEnd => {
                self.close(statement.directive.keyword(), at)?;
            }
            Directive::ObjectInstance(name) => self.object_instance(name)?,
            Directive::ReverseOrientation => self.state.reverse_orientation = !self.state.reverse_orientation,
            Directive::WorldBegin => self.world_begin(at),
            Directive::WorldEnd => self.world_end(),
            Directive::NamedMaterial(name) => self.named_material(name)?,
            Directive::MediumInterface { inside, outside } => {
                for name in [Some(inside), outside].into_iter().flatten() {
                    self.medium(name)?;
                }
            }
            Directive::Texture { name, value, entity } => self.texture(name, value, entity),
            Directive::Entity(kind, entity) => self.entity(kind, entity, at, statement.faulty)?,
            // The loader has followed it.
            Directive::Include { .. } => {}
        }
        Ok(())
    }

    fn entity(
        &mut self,
        kind: EntityKind,
        entity: Entity,
        at: Span,
        faulty: bool,
    ) -> Result<(), Box<Diagnostic>> {
        match kind {
            EntityKind::Shape if !faulty => self.shape(entity),
            EntityKind::LightSource if !faulty => self.light_source(entity),
            // A shape or light of which a part is missing would be another one.
            EntityKind::Shape | EntityKind::LightSource => {}
            EntityKind::Material => {
                let instance = self.material(entity, "Material");
                self.state.material = Rc::new(instance);
            }
            EntityKind::MakeNamedMaterial => self.make_named_material(entity, faulty)?,
            EntityKind::AreaLightSource => {
                let params = &mut Params::new("AreaLightSource", entity, &self.files, &mut self.report);
                self.state.emission = light::emission(params);
            }
            EntityKind::MakeNamedMedium => {
                let message = "participating media are not rendered; space is empty";
                self.report.unsupported(at, message.into());
                self.media.push(entity.name.value);
            }
            _ => {
                let world_from_camera = self.state.ctm.inverse();
                if kind == EntityKind::Camera {
                    self.idle_transform = None;
                    self.coordinate_systems.insert("camera".into(), world_from_camera);
                }
                self.options.set(kind, entity, at, world_from_camera, &mut self.report);
            }
        }
        Ok(())
    }

    /// Reports a directive in the wrong block.
    fn belongs_here(&mut self, statement: &Statement) -> bool {
        let (home, at) = (home_block(&statement.directive), statement.keyword);
        let keyword = statement.directive.keyword();
        if self.block == Block::Ended {
            let message = "directives after WorldEnd are ignored: lookat renders one picture of a file";
            self.report.unsupported(at, message.into());
            return false;
        }
        match (home, self.block) {
            (Some(Block::Options), Block::World) => self.report_late(&statement.directive, at),
            // Told when it is known where WorldBegin stands, if anywhere.
            (Some(Block::World), Block::Options) => self.early.push((keyword, at)),
            _ => return true,
        }
        false
    }

    fn report_late(&mut self, directive: &Directive, at: Span) {
        let error = match directive {
            Directive::WorldBegin => {
                Diagnostic::error(at, "a second WorldBegin").help("one file is one world")
            }
            other => Diagnostic::error(at, format!("{} inside the world block", other.keyword()))
                .help("it belongs before WorldBegin"),
        };
        let error = match self.world_begin {
            Some(begin) => error.related(begin, "the world block begins here"),
            None => error,
        };
        self.report.push(error);
    }

    fn report_early(&mut self, world_begin: Span) {
        for (keyword, at) in std::mem::take(&mut self.early) {
            let error = Diagnostic::error(at, format!("{keyword} before WorldBegin"))
                .help("it belongs after WorldBegin")
                .related(world_begin, "the world block begins here");
            self.report.once(error);
        }
    }

    fn report_no_world(&mut self, end: Span) {
        if self.report.incomplete {
            return;
        }
        let error = match self.early.first() {
            None => Diagnostic::error(end, "the file has no WorldBegin: there is nothing to render")
                .help("WorldBegin and WorldEnd enclose the lights and shapes"),
            Some((keyword, at)) => {
                let before = Span { end: at.start, ..*at };
                Diagnostic::error(*at, format!("{keyword} without WorldBegin"))
                    .help("WorldBegin and WorldEnd enclose the lights and shapes")
                    .fix(before, "WorldBegin\n")
            }
        };
        self.report.push(error);
    }

    // Transformations

    fn concat(&mut self, transform: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        self.replace(self.state.ctm * transform, at)
    }

    fn replace(&mut self, ctm: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        if self.block == Block::Options && self.options.camera_is_set() {
            self.idle_transform.get_or_insert(at);
        }
        self.state.ctm = in_range(ctm, at)?;
        Ok(())
    }

    fn look_at(&mut self, points: [f64; 9], span: Span) -> Result<(), Box<Diagnostic>> {
        let [eye, look, up] = [0, 3, 6].map(|at| DVec3::new(points[at], points[at + 1], points[at + 2]));
        if self.block == Block::World {
            let warning =
                Diagnostic::warning(span, "LookAt inside the world block moves shapes, not the camera")
                    .help("a LookAt that places the camera stands before Camera");
            self.report.push(warning);
        }
        match Transform::look_at(eye, look, up) {
            Ok(transform) => self.concat(transform, span),
            Err(fault) => {
                let (message, help) = match fault {
                    LookAtFault::EyeAtLook => (
                        "LookAt has its eye where it looks",
                        "the first three numbers are the eye, the next three another point",
                    ),
                    LookAtFault::ZeroUp => ("the up vector of LookAt is zero", "0 1 0 or 0 0 1 are usual"),
                    LookAtFault::UpParallel => (
                        "the up vector of LookAt is parallel to the view",
                        "the last three numbers give a direction that is up in the picture: choose one across the view",
                    ),
                };
                Err(Box::new(Diagnostic::error(span, message).help(help)))
            }
        }
    }

    fn coord_sys_transform(&mut self, name: Text) -> Result<(), Box<Diagnostic>> {
        match self.coordinate_systems.get(&name.value) {
            Some(transform) => {
                let transform = *transform;
                self.replace(transform, name.span)
            }
            None => {
                let known = self.coordinate_systems.keys();
                self.undefined("coordinate system", &name, known, "CoordinateSystem")
            }
        }
    }

    fn motion(&mut self, at: Span, keyword: &str) {
        let message = format!("{keyword}: motion is not rendered; the scene stands still");
        self.report.unsupported(at, message);
    }

    // Blocks

    fn world_begin(&mut self, at: Span) {
        self.block = Block::World;
        self.world_begin = Some(at);
        self.report_early(at);
        self.state.ctm = Transform::IDENTITY;
        self.coordinate_systems.insert("world".into(), Transform::IDENTITY);
        if let Some(idle) = self.idle_transform.take() {
            let warning = Diagnostic::warning(idle, "a transformation after Camera changes nothing")
                .help("Camera takes the transformations before it, and WorldBegin starts afresh");
            self.report.push(warning);
        }
        let options = std::mem::take(&mut self.options);
        self.settled = Some(options.settle(at, self.overrides, &self.files, &mut self.report));
    }

    fn world_end(&mut self) {
        for open in std::mem::take(&mut self.open).into_iter().rev() {
            let (begin, end) = open.keywords();
            let warning = Diagnostic::warning(open.at(), format!("this {begin} is not closed"))
                .help(format!("{end} closes it; the world block ends first"));
            self.report.push(warning);
            self.restore(open);
        }
        self.block = Block::Ended;
    }

    fn close(&mut self, keyword: &'static str, at: Span) -> Result<(), Box<Diagnostic>> {
        let Some(inner) = self.open.last().map(|open| (open.keywords(), open.at())) else {
            return self.close_nothing(keyword, at);
        };
        let ((begin, end), opened) = inner;
        if end == keyword {
            self.open.pop().into_iter().for_each(|open| self.restore(open));
            return Ok(());
        }
        self.close_wrongly(keyword);
        let error = Diagnostic::error(at, format!("{keyword} inside the block of {begin}"))
            .note(format!("expected {end}"))
            .related(opened, "the block opens here");
        Err(Box::new(error))
    }

    fn close_nothing(&mut self, keyword: &'static str, at: Span) -> Result<(), Box<Diagnostic>> {
        if let Some(known) = self.forgiven.iter().position(|forgiven| *forgiven == keyword) {
            self.forgiven.remove(known);
            return Ok(());
        }
        let begin = keyword.replace("End", "Begin");
        Err(Box::new(Diagnostic::error(at, format!("{keyword} without {begin}"))))
    }

    /// Closes what most likely was meant, so that one wrong end is one error: up to the block that matches; else the
    /// inner block, if it was mistaken for one of the other kind; else nothing.
    fn close_wrongly(&mut self, keyword: &'static str) {
        let depth = match self.open.iter().rposition(|open| open.keywords().1 == keyword) {
            Some(matching) => matching,
            None if keyword == "ObjectEnd" || matches!(self.open.last(), Some(Open::Object { .. })) => return,
            None => self.open.len() - 1,
        };
        for open in self.open.split_off(depth).into_iter().rev() {
            let end = open.keywords().1;
            if end != keyword {
                self.forgiven.push(end);
            }
            self.restore(open);
        }
    }

    fn restore(&mut self, open: Open) {
        match open {
            Open::Attribute { saved, .. } => self.state = *saved,
            Open::Transform { saved, .. } => self.state.ctm = *saved,
            Open::Object { saved, name, .. } => {
                self.state = *saved;
                if let Some(name) = name {
                    let object = self.object.take().unwrap_or_default();
                    self.objects.insert(name, Arc::new(object));
                }
            }
        }
    }

    // Objects

    fn object_begin(&mut self, name: Text, at: Span) -> Result<(), Box<Diagnostic>> {
        let inside = self.open.iter().find(|open| matches!(open, Open::Object { .. })).map(Open::at);
        let saved = Box::new(self.state.clone());
        let Some(outer) = inside else {
            self.open.push(Open::Object { saved, name: Some(name.value), at });
            self.object = Some(Object::default());
            return Ok(());
        };
        // Its ObjectEnd and its instances are not wrong for that.
        self.open.push(Open::Object { saved, name: None, at });
        self.objects.entry(name.value).or_default();
        Err(Box::new(
            Diagnostic::error(at, "ObjectBegin inside the definition of an object")
                .related(outer, "the outer object begins here"),
        ))
    }

    fn object_instance(&mut self, name: Text) -> Result<(), Box<Diagnostic>> {
        if let Some(Open::Object { at, .. }) =
            self.open.iter().find(|open| matches!(open, Open::Object { .. }))
        {
            return Err(Box::new(
                Diagnostic::error(name.span, "ObjectInstance inside the definition of an object")
                    .related(*at, "the object begins here"),
            ));
        }
        let Some(object) = self.objects.get(&name.value) else {
            return self.undefined("object", &name, self.objects.keys(), "ObjectBegin");
        };
        if !object.primitives.is_empty() {
            self.instances.push(Instance { object: object.clone(), world_from_object: self.state.ctm });
        }
        Ok(())
    }

    /// The error for a name that nothing has defined; none where a file that may define it is missing.
    fn undefined<'n>(
        &self,
        what: &str,
        name: &Text,
        known: impl Iterator<Item = &'n String>,
        definer: &str,
    ) -> Result<(), Box<Diagnostic>> {
        if self.report.incomplete { Ok(()) } else { Err(undefined(what, name, known, definer)) }
    }

    // Materials and textures

    fn material(&mut self, entity: Entity, keyword: &'static str) -> MaterialInstance {
        let params = &mut Params::new(keyword, entity.clone(), &self.files, &mut self.report)
            .with_textures(&self.state.textures);
        let material = Arc::new(material::material(params));
        MaterialInstance { material, names: params.asked(), entity: Some(entity) }
    }

    /// The type of a named material is one of its parameters.
    fn make_named_material(&mut self, entity: Entity, faulty: bool) -> Result<(), Box<Diagnostic>> {
        let Entity { name, mut params } = entity;
        let is_type = |param: &Param| param.name.value == "type" && param.ty == ParamType::String;
        let kind = params.iter().position(is_type).and_then(|at| match params.remove(at).values.value {
            Values::Strings(mut names) => names.pop(),
            _ => None,
        });
        let missing = kind.is_none() && !faulty;
        let kind = kind.unwrap_or_else(|| Text { value: "matte".into(), span: name.span });
        let instance = self.material(Entity { name: kind, params }, "Material");
        // Named materials may be defined again: pbrt-v3 says so too.
        if self.state.named_materials.contains_key(&name.value) {
            let message =
                format!("material \"{}\" is defined again; the new one counts from here", name.value);
            self.report.push(Diagnostic::warning(name.span, message));
        }
        Rc::make_mut(&mut self.state.named_materials).insert(name.value.clone(), Rc::new(instance));
        if missing {
            let error =
                Diagnostic::error(name.span, format!("named material \"{}\" has no type", name.value))
                    .help("\"string type\" \"matte\" gives it one");
            return Err(Box::new(error));
        }
        Ok(())
    }

    fn named_material(&mut self, name: Text) -> Result<(), Box<Diagnostic>> {
        match self.state.named_materials.get(&name.value) {
            Some(instance) => {
                self.state.material = instance.clone();
                Ok(())
            }
            None => {
                let known = self.state.named_materials.keys();
                self.undefined("named material", &name, known, "MakeNamedMaterial")
            }
        }
    }

    fn texture(&mut self, name: Text, value: Text, entity: Entity) {
        let textures = self.state.textures.clone();
        let params =
            &mut Params::new("Texture", entity, &self.files, &mut self.report).with_textures(&textures);
        match value.value.as_str() {
            "float" => {
                let made = texture::float_texture(params);
                Rc::make_mut(&mut self.state.textures).float.insert(name.value, made);
            }
            "spectrum" | "color" => {
                let made = texture::spectrum_texture(params);
                Rc::make_mut(&mut self.state.textures).spectrum.insert(name.value, made);
            }
            other => {
                let error =
                    Diagnostic::error(value.span, format!("unknown type \"{other}\" of a texture's values"))
                        .help("textures are of type \"float\" or \"spectrum\" (\"color\" is an old name)");
                params.error(error);
                // The name is defined for all that.
                let textures = Rc::make_mut(&mut self.state.textures);
                textures.float.insert(name.value.clone(), None);
                textures.spectrum.insert(name.value, None);
            }
        }
    }

    fn medium(&mut self, name: Text) -> Result<(), Box<Diagnostic>> {
        if name.value.is_empty() || self.media.contains(&name.value) {
            return Ok(());
        }
        self.undefined("medium", &name, self.media.iter(), "MakeNamedMedium")
    }

    // Lights and shapes

    fn light_source(&mut self, entity: Entity) {
        let params = &mut Params::new("LightSource", entity, &self.files, &mut self.report);
        let light = light::light(params, self.state.ctm);
        self.dark_light |= light.is_none();
        self.lights.extend(light);
    }

    fn shape(&mut self, entity: Entity) {
        let name = entity.name.clone();
        let params = &mut Params::new("Shape", entity, &self.files, &mut self.report);
        let shape = shape::shape(params, self.state.ctm);
        let (overriding, unknown) = self.state.material.split(params.take_rest());
        params.put_back(unknown);
        params.finish();
        let Some(shape) = shape else {
            self.dark_light |= self.state.emission.is_some();
            return;
        };
        let material = self.material_for_shape(overriding);
        let emission = self.emission(&name);
        let primitive = Primitive {
            shape,
            reverse_orientation: self.state.reverse_orientation,
            mirrored: self.state.ctm.swaps_handedness(),
            material,
            emission,
        };
        match &mut self.object {
            Some(object) => object.primitives.push(primitive),
            None => self.primitives.push(primitive),
        }
    }

    /// The current material, with the parameters that the shape gives in place of its own.
    fn material_for_shape(&mut self, overriding: Vec<Param>) -> Arc<crate::Material> {
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

    fn emission(&mut self, shape: &Text) -> Option<Emission> {
        let emission = self.state.emission?;
        if self.object.is_some() {
            let message =
                "a shape of an object glows, but lights nothing; place the light outside ObjectBegin";
            self.report.unsupported(shape.span, message.into());
        }
        Some(emission)
    }

    /// The scene, after the last directive of the scene file.
    pub fn finish(mut self, file: FileId) -> Loaded {
        let end = self.files.sources.file(file).text.len() as u32;
        let at = Span { file, start: end, end };
        match self.block {
            Block::Options => self.report_no_world(at),
            Block::World => {
                self.report_no_end(at);
                self.world_end();
            }
            Block::Ended => {}
        }
        self.warn_dark(at);
        let scene =
            (!self.report.has_errors() || self.overrides.keep_going).then(|| self.settled.take()).flatten();
        let diagnostics = self.report.finish(&self.files.sources);
        let scene = scene.map(|settled| Scene {
            camera: settled.camera,
            film: settled.film,
            filter: settled.filter,
            sampler: settled.sampler,
            integrator: settled.integrator,
            primitives: self.primitives,
            instances: self.instances,
            lights: self.lights,
        });
        Loaded { sources: self.files.sources, scene, diagnostics }
    }

    fn report_no_end(&mut self, end: Span) {
        // pbrt-v4 has no WorldEnd.
        if self.report.is_v4() || self.report.incomplete || self.report.incomplete_end {
            return;
        }
        let warning = Diagnostic::warning(end, "the file ends without WorldEnd")
            .help("add WorldEnd; pbrt-v3 renders nothing without it");
        self.report.push(warning);
    }

    fn warn_dark(&mut self, end: Span) {
        let Some(settled) = &self.settled else { return };
        let emits = self.primitives.iter().any(|primitive| primitive.emission.is_some());
        let ambient = matches!(settled.integrator, crate::Integrator::AmbientOcclusion { .. });
        // A light in error is a light all the same.
        if self.lights.is_empty() && !emits && !ambient && !self.report.has_errors() {
            let at = self.world_begin.unwrap_or(end);
            let what =
                if self.dark_light { "no light of the scene is rendered" } else { "the scene has no lights" };
            self.report.push(Diagnostic::warning(at, format!("{what}: the picture is black")));
        }
    }
}

/// The block that a directive belongs to; none if it may stand in both.
fn home_block(directive: &Directive) -> Option<Block> {
    match directive {
        Directive::WorldBegin | Directive::TransformTimes(_) => Some(Block::Options),
        Directive::Entity(kind, _) => match kind {
            EntityKind::Camera
            | EntityKind::Film
            | EntityKind::PixelFilter
            | EntityKind::Sampler
            | EntityKind::Integrator
            | EntityKind::Accelerator => Some(Block::Options),
            EntityKind::MakeNamedMedium => None,
            _ => Some(Block::World),
        },
        Directive::AttributeBegin
        | Directive::AttributeEnd
        | Directive::TransformBegin
        | Directive::TransformEnd
        | Directive::ObjectBegin(_)
        | Directive::ObjectEnd
        | Directive::ObjectInstance(_)
        | Directive::ReverseOrientation
        | Directive::NamedMaterial(_)
        | Directive::Texture { .. }
        | Directive::WorldEnd => Some(Block::World),
        _ => None,
    }
}

fn in_range(transform: Transform, at: Span) -> Result<Transform, Box<Diagnostic>> {
    if transform.in_range() {
        return Ok(transform);
    }
    let message = format!("a transformation beyond {LARGEST:e}, or so small that undoing it is");
    Err(Box::new(
        Diagnostic::error(at, message).help("it counts together with the transformations before it"),
    ))
}

fn scale(by: [f64; 3], span: &Span) -> Result<Transform, Box<Diagnostic>> {
    let message = if by.contains(&0.0) {
        "Scale by 0 flattens space: it cannot be undone"
    } else {
        "Scale by so small a factor cannot be undone"
    };
    Transform::scale(by.into()).ok_or_else(|| {
        Box::new(
            Diagnostic::error(*span, message)
                .help("every factor is other than 0; use a small one such as 1e-3 for something thin"),
        )
    })
}

fn rotate(degrees: f64, axis: [f64; 3], span: &Span) -> Result<Transform, Box<Diagnostic>> {
    Transform::rotate(degrees, axis.into()).ok_or_else(|| {
        Box::new(
            Diagnostic::error(*span, "Rotate about an axis of length 0")
                .help("the first number is the angle in degrees, the next three are the axis"),
        )
    })
}

fn matrix(m: &[f64; 16], keyword: &str, span: &Span) -> Result<Transform, Box<Diagnostic>> {
    let m = DMat4::from_cols_array(m);
    Transform::from_matrix(m).ok_or_else(|| {
        let affine = m.row(3) == glam::DVec4::W;
        let (message, help) = if affine {
            ("is singular: it flattens space and cannot be undone", "check that no row or column is zero")
        } else {
            (
                "is not affine",
                "the numbers stand column by column: the 4th, 8th and 12th are 0 and the 16th is 1",
            )
        };
        Box::new(Diagnostic::error(*span, format!("the matrix of {keyword} {message}")).help(help))
    })
}

/// The error for a name that nothing has defined.
fn undefined<'n>(
    what: &str,
    name: &Text,
    known: impl Iterator<Item = &'n String>,
    definer: &str,
) -> Box<Diagnostic> {
    let mut known: Vec<&str> = known.map(String::as_str).collect();
    known.sort_unstable();
    let error = Diagnostic::error(name.span, format!("there is no {what} \"{}\"", name.value));
    Box::new(match nearest(&name.value, known.iter().copied()) {
        Some(near) => error.help(format!("did you mean \"{near}\"?")).fix(name.span, format!("\"{near}\"")),
        None if known.is_empty() => error.help(format!("{definer} defines one; none is defined here")),
        None => error.help(format!("{definer} defines one; defined here: {}", listed(&known))),
    })
}

/// Names for a message, not too many of them.
fn listed(names: &[&str]) -> String {
    let shown = names.iter().take(8).map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    if names.len() > 8 { format!("{shown} and {} more", names.len() - 8) } else { shown }
}
