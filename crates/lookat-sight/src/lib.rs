//! What a view shows: warnings about where the camera is, what is in view, what is sharp and what is lit; and the metadata of its picture.

mod facts;
mod lights;
mod media;
mod metadata;
mod placement;
mod window;
mod words;

use std::array::from_fn;

use lookat_render::{Focus, LightPlace, Prepared};
use lookat_scene::glam::DVec3;
use lookat_scene::syntax::{Diagnostic, FileId, ParamType, Span, statement_at};
use lookat_scene::{CameraPlacement, DirectiveText, Loaded, Places, Projection, Scene, Sources, View};

pub use facts::{LightFacts, ShapeFacts, ViewFacts};
pub use media::WrongSide;
pub use metadata::{Metadata, Numbered};
use words::point;
pub use words::{digits, short};

/// A scene and what it shows.
pub struct Sight<'l> {
    /// The scene, with the view that is looked at.
    pub scene: &'l Scene,
    /// Where its directives are.
    pub places: &'l Places,
    /// The texts of its files.
    pub sources: &'l Sources,
    /// The `LookAt` that alone places the camera, and its place.
    look_at: Option<(Span, CameraPlacement)>,
    /// What the view shows.
    pub facts: ViewFacts,
    /// What is sharp, with a lens.
    pub focus: Option<Focus>,
    /// What is in view where eye and target of the `LookAt` change places.
    turned: Option<ViewFacts>,
    /// What is in view from cameras that the inverse of the transformation places.
    inverses: Vec<(View, ViewFacts)>,
}

/// What a scene shows.
pub fn look<'l>(loaded: &'l Loaded, scene: &'l Scene, facts: ViewFacts) -> Sight<'l> {
    let placement = loaded.placement.filter(CameraPlacement::is_plain);
    Sight {
        scene,
        places: &loaded.places,
        sources: &loaded.sources,
        look_at: placement.and_then(|placement| Some((placement.span?, placement))),
        facts,
        focus: Focus::new(&scene.view.camera, &scene.view.film),
        turned: None,
        inverses: Vec::new(),
    }
}

/// Warnings. Where the camera is in the wrong place, nothing is said about what it shows from there.
pub fn advise(loaded: &Loaded, scene: &Scene, prepared: &mut Prepared) -> Vec<Diagnostic> {
    advise_by(loaded, scene, |view| {
        prepared.look(&view.camera);
        ViewFacts::new(prepared, view)
    })
}

/// Warnings, from a function that finds the facts about a view.
pub fn advise_by(
    loaded: &Loaded,
    scene: &Scene,
    mut facts: impl FnMut(&View) -> ViewFacts,
) -> Vec<Diagnostic> {
    let mut sight = look(loaded, scene, facts(&scene.view));
    if sight.is_odd() {
        // A turntable has cameras of its own.
        let is_own = loaded.scene.as_ref().is_none_or(|own| own.view.camera == scene.view.camera);
        match (sight.look_at, loaded.placement) {
            (Some((_, look_at)), _) => {
                sight.turned = turned(&scene.view, &look_at).map(|view| facts(&view));
            }
            (None, None) if is_own => {
                let views = placement::inverse_views(&scene.view).into_iter();
                sight.inverses = views.map(|view| (view.clone(), facts(&view))).collect();
            }
            _ => {}
        }
    }
    let sight = &sight;
    // Without Camera, reading the scene gave a warning about the place of the default camera.
    let is_placed = sight.places.camera.is_some() || loaded.placement.is_some();
    let first =
        placement::giant(sight).or_else(|| window::other_order(sight)).or_else(|| window::small(sight));
    if let Some(found) = first.or_else(|| is_placed.then(|| placement::odd(sight)).flatten()) {
        return vec![found];
    }
    let others =
        window::stretched(sight).into_iter().chain(window::blurred(sight)).chain(media::wrong_side(sight));
    others.chain(lights::idle(sight)).collect()
}

/// The view with eye and target in each other's place.
fn turned(view: &View, look_at: &CameraPlacement) -> Option<View> {
    let mut view = view.clone();
    view.camera = view.camera.placed(exchanged(look_at).world_from_camera().ok()?);
    Some(view)
}

/// A `LookAt` with eye and target in each other's place.
fn exchanged(look_at: &CameraPlacement) -> CameraPlacement {
    let mut points = look_at.points;
    points[..6].rotate_left(3);
    CameraPlacement { points, ..*look_at }
}

impl Sight<'_> {
    /// Whether the camera may be in the wrong place.
    fn is_odd(&self) -> bool {
        self.facts.inside.is_some() || self.shapes_in_view().count() < 2
    }

    /// The shapes that are seen.
    fn shapes_in_view(&self) -> impl Iterator<Item = &ShapeFacts> {
        self.facts.shapes.iter().filter(|shape| shape.share > 0.0)
    }

    /// Where the eye is, in words.
    fn eye(&self) -> String {
        format!("the eye is at {}", point(self.facts.eye))
    }

    /// The place of the directive that places the camera.
    fn camera_place(&self) -> Span {
        let Places { camera, world_begin, .. } = self.places;
        self.look_at.map(|(span, _)| span).or(*camera).or(*world_begin).unwrap_or(Span {
            file: FileId(0),
            start: 0,
            end: 0,
        })
    }

    /// The extent of the shorter side of the picture at a depth. `None` if the picture shows all directions.
    fn extent_at(&self, depth: f64) -> Option<f64> {
        let camera = &self.scene.view.camera;
        let side = (camera.screen.max - camera.screen.min).abs().min_element();
        match &camera.projection {
            Projection::Perspective { fov } => Some(side * depth * (fov.to_radians() * 0.5).tan()),
            Projection::Orthographic { .. } => Some(side),
            Projection::Environment => None,
            Projection::Realistic(_) => self.scale_at(depth).map(|scale| side * scale),
        }
    }

    /// The size of a unit of the screen window at a depth before a lens system.
    fn scale_at(&self, depth: f64) -> Option<f64> {
        let View { camera, film, .. } = &self.scene.view;
        let view = camera.lens_system()?.equivalent_view(camera.lens?.focal_distance)?;
        Some((depth - view.depth) * view.scale * camera.screen_unit(film))
    }

    /// Whether a point in camera space is in the picture, if nothing hides it.
    fn is_in_picture(&self, p: DVec3) -> bool {
        let camera = &self.scene.view.camera;
        let scale = match &camera.projection {
            Projection::Perspective { fov } => p.z * (fov.to_radians() * 0.5).tan(),
            Projection::Orthographic { .. } => 1.0,
            Projection::Environment => return true,
            Projection::Realistic(_) => self.scale_at(p.z).unwrap_or(p.z),
        };
        let (at, screen) = (p.truncate() / scale, &camera.screen);
        p.z > 0.0 && at.cmpge(screen.min).all() && at.cmple(screen.max).all()
    }

    /// The pixels on the shorter side of the full picture.
    fn short_side(&self) -> f64 {
        f64::from(self.scene.view.film.resolution[0].min(self.scene.view.film.resolution[1]))
    }

    /// Whether the picture shows all directions.
    fn is_all_around(&self) -> bool {
        self.scene.view.camera.projection == Projection::Environment
    }

    /// The box around all shapes that are no lights.
    fn bounds(&self) -> Option<[DVec3; 2]> {
        union(self.facts.shapes.iter().filter(|shape| !shape.is_emitter).map(|shape| shape.bounds))
    }

    /// The largest side of the box around all shapes that are no lights.
    fn world_size(&self) -> f64 {
        self.bounds().map_or(0.0, |[low, high]| (high - low).max_element())
    }

    /// The start of the directive around a place.
    fn directive_start(&self, place: Span) -> Option<Span> {
        let text = &self.sources.files.get(place.file.0 as usize)?.text;
        let start = statement_at(text, place)?.keyword.start;
        Some(Span { start, end: start, ..place })
    }

    /// Proposes other values for a parameter of the directive at a place, as words of the text.
    fn propose(
        &self,
        warning: Diagnostic,
        place: Span,
        ty: ParamType,
        name: &str,
        words: &[String],
    ) -> Diagnostic {
        let edits =
            DirectiveText::at(self.sources, place).map_or(Vec::new(), |text| text.set(ty, name, words));
        match edits.into_iter().next() {
            Some(edit) => warning.fix(edit.span, edit.replacement),
            None => warning,
        }
    }

    /// What all lights bring to the surfaces in view.
    fn irradiance(&self) -> f64 {
        self.facts.lights.iter().map(|light| light.irradiance.mean).sum()
    }

    /// The place of the directive of a light.
    pub fn light_place(&self, light: &LightFacts) -> Option<Span> {
        match light.irradiance.light {
            LightPlace::Light(number) => self.places.lights.get(number).copied(),
            LightPlace::Primitive(number) => self.scene.world.primitives[number].span,
        }
    }

    /// The distance of the eye from the box around all shapes; 0 within it. `None` without shapes.
    pub fn distance(&self) -> Option<f64> {
        let [low, high] = self.bounds()?;
        Some(self.facts.eye.clamp(low, high).distance(self.facts.eye))
    }

    /// Whether all of the picture is rendered.
    fn is_whole(&self) -> bool {
        let film = &self.scene.view.film;
        film.crop.area() == u64::from(film.resolution[0]) * u64::from(film.resolution[1])
    }

    /// A point in camera space.
    fn in_camera(&self, p: DVec3) -> DVec3 {
        self.scene.view.camera.middle().inverse().point(p)
    }
}

/// The box around boxes. `None` around nothing.
fn union(boxes: impl Iterator<Item = [DVec3; 2]>) -> Option<[DVec3; 2]> {
    boxes.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// The corners of a box.
fn corners([low, high]: [DVec3; 2]) -> [DVec3; 8] {
    from_fn(|corner| {
        DVec3::from(from_fn(|axis| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] }))
    })
}
