//! The pictures of a view: a small one while it moves, and then the one that `render` makes.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::thread::Builder;
use std::time::{Duration, Instant};

use lookat_image::Image;
use lookat_render::{Progress, Settings};

use super::looking::relative_errors;
use super::{Engine, Stage};
use crate::render::Metadata;
use crate::view::gallery::Gallery;
use crate::view::messages::{About, Content, pixels};
use crate::view::outbox::{Hub, Kind};
use crate::view::requests::Requests;

/// The shortest time between two pictures that grow. A picture takes at most a tenth of the time of a thread.
const STEP: Duration = Duration::from_millis(60);

impl Engine {
    /// Renders a picture of the resolution for which there is time.
    pub(super) fn render_small(&mut self) {
        let Some(opened) = &self.opened else {
            self.stage = Stage::Finished;
            return;
        };
        let view = self.pace.view(&opened.view);
        let started = Instant::now();
        let rendered =
            opened.prepared.render_unmoved(&view, &Settings::default(), &|_| ControlFlow::Continue(()));
        self.pace.learn(started.elapsed());
        let total = rendered.statistics.samples;
        let seconds = started.elapsed().as_secs_f64();
        show(&self.hub, &rendered.image, About { done: total, total, seconds, ..self.about() });
        (self.stage, self.small_at) = (Stage::Small, Instant::now());
    }

    /// Renders the picture that `render` makes, until there is something else to do.
    pub(super) fn render_full(&mut self) {
        let (started, settings, about) = (Instant::now(), self.settings(), self.about());
        let Some(opened) = &mut self.opened else { return };
        // The scene has memory for a film without error layers.
        let charge = if self.has_errors { opened.charge_film(&settings).map(Some) } else { Ok(None) };
        let Ok(_charge) = charge.map_err(|reason| self.errors_refused = Some(reason)) else {
            self.has_errors = false;
            return self.tell_looking();
        };
        opened.prepared.look(&opened.view.camera);
        let engine = &*self;
        let Engine { opened: Some(opened), requests, watch, hub, gallery, .. } = engine else { return };
        let area = opened.view.film.crop.area();
        let next = Mutex::new(started + STEP);
        let progress = |progress: Progress| {
            if watch.has_changed() {
                return ControlFlow::Break(());
            }
            // Another thread does it.
            let Ok(mut next) = next.try_lock() else { return ControlFlow::Continue(()) };
            if requests.has_any() {
                return ControlFlow::Break(());
            }
            let now = Instant::now();
            // At first, some pixels have no samples.
            if now >= *next && progress.done > area {
                let (done, total, seconds) = (progress.done, progress.total, started.elapsed().as_secs_f64());
                let about = About { done, total, seconds, ..about };
                show_full((hub, gallery), progress.snapshot_with_errors(), about);
                *next = Instant::now() + STEP.max(10 * now.elapsed());
            }
            ControlFlow::Continue(())
        };
        let is_over = AtomicBool::new(false);
        let rendered = std::thread::scope(|scope| {
            // Without a thread, queries wait for the end of the picture.
            let _ = Builder::new().spawn_scoped(scope, || engine.answer_meanwhile(&is_over));
            let _stop = StopQueries(requests, &is_over);
            opened.prepared.render_unmoved(&opened.view, &settings, &progress)
        });
        if rendered.complete {
            let total = rendered.statistics.samples;
            let (mut image, seconds) = (rendered.image, started.elapsed().as_secs_f64());
            let samples_per_pixel = rendered.statistics.samples_in_picture as f64 / area as f64;
            image.metadata =
                Metadata::new(&self.path, &opened.view.camera, settings.seed, samples_per_pixel).as_json();
            let about = About { done: total, total, seconds, content: Content::Finished, ..about };
            show_full((hub, gallery), image, about);
            self.stage = Stage::Finished;
            self.compare();
        }
    }

    /// What all pictures of the view have in common.
    pub(super) fn about(&self) -> About {
        let (generation, number) = (self.generation, self.set.number);
        About { generation, number, done: 0, total: 0, seconds: 0.0, content: Content::Growing }
    }
}

/// Ends the thread that answers queries, also if rendering panics.
struct StopQueries<'a>(&'a Requests, &'a AtomicBool);

impl Drop for StopQueries<'_> {
    fn drop(&mut self) {
        self.0.stop_queries(self.1);
    }
}

/// Shows a picture of full size to the pages, with its errors if it knows them.
fn show_full((hub, gallery): (&Hub, &Gallery), image: Image, about: About) {
    let image = gallery.put(image, about.content == Content::Finished);
    if let Some(errors) = relative_errors(&image) {
        let about = About { content: Content::Errors, ..about };
        hub.tell(Kind::Errors, pixels(image.data_window.size(), &errors, about));
    }
    show(hub, &image, about);
}

/// Shows a picture to the pages.
fn show(hub: &Hub, image: &Image, about: About) {
    if let Some(colors) = image.rgb() {
        hub.tell(Kind::Picture, pixels(image.data_window.size(), &colors, about));
    }
}
