//! The interpreter: every directive changes the state as api.cpp of pbrt-v3 has it, or adds to the scene.

mod block;
mod departures;
mod doubts;
mod transformation;
mod world;

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::rc::Rc;
use std::sync::Arc;

use lookat_syntax::{
    ActiveTransform, Diagnostic, Directive, Entity, EntityKind, FileId, Span, Spanned, Statement,
};

use crate::elsewhere::Kind;
use crate::files::Files;
use crate::loaded::Loaded;
use crate::options::{Options, Settled};
use crate::overrides::Overrides;
use crate::params::Params;
use crate::picture::Pictures;
use crate::report::Report;
use crate::state::{Definitions, GraphicsState, Open, Saved};
use crate::transform::Transform;
use crate::{Instance, Light, Object, Primitive, Scene, light};
pub(crate) use block::home_block;
use doubts::is_scaled;
use transformation::{matrix, rotate, scale};

/// Where a directive may stand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Block {
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
    /// The first directive of a file that is a part of a scene.
    part: Option<Span>,
    /// Directives of the world that stand before it: their keywords and places.
    early: Vec<(&'static str, Span)>,
    /// How many there are, and what is said of some, if there are not too many others.
    rotations: usize,
    doubted_rotations: Vec<Diagnostic>,
    state: GraphicsState,
    definitions: Definitions,
    open: Vec<Open>,
    /// The first AttributeEnd inside the object that is open, of a block around it.
    crossed: Option<Span>,
    /// Directives that would close a block which a wrong one has closed already, or that was never opened.
    forgiven: HashMap<&'static str, usize>,
    coordinate_systems: HashMap<String, Transform>,
    options: Options,
    settled: Option<Settled>,
    /// A transformation after `Camera`, which nothing has used yet.
    idle_transform: Option<Span>,
    /// AreaLightSources that no shape has followed yet.
    idle_emissions: HashSet<Span>,
    /// Objects that have no instance yet.
    idle_objects: HashMap<String, Span>,
    /// The first shape that all rays pass.
    passed: Option<Span>,
    /// A Camera whose lengths are others in the world.
    scaled_camera: Option<Span>,
    /// The first shape with `shadowalpha`.
    shadow_alpha: Option<Span>,
    primitives: Vec<Primitive>,
    instances: Vec<Instance>,
    lights: Vec<Light>,
    /// The object that is being defined.
    object: Option<Object>,
    objects: BTreeMap<String, Arc<Object>>,
    media: BTreeSet<String>,
    pictures: Pictures,
}

impl<'a> Resolver<'a> {
    pub fn new(files: Files<'a>, overrides: &'a Overrides) -> Self {
        Resolver {
            files,
            report: Report::default(),
            overrides,
            block: Block::Options,
            world_begin: None,
            part: None,
            early: Vec::new(),
            rotations: 0,
            doubted_rotations: Vec::new(),
            state: GraphicsState::new(),
            definitions: Definitions::default(),
            open: Vec::new(),
            crossed: None,
            forgiven: HashMap::new(),
            coordinate_systems: HashMap::new(),
            options: Options::default(),
            settled: None,
            idle_transform: None,
            idle_emissions: HashSet::new(),
            idle_objects: HashMap::new(),
            passed: None,
            scaled_camera: None,
            shadow_alpha: None,
            primitives: Vec::new(),
            instances: Vec::new(),
            lights: Vec::new(),
            object: None,
            objects: BTreeMap::new(),
            media: BTreeSet::new(),
            pictures: Pictures::default(),
        }
    }

    /// One directive. What is wrong with it is reported, and the next one goes on.
    pub fn apply(&mut self, statement: Statement) {
        if !self.belongs_here(&statement) {
            return;
        }
        self.report.partial = statement.faulty;
        if let Err(error) = self.directive(statement) {
            self.report.push(*error);
        }
    }

    fn directive(&mut self, statement: Statement) -> Result<(), Box<Diagnostic>> {
        let at = statement.keyword;
        match statement.directive {
            Directive::Identity => self.replace(Transform::IDENTITY, at)?,
            Directive::Translate(by) => self.concat(Transform::translate(by.into()), at)?,
            Directive::Scale(by) => self.concat(scale(by, &statement.span)?, at)?,
            Directive::Rotate([angle, axis @ ..]) => {
                self.doubt_rotation(angle, axis, statement.span);
                self.concat(rotate(angle, axis, &statement.span)?, at)?
            }
            Directive::LookAt(points) => self.look_at(points, statement.span)?,
            Directive::Transform(m) => self.replace(matrix(&m, "Transform", &statement.span)?, at)?,
            Directive::ConcatTransform(m) => {
                self.concat(matrix(&m, "ConcatTransform", &statement.span)?, at)?
            }
            Directive::CoordinateSystem(name) => {
                self.idle_transform = None;
                self.report.define(Kind::CoordinateSystem, &name);
                self.coordinate_systems.insert(name.value, self.state.ctm);
            }
            Directive::CoordSysTransform(name) => self.coord_sys_transform(name),
            Directive::ActiveTransform(which) => {
                self.motion(at, "ActiveTransform");
                self.state.at_start = which != ActiveTransform::EndTime;
            }
            Directive::TransformTimes(_) => self.motion(at, "TransformTimes"),
            Directive::TransformBegin => {
                let saved = Box::new((self.state.ctm, self.state.at_start));
                self.begin(Open::Transform { saved, at });
            }
            Directive::AttributeBegin => {
                let saved = Saved::new(&self.state, &self.definitions);
                self.begin(Open::Attribute { saved, at });
            }
            Directive::ObjectBegin(name) => self.object_begin(name, at)?,
            Directive::TransformEnd | Directive::AttributeEnd | Directive::ObjectEnd => {
                self.close(statement.directive.keyword(), at)?;
            }
            Directive::ObjectInstance(name) => self.object_instance(name)?,
            Directive::ReverseOrientation => self.state.reverse_orientation = !self.state.reverse_orientation,
            Directive::WorldBegin => self.world_begin(at),
            Directive::WorldEnd => self.world_end(),
            Directive::NamedMaterial(name) => self.named_material(name),
            Directive::MediumInterface { inside, outside } => {
                for name in [Some(inside), outside].into_iter().flatten() {
                    self.medium(name);
                }
            }
            Directive::Texture { name, value, entity } => self.texture(name, value, entity),
            Directive::Entity(kind, entity) => self.entity(kind, entity, at)?,
            // The loader has followed it.
            Directive::Include { .. } => {}
        }
        Ok(())
    }

    fn entity(&mut self, kind: EntityKind, entity: Entity, at: Span) -> Result<(), Box<Diagnostic>> {
        match kind {
            EntityKind::Shape => self.shape(entity),
            EntityKind::LightSource => self.light_source(entity),
            EntityKind::Material => {
                let instance = self.material(entity, "Material");
                self.state.material = Rc::new(instance);
            }
            EntityKind::MakeNamedMaterial => self.make_named_material(entity)?,
            EntityKind::AreaLightSource => {
                let params = &mut Params::new("AreaLightSource", entity, &self.files, &mut self.report);
                let emission = light::emission(params);
                self.state.emission = emission.map(|value| Spanned { value, span: at });
                self.idle_emissions.extend(emission.filter(|emission| !emission.is_black()).map(|_| at));
            }
            EntityKind::MakeNamedMedium => {
                self.report.define(Kind::Medium, &entity.name);
                self.media.insert(entity.name.value);
            }
            _ => {
                let world_from_camera = self.state.ctm.inverse();
                if kind == EntityKind::Camera {
                    self.idle_transform = None;
                    self.scaled_camera = is_scaled(&world_from_camera).then_some(at);
                    self.warn_large_world(&world_from_camera, at);
                    self.coordinate_systems.insert("camera".into(), world_from_camera);
                }
                self.options.set(kind, entity, at, world_from_camera, &mut self.report);
            }
        }
        Ok(())
    }

    /// The scene, after the last directive of the scene file.
    pub fn finish(mut self, file: FileId) -> Loaded {
        let end = self.files.sources.file(file).text.len() as u32;
        let at = Span { file, start: end, end };
        match self.block {
            Block::Options => match self.part {
                Some(first) => self.end_options_part(first),
                None => self.report_no_world(at),
            },
            Block::World => match self.part {
                // Its blocks may end elsewhere.
                Some(first) => self.report_part(first, "Camera, Film and WorldBegin"),
                None => {
                    self.report_no_end(at);
                    self.world_end();
                }
            },
            Block::Ended => {}
        }
        self.tell_doubted_rotations();
        self.tell_substituted_integrator();
        // A shape or a light in error is one all the same.
        if !self.report.has_errors() {
            self.warn_of_all(at);
        }
        let misfit = self.report.misfit.take();
        let can_keep_going =
            self.settled.is_some() && !self.report.is_v4(&self.files.sources) && misfit.is_none();
        let is_scene = (!self.report.has_errors() || self.overrides.keep_going) && misfit.is_none();
        let scene = is_scene.then(|| self.settled.take()).flatten();
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
        let (sources, inputs, memory) = self.files.into_parts();
        Loaded { sources, inputs, memory, scene, diagnostics, can_keep_going, misfit }
    }

    /// Names may be defined again, with the same effect as in pbrt-v3.
    fn note_again(&mut self, what: &str, name: &str, at: Span) {
        let message = format!("{what} \"{name}\" is defined again; the new one counts from here");
        self.report.push(Diagnostic::note_at(at, message));
    }
}
