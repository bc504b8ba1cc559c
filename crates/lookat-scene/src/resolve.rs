//! The interpreter: each directive changes the state, as in api.cpp of pbrt-v3, or adds to the scene.

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
use crate::{Instance, Light, Object, Primitive, Scene, World, light};
pub(crate) use block::home_block;
use doubts::is_scaled;
use transformation::{matrix, rotate, scale};

/// The block of a directive.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Block {
    Options,
    World,
    /// The file after `WorldEnd`.
    Ended,
}

/// Interprets directives in order. Call [`Resolver::finish`] for the scene.
pub(crate) struct Resolver<'a> {
    pub files: Files<'a>,
    pub report: Report,
    overrides: &'a Overrides,
    block: Block,
    world_begin: Option<Span>,
    /// The first directive of a file that other scenes include.
    part: Option<Span>,
    /// World directives before `WorldBegin`: keyword and place.
    early: Vec<(&'static str, Span)>,
    /// The number of rotations, and warnings about doubtful ones, which are reported if rotations are few.
    rotations: usize,
    doubted_rotations: Vec<Diagnostic>,
    state: GraphicsState,
    definitions: Definitions,
    open: Vec<Open>,
    /// The first AttributeEnd in the open object that closes a block around the object.
    crossed: Option<Span>,
    /// Unmatched end directives, counted so that each is reported once.
    forgiven: HashMap<&'static str, usize>,
    coordinate_systems: HashMap<String, Transform>,
    options: Options,
    settled: Option<Settled>,
    /// A transformation after `Camera` that nothing has used yet.
    idle_transform: Option<Span>,
    /// AreaLightSources without a following shape so far.
    idle_emissions: HashSet<Span>,
    /// Objects without an instance so far.
    idle_objects: HashMap<String, Span>,
    /// The first shape without a material, which rays pass through.
    passed: Option<Span>,
    /// A Camera under a scale.
    scaled_camera: Option<Span>,
    /// The first shape with `shadowalpha`.
    shadow_alpha: Option<Span>,
    primitives: Vec<Primitive>,
    instances: Vec<Instance>,
    lights: Vec<Light>,
    /// The open object.
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

    /// Interprets one directive. Reports its errors and continues.
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
            // The loader follows includes.
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

    /// Returns the scene after the last directive of the scene file.
    pub fn finish(mut self, file: FileId) -> Loaded {
        let end = self.files.sources.file(file).text.len() as u32;
        let at = Span { file, start: end, end };
        match self.block {
            Block::Options => match self.part {
                Some(first) => self.end_options_part(first),
                None => self.report_no_world(at),
            },
            Block::World => match self.part {
                // Its blocks may end in another file.
                Some(first) => self.report_part(first, "Camera, Film or WorldBegin"),
                None => {
                    self.report_no_end(at);
                    self.world_end();
                }
            },
            Block::Ended => {}
        }
        self.tell_doubted_rotations();
        self.tell_substituted_integrator();
        // A shape or light with an error still counts as present.
        if !self.report.has_errors() {
            self.warn_of_all(at);
        }
        let misfit = self.report.misfit.take();
        let can_keep_going =
            self.settled.is_some() && !self.report.is_v4(&self.files.sources) && misfit.is_none();
        let is_scene = (!self.report.has_errors() || self.overrides.keep_going) && misfit.is_none();
        let scene = is_scene.then(|| self.settled.take()).flatten();
        let diagnostics = self.report.finish(&self.files.sources);
        let world = World { primitives: self.primitives, instances: self.instances, lights: self.lights };
        let scene = scene.map(|settled| Scene { view: settled.view, world: Arc::new(world) });
        let (sources, inputs, memory) = self.files.into_parts();
        Loaded { sources, inputs, memory, scene, diagnostics, can_keep_going, misfit }
    }

    /// Adds a note about a name that is defined again, which has the same effect as in pbrt-v3.
    fn note_again(&mut self, what: &str, name: &str, at: Span) {
        let message = format!("{what} \"{name}\" is defined again: the new definition applies from here on");
        self.report.push(Diagnostic::note_at(at, message));
    }
}
