//! The directives before `WorldBegin`. They are resolved together, because `Camera` needs the `Film` and either may
//! come first.

use std::path::PathBuf;

use lookat_syntax::{Entity, EntityKind, Severity, Span, Spanned, Text};

use crate::advice::Facts;
use crate::camera::{self, Camera, Projection};
use crate::files::Files;
use crate::filter::{self, Filter};
use crate::integrator::{self, Integrator};
use crate::load::LoadOptions;
use crate::params::Params;
use crate::report::Report;
use crate::sampler::{self, Sampler};
use crate::scene::Places;
use crate::schema::{DefaultValue, Effect, Key, Kind, Name, names};
use crate::{Transform, View, film};

/// The last option of each kind, as written.
#[derive(Default)]
pub(crate) struct Options {
    camera: Option<(Given, Transform)>,
    film: Option<Given>,
    filter: Option<Given>,
    sampler: Option<Given>,
    integrator: Option<Given>,
    accelerator: Option<Given>,
}

struct Given {
    entity: Entity,
    at: Span,
}

/// The resolved options.
pub(crate) struct Settled {
    pub view: View,
    /// Where the view is in the text.
    pub places: Places,
    /// The file of the picture.
    pub output: PathBuf,
    /// True if the integrator ignores surfaces without a material.
    pub passes_boundaries: bool,
    /// The type of an Integrator that `path` replaces.
    pub substituted: Option<Text>,
}

impl Options {
    /// Stores an option. The last one of a kind counts. Returns the place of the one before.
    pub fn set(
        &mut self,
        kind: EntityKind,
        entity: Entity,
        at: Span,
        world_from_camera: Transform,
    ) -> Option<Span> {
        let given = Given { entity, at };
        let before = match kind {
            EntityKind::Camera => self.camera.replace((given, world_from_camera)).map(|(given, _)| given),
            EntityKind::Film => self.film.replace(given),
            EntityKind::PixelFilter => self.filter.replace(given),
            EntityKind::Sampler => self.sampler.replace(given),
            EntityKind::Integrator => self.integrator.replace(given),
            _ => self.accelerator.replace(given),
        };
        before.map(|before| before.at)
    }

    /// Resolves the options. Reports an option with an error and replaces it by the default.
    pub fn settle(
        self,
        world_begin: Span,
        load_options: &LoadOptions,
        files: &Files,
        report: &mut Report,
        facts: &mut Facts,
    ) -> Settled {
        // An unreadable directive may be the missing one.
        if !report.has_errors_before(world_begin) && !report.incomplete {
            facts.missing_options = self.missing();
        }
        let entity = |given: Option<Given>, default: &str| match given {
            Some(given) => given.entity,
            None => Entity { name: Spanned { value: default.into(), span: world_begin }, params: Vec::new() },
        };
        let params = &mut Params::new("Film", entity(self.film, "image"), files, report);
        let (film, output) = film::film(params, &load_options.film);
        let crop_window = params.given_place("cropwindow");
        let filter =
            filter::filter(&mut Params::new("PixelFilter", entity(self.filter, "box"), files, report));
        let params = &mut Params::new("Sampler", entity(self.sampler, "halton"), files, report);
        let sampler = sampler::sampler(params);
        let params = &mut Params::new("Integrator", entity(self.integrator, "path"), files, report);
        let passes_boundaries = integrator::passes_boundaries(params.kind());
        let substituted = Some(params.kind_text()).filter(|kind| integrator::is_substituted(&kind.value));
        let integrator = integrator::integrator(params);
        if let Some(given) = self.accelerator {
            accelerator(&mut Params::new("Accelerator", given.entity, files, report));
        }
        let view_override = &load_options.view;
        if let Err(reason) = view_override.check() {
            report.misfit = Some(reason);
        }
        let (given, world_from_camera) = match self.camera {
            Some((given, world_from_camera)) => (Some(given), world_from_camera),
            None => (None, view_override.world_from_camera().unwrap_or(Transform::IDENTITY)),
        };
        let at = given.as_ref().map(|given| given.entity.name.span);
        let params = &mut Params::new("Camera", entity(given, "perspective"), files, report);
        let camera = camera::camera(params, world_from_camera, &film, view_override);
        let places = Places {
            camera: at,
            screen_window: params.given_place("screenwindow"),
            lens_radius: params.given_place("lensradius"),
            focal_distance: params.given_place("focaldistance"),
            crop_window,
            world_begin: Some(world_begin),
            lights: Vec::new(),
        };
        let view = View {
            camera: camera
                .unwrap_or_else(|| Camera::new(world_from_camera.inverse(), Projection::PBRT_DEFAULT, &film)),
            film,
            filter: filter.unwrap_or(Filter::BOX),
            sampler: sampler.unwrap_or(Sampler::PBRT_DEFAULT),
            integrator: integrator.unwrap_or(Integrator::PBRT_DEFAULT),
        };
        Settled { view, places, output, passes_boundaries, substituted }
    }

    /// The kinds of options that are usually given and are not.
    fn missing(&self) -> Vec<EntityKind> {
        let given = [
            (EntityKind::Camera, self.camera.is_some()),
            (EntityKind::Film, self.film.is_some()),
            (EntityKind::Sampler, self.sampler.is_some()),
            (EntityKind::Integrator, self.integrator.is_some()),
        ];
        given.into_iter().filter(|(_, is_given)| !is_given).map(|(kind, _)| kind).collect()
    }
}

const fn unread<T: DefaultValue>(key: Key<T>) -> Key<T> {
    key.effect(Effect::NotRendered)
}

const SPLIT_METHOD: Key<Name> = unread(
    Key::string("splitmethod", "how nodes are split: sah, hlbvh, middle or equal").default_words("\"sah\""),
);
const MOST_IN_NODE: Key<i32> = unread(Key::integer("maxnodeprims", 4, "the most shapes in a leaf"));
const INTERSECT_COST: Key<i32> =
    unread(Key::integer("intersectcost", 80, "the cost of an intersection test"));
const TRAVERSAL_COST: Key<i32> = unread(Key::integer("traversalcost", 1, "the cost of visiting a node"));
const EMPTY_BONUS: Key<f64> =
    unread(Key::float("emptybonus", 0.5, "the share of the cost that a split saves with an empty side"));
const MOST_IN_LEAF: Key<i32> = unread(Key::integer("maxprims", 1, "the most shapes in a leaf"));
const MAX_DEPTH: Key<i32> =
    unread(Key::integer("maxdepth", -1, "the depth of the tree; negative depends on the number of shapes"));

pub(crate) const KINDS: &[Kind] = &[
    Kind::new(
        "Accelerator",
        "bvh",
        "a bounding volume hierarchy; lookat always builds its own",
        &[&[&SPLIT_METHOD, &MOST_IN_NODE]],
    ),
    Kind::new(
        "Accelerator",
        "kdtree",
        "a k-d tree; lookat builds its own bounding volume hierarchy",
        &[&[&INTERSECT_COST, &TRAVERSAL_COST, &EMPTY_BONUS, &MOST_IN_LEAF, &MAX_DEPTH]],
    ),
];

/// Reports an unknown type, which is only a warning, because the picture does not depend on it.
fn accelerator(params: &mut Params) {
    if !names(KINDS).contains(&params.kind()) {
        params.say_unknown_kind(&names(KINDS), Severity::Warning);
    }
}
