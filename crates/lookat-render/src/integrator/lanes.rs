//! Samples side by side: what integrators take them, of which scenes.

pub(super) mod world;

use fearless_simd::Level;
use lookat_scene::{Projection, View};

use super::{direct, path};
use crate::lanes::{level, name};
use crate::light::LightTable;
use crate::traceable::Traceable;
use world::World;

/// A scene whose samples are taken side by side.
pub(crate) struct Lanes<'s> {
    pub level: Level,
    pub integrator: LanesIntegrator<'s>,
}

/// What takes them.
pub(crate) enum LanesIntegrator<'s> {
    Direct(direct::lanes::Lanes<'s>),
    Path(path::lanes::Lanes<'s>),
}

impl<'s> Lanes<'s> {
    /// `None` of scenes that have other things than these serve for, and of processors that have too little.
    pub fn new(view: &View, traceable: &'s Traceable, lights: &'s LightTable) -> Option<Self> {
        let is_environment = matches!(view.camera.projection, Projection::Environment);
        if is_environment {
            return None;
        }
        let level = level()?;
        let direct =
            || Some(LanesIntegrator::Direct(direct::lanes::Lanes::new(&view.integrator, traceable, lights)?));
        let path =
            || Some(LanesIntegrator::Path(path::lanes::Lanes::new(&view.integrator, traceable, lights)?));
        Some(Lanes { level, integrator: direct().or_else(path)? })
    }

    /// The instructions that are used.
    pub fn name(&self) -> &'static str {
        name(self.level)
    }

    /// Whether all materials are diffuse and nothing else.
    pub fn is_lambert(&self) -> bool {
        self.world().is_lambert()
    }

    /// Whether any material has textures.
    pub fn has_textures(&self) -> bool {
        self.world().has_textures()
    }

    /// Whether rays go down the tree of the world.
    pub fn asks_tree(&self) -> bool {
        matches!(self.world(), World::Tree(..))
    }

    fn world(&self) -> &World<'s> {
        match &self.integrator {
            LanesIntegrator::Direct(direct) => &direct.world,
            LanesIntegrator::Path(path) => &path.world,
        }
    }
}
