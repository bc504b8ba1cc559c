//! The interpreter: each directive changes the state, as in api.cpp of pbrt-v3, or adds to the scene.

mod blocks;
mod projective;
mod world;

use std::collections::HashSet;
use std::rc::Rc;
use std::sync::Arc;

use glam::DMat4;
use lookat_syntax::{
    ActiveTransform, Diagnostic, Directive, Entity, EntityKind, FileId, ParamType, Severity, Span, Statement,
    Text,
};

use crate::MediumInterface;
use crate::camera::{CameraPlacement, look_at};
use crate::draft::Draft;
use crate::facts::{Block, BlockKind, Facts, Rotation};
use crate::files::Files;
use crate::light::{self, Emission};
use crate::material::{MaterialInstance, Tables};
use crate::names::Names;
use crate::options::{LoadOptions, Options, ResolvedOptions};
use crate::params::Params;
use crate::report::Report;
use crate::symbols::SymbolKind;
use crate::texture::Textures;
use crate::transform::{AnimatedTransform, LookAtError, Transform, TransformSet, in_range};

pub(crate) use crate::resolve::blocks::{Blocks, home_block};
use crate::resolve::projective::{Projective, is_affine};

/// Interprets directives in order. Call [`Resolver::finish`] at the end of the scene file.
pub(crate) struct Resolver<'a> {
    pub files: Files<'a>,
    pub report: Report,
    pub facts: Facts,
    load_options: &'a LoadOptions,
    block: Block,
    blocks: Blocks,
    state: GraphicsState,
    /// The names and types of the parameters of materials, which those of one kind share.
    known_parameters: HashSet<Rc<[(&'static str, ParamType)]>>,
    /// The matrices that are not affine of which something was reported, and whether that is an error.
    reported_matrices: HashSet<(Span, bool)>,
    /// The tables of materials so far.
    tables: Tables,
    definitions: Definitions,
    options: Options,
    /// The options at `WorldBegin`.
    pub resolved: Option<ResolvedOptions>,
    pub draft: Draft,
}

impl<'a> Resolver<'a> {
    pub fn new(files: Files<'a>, load_options: &'a LoadOptions) -> Self {
        Resolver {
            files,
            report: Report::default(),
            facts: Facts::default(),
            load_options,
            block: Block::Options,
            blocks: Blocks::default(),
            state: GraphicsState::new(),
            known_parameters: HashSet::new(),
            reported_matrices: HashSet::new(),
            tables: Tables::new(),
            definitions: Definitions {
                objects: Names::new(SymbolKind::Object),
                media: Names::new(SymbolKind::Medium),
                coordinate_systems: Names::new(SymbolKind::CoordinateSystem),
            },
            options: Options::default(),
            resolved: None,
            draft: Draft::new(load_options.fast),
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
        let Statement { keyword: at, span, directive, faulty } = statement;
        match directive {
            // Some of the numbers are unreadable.
            directive if faulty && directive.is_transformation() => {}
            Directive::Identity => self.replace(Transform::IDENTITY, at)?,
            Directive::Translate(by) => self.concat(Transform::translate(by.into()), at)?,
            Directive::Scale(by) => {
                let scale = self.scale(by, span)?;
                self.concat(scale, at)?
            }
            Directive::Rotate([angle, axis @ ..]) => {
                let is_motion = self.state.active != ActiveTransform::All;
                self.facts.rotations.push(Rotation { angle, axis, is_motion, at: span });
                self.concat(rotate(angle, axis, &span)?, at)?
            }
            Directive::LookAt(points) => self.look_at(points, span)?,
            Directive::Transform(m) => match DMat4::from_cols_array(&m) {
                m if is_affine(&m) => {
                    let matrix = self.matrix(m, "Transform", span)?;
                    self.replace(matrix, at)?
                }
                m => self.concat_projective(DMat4::IDENTITY, m, "Transform", span)?,
            },
            Directive::ConcatTransform(m) => match DMat4::from_cols_array(&m) {
                m if is_affine(&m) => {
                    let matrix = self.matrix(m, "ConcatTransform", span)?;
                    self.concat(matrix, at)?
                }
                m => self.concat_projective(self.current_matrix(), m, "ConcatTransform", span)?,
            },
            Directive::CoordinateSystem(name) => {
                self.use_transform();
                let current =
                    Coordinates { ctm: self.state.ctm.clone(), projective: self.state.projective.clone() };
                self.definitions.coordinate_systems.define(&name, current, &mut self.report);
            }
            Directive::CoordSysTransform(name) => {
                self.facts.uses_camera_space |= self.block == Block::World && name.value == "camera";
                // Applies to both times.
                let known = self.definitions.coordinate_systems.find(&name, &mut self.report);
                if let Some(known) = known {
                    self.state.ctm = known.ctm.clone();
                    self.state.projective = known.projective.clone();
                }
                self.facts.placed = None;
            }
            Directive::ActiveTransform(which) => {
                self.state.active = which;
                self.state.active_since = (which != ActiveTransform::All).then_some(span);
            }
            Directive::TransformTimes(times) => {
                let [start, end] = times;
                if start >= end || !in_range(&times) {
                    let help = "write the earlier time first: TransformTimes start end";
                    let message = "the end time of TransformTimes is not after the start time";
                    return Diagnostic::error(span, message).help(help).fail();
                }
                self.options.transform_times = times;
            }
            Directive::TransformBegin => drop(self.begin(BlockKind::Transform, at, None)),
            Directive::AttributeBegin => drop(self.begin(BlockKind::Attribute, at, None)),
            Directive::ObjectBegin(name) => self.object_begin(name, at)?,
            Directive::TransformEnd => self.close(BlockKind::Transform, at)?,
            Directive::AttributeEnd => self.close(BlockKind::Attribute, at)?,
            Directive::ObjectEnd => self.close(BlockKind::Object, at)?,
            Directive::ObjectInstance(name) => self.object_instance(name)?,
            Directive::ReverseOrientation => self.state.reverse_orientation ^= true,
            Directive::WorldBegin => self.world_begin(at),
            Directive::WorldEnd => self.world_end(),
            Directive::NamedMaterial(name) => {
                let known = self.state.materials.find(&name, &mut self.report);
                if let Some(known) = known {
                    self.state.material = known.clone();
                }
            }
            Directive::MediumInterface { inside, outside } => {
                let mut medium = |name: &Text| {
                    let named = Some(name).filter(|name| !name.value.is_empty())?;
                    self.definitions.media.find(named, &mut self.report).copied()?
                };
                let inside = medium(&inside);
                // Without a second name, it is the same medium.
                let outside = outside.as_ref().map_or(inside, medium);
                self.state.medium = MediumInterface { inside, outside };
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
            EntityKind::Shape => self.shape(entity)?,
            EntityKind::LightSource => self.light_source(entity),
            EntityKind::Material => self.state.material = Rc::new(self.material(entity, "Material")),
            EntityKind::MakeNamedMaterial => self.make_named_material(entity),
            EntityKind::AreaLightSource => {
                let params = &mut Params::new("AreaLightSource", entity, &self.files, &mut self.report);
                let emission = light::emission(params);
                if emission.is_some_and(|emission| !emission.is_black()) {
                    self.facts.emissions.push(at);
                }
                self.state.emission =
                    emission.map(|emission| Arc::new(Emission { span: Some(at), ..emission }));
            }
            EntityKind::MakeNamedMedium => self.make_named_medium(entity),
            _ => {
                if kind == EntityKind::Camera {
                    let instead = self.load_options.view.world_from_camera();
                    if instead.is_none() {
                        self.need_affine(at);
                    }
                    let world_from_camera =
                        instead.map_or_else(|| self.state.ctm.inverse(), TransformSet::still);
                    self.use_transform();
                    self.facts.placement = self.facts.placed;
                    self.facts.camera = Some((at, world_from_camera.clone()));
                    self.definitions.coordinate_systems.define_builtin("camera", world_from_camera.into());
                }
                let replaced = self.options.set(kind, entity, at);
                self.report.extend(replaced.map(|before| {
                    let message = format!("a second {}: the last one is used", kind.keyword());
                    Diagnostic::warning(at, message).related(before, "this one is ignored")
                }));
            }
        }
        Ok(())
    }

    /// Ends the scene file.
    pub fn finish(&mut self, file: FileId) {
        match (self.block, self.facts.part) {
            // Resolves the options, so that their errors are reported.
            (Block::Options, Some((_, first))) => drop(self.resolve_options(first)),
            (Block::World, None) => {
                self.facts.missing_end = Some(self.files.sources.end(file));
                self.world_end();
            }
            _ => {}
        }
    }
}

impl Resolver<'_> {
    pub(super) fn concat(&mut self, transform: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        self.change_ctm(|ctm| *ctm * transform, at)?;
        self.follow_projective(&transform);
        if let Some(placement) = self.facts.placed.as_mut().filter(|_| self.state.changes_start()) {
            placement.after = placement.after * transform;
        }
        Ok(())
    }

    pub(super) fn replace(&mut self, ctm: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        self.facts.placed = None;
        if self.state.changes_start() {
            self.state.projective = None;
        }
        self.change_ctm(|_| ctm, at)
    }

    /// Changes the current transformation at the active times.
    fn change_ctm(
        &mut self,
        change: impl Fn(&Transform) -> Transform,
        at: Span,
    ) -> Result<(), Box<Diagnostic>> {
        let before = &self.state.ctm;
        let ctm = match self.state.active {
            ActiveTransform::All => before.map(change),
            ActiveTransform::StartTime => {
                TransformSet { start: Arc::new(change(&before.start)), end: before.end.clone() }
            }
            ActiveTransform::EndTime => {
                TransformSet { start: before.start.clone(), end: Arc::new(change(&before.end)) }
            }
        };
        if !(ctm.start.in_range() && ctm.end.in_range()) {
            let help = "transformations accumulate: check the ones before it, too";
            return Diagnostic::error(at, LookAtError::OutOfRange.to_string()).help(help).fail();
        }
        if self.block == Block::Options && (*ctm.start, *ctm.end) != (*before.start, *before.end) {
            self.facts.idle_transform.get_or_insert(at);
        }
        self.state.ctm = ctm;
        Ok(())
    }

    /// The motion of what the current transformation places. `None` if it stands still.
    fn motion(&self, at: Span) -> Result<Option<Box<AnimatedTransform>>, Box<Diagnostic>> {
        let TransformSet { start, end } = &self.state.ctm;
        if !self.state.ctm.is_animated() {
            return Ok(None);
        }
        AnimatedTransform::new(**start, **end).map(|motion| Some(Box::new(motion))).or_else(|fault| {
            let help =
                "scale by numbers of the same sign at both times: between them, the shape would be flat";
            Diagnostic::error(at, format!("this cannot move: {fault}")).help(help).fail()
        })
    }

    /// The current transformation, for a directive that needs an affine one and makes what cannot move.
    fn placing(&mut self, what: &str, at: Span) -> Transform {
        self.need_affine(at);
        self.still_ctm(what, at)
    }

    /// The current transformation at the start time, for a directive that makes what cannot move.
    fn still_ctm(&mut self, what: &str, at: Span) -> Transform {
        if self.state.ctm.is_animated() {
            let message = format!(
                "a {what} does not move: it uses the transformation at the start time, as in pbrt-v3"
            );
            let help = "write ActiveTransform All and the same transformations for both times before it";
            self.report.push(Diagnostic::warning(at, message).help(help));
        }
        *self.state.ctm.start
    }

    /// Notes that something uses the current transformation before `WorldBegin`.
    pub(super) fn use_transform(&mut self) {
        if self.block == Block::Options {
            self.facts.idle_transform = None;
        }
    }

    pub(super) fn look_at(&mut self, points: [f64; 9], span: Span) -> Result<(), Box<Diagnostic>> {
        if self.block == Block::World && self.blocks.open.is_empty() {
            self.facts.look_at_in_world.get_or_insert(span);
        }
        match look_at(points) {
            Ok(transform) => {
                let before = *self.state.ctm.start;
                self.concat(transform, span)?;
                if self.state.changes_start() {
                    let after = Transform::IDENTITY;
                    self.facts.placed = Some(CameraPlacement { span: Some(span), before, points, after });
                }
                Ok(())
            }
            Err(fault) => {
                let help = match fault {
                    LookAtError::EyeAtLook => {
                        "the first three numbers are the eye, the next three the target: make them different"
                    }
                    LookAtError::ZeroUp => {
                        "write the direction that is up in the picture, usually 0 1 0 or 0 0 1"
                    }
                    LookAtError::UpParallel => {
                        "the last three numbers are the direction that is up in the picture: choose one that is not parallel to the view"
                    }
                    LookAtError::OutOfRange => "write smaller numbers",
                };
                Diagnostic::error(span, fault.to_string()).help(help).fail()
            }
        }
    }

    fn scale(&mut self, by: [f64; 3], span: Span) -> Result<Transform, Box<Diagnostic>> {
        Transform::scale(by.into()).map_or_else(
            || {
                let message = if by.contains(&0.0) {
                    "Scale by 0 is not invertible"
                } else {
                    "this Scale is too small to invert"
                };
                let help = "use nonzero factors, such as 1e-3 for a thin shape";
                self.flatten(DMat4::from_scale(by.into()), Diagnostic::error(span, message).help(help))
            },
            Ok,
        )
    }

    fn matrix(&mut self, m: DMat4, keyword: &str, span: Span) -> Result<Transform, Box<Diagnostic>> {
        Transform::from_matrix(m).map_or_else(
            || {
                let message = format!("the matrix of {keyword} is singular");
                let help = "a transformation must be invertible: no row or column may be zero or a combination of the others";
                self.flatten(m, Diagnostic::error(span, message).help(help))
            },
            Ok,
        )
    }

    /// A singular transformation. What it flattens renders flat, as meshes do in pbrt-v3; there is no view from a flat camera.
    fn flatten(&mut self, m: DMat4, error: Diagnostic) -> Result<Transform, Box<Diagnostic>> {
        let thin = (self.block == Block::World).then(|| Transform::thickened(m)).flatten();
        let Some(thin) = thin else { return error.fail() };
        let note = "what it transforms is rendered flat, as meshes are in pbrt-v3";
        self.report.push(Diagnostic { severity: Severity::Warning, ..error.note(note) });
        Ok(thin)
    }
}

pub(super) fn rotate(degrees: f64, axis: [f64; 3], span: &Span) -> Result<Transform, Box<Diagnostic>> {
    let help = "the first number is the angle in degrees, the next three are the axis";
    let fault = || Diagnostic::error(*span, "the axis of Rotate has length 0").help(help);
    Transform::rotate(degrees, axis.into()).map_or_else(|| fault().fail(), Ok)
}

// The graphics state: the globals of pbrt-v3's api.cpp.

/// The state that `AttributeBegin` saves and `AttributeEnd` restores.
#[derive(Clone)]
pub(crate) struct GraphicsState {
    /// The current transformation matrix (CTM).
    pub ctm: TransformSet,
    /// The current transformation at the start time after a matrix that is not affine, which `ctm` leaves out.
    pub projective: Option<Rc<Projective>>,
    /// The times whose transformation changes.
    pub active: ActiveTransform,
    /// The directive that says so. `None` for all times.
    pub active_since: Option<Span>,
    pub reverse_orientation: bool,
    pub material: Rc<MaterialInstance>,
    pub emission: Option<Arc<Emission>>,
    pub medium: MediumInterface,
    pub materials: Names<Rc<MaterialInstance>>,
    pub textures: Textures,
}

/// The definitions that outlast their block.
pub(crate) struct Definitions {
    /// The index of each object in the draft.
    pub objects: Names<usize>,
    /// The index of each medium in the draft. `None` for one with errors.
    pub media: Names<Option<u32>>,
    pub coordinate_systems: Names<Coordinates>,
}

/// A named coordinate system: the transformations of the graphics state.
#[derive(Clone)]
pub(crate) struct Coordinates {
    ctm: TransformSet,
    projective: Option<Rc<Projective>>,
}

impl From<TransformSet> for Coordinates {
    fn from(ctm: TransformSet) -> Self {
        Coordinates { ctm, projective: None }
    }
}

impl GraphicsState {
    pub fn new() -> Self {
        GraphicsState {
            ctm: TransformSet::still(Transform::IDENTITY),
            projective: None,
            active: ActiveTransform::All,
            active_since: None,
            reverse_orientation: false,
            material: Rc::new(MaterialInstance::default()),
            emission: None,
            medium: MediumInterface::default(),
            materials: Names::new(SymbolKind::Material),
            textures: Textures::default(),
        }
    }

    /// True if transformations apply to the start time.
    pub fn changes_start(&self) -> bool {
        self.active != ActiveTransform::EndTime
    }
}
