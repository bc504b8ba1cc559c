//! The pictures of a view: a small one while it moves, then the one that `render` makes, its error map, and its reference.

use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, MutexGuard};
use std::thread::Builder;
use std::time::{Duration, Instant};

use lookat_image::{Image, Window, luminance};
use lookat_render::{DARK, Progress, Settings, Stop};
use lookat_scene::{Film, PixelBounds};
use lookat_sight::Metadata;

use crate::render::settings::check_error_layers;
use crate::view::engine::{Engine, Stage};
use crate::view::messages::{About, Content, News, ReferenceFrom, pixels};
use crate::view::outbox::{Hub, Requests, Topic};
use crate::view::reference::{Gallery, References, Shared, over};
use crate::writer::lock;

/// The shortest time between two pictures that grow. A picture takes at most a tenth of the time of a thread.
const STEP: Duration = Duration::from_millis(60);

impl Engine {
    /// Renders a picture of the resolution for which there is time.
    pub fn render_small(&mut self) {
        let Some(opened) = &self.opened else {
            self.stage = Stage::Finished;
            return;
        };
        let view = self.pace.view(&opened.view);
        let started = Instant::now();
        let rendered = opened.prepared.render(&view, &Settings::default(), &|_| ControlFlow::Continue(()));
        self.pace.learn(started.elapsed());
        let total = rendered.statistics.samples;
        let seconds = started.elapsed().as_secs_f64();
        show(&self.shared.hub, &rendered.image, About { done: total, total, seconds, ..self.about() });
        (self.stage, self.small_at) = (Stage::Small, Instant::now());
    }

    /// Renders the picture that `render` makes, until there is something else to do.
    pub fn render_full(&mut self) {
        let (started, settings, about) = (Instant::now(), self.settings(), self.about());
        let Some(opened) = &mut self.opened else { return };
        // The scene has memory for a film without error layers.
        let charge = if self.has_errors { opened.charge_film(&settings).map(Some) } else { Ok(None) };
        let Ok(_charge) = charge.map_err(|reason| self.errors_refused = Some(reason.into())) else {
            self.has_errors = false;
            return self.tell_looking();
        };
        opened.prepared.look(&opened.view.camera);
        let engine = &*self;
        let Engine { opened: Some(opened), watch, shared, .. } = engine else { return };
        let Shared { requests, hub, gallery } = &**shared;
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
                show_full(hub, gallery, progress.snapshot_with_errors(), about);
                *next = Instant::now() + STEP.max(10 * now.elapsed());
            }
            ControlFlow::Continue(())
        };
        let is_over = AtomicBool::new(false);
        let rendered = std::thread::scope(|scope| {
            // Without a thread, queries wait for the end of the picture.
            let _ = Builder::new().spawn_scoped(scope, || engine.answer_meanwhile(&is_over));
            let _stop = StopQueries(requests, &is_over);
            opened.prepared.render(&opened.view, &settings, &progress)
        });
        if rendered.complete {
            let total = rendered.statistics.samples;
            let (mut image, seconds) = (rendered.image, started.elapsed().as_secs_f64());
            let samples_per_pixel = rendered.statistics.samples_in_picture as f64 / area as f64;
            image.metadata =
                Metadata::new(&self.path, &opened.view.camera, settings.seed, samples_per_pixel).as_json();
            let about = About { done: total, total, seconds, content: Content::Finished, ..about };
            show_full(hub, gallery, image, about);
            self.stage = Stage::Finished;
            self.compare();
        }
    }

    /// What all pictures of the view have in common.
    pub fn about(&self) -> About {
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
fn show_full(hub: &Hub, gallery: &Gallery, image: Image, about: About) {
    let image = gallery.put(image, about.content == Content::Finished);
    if let Some(errors) = relative_errors(&image) {
        let about = About { content: Content::Errors, ..about };
        hub.tell(Topic::Errors, pixels(image.data_window.size(), &errors, about));
    }
    show(hub, &image, about);
}

/// Shows a picture to the pages.
fn show(hub: &Hub, image: &Image, about: About) {
    if let Some(colors) = image.rgb() {
        hub.tell(Topic::Picture, pixels(image.data_window.size(), &colors, about));
    }
}

impl Engine {
    /// How the picture is rendered.
    pub fn settings(&self) -> Settings {
        Settings { stop: Stop::Samples { error_layers: self.has_errors }, ..Settings::default() }
    }

    /// Renders the picture again, with or without error layers.
    pub fn set_errors(&mut self, is_on: bool) {
        let samples = self.opened.as_ref().map_or(u32::MAX, |opened| opened.view.sampler.samples_per_pixel);
        let checked = if is_on { check_error_layers(samples) } else { Ok(()) };
        let is_on = is_on && checked.is_ok();
        if is_on != self.has_errors && self.opened.is_some() {
            self.restart();
        }
        self.has_errors = is_on;
        self.shared.hub.take_back(Topic::Errors);
        self.errors_refused = checked.err().map(String::from);
        self.tell_looking();
    }

    pub fn references(&self) -> MutexGuard<'_, References> {
        lock(&self.references)
    }

    pub fn set_reference(&self, from: ReferenceFrom) {
        let mut references = self.references();
        match (from, self.shared.gallery.newest()) {
            (ReferenceFrom::Nothing, _) => references.clear(),
            (ReferenceFrom::File, _) => references.read(),
            (ReferenceFrom::Picture, Some(picture)) => references.keep(picture),
            (ReferenceFrom::Picture, None) => {
                references.refused = Some("the picture is not at full size yet".into());
            }
        }
        drop(references);
        self.show_reference();
    }

    /// Reads the file of the reference again, if it has changed.
    pub fn follow_reference(&self) {
        if self.references().watch.has_changed() {
            self.references().read();
            self.show_reference();
        }
    }

    /// Data window and display window of the picture.
    pub fn film_windows(&self) -> Option<[Window; 2]> {
        self.opened.as_ref().map(|opened| windows(&opened.view.film))
    }

    /// Shows the reference to the pages, and compares the picture with it.
    pub fn show_reference(&self) {
        let film = self.film_windows();
        self.comparer.cancel();
        let mut references = self.references();
        self.shared.hub.take_back(Topic::Reference);
        self.shared.hub.take_back(Topic::Compared);
        (references.is_shown, references.mismatch) = (false, None);
        if let (Some(reference), Some([data, display])) = (&references.current, film) {
            match over(&reference.image, data, display) {
                Ok(values) => {
                    let about = About { content: Content::Reference, ..self.about() };
                    self.shared.hub.tell(Topic::Reference, pixels(data.size(), &values, about));
                    references.is_shown = true;
                }
                Err(reason) => references.mismatch = Some(reason.into()),
            }
        }
        drop(references);
        self.tell_looking();
        self.compare();
    }

    pub fn tell_looking(&self) {
        let references = self.references();
        let looking = News::Looking {
            has_errors: self.has_errors,
            errors_refused: self.errors_refused.as_deref(),
            reference: references.current.as_ref().map(|reference| &*reference.name),
            is_shown: references.is_shown,
            reference_refused: references.mismatch.as_deref().or(references.refused.as_deref()),
            file: references.file().map(|file| file.display().to_string()),
        };
        self.shared.hub.tell(Topic::Looking, looking);
    }

    /// Compares the finished picture with the reference.
    pub fn compare(&self) {
        self.comparer.cancel();
        let references = self.references();
        let (Some(reference), Some(picture)) = (&references.current, self.shared.gallery.finished()) else {
            return;
        };
        let pictures = [("picture".into(), picture), (reference.name.clone(), reference.image.clone())];
        let shared = self.shared.clone();
        let tell = move |compared: News| shared.hub.tell(Topic::Compared, compared);
        self.comparer.compare(self.generation, pictures, references.memory.clone(), tell);
    }
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
