//! Queries: what is answered beside the picture.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use lookat_image::Image;
use lookat_render::{Layer, Layers, Progress, Settings, threads};
use lookat_scene::{Film, PixelBounds, View};

use super::opened::Opened;
use super::{Engine, IDLE, Stage};
use crate::view::messages::{About, Content, LAYERS, News, Request, pixels};
use crate::view::outbox::Topic;

impl Engine {
    /// Answers a query in the resolution of the picture that is shown. Puts it back if another request comes before.
    pub fn answer_query(&mut self, query: Request) {
        let is_full = self.stage == Stage::Finished;
        let view = self
            .opened
            .as_ref()
            .map(|opened| if is_full { opened.view.clone() } else { self.pace.view(&opened.view) });
        // A small layer is there soon.
        let is_over = || is_full && (self.shared.requests.has_any() || self.watch.has_changed());
        if !self.is_answered(&query, view.as_ref(), 0, &is_over) {
            self.shared.requests.put_back(vec![query]);
        }
    }

    /// Answers beside a picture that is being rendered, until it is over. Puts the rest back then.
    pub fn answer_meanwhile(&self, is_over: &AtomicBool) {
        let Some(opened) = &self.opened else { return };
        // Without memory for another film, the others wait until the picture ends.
        let charge = opened.charge_film(&Settings::default());
        let accepts = |query: &Request| charge.is_ok() || !query.needs_film();
        while let Some(queries) = self.shared.requests.take_queries(IDLE, accepts, is_over) {
            self.follow_reference();
            let ends = || is_over.load(Ordering::Relaxed);
            let (view, threads) = (Some(&opened.view), threads());
            let left = queries.into_iter().filter(|query| !self.is_answered(query, view, threads, &ends));
            self.shared.requests.put_back(left.collect());
        }
    }

    /// Answers a query. False if it is over before.
    fn is_answered(
        &self,
        query: &Request,
        view: Option<&View>,
        threads: usize,
        is_over: &(dyn Fn() -> bool + Sync),
    ) -> bool {
        let hub = &self.shared.hub;
        match (query, self.opened.as_ref().zip(view)) {
            (&Request::Show { by }, _) => self.show_changes(by),
            (&Request::Open { by, at }, _) => self.open_editor(by, at),
            (&Request::Reference { from }, _) => self.set_reference(from),
            (&Request::Pick { by, number, at }, Some((opened, _))) => {
                let hit = opened.pick(at, self.reading);
                hub.tell(Topic::Picked(by), News::Picked { by, number, at, hit });
            }
            (&Request::Depths { by, number, columns, rows }, Some((opened, _))) => {
                let depths = opened.depths(columns, rows);
                hub.tell(Topic::Depths(by), News::Depths { by, number, columns, depths });
            }
            (&Request::Layer { layer: number }, Some((opened, view))) => {
                let Some(layer) = LAYERS.get(usize::from(number)) else { return true };
                let Some(image) = layers(opened, view, std::slice::from_ref(layer), threads, is_over) else {
                    return false;
                };
                let values: Vec<[f32; 3]> = values_of(&image, layer.1).map(padded).collect();
                let about = About { number: number.into(), content: Content::Layer, ..self.about() };
                hub.tell(Topic::Layer(number), pixels(image.data_window.size(), &values, about));
            }
            (&Request::Values { by, number, at }, Some((opened, _))) => {
                let mut values = Vec::new();
                if let Some(film) = pixel_of(&opened.view.film, at) {
                    let view = View { film, ..opened.view.clone() };
                    let Some(image) = layers(opened, &view, &LAYERS, threads, is_over) else { return false };
                    values =
                        LAYERS.map(|(_, layer)| values_of(&image, layer).next().unwrap_or_default()).into();
                }
                hub.tell(Topic::Values(by), News::Values { by, number, at, values });
            }
            // Without a scene, there is nothing to ask about.
            _ => {}
        }
        true
    }
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
