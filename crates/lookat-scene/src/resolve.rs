//! The interpreter: each directive changes the state, as in api.cpp of pbrt-v3, or adds to the scene.

mod block;
mod object;
mod transformation;
mod world;

use std::rc::Rc;

use lookat_syntax::{ActiveTransform, Diagnostic, Directive, Entity, EntityKind, FileId, Span, Statement};

use crate::draft::Draft;
use crate::facts::{Block, Facts, Rotation};
use crate::files::Files;
use crate::light::{self, Emission};
use crate::load_options::LoadOptions;
use crate::options::{Options, Settled};
use crate::params::Params;
use crate::report::Report;
use crate::state::{Blocks, Definitions, GraphicsState, Open, Saved};
use crate::transform::Transform;
pub(crate) use block::home_block;
use transformation::{matrix, rotate, scale};

/// Interprets directives in order. Call [`Resolver::finish`] at the end of the scene file.
pub(crate) struct Resolver<'a> {
    pub files: Files<'a>,
    pub report: Report,
    pub facts: Facts,
    load_options: &'a LoadOptions,
    block: Block,
    blocks: Blocks,
    state: GraphicsState,
    definitions: Definitions,
    options: Options,
    /// The options at `WorldBegin`.
    pub settled: Option<Settled>,
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
            definitions: Definitions::new(),
            options: Options::default(),
            settled: None,
            draft: Draft::default(),
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
            Directive::Scale(by) => self.concat(scale(by, &span)?, at)?,
            Directive::Rotate([angle, axis @ ..]) => {
                self.facts.rotations.push(Rotation { angle, axis, at: span });
                self.concat(rotate(angle, axis, &span)?, at)?
            }
            Directive::LookAt(points) => self.look_at(points, span)?,
            Directive::Transform(m) => self.replace(matrix(&m, "Transform", &span)?, at)?,
            Directive::ConcatTransform(m) => self.concat(matrix(&m, "ConcatTransform", &span)?, at)?,
            Directive::CoordinateSystem(name) => {
                self.use_transform();
                self.definitions.coordinate_systems.define(&name, self.state.ctm, &mut self.report);
            }
            Directive::CoordSysTransform(name) => {
                self.facts.uses_camera_space |= self.block == Block::World && name.value == "camera";
                // Applies to both times.
                let known = self.definitions.coordinate_systems.find(&name, &mut self.report);
                known.into_iter().for_each(|known| self.state.ctm = *known);
                self.facts.placed = None;
            }
            Directive::ActiveTransform(which) => {
                self.facts.motion.push(("ActiveTransform", at));
                self.state.at_start = which != ActiveTransform::EndTime;
            }
            Directive::TransformTimes(_) => self.facts.motion.push(("TransformTimes", at)),
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
                self.close(directive.keyword(), at)?;
            }
            Directive::ObjectInstance(name) => self.object_instance(name)?,
            Directive::ReverseOrientation => self.state.reverse_orientation ^= true,
            Directive::WorldBegin => self.world_begin(at),
            Directive::WorldEnd => self.world_end(),
            Directive::NamedMaterial(name) => {
                let known = self.definitions.materials.find(&name, &mut self.report);
                known.into_iter().for_each(|known| self.state.material = known.clone());
            }
            Directive::MediumInterface { inside, outside } => {
                for name in [Some(inside), outside].into_iter().flatten().filter(|it| !it.value.is_empty()) {
                    self.definitions.media.find(&name, &mut self.report);
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
            EntityKind::Material => self.state.material = Rc::new(self.material(entity, "Material")),
            EntityKind::MakeNamedMaterial => self.make_named_material(entity),
            EntityKind::AreaLightSource => {
                let params = &mut Params::new("AreaLightSource", entity, &self.files, &mut self.report);
                let emission = light::emission(params);
                if emission.is_some_and(|emission| !emission.is_black()) {
                    self.facts.emissions.entry(at).or_default();
                }
                self.state.emission = emission.map(|emission| Emission { span: Some(at), ..emission });
            }
            EntityKind::MakeNamedMedium => {
                self.definitions.media.define(&entity.name, (), &mut self.report);
            }
            _ => {
                let instead = self.load_options.view.world_from_camera();
                let world_from_camera = instead.unwrap_or_else(|| self.state.ctm.inverse());
                if kind == EntityKind::Camera {
                    self.use_transform();
                    self.facts.placement = self.facts.placed;
                    self.facts.camera = Some((at, world_from_camera));
                    self.definitions.coordinate_systems.define_builtin("camera", world_from_camera);
                }
                let replaced = self.options.set(kind, entity, at, world_from_camera);
                self.facts.replaced_options.extend(replaced.map(|before| (kind, at, before)));
            }
        }
        Ok(())
    }

    /// Ends the scene file.
    pub fn finish(&mut self, file: FileId) {
        match (self.block, self.facts.part) {
            // Resolves the options, so that their errors are reported.
            (Block::Options, Some((_, first))) => drop(self.settle(first)),
            (Block::World, None) => {
                self.facts.missing_end = Some(self.files.sources.end(file));
                self.world_end();
            }
            _ => {}
        }
    }
}
