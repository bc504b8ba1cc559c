//! Layers, the error map and the reference.

use std::ops::ControlFlow;
use std::sync::MutexGuard;
use std::sync::atomic::{AtomicBool, Ordering};

use lookat_image::{Image, Window};
use lookat_render::{DARK, Layer, Layers, Progress, Settings, Stop, threads};
use lookat_scene::{Film, PixelBounds, View};

use super::opened::Opened;
use super::{Engine, IDLE, Stage};
use crate::lock::lock;
use crate::view::messages::{
    About, Content, Depths, GetDepths, GetLayer, GetValues, LAYERS, LayerValues, Looking, News, Pick, Picked,
    ReferenceFrom, Request, SetErrors, SetReference, pixels,
};
use crate::view::outbox::{Hub, Kind};
use crate::view::reference::{References, over};

impl Engine {
    /// How the picture is rendered.
    pub(super) fn settings(&self) -> Settings {
        Settings { stop: Stop::Samples { error_layers: self.has_errors }, ..Settings::default() }
    }

    /// Renders the picture again, with or without error layers.
    pub(super) fn set_errors(&mut self, SetErrors { is_on }: SetErrors) {
        let samples = self.opened.as_ref().map_or(u32::MAX, |opened| opened.view.sampler.samples_per_pixel);
        let checked = if is_on { crate::render::check_error_layers(samples) } else { Ok(()) };
        let is_on = is_on && checked.is_ok();
        if is_on != self.has_errors && self.opened.is_some() {
            self.restart();
        }
        self.has_errors = is_on;
        self.hub.take_back(Kind::Errors);
        self.errors_refused = checked.err();
        self.tell_looking();
    }

    pub(super) fn references(&self) -> MutexGuard<'_, References> {
        lock(&self.references)
    }

    fn set_reference(&self, SetReference { from }: SetReference) {
        let mut references = self.references();
        match (from, self.gallery.newest()) {
            (ReferenceFrom::Nothing, _) => references.clear(),
            (ReferenceFrom::File, _) => references.read(),
            (ReferenceFrom::Picture, Some(picture)) => references.keep(picture),
            (ReferenceFrom::Picture, None) => {
                references.refused = Some("there is no picture of full size yet".into());
            }
        }
        drop(references);
        self.show_reference();
    }

    /// Reads the file of the reference again, if it has changed.
    pub(super) fn follow_reference(&self) {
        if self.references().has_changed() {
            self.references().read();
            self.show_reference();
        }
    }

    /// Data window and display window of the picture.
    pub(super) fn film_windows(&self) -> Option<[Window; 2]> {
        self.opened.as_ref().map(|opened| windows(&opened.view.film))
    }

    /// Shows the reference to the pages, and compares the picture with it.
    pub(super) fn show_reference(&self) {
        let film = self.film_windows();
        self.comparer.cancel();
        let mut references = self.references();
        self.hub.take_back(Kind::Reference);
        self.hub.take_back(Kind::Compared);
        (references.is_shown, references.misfit) = (false, None);
        if let (Some(reference), Some([data, display])) = (&references.current, film) {
            match over(&reference.image, data, display) {
                Ok(values) => {
                    let about = About { content: Content::Reference, ..self.about() };
                    self.hub.tell(Kind::Reference, pixels(data.size(), &values, about));
                    references.is_shown = true;
                }
                Err(reason) => references.misfit = Some(reason),
            }
        }
        drop(references);
        self.tell_looking();
        self.compare();
    }

    pub(super) fn tell_looking(&self) {
        let references = self.references();
        let looking = Looking {
            has_errors: self.has_errors,
            errors_refused: self.errors_refused.as_deref(),
            reference: references.current.as_ref().map(|reference| &*reference.name),
            is_shown: references.is_shown,
            reference_refused: references.misfit.as_deref().or(references.refused.as_deref()),
            file: references.file().map(|file| file.display().to_string()),
        };
        self.hub.tell(Kind::Looking, News::Looking(looking).message());
    }

    /// Compares the finished picture with the reference.
    pub(super) fn compare(&self) {
        self.comparer.cancel();
        let references = self.references();
        let (Some(reference), Some(picture)) = (&references.current, self.gallery.finished()) else { return };
        let pictures = [("picture".into(), picture), (reference.name.clone(), reference.image.clone())];
        let hub = self.hub.clone();
        let tell = move |compared| hub.tell(Kind::Compared, News::Compared(compared).message());
        self.comparer.compare(self.generation, pictures, references.memory.clone(), tell);
    }

    /// Answers questions beside the picture, in the resolution of the picture that is shown.
    pub(super) fn answer_queries(&mut self, queries: Vec<Request>) {
        let Some(opened) = &self.opened else { return };
        let is_full = self.stage == Stage::Finished;
        let view = if is_full { opened.view.clone() } else { self.pace.view(&opened.view) };
        // A small layer is there soon.
        let is_over = || is_full && (self.requests.has_any() || self.watch.has_changed());
        queries.into_iter().for_each(|query| self.answer_query(query, (&view, 0), &is_over));
    }

    /// Answers beside a picture that is being rendered, until it is over.
    pub(super) fn answer_meanwhile(&self, is_over: &AtomicBool) {
        let Some(opened) = &self.opened else { return };
        // Without memory for another film, the others wait until the picture ends.
        let charge = opened.charge_film(&Settings::default());
        let is_wanted = |request: &Request| request.is_query() && (charge.is_ok() || !request.needs_film());
        while let Some(queries) = self.requests.take_wanted(IDLE, is_wanted, is_over) {
            self.follow_reference();
            let ends = || is_over.load(Ordering::Relaxed);
            queries.into_iter().for_each(|query| self.answer_query(query, (&opened.view, threads()), &ends));
        }
    }

    /// Answers one question, or puts it back if it is over before.
    fn answer_query(&self, query: Request, view: (&View, usize), is_over: &(dyn Fn() -> bool + Sync)) {
        let Some(opened) = &self.opened else { return };
        let is_answered = match query {
            Request::Layer(layer) => show_layer(layer, opened, view, (&self.hub, self.about()), is_over),
            Request::Values(values) => tell_values(values, opened, view.1, &self.hub, is_over),
            Request::Reference(reference) => {
                self.set_reference(reference);
                true
            }
            Request::Depths(asked) => {
                tell_depths(asked, opened, &self.hub);
                true
            }
            Request::Pick(pick) => {
                tell_pick(pick, opened, self.reading, &self.hub);
                true
            }
            Request::Open(open) => {
                self.open_editor(open);
                true
            }
            Request::Edit(edit) => {
                self.show_changes(edit.by);
                true
            }
            _ => true,
        };
        if !is_answered {
            self.requests.put_back(query);
        }
    }
}

/// Tells what the picture shows at a place.
fn tell_pick(Pick { by, number, at }: Pick, opened: &Opened, reading: u32, hub: &Hub) {
    let hit = opened.pick(at, reading);
    hub.tell(Kind::Picked(by), News::Picked(Picked { by, number, at, hit }).message());
}

/// Tells the depths of the picture.
fn tell_depths(GetDepths { by, number, columns, rows }: GetDepths, opened: &Opened, hub: &Hub) {
    let depths = opened.depths(columns, rows);
    hub.tell(Kind::Depths(by), News::Depths(Depths { by, number, columns, depths }).message());
}

/// Shows a layer to the pages. False if it was over before.
fn show_layer(
    GetLayer { layer: number }: GetLayer,
    opened: &Opened,
    (view, threads): (&View, usize),
    (hub, about): (&Hub, About),
    is_over: &(dyn Fn() -> bool + Sync),
) -> bool {
    let Some(layer) = LAYERS.get(usize::from(number)) else { return true };
    let Some(image) = layers(opened, view, std::slice::from_ref(layer), threads, is_over) else {
        return false;
    };
    let values: Vec<[f32; 3]> = values_of(&image, layer.1).map(padded).collect();
    let about = About { number: number.into(), content: Content::Layer, ..about };
    hub.tell(Kind::Layer(number), pixels(image.data_window.size(), &values, about));
    true
}

/// Tells the values of all layers at a place. False if it was over before.
fn tell_values(
    GetValues { by, number, at }: GetValues,
    opened: &Opened,
    threads: usize,
    hub: &Hub,
    is_over: &(dyn Fn() -> bool + Sync),
) -> bool {
    let mut values = Vec::new();
    if let Some(film) = pixel_of(&opened.view.film, at) {
        let view = View { film, ..opened.view.clone() };
        let Some(image) = layers(opened, &view, &LAYERS, threads, is_over) else { return false };
        values = LAYERS.map(|(_, layer)| values_of(&image, layer).next().unwrap_or_default()).into();
    }
    hub.tell(Kind::Values(by), News::Values(LayerValues { by, number, at, values }).message());
    true
}

/// A picture with layers. `None` if it is over before.
fn layers(
    opened: &Opened,
    view: &View,
    wanted: &[(&str, Layer)],
    threads: usize,
    is_over: &(dyn Fn() -> bool + Sync),
) -> Option<Image> {
    let layers = wanted.iter().filter_map(|(name, _)| Layers::named(name));
    let layers = layers.fold(Layers::default(), Layers::union);
    let settings = Settings { layers, threads, ..Settings::default() };
    let flow = |_: Progress| if is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    opened.prepared.layers(view, &settings, &flow)
}

/// The values of a layer, pixel by pixel.
fn values_of(image: &Image, layer: Layer) -> impl Iterator<Item = Vec<f32>> {
    let planes: Vec<&[f32]> = layer.channels().iter().filter_map(|name| image.channel(name)).collect();
    (0..image.data_window.area() as usize).map(move |at| planes.iter().map(|plane| plane[at]).collect())
}

fn padded(values: Vec<f32>) -> [f32; 3] {
    std::array::from_fn(|axis| values.get(axis).copied().unwrap_or(0.0))
}

/// The film of one pixel.
fn pixel_of(film: &Film, at: [f64; 2]) -> Option<Film> {
    let PixelBounds { x0, y0, x1, y1 } = film.crop;
    // What is no number or outside of the range becomes another number.
    let [x, y] = at.map(|edge| edge.floor() as i64);
    let is_inside = (x0.into()..x1.into()).contains(&x) && (y0.into()..y1.into()).contains(&y);
    let (x0, y0) = (x as u32, y as u32);
    is_inside.then(|| Film { crop: PixelBounds { x0, y0, x1: x0 + 1, y1: y0 + 1 }, ..film.clone() })
}

/// Data window and display window of the pictures of a film.
fn windows(film: &Film) -> [Window; 2] {
    let PixelBounds { x0, y0, .. } = film.crop;
    let [width, height] = film.resolution;
    let (x, y) = (x0 as i32, y0 as i32);
    let data = Window { x, y, width: film.crop.width(), height: film.crop.height() };
    [data, Window { x: 0, y: 0, width, height }]
}

/// The estimated error of each pixel relative to its luminance, its standard error, and the number of replicates that tell it.
/// Dark pixels are judged relative to the picture, as by `--target-error`. `None` without an error that is known.
pub fn relative_errors(image: &Image) -> Option<Vec<[f32; 3]>> {
    let (errors, colors) = (image.errors()?, image.rgb()?);
    let luminance = |[red, green, blue]: [f32; 3]| 0.212_671 * red + 0.715_16 * green + 0.072_169 * blue;
    let roots: f64 = colors.iter().map(|color| f64::from(luminance(*color).max(0.0)).sqrt()).sum();
    let brightness = (roots / colors.len() as f64).powi(2);
    let least = (DARK * brightness) as f32;
    let relative = |(error, color): (&lookat_image::PixelError, &[f32; 3])| {
        let standard_error = luminance(error.standard_error);
        let value = luminance(*color).max(least);
        let share = if standard_error == 0.0 { 0.0 } else { standard_error / value };
        [share, standard_error, error.replicates as f32]
    };
    let all: Vec<[f32; 3]> = errors.iter().zip(&colors).map(relative).collect();
    all.iter().any(|error| error[0].is_finite()).then_some(all)
}
