//! The directives before `WorldBegin`. They are resolved together, because `Camera` needs the `Film` and either may
//! come first.

use std::collections::HashMap;
use std::path::PathBuf;

use lookat_syntax::{Entity, EntityKind, Severity, Span, Text};

use crate::camera::{self, Camera, Projection, ViewOverride};
use crate::facts::Facts;
use crate::files::Files;
use crate::filter::{self, Filter};
use crate::integrator::{self, Integrator};
use crate::params::Params;
use crate::report::Report;
use crate::sampler::{self, Sampler};
use crate::scene::Places;
use crate::schema::{Key, Kind};
use crate::transform::{Transform, TransformSet};
use crate::{FilmOverride, View, film};

/// How [`load`](crate::load()) reads a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadOptions {
    /// The size and the crop window, if they replace those of the scene. Default: those of the scene.
    pub film: FilmOverride,
    /// The settings of the camera that replace those of the scene. Default: those of the scene.
    pub view: ViewOverride,
    /// Omit directives with errors and build a scene from the others. Default: false.
    pub keep_going: bool,
    /// The most memory for reading the scene, in bytes. Default:
    /// [`MemoryBudget::machine_limit`](lookat_image::MemoryBudget::machine_limit).
    pub max_memory: Option<u64>,
    /// Accept a file that other scenes include: its missing parts are a warning instead of an error. Default: false.
    pub accept_part: bool,
    /// Only check: open the files of meshes and pictures, but read no more than the headers of meshes. Gives no scene.
    /// Default: false.
    pub fast: bool,
}

/// The last directive of each kind of option.
pub(crate) struct Options {
    /// With the places of the directives.
    given: HashMap<EntityKind, (Entity, Span)>,
    /// The start time and the end time of motion.
    pub transform_times: [f64; 2],
}

impl Default for Options {
    fn default() -> Self {
        Options { given: HashMap::new(), transform_times: [0.0, 1.0] }
    }
}

/// The resolved options.
pub(crate) struct ResolvedOptions {
    pub view: View,
    /// Where the view is in the text.
    pub places: Places,
    /// The file of the picture.
    pub output: PathBuf,
    /// True if the integrator ignores surfaces without a material.
    pub passes_boundaries: bool,
    /// The type of an Integrator that `path` replaces.
    pub replaced_integrator: Option<Text>,
}

impl Options {
    /// Stores an option. The last one of a kind counts. Returns the place of the one before.
    pub fn set(&mut self, kind: EntityKind, entity: Entity, at: Span) -> Option<Span> {
        self.given.insert(kind, (entity, at)).map(|(_, before)| before)
    }

    /// The parameters of an option, or of its default.
    fn params<'a>(
        &mut self,
        kind: EntityKind,
        default: &str,
        world_begin: Span,
        files: &'a Files<'a>,
        report: &'a mut Report,
    ) -> Params<'a> {
        let missing = || Text { value: default.into(), span: world_begin };
        let given = self.given.remove(&kind).map(|(entity, _)| entity);
        let entity = given.unwrap_or_else(|| Entity { name: missing(), params: Vec::new() });
        Params::new(kind.keyword(), entity, files, report)
    }

    /// Resolves the options. Reports an option with an error and replaces it by the default.
    pub fn resolve(
        mut self,
        world_begin: Span,
        load_options: &LoadOptions,
        files: &Files,
        report: &mut Report,
        facts: &mut Facts,
    ) -> ResolvedOptions {
        // An unreadable directive may be the missing one.
        if !report.has_errors_before(world_begin) && !report.incomplete {
            let usual = [EntityKind::Camera, EntityKind::Film, EntityKind::Sampler, EntityKind::Integrator];
            facts.missing_options = usual.into_iter().filter(|kind| !self.given.contains_key(kind)).collect();
        }
        let camera_at = self.given.get(&EntityKind::Camera).map(|(entity, _)| entity.name.span);
        let film_params = &mut self.params(EntityKind::Film, "image", world_begin, files, report);
        let (film, output) = film::film(film_params, &load_options.film);
        let crop_window = film_params.given_place("cropwindow");
        let filter =
            filter::filter(&mut self.params(EntityKind::PixelFilter, "box", world_begin, files, report));
        let sampler =
            sampler::sampler(&mut self.params(EntityKind::Sampler, "halton", world_begin, files, report));
        let integrator_params = &mut self.params(EntityKind::Integrator, "path", world_begin, files, report);
        let passes_boundaries = integrator::passes_boundaries(integrator_params.kind());
        let replaced = Some(integrator_params.kind_text());
        let replaced_integrator = replaced.filter(|kind| integrator::is_replaced(&kind.value));
        let integrator = integrator::integrator(integrator_params);
        // An unknown type is only a warning, because the picture does not depend on it.
        let accelerator = &mut self.params(EntityKind::Accelerator, "bvh", world_begin, files, report);
        if !accelerator.is_known_kind(KINDS) {
            accelerator.report_unknown_type(KINDS, Severity::Warning);
        }
        let view_override = &load_options.view;
        if let Err(reason) = view_override.check() {
            report.override_error = Some(reason);
        }
        let given = facts.camera.as_ref().map(|(_, placed)| placed.clone());
        let placed = given.unwrap_or_else(|| {
            TransformSet::still(view_override.world_from_camera().unwrap_or(Transform::IDENTITY))
        });
        let transform_times = self.transform_times;
        let params = &mut self.params(EntityKind::Camera, "perspective", world_begin, files, report);
        let camera = camera::camera(params, &placed, transform_times, &film, view_override);
        let places = Places {
            camera: camera_at,
            screen_window: params.given_place("screenwindow"),
            lens_radius: params.given_place("lensradius"),
            focal_distance: params.given_place("focaldistance").or(params.given_place("focusdistance")),
            crop_window,
            world_begin: Some(world_begin),
            lights: Vec::new(),
        };
        let view = View {
            camera: camera
                .unwrap_or_else(|| Camera::new(placed.start.inverse(), Projection::PBRT_DEFAULT, &film)),
            film,
            filter: filter.unwrap_or(Filter::BOX),
            sampler: sampler.unwrap_or(Sampler::PBRT_DEFAULT),
            integrator: integrator.unwrap_or(Integrator::PBRT_DEFAULT),
        };
        ResolvedOptions { view, places, output, passes_boundaries, replaced_integrator }
    }
}

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("bvh", "a bounding volume hierarchy; lookat always builds its own", &[]).ignoring(&[&[
        &Key::string("splitmethod", "how nodes are split: sah, hlbvh, middle or equal")
            .default_words("\"sah\""),
        &Key::integer("maxnodeprims", 4, "the largest number of shapes in a leaf"),
    ]]),
    Kind::new("kdtree", "a k-d tree; lookat builds its own bounding volume hierarchy", &[]).ignoring(&[&[
        &Key::integer("intersectcost", 80, "the cost of an intersection test"),
        &Key::integer("traversalcost", 1, "the cost of visiting a node"),
        &Key::float("emptybonus", 0.5, "the share of the cost that a split saves with an empty side"),
        &Key::integer("maxprims", 1, "the largest number of shapes in a leaf"),
        &Key::integer("maxdepth", -1, "the depth of the tree; negative depends on the number of shapes"),
    ]]),
];
