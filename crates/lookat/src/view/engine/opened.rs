//! A scene that has been read and prepared, and its directives for the page.

use lookat_image::Charge;
use lookat_render::{Prepared, Settings, film_bytes};
use lookat_scene::glam::DVec2;
use lookat_scene::schema::{Count, Effect, Kind};
use lookat_scene::syntax::{self, EntityKind, Param, Span};
use lookat_scene::{Camera, FileCamera, Loaded, Scene, Sources, View, ViewOverride, kinds};

use crate::args::way_out;
use crate::explain::ParameterFacts;
use crate::failure::Failure;
use crate::render::settings::charge_memory;
use crate::report;
use crate::view::camera::{camera_fixes, placement, rounded, values};
use crate::view::messages::{self, Described, Hit, Parameter, TextPlace, TextValues, Values};
use crate::view::write::{FileChange, changes};
use lookat_scene::DirectiveText;
use lookat_sight::ViewFacts;

/// The most places along a side of which the depths are told.
const MOST_DEPTHS: u32 = 64;
/// The most lights that a page lists.
const MOST_LIGHTS: usize = 64;

/// A scene that is ready to render.
pub struct Opened {
    pub loaded: Loaded,
    scene: Scene,
    file_camera: FileCamera,
    /// What the page sees.
    pub view: View,
    /// The `LookAt` of what the page sees.
    points: [f64; 9],
    pub prepared: Prepared,
    /// Whether the file had another camera before.
    pub has_new_camera: bool,
    /// Warnings and notes as text, also about what the camera of the file shows once [`Opened::advise`] has added them.
    pub messages: String,
    /// Whether they are also about what the camera of the file shows.
    is_advised: bool,
    _charge: Charge,
}

impl Opened {
    /// Prepares a scene. Takes `before` over, and gives the rest of its memory back.
    pub fn new(mut loaded: Loaded, before: &mut Option<Opened>) -> Result<Opened, Failure> {
        let scene = loaded.scene.take().ok_or_else(String::new)?;
        let charge = charge_memory(&scene, &Settings::default(), &loaded.memory)?;
        let (mut has_new_camera, mut messages) = (false, None);
        let prepared = match before.take().map(|before| (before.prepared, before.scene, before.messages)) {
            Some((mut prepared, before, old)) => {
                has_new_camera = is_new_camera(&before.view, &scene.view);
                // Until the new ones are known.
                messages = Some(old);
                drop(before);
                prepared.renew(&scene);
                prepared
            }
            None => Prepared::new(&scene),
        };
        let focal_distance = loaded.places.focal_distance;
        let focal_distance = focal_distance.and_then(|span| loaded.sources.word(span).parse().ok());
        let placement = placement(&loaded, &scene, &prepared);
        Ok(Opened {
            view: scene.view.clone(),
            points: placement.map_or([0.0; 9], |placement| placement.points),
            loaded,
            scene,
            file_camera: FileCamera { placement, focal_distance },
            prepared,
            has_new_camera,
            messages: messages.unwrap_or_default(),
            is_advised: false,
            _charge: charge,
        })
    }

    /// Charges the memory of one more film.
    pub fn charge_film(&self, settings: &Settings) -> Result<Charge, Failure> {
        Ok(self.loaded.memory.reserve(film_bytes(&self.view, settings)).map_err(way_out)?)
    }

    /// Adds warnings about what the camera of the file shows. False if they are there already.
    pub fn advise(&mut self) -> bool {
        if self.is_advised {
            return false;
        }
        let Opened { loaded, scene, prepared, .. } = self;
        let advice = lookat_sight::advise_by(loaded, scene, |view| ViewFacts::new(prepared, view));
        loaded.diagnostics.extend(advice);
        self.messages = report::text(loaded);
        self.is_advised = true;
        true
    }

    /// The `LookAt` of the file.
    fn own_points(&self) -> [f64; 9] {
        self.file_camera.placement.map_or(self.points, |placement| placement.points)
    }

    /// What is set, in numbers that are short enough to write.
    pub fn rounded(&self, set: ViewOverride) -> ViewOverride {
        rounded(set, self.own_points())
    }

    /// What writing the camera that is set changes in the files. Fails with the reason why nothing can be written.
    pub fn changes(&self, set: &ViewOverride) -> Result<Vec<FileChange>, Failure> {
        let fixes = camera_fixes(&self.loaded, &self.scene.view.camera, set)?;
        changes(&self.loaded.sources, &fixes)
    }

    /// Sets the camera. Fails with the reason, and changes nothing.
    pub fn set(&mut self, set: &ViewOverride) -> Result<(), Failure> {
        if set.look_at.is_some() && self.loaded.world_follows_camera {
            bail!(
                "CoordSysTransform \"camera\" places a part of this world relative to the camera: \
                        move the camera in the file"
            );
        }
        self.view.camera = set.changed(&self.scene.view.camera, &self.file_camera)?;
        self.points = set.look_at.unwrap_or(self.own_points());
        Ok(())
    }

    /// What the page sees, in numbers.
    pub fn values(&self) -> messages::Camera {
        values(&self.view, &self.file_camera, self.points, self.scene.has_motion())
    }

    /// The camera of the file, in numbers.
    pub fn own(&self) -> messages::Camera {
        values(&self.scene.view, &self.file_camera, self.own_points(), self.scene.has_motion())
    }

    pub fn film(&self) -> messages::Film {
        let View { film, sampler, .. } = &self.scene.view;
        let crop = film.crop;
        messages::Film {
            resolution: film.resolution,
            crop: [crop.x0, crop.y0, crop.x1, crop.y1],
            samples_per_pixel: sampler.samples_per_pixel,
        }
    }

    /// What the picture shows at a place.
    pub fn pick(&self, [x, y]: [f64; 2], reading: u32) -> Option<Hit> {
        if !x.is_finite() || !y.is_finite() {
            return None;
        }
        let Opened { prepared, view, loaded, .. } = self;
        let picked = prepared.pick(view, DVec2::new(x, y))?;
        let (shape, material) = (picked.primitive.span, picked.primitive.material.span);
        let word = |span: Option<_>| span.map(|span| loaded.sources.word(span));
        let place = |span: Option<_>| span.map(|span| TextPlace::new(span, &loaded.sources, reading));
        let emission = picked.primitive.emission.as_ref().and_then(|emission| emission.span);
        let directives = [material, emission].into_iter().flatten();
        Some(Hit {
            p: picked.p.to_array(),
            p_look_at: self
                .file_camera
                .placement
                .map_or(picked.p, |placement| placement.after.point(picked.p))
                .to_array(),
            depth: picked.depth,
            shape: word(shape).unwrap_or_default(),
            shape_place: place(shape),
            material: word(material).unwrap_or_else(|| "the default material".into()),
            material_place: place(material),
            directives: directives.filter_map(|span| describe(&loaded.sources, span, reading)).collect(),
        })
    }

    /// The depths at the middles of equal parts of the picture, row by row.
    pub fn depths(&self, columns: u32, rows: u32) -> Vec<Option<f64>> {
        let crop = self.view.film.crop;
        let middle = |from: u32, size: u32, part: u32, parts: u32| {
            f64::from(from) + (f64::from(part) + 0.5) / f64::from(parts) * f64::from(size)
        };
        let depth = |x: f64, y: f64| Some(self.prepared.pick(&self.view, DVec2::new(x, y))?.depth);
        let (columns, rows) = (columns.clamp(1, MOST_DEPTHS), rows.clamp(1, MOST_DEPTHS));
        let ys = (0..rows).map(|row| middle(crop.y0, crop.height(), row, rows));
        let xs = |column| middle(crop.x0, crop.width(), column, columns);
        ys.flat_map(|y| (0..columns).map(move |column| (column, y)))
            .map(|(column, y)| depth(xs(column), y))
            .collect()
    }

    /// The lights without a shape, up to 64.
    pub fn lights(&self, reading: u32) -> Vec<Described> {
        let lights = self.loaded.places.lights.iter().take(MOST_LIGHTS);
        lights.filter_map(|span| describe(&self.loaded.sources, *span, reading)).collect()
    }
}

/// Whether the camera of the file has changed. The shape of the film changes the screen of a camera without `screenwindow`, too.
fn is_new_camera(before: &View, now: &View) -> bool {
    let same_film = before.film.resolution == now.film.resolution;
    let screen = if same_film { before.camera.screen } else { now.camera.screen };
    Camera { screen, ..before.camera.clone() } != now.camera
}

/// The directive around a place. `None` for one without a type.
pub fn describe(sources: &Sources, place: Span, reading: u32) -> Option<Described> {
    let found = DirectiveText::at(sources, place)?;
    let kind = kind_of(&found)?;
    // Pages cannot show long lists; another type has other parameters.
    let parameters = kind.parameters().filter(|parameter| {
        let is_used = matches!(parameter.effect, Effect::Rendered | Effect::Own);
        parameter.count != Count::List && is_used && parameter.name != "type"
    });
    let described = |parameter| Parameter {
        facts: ParameterFacts::new(&parameter),
        given: found.param(parameter.name).map(given),
    };
    Some(Described {
        directive: kind.directive,
        kind: kind.name,
        name: is_named(&found).then(|| found.entity.name.value.clone()),
        place: TextPlace::new(found.entity.name.span, sources, reading),
        parameters: parameters.map(described).collect(),
    })
}

/// The type of a directive in the schema.
pub fn kind_of(found: &DirectiveText) -> Option<&'static Kind> {
    let name = match found.param("type").map(|param| &param.values.value) {
        Some(syntax::Values::Strings(names)) if is_named(found) => &names.first()?.value,
        _ => &found.entity.name.value,
    };
    kinds().find(|kind| kind.directive == found.kind.keyword() && kind.name == name)
}

/// Whether the directive has a name in place of its type.
fn is_named(found: &DirectiveText) -> bool {
    found.kind == EntityKind::MakeNamedMaterial
}

fn given(param: &Param) -> TextValues {
    let whole = |list: &[i32]| list.iter().map(|value| f64::from(*value)).collect();
    let values = match &param.values.value {
        syntax::Values::Integers(list) => Values::Numbers(whole(list)),
        syntax::Values::Numbers(list) => Values::Numbers(list.clone()),
        syntax::Values::Pairs(list) => Values::Numbers(list.as_flattened().to_vec()),
        syntax::Values::Triples(list) => Values::Numbers(list.as_flattened().to_vec()),
        syntax::Values::Bools(list) => Values::Words(list.iter().map(bool::to_string).collect()),
        syntax::Values::Strings(list) => Values::Words(list.iter().map(|text| text.value.clone()).collect()),
    };
    TextValues { ty: param.ty.name(), values }
}
