//! Queries: what is answered beside the picture.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use lookat_image::Image;
use lookat_render::{Layer, Layers, Progress, Settings, threads};
use lookat_scene::{Film, PixelBounds, View};

use super::opened::Opened;
use super::{Engine, IDLE, Stage};
use crate::view::messages::{
    About, Content, Depths, GetDepths, GetLayer, GetValues, LAYERS, LayerValues, News, Pick, Picked, Query,
    pixels,
};
use crate::view::outbox::{Hub, Topic};

impl Engine {
    /// Answers a query in the resolution of the picture that is shown. Puts it back if another request comes before.
    pub fn answer_query(&mut self, query: Query) {
        let is_full = self.stage == Stage::Finished;
        let view = self
            .opened
            .as_ref()
            .map(|opened| if is_full { opened.view.clone() } else { self.pace.view(&opened.view) });
        // A small layer is there soon.
        let is_over = || is_full && (self.requests.has_any() || self.watch.has_changed());
        if !self.is_answered(query, view.as_ref(), 0, &is_over) {
            self.requests.put_back(vec![query]);
        }
    }

    /// Answers beside a picture that is being rendered, until it is over. Puts the rest back then.
    pub fn answer_meanwhile(&self, is_over: &AtomicBool) {
        let Some(opened) = &self.opened else { return };
        // Without memory for another film, the others wait until the picture ends.
        let charge = opened.charge_film(&Settings::default());
        let accepts = |query: &Query| charge.is_ok() || !query.needs_film();
        while let Some(queries) = self.requests.take_queries(IDLE, accepts, is_over) {
            self.follow_reference();
            let ends = || is_over.load(Ordering::Relaxed);
            let (view, threads) = (Some(&opened.view), threads());
            let left =
                queries.into_iter().filter(|query| !self.is_answered(*query, view, threads, &ends)).collect();
            self.requests.put_back(left);
        }
    }

    /// Answers a query. False if it is over before.
    fn is_answered(
        &self,
        query: Query,
        view: Option<&View>,
        threads: usize,
        is_over: &(dyn Fn() -> bool + Sync),
    ) -> bool {
        match (query, self.opened.as_ref().zip(view)) {
            (Query::Show(show), _) => self.show_changes(show.by),
            (Query::Open(open), _) => self.open_editor(open),
            (Query::Reference(reference), _) => self.set_reference(reference),
            // Without a scene, there is nothing to ask about.
            (_, None) => {}
            (Query::Pick(pick), Some((opened, _))) => tell_pick(pick, opened, self.reading, &self.hub),
            (Query::Depths(depths), Some((opened, _))) => tell_depths(depths, opened, &self.hub),
            (Query::Layer(layer), Some((opened, view))) => {
                return show_layer(layer, opened, view, threads, &self.hub, self.about(), is_over);
            }
            (Query::Values(values), Some((opened, _))) => {
                return tell_values(values, opened, threads, &self.hub, is_over);
            }
        }
        true
    }
}

/// Tells what the picture shows at a place.
fn tell_pick(Pick { by, number, at }: Pick, opened: &Opened, reading: u32, hub: &Hub) {
    let hit = opened.pick(at, reading);
    hub.tell(Topic::Picked(by), News::Picked(Picked { by, number, at, hit }).message());
}

/// Tells the depths of the picture.
fn tell_depths(GetDepths { by, number, columns, rows }: GetDepths, opened: &Opened, hub: &Hub) {
    let depths = opened.depths(columns, rows);
    hub.tell(Topic::Depths(by), News::Depths(Depths { by, number, columns, depths }).message());
}

/// Shows a layer to the pages. False if it was over before.
fn show_layer(
    GetLayer { layer: number }: GetLayer,
    opened: &Opened,
    view: &View,
    threads: usize,
    hub: &Hub,
    about: About,
    is_over: &(dyn Fn() -> bool + Sync),
) -> bool {
    let Some(layer) = LAYERS.get(usize::from(number)) else { return true };
    let Some(image) = layers(opened, view, std::slice::from_ref(layer), threads, is_over) else {
        return false;
    };
    let values: Vec<[f32; 3]> = values_of(&image, layer.1).map(padded).collect();
    let about = About { number: number.into(), content: Content::Layer, ..about };
    hub.tell(Topic::Layer(number), pixels(image.data_window.size(), &values, about));
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
    hub.tell(Topic::Values(by), News::Values(LayerValues { by, number, at, values }).message());
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
