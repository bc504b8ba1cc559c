//! The pictures of a view: a small one while it moves, and then the one that `render` makes.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use lookat_image::Image;
use lookat_render::{Progress, Settings};
use lookat_scene::View;

use super::{Engine, Stage, answer};
use crate::view::messages::{About, picture};
use crate::view::outbox::{Hub, Kind};

/// The shortest time between two pictures that grow. A picture takes at most a tenth of the time of a thread.
const STEP: Duration = Duration::from_millis(60);

impl Engine {
    /// Renders a picture of the resolution for which there is time.
    pub(super) fn render_small(&mut self) {
        let Some(opened) = &self.opened else {
            self.stage = Stage::Finished;
            return;
        };
        let film = self.pace.film(&opened.view.film);
        let sampler = opened.view.sampler.with_samples(1);
        let view = View { film, sampler, ..opened.view.clone() };
        let started = Instant::now();
        let rendered =
            opened.prepared.render_unmoved(&view, &Settings::default(), &|_| ControlFlow::Continue(()));
        self.pace.learn(started.elapsed());
        let total = rendered.statistics.samples;
        let about = About { done: total, total, is_final: false, ..self.about(started) };
        show(&self.hub, &rendered.image, about);
        self.stage = Stage::Small;
    }

    /// Renders the picture that `render` makes, until there is something else to do.
    pub(super) fn render_full(&mut self) {
        let started = Instant::now();
        let about = self.about(started);
        let Some(opened) = &mut self.opened else { return };
        opened.prepared.look(&opened.view.camera);
        let (opened, requests, watch, hub) = (&*opened, &self.requests, &self.watch, &self.hub);
        let area = opened.view.film.crop.area();
        let next = Mutex::new(started + STEP);
        let progress = |progress: Progress| {
            if watch.has_changed() {
                return ControlFlow::Break(());
            }
            // Another thread does it.
            let Ok(mut next) = next.try_lock() else { return ControlFlow::Continue(()) };
            if let Some(pick) = requests.take_pick() {
                answer(pick, opened, hub);
            }
            if requests.has_any() {
                return ControlFlow::Break(());
            }
            let now = Instant::now();
            // At first, some pixels have no samples.
            if now >= *next && progress.done > area {
                let (done, total, seconds) = (progress.done, progress.total, started.elapsed().as_secs_f64());
                show(hub, &progress.snapshot(), About { done, total, seconds, ..about });
                *next = Instant::now() + STEP.max(10 * now.elapsed());
            }
            ControlFlow::Continue(())
        };
        let rendered = opened.prepared.render_whole(&opened.view, &Settings::default(), &progress);
        if let Some(rendered) = rendered.filter(|rendered| rendered.complete) {
            let total = rendered.statistics.samples;
            let about = About { done: total, total, is_final: true, ..self.about(started) };
            show(&self.hub, &rendered.image, about);
            self.stage = Stage::Finished;
        }
    }

    fn about(&self, started: Instant) -> About {
        let (generation, number, seconds) =
            (self.generation, self.set.number, started.elapsed().as_secs_f64());
        About { generation, number, done: 0, total: 0, seconds, is_final: false }
    }
}

/// Sends a picture to the pages.
fn show(hub: &Hub, image: &Image, about: About) {
    picture(image, about).into_iter().for_each(|message| hub.tell(Kind::Picture, message));
}
