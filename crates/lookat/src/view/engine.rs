//! Renders what the pages ask for, and follows the file.

mod edits;
mod opened;
mod pace;
mod pictures;
mod queries;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use lookat_scene::{FilmOverride, LoadCache, LoadOptions, Loaded, MAX_SAMPLES, MAX_SIDE, ViewOverride};

use crate::args::{self, Report};
use crate::failure::Failure;
use crate::live::Watch;
use crate::output::is_among;
use crate::report;
use crate::source::{load_watched, replace_samples};
use crate::verify::files::beside;
use crate::view::editor::Editor;
use crate::view::engine::opened::Opened;
use crate::view::engine::pace::Pace;
use crate::view::messages::{News, Request, SetView};
use crate::view::outbox::Topic;
use crate::view::reference::{Comparer, References, Shared};
use crate::view::write::{History, Shown, Unsaved};

/// The time between two looks at the files while there is nothing to do.
const IDLE: Duration = Duration::from_millis(50);
/// The camera rests if it has not moved for so long.
const REST: Duration = Duration::from_millis(60);
/// The camera rests if it has not moved for so long, where the world has to be prepared again: nothing can interrupt that.
const LONG_REST: Duration = Duration::from_millis(500);

/// How far the picture of a view is.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// There is none: a small one comes first.
    New,
    /// It is small.
    Small,
    Finished,
}

/// Renders the newest view.
pub struct Engine {
    shared: Arc<Shared>,
    editor: Option<Editor>,
    path: PathBuf,
    options: LoadOptions,
    samples_per_pixel: Option<u32>,
    watch: Watch,
    /// What the last load has read.
    cache: LoadCache,
    /// The last file without errors.
    opened: Option<Opened>,
    /// The errors of the file since then.
    error: Option<String>,
    /// Counts how often a scene without errors has been read.
    reading: u32,
    /// The changes of parameters.
    unsaved: Unsaved,
    has_lost: bool,
    /// What the page sets of its camera.
    set: SetView,
    history: History,
    shown: Mutex<Shown>,
    pace: Pace,
    stage: Stage,
    /// When the last small picture was shown.
    small_at: Instant,
    /// Counts the views.
    generation: u32,
    /// Whether pictures have error layers, and why not.
    has_errors: bool,
    errors_refused: Option<String>,
    references: Mutex<References>,
    comparer: Comparer,
}

impl Engine {
    pub fn new(
        arguments: &args::View,
        editor: Option<Editor>,
        shared: Arc<Shared>,
        references: References,
    ) -> Engine {
        let options = LoadOptions { max_memory: arguments.memory.limit(), ..LoadOptions::default() };
        let woken = shared.clone();
        Engine {
            shared,
            editor,
            path: arguments.scene.clone(),
            options,
            samples_per_pixel: None,
            watch: Watch::new(move || woken.requests.wake()),
            cache: LoadCache::default(),
            opened: None,
            error: None,
            reading: 0,
            unsaved: Unsaved::default(),
            has_lost: false,
            set: SetView::default(),
            history: History::default(),
            shown: Mutex::default(),
            pace: Pace::default(),
            stage: Stage::Finished,
            small_at: Instant::now(),
            generation: 0,
            has_errors: false,
            errors_refused: None,
            references: Mutex::new(references),
            comparer: Comparer::new(),
        }
    }

    /// Renders until a signal ends the program.
    pub fn run(mut self) -> ! {
        self.tell_looking();
        self.read();
        for line in self.error.iter().flat_map(|error| error.lines()) {
            crate::say(line);
        }
        loop {
            let requests = self.shared.requests.take(self.free_time());
            // First, because a request may read the scene.
            let has_changed =
                if requests.is_empty() { self.watch.has_changed() } else { self.watch.has_changed_by_now() };
            if has_changed {
                self.watch.settle();
                self.read();
            }
            // A picture comes before its layers.
            let (layers, requests): (Vec<_>, Vec<_>) = requests.into_iter().partition(Request::needs_film);
            for request in requests {
                self.answer(request);
            }
            self.follow_reference();
            if self.stage == Stage::New {
                self.render_small();
                self.advise();
            } else if self.stage == Stage::Small && layers.is_empty() && self.free_time().is_zero() {
                self.render_full();
            }
            for request in layers {
                self.answer(request);
            }
        }
    }

    /// The time until there is something to render.
    fn free_time(&self) -> Duration {
        let rest = match self.stage {
            Stage::New => return Duration::ZERO,
            Stage::Finished => return IDLE,
            Stage::Small if self.opened.as_ref().is_some_and(|it| it.prepared.is_near(&it.view.camera)) => {
                REST
            }
            Stage::Small => LONG_REST,
        };
        rest.saturating_sub(self.small_at.elapsed())
    }

    fn answer(&mut self, request: Request) {
        match request {
            Request::Film { resolution, crop, samples_per_pixel } => {
                self.set_film(resolution, crop, samples_per_pixel);
            }
            Request::View(view) => self.set_view(view),
            Request::Change(change) => self.change(change),
            Request::Edit { by, action } => self.edit(by, action),
            Request::Errors { is_on } => self.set_errors(is_on),
            query => self.answer_query(query),
        }
    }

    fn set_film(
        &mut self,
        resolution: Option<[f64; 2]>,
        crop: Option<[f64; 4]>,
        samples_per_pixel: Option<f64>,
    ) {
        let before = (self.options.film, self.samples_per_pixel);
        let is_count =
            |value: f64, most: u32| value.fract() == 0.0 && (1.0..=f64::from(most)).contains(&value);
        let is_valid = resolution.iter().flatten().all(|side| is_count(*side, MAX_SIDE))
            && samples_per_pixel.is_none_or(|samples| is_count(samples, MAX_SAMPLES));
        let opened = if is_valid {
            let resolution = resolution.map(|sides| sides.map(|side| side as u32));
            self.options.film = FilmOverride { resolution, crop, quarter: false };
            self.samples_per_pixel = samples_per_pixel.map(|samples| samples as u32);
            self.load().and_then(|loaded| self.open(loaded))
        } else {
            Err(format!("resolution is 1 to {MAX_SIDE}, pixelsamples 1 to {MAX_SAMPLES}").into())
        };
        match &opened {
            Ok(()) => self.error = None,
            Err(_) => (self.options.film, self.samples_per_pixel) = before,
        }
        self.tell_scene(opened.err().map(String::from).as_deref());
    }

    fn set_view(&mut self, view: SetView) {
        let Some(opened) = &mut self.opened else { return };
        let view = SetView { camera: opened.rounded(view.camera), ..view };
        let refused = opened.set(&view.camera).err().map(String::from);
        // A page ignores answers to its earlier requests, so the newest one is remembered even if it is refused.
        let camera = if refused.is_none() { view.camera } else { self.set.camera };
        self.set = SetView { camera, ..view };
        if refused.is_none() {
            self.restart();
        }
        self.tell_view(refused.as_deref());
    }

    /// Begins the picture of another view.
    fn restart(&mut self) {
        self.stage = Stage::New;
        self.generation = self.generation.wrapping_add(1);
        self.shared.gallery.clear();
        self.comparer.cancel();
    }

    /// Tells the warnings about what the camera of the file shows. They take longer than a small picture.
    fn advise(&mut self) {
        if self.opened.as_mut().is_some_and(Opened::advise) {
            self.tell_scene(None);
        }
    }

    /// Tells what the file has, and why the film is not the one that was asked for.
    fn tell_scene(&self, film_refused: Option<&str>) {
        let opened = self.opened.as_ref();
        let messages = self.error.as_ref().or(opened.map(|opened| &opened.messages));
        let scene = News::Scene {
            name: &self.path.display().to_string(),
            messages: messages.map_or("", String::as_str),
            has_errors: self.error.is_some(),
            film: opened.map(Opened::film),
            film_refused,
            camera: opened.map(Opened::own),
            can_undo: !self.unsaved.done.is_empty() || !self.history.done.is_empty(),
            can_redo: !self.unsaved.undone.is_empty() || !self.history.undone.is_empty(),
            has_unsaved: !self.unsaved.files.is_empty(),
            has_lost: self.has_lost,
            lights: opened.map_or(Vec::new(), |opened| opened.lights(self.reading)),
            has_editor: self.editor.is_some(),
        };
        self.shared.hub.tell(Topic::Scene, scene);
        self.tell_view(None);
    }

    fn tell_view(&self, refused: Option<&str>) {
        let Some(opened) = &self.opened else { return };
        let SetView { by, number, camera: set } = self.set;
        let camera = opened.values();
        self.shared.hub.tell(Topic::View, News::View { by, number, set, camera, refused });
    }
}

/// A file with errors is read again if it changes within this time: it is just being saved.
const SAVING: Duration = Duration::from_millis(200);
/// The most times that it is read again, so that a file that is written all the time holds up nobody.
const MOST_READINGS: u32 = 10;

impl Engine {
    /// Reads the file.
    pub fn read(&mut self) {
        self.has_lost = self.unsaved.forget_old();
        self.error = self.load().and_then(|loaded| self.open(loaded)).err().map(String::from);
        self.tell_scene(None);
    }

    /// Fails with the errors of the file.
    pub fn load(&mut self) -> Result<Loaded, Failure> {
        let mut loaded = self.load_once();
        for _ in 0..MOST_READINGS {
            let end = Instant::now() + SAVING;
            let has_errors = loaded.scene.is_none() && loaded.override_error.is_none();
            while has_errors && Instant::now() < end && !self.watch.has_changed() {
                std::thread::sleep(Duration::from_millis(20));
            }
            if loaded.scene.is_some() || !self.watch.has_changed() {
                break;
            }
            loaded = self.load_once();
        }
        if loaded.scene.is_none() {
            let override_error = loaded.override_error.as_ref().map(|reason| format!("error: {reason}\n"));
            return Err((report::text(&loaded) + &override_error.unwrap_or_default()).into());
        }
        Ok(loaded)
    }

    pub fn load_once(&mut self) -> Loaded {
        self.watch.restart();
        let Engine { path, options, watch, unsaved, cache, .. } = self;
        let instead = |file: &Path| {
            watch.note(file);
            unsaved.text(file)
        };
        // The stamp of a file says nothing about a text that is not written.
        let stamp = |file: &Path| unsaved.text(file).is_none().then(|| watch.stamp(file)).flatten();
        let mut loaded = load_watched(path, options, Report::default(), &instead, Some((cache, &stamp)));
        replace_samples(&mut loaded, self.samples_per_pixel);
        loaded
    }

    /// Takes a file without errors over. Fails if there is not enough memory.
    pub fn open(&mut self, loaded: Loaded) -> Result<(), Failure> {
        let beside = beside(&self.path).find(|picture| !is_among(picture, &loaded.inputs));
        self.references().beside = beside;
        let film = self.film_windows();
        let opened = Opened::new(loaded, &mut self.opened);
        let mut opened = opened.map_err(|reason| format!("error: {reason}\n"))?;
        // A camera that was written into the file replaces the one that was set by hand.
        if opened.has_new_camera || opened.set(&self.set.camera).is_err() {
            self.set.camera = ViewOverride::default();
        }
        self.opened = Some(opened);
        self.reading = self.reading.wrapping_add(1);
        self.restart();
        if self.film_windows() == film {
            self.tell_looking();
        } else {
            self.show_reference();
        }
        Ok(())
    }
}
