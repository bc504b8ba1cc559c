//! Renders what the pages ask for, and follows the file.

mod opened;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use lookat_render::{Progress, Settings};
use lookat_scene::{FilmOverride, LoadOptions, Loaded, View};

use super::messages::{self, About, Action, Edit, News, Pick, Picked, SetCamera, SetFilm, SetView, picture};
use super::outbox::{Hub, Kind};
use super::pace::Pace;
use super::requests::{Pending, Requests};
use super::write::{FileChange, History};
use crate::args::{self, Report};
use crate::live::Watch;
use crate::report;
use crate::source::{load_noted, replace_samples};
use opened::Opened;

/// The time between two looks at the files while there is nothing to do.
const IDLE: Duration = Duration::from_millis(50);
/// The camera rests if it has not moved for so long.
const REST: Duration = Duration::from_millis(60);
/// The same where the world has to be prepared again, which nothing can interrupt.
const LONG_REST: Duration = Duration::from_millis(500);
/// A file with errors is read again if it changes within this time: it is just being saved.
const SAVING: Duration = Duration::from_millis(200);
/// The shortest time between two pictures that grow. A picture takes at most a tenth of the time of a thread.
const STEP: Duration = Duration::from_millis(60);

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
    requests: Arc<Requests>,
    hub: Arc<Hub>,
    path: PathBuf,
    options: LoadOptions,
    samples_per_pixel: Option<u32>,
    watch: Watch,
    /// The last file without errors.
    opened: Option<Opened>,
    /// What the page sets of its camera.
    set: SetView,
    history: History,
    /// The changes that a page was shown last, and the page.
    shown: Option<(u32, Vec<FileChange>)>,
    pace: Pace,
    stage: Stage,
    /// Counts the views.
    generation: u32,
}

impl Engine {
    pub fn new(arguments: &args::View, requests: Arc<Requests>, hub: Arc<Hub>) -> Engine {
        let options = LoadOptions { max_memory: arguments.memory.limit(), ..LoadOptions::default() };
        Engine {
            requests,
            hub,
            path: arguments.scene.clone(),
            options,
            samples_per_pixel: None,
            watch: Watch::default(),
            opened: None,
            set: SetView { by: 0, number: 0, camera: SetCamera::default() },
            history: History::default(),
            shown: None,
            pace: Pace::default(),
            stage: Stage::Finished,
            generation: 0,
        }
    }

    /// Renders until a signal ends the program.
    pub fn run(mut self) -> ! {
        self.read();
        loop {
            let time = match self.stage {
                Stage::New => Duration::ZERO,
                Stage::Small if self.opened.as_ref().is_some_and(Opened::is_near) => REST,
                Stage::Small => LONG_REST,
                Stage::Finished => IDLE,
            };
            let pending = self.requests.take(time);
            let is_new = pending.film.is_some() || pending.view.is_some() || pending.pick.is_some();
            self.answer(pending);
            if self.watch.has_changed() {
                self.read();
            } else if self.stage == Stage::New {
                self.render_small();
            } else if self.stage == Stage::Small && !is_new {
                self.render_full();
            }
        }
    }

    fn answer(&mut self, pending: Pending) {
        if let Some(film) = pending.film {
            self.set_film(film);
        }
        if let Some(view) = pending.view {
            self.set_view(view);
        }
        if let Some((pick, opened)) = pending.pick.zip(self.opened.as_ref()) {
            answer(pick, opened, &self.hub);
        }
        for edit in pending.edits {
            self.edit(edit);
        }
    }

    /// Changes the files, or shows what would change.
    fn edit(&mut self, Edit { by, action }: Edit) {
        let done = match action {
            Action::Show => self.show_changes(by),
            Action::Write => {
                let shown = self.shown.take().filter(|(page, _)| *page == by);
                shown.map_or(Err("there is nothing to write".into()), |(_, changes)| {
                    self.history.write(changes)
                })
            }
            Action::Undo => self.history.undo(),
            Action::Redo => self.history.redo(),
        };
        let is_shown = matches!(action, Action::Show) && done.is_ok();
        let lines = self.shown.iter().filter(|_| is_shown).flat_map(|(_, changes)| changes);
        let edited = messages::Edited {
            by,
            lines: lines.map(FileChange::lines).collect(),
            can_undo: self.history.can_undo(),
            can_redo: self.history.can_redo(),
            refused: done.err(),
        };
        if !matches!(action, Action::Show) && edited.refused.is_none() {
            self.read();
        }
        self.hub.tell(Kind::Edited, News::Edited(edited).message());
    }

    fn show_changes(&mut self, by: u32) -> Result<(), String> {
        self.shown = None;
        let opened = self.opened.as_ref().ok_or("no scene has been read yet")?;
        let changes = opened.changes(&self.set.camera)?;
        if changes.is_empty() {
            return Err("the file has this camera already".into());
        }
        self.shown = Some((by, changes));
        Ok(())
    }

    fn set_film(&mut self, SetFilm { resolution, crop, samples_per_pixel }: SetFilm) {
        self.options.film = FilmOverride { resolution, crop, quarter: false };
        self.samples_per_pixel = samples_per_pixel.map(|samples| samples.max(1));
        self.read();
    }

    fn set_view(&mut self, view: SetView) {
        let Some(opened) = &mut self.opened else { return };
        let view = SetView { camera: opened.rounded(view.camera), ..view };
        let refused = opened.set(&view.camera).err();
        if refused.is_none() {
            self.set = view;
            self.restart();
        }
        self.tell_view(view, refused.as_deref());
    }

    /// Begins the picture of another view.
    fn restart(&mut self) {
        self.stage = Stage::New;
        self.generation = self.generation.wrapping_add(1);
    }

    /// Reads the file.
    fn read(&mut self) {
        let loaded = self.load();
        let error = self.open(loaded).err();
        let opened = self.opened.as_ref();
        let messages = error.clone().or(opened.map(Opened::messages)).unwrap_or_default();
        let scene = messages::Scene {
            name: &self.path.display().to_string(),
            messages: &messages,
            has_errors: error.is_some(),
            film: opened.map(Opened::film),
            camera: opened.map(Opened::own),
        };
        self.hub.tell(Kind::Scene, News::Scene(scene).message());
        self.tell_view(self.set, None);
    }

    fn load(&self) -> Loaded {
        loop {
            self.watch.restart();
            let note = |file: &Path| self.watch.note(file);
            let plain = Report { strict: false, json: false };
            let loaded = load_noted(&self.path, &self.options, plain, &note);
            let end = Instant::now() + SAVING;
            while loaded.scene.is_none() && Instant::now() < end && !self.watch.has_changed() {
                std::thread::sleep(Duration::from_millis(20));
            }
            if loaded.scene.is_some() || !self.watch.has_changed() {
                return loaded;
            }
        }
    }

    /// Takes a file over if it has no errors. Fails with its errors.
    fn open(&mut self, mut loaded: Loaded) -> Result<(), String> {
        replace_samples(&mut loaded, self.samples_per_pixel);
        if loaded.scene.is_none() {
            let misfit = loaded.misfit.as_ref().map(|reason| format!("error: {reason}\n"));
            return Err(report::text(&loaded) + &misfit.unwrap_or_default());
        }
        // Gives the memory of the old scene back first.
        let before = self.opened.take().map(|before| before.own_camera());
        let mut opened = Opened::new(loaded, before)?;
        // A camera that was written into the file replaces the one that was set by hand.
        if opened.has_new_camera || opened.set(&self.set.camera).is_err() {
            self.set.camera = SetCamera::default();
        }
        self.opened = Some(opened);
        self.restart();
        Ok(())
    }

    fn tell_view(&self, SetView { by, number, .. }: SetView, refused: Option<&str>) {
        let Some(opened) = &self.opened else { return };
        let (set, camera) = (self.set.camera, opened.values());
        self.hub.tell(Kind::View, News::View(messages::View { by, number, set, camera, refused }).message());
    }

    /// Renders a picture of the resolution for which there is time.
    fn render_small(&mut self) {
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
        if let Some(message) = picture(&rendered.image, about) {
            self.hub.tell(Kind::Picture, message);
        }
        self.stage = Stage::Small;
    }

    /// Renders the picture that `render` makes, until there is something else to do.
    fn render_full(&mut self) {
        let started = Instant::now();
        let about = self.about(started);
        let Some(opened) = &mut self.opened else { return };
        opened.prepared.look(&opened.view.camera);
        let (opened, requests, watch, hub) = (&*opened, &self.requests, &self.watch, &self.hub);
        let area = opened.view.film.crop.area();
        let next = Mutex::new(started + STEP);
        let progress = |progress: Progress| {
            // Another thread does it.
            let Ok(mut next) = next.try_lock() else { return ControlFlow::Continue(()) };
            if let Some(pick) = requests.take_pick() {
                answer(pick, opened, hub);
            }
            if requests.has_any() || watch.has_changed() {
                return ControlFlow::Break(());
            }
            let now = Instant::now();
            // At first, some pixels have no samples.
            if now >= *next && progress.done > area {
                let (done, total, seconds) = (progress.done, progress.total, started.elapsed().as_secs_f64());
                if let Some(message) = picture(&progress.snapshot(), About { done, total, seconds, ..about })
                {
                    hub.tell(Kind::Picture, message);
                }
                *next = Instant::now() + STEP.max(10 * now.elapsed());
            }
            ControlFlow::Continue(())
        };
        let rendered = opened.prepared.render_unmoved(&opened.view, &Settings::default(), &progress);
        if rendered.complete {
            let total = rendered.statistics.samples;
            let about = About { done: total, total, is_final: true, ..self.about(started) };
            if let Some(message) = picture(&rendered.image, about) {
                self.hub.tell(Kind::Picture, message);
            }
            self.stage = Stage::Finished;
        }
    }

    fn about(&self, started: Instant) -> About {
        let (generation, number, seconds) =
            (self.generation, self.set.number, started.elapsed().as_secs_f64());
        About { generation, number, done: 0, total: 0, seconds, is_final: false }
    }
}

/// Tells what the picture shows at a place.
fn answer(Pick { by, number, at }: Pick, opened: &Opened, hub: &Hub) {
    let hit = opened.pick(at);
    hub.tell(Kind::Picked, News::Picked(Picked { by, number, at, hit }).message());
}
