//! Warnings about the scene as a whole.

use glam::{DVec3, Vec3};
use lookat_syntax::{Diagnostic, Span, shown};

use super::Resolver;
use crate::options::Settled;
use crate::texture::Texture;
use crate::transform::Transform;
use crate::{Emission, Integrator, Light, MaterialKind, Primitive};

impl Resolver<'_> {
    /// Adds all warnings about the scene as a whole. The last directive ends at `end`.
    pub(super) fn warn_of_all(&mut self, end: Span) {
        self.warn_idle_emissions();
        self.warn_idle_objects();
        self.warn_dark(end);
        self.warn_empty(end);
        self.warn_scaled_camera();
        self.warn_of_shadow_alpha();
    }

    /// All shapes, including shapes of objects.
    fn shapes(&self) -> impl Iterator<Item = &Primitive> {
        self.primitives.iter().chain(self.objects.values().flat_map(|object| &object.primitives))
    }

    fn warn_idle_emissions(&mut self) {
        let mut idle: Vec<Span> = self.idle_emissions.drain().collect();
        idle.sort_by_key(|at| (at.file, at.start));
        for at in idle {
            let message = "no shape follows this AreaLightSource: it emits no light";
            let help = "put it before the shape that emits light, in the same block";
            self.report.push(Diagnostic::warning(at, message).help(help));
        }
    }

    fn warn_idle_objects(&mut self) {
        for (name, at) in self.idle_objects.drain() {
            let message = format!("object \"{}\" is defined and never used", shown(name.as_bytes()));
            let help = "place it with ObjectInstance";
            self.report.push(Diagnostic::warning(at, message).help(help));
        }
    }

    /// Warns of an empty world, where only infinite lights are visible.
    fn warn_empty(&mut self, end: Span) {
        if self.settled.is_none() || !self.primitives.is_empty() || !self.instances.is_empty() {
            return;
        }
        if let Some(passed) = self.passed {
            let warning = Diagnostic::warning(passed, "no shape has a material: all shapes are invisible");
            let help = "this Integrator ignores shapes without a material: write Material \"matte\" before the shapes";
            self.report.push(warning.help(help));
        } else if !self.lights.is_empty() && self.lights.iter().all(Light::is_delta) {
            let warning = Diagnostic::warning(
                self.world_begin.unwrap_or(end),
                "the world has no shapes: the picture is black",
            );
            self.report
                .push(warning.help("add a shape: Shape \"sphere\" is a sphere of radius 1 at the origin of the current transformation"));
        }
    }

    fn warn_dark(&mut self, end: Span) {
        let Some(settled) = &self.settled else { return };
        if matches!(settled.view.integrator, Integrator::AmbientOcclusion { .. }) {
            return;
        }
        // An object without an instance is not in the world.
        let copied = self.instances.iter().flat_map(|instance| &instance.object.primitives);
        let emits = |primitive: &Primitive| primitive.emission.filter(|_| !primitive.shape.is_invisible());
        let emissions: Vec<Emission> = self.primitives.iter().chain(copied).filter_map(emits).collect();
        let shows_emission_alone = matches!(settled.view.integrator, Integrator::Path { max_depth: 0, .. });
        let (message, help) = if self.lights.is_empty() && emissions.is_empty() {
            let help = "add a light: LightSource \"infinite\" lights a scene from all sides";
            ("the scene has no lights: the picture is black", help)
        } else if self.lights.iter().all(Light::is_black) && emissions.iter().all(Emission::is_black) {
            let help = "give them a color and a scale above 0";
            ("all lights of the scene are black: the picture is black", help)
        } else if shows_emission_alone && emissions.is_empty() && self.lights.iter().all(Light::is_delta) {
            let help = "write \"integer maxdepth\" 1 or more, so that surfaces are lit";
            (
                "maxdepth 0 shows lights alone, and no light of the scene is visible: the picture is black",
                help,
            )
        } else {
            return;
        };
        self.report.push(Diagnostic::warning(self.world_begin.unwrap_or(end), message).help(help));
    }

    /// Reports that `path` replaces the integrator. The picture is the same, except for caustics of delta lights.
    pub(super) fn tell_substituted_integrator(&mut self) {
        let Some(kind) = self.settled.as_ref().and_then(|settled| settled.substituted.as_ref()) else {
            return;
        };
        let message = format!("lookat renders Integrator \"{}\" with \"path\"", kind.value);
        let casts_caustics = self.lights.iter().any(Light::is_delta)
            && self.shapes().any(|primitive| is_specular(&primitive.material.kind));
        self.report.push(match casts_caustics {
            true => Diagnostic::warning(kind.span, message).help(
                "\"path\" does not find caustics of point, spot and distant lights; for caustics, use a shape with an AreaLightSource",
            ),
            false => Diagnostic::note_at(kind.span, message).help("the picture is the same apart from its noise"),
        });
    }

    /// Warns of a large world: pbrt-v3 loses hits at small distances in camera units.
    pub(super) fn warn_large_world(&mut self, world_from_camera: &Transform, at: Span) {
        const LARGE: f64 = 1000.0;
        let unit = world_from_camera.vector(DVec3::Z).length();
        if unit * LARGE < 1.0 {
            let times = (1.0 / unit).round();
            let message = format!(
                "pbrt-v3 may miss near surfaces: one unit of the world is {times} units of the camera"
            );
            let help = "leave out the scale before Camera";
            self.report.push(Diagnostic::warning(at, message).help(help));
        }
    }

    /// Warns of a scale before Camera: pbrt-v3 then passes the BSDF of the first surface a direction that is not
    /// normalized.
    fn warn_scaled_camera(&mut self) {
        let is_path = |settled: &Settled| matches!(settled.view.integrator, Integrator::Path { .. });
        if !self.settled.as_ref().is_some_and(is_path) {
            return;
        }
        let is_seen = self.shapes().any(|primitive| is_glossy(&primitive.material.kind));
        if let Some(at) = self.scaled_camera.filter(|_| is_seen) {
            let message = "a scale before Camera: pbrt-v3 renders glossy and transparent surfaces too dark or too bright, or crashes";
            let help =
                "lookat renders them correctly; for equal pictures, scale the world after WorldBegin instead";
            self.report.push(Diagnostic::warning(at, message).help(help));
        }
    }
}

/// True if the camera transformation scales lengths.
pub(super) fn is_scaled(world_from_camera: &Transform) -> bool {
    let is_other = |axis: &DVec3| (world_from_camera.vector(*axis).length() - 1.0).abs() > 1e-3;
    [DVec3::X, DVec3::Y, DVec3::Z].iter().any(is_other)
}

/// True if a material has specular lobes, which reflect or refract light in single directions.
fn is_specular(material: &MaterialKind) -> bool {
    match material {
        MaterialKind::Mirror(_) | MaterialKind::Glass(_) => true,
        MaterialKind::Uber(uber) => {
            let is_black = |share: &Texture<Vec3>| share.constant() == Some(Vec3::ZERO);
            !is_black(&uber.kr) || !is_black(&uber.kt) || uber.opacity.constant() != Some(Vec3::ONE)
        }
        MaterialKind::Mix(mix) => mix.materials.iter().any(|material| is_specular(&material.kind)),
        _ => false,
    }
}

/// True if a material has glossy lobes.
fn is_glossy(material: &MaterialKind) -> bool {
    match material {
        MaterialKind::None | MaterialKind::Matte(_) | MaterialKind::Mirror(_) => false,
        MaterialKind::Mix(mix) => mix.materials.iter().any(|material| is_glossy(&material.kind)),
        _ => true,
    }
}
