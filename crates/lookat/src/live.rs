//! A picture shown while it is rendered: in the terminal, in the viewer tev, and again after each change of its files.

mod drawing;
mod protocol;
mod sixel;
mod terminal;
mod tev;
mod watch;

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use lookat_image::Image;
use lookat_render::Progress;

use crate::args::LiveView;
use crate::interrupt;
use terminal::Terminal;
use tev::Tev;
pub use watch::Watch;

/// The shortest time between two updates. The picture takes at most a tenth of the time of a thread.
const STEP: Duration = Duration::from_millis(250);

/// Where the picture is shown.
pub struct Live {
    views: Mutex<Views>,
    /// The files of the scene, with `--watch`.
    pub watch: Option<Watch>,
}

struct Views {
    terminal: Option<Terminal>,
    tev: Option<Tev>,
    next: Instant,
}

impl Live {
    /// Fails without a terminal for `--show`.
    pub fn new(arguments: &LiveView) -> Result<Live, String> {
        let terminal = arguments.show.map(Terminal::new).transpose()?;
        let tev = arguments.tev.as_deref().and_then(Tev::connect);
        let views = Views { terminal, tev, next: Instant::now() };
        Ok(Live { views: Mutex::new(views), watch: arguments.watch.then(|| Watch::new(|| ())) })
    }

    /// Begins a picture of this file and size.
    pub fn begin(&self, file: &Path, size: [u32; 2]) {
        let Ok(mut views) = self.views.lock() else { return };
        views.next = Instant::now() + STEP;
        views.terminal.iter_mut().for_each(Terminal::begin);
        views.on_tev(|tev| tev.begin(file, size));
    }

    /// Shows the picture so far, a few times per second.
    pub fn update(&self, progress: &Progress, bar: &ProgressBar) {
        // Another thread is showing the picture.
        let Ok(mut views) = self.views.try_lock() else { return };
        let started = Instant::now();
        if !views.is_used() || started < views.next || interrupt::flow().is_break() {
            return;
        }
        let image = progress.snapshot();
        bar.suspend(|| views.show(&image));
        views.next = Instant::now() + STEP.max(10 * started.elapsed());
    }

    /// Shows the finished picture.
    pub fn finish(&self, image: &Image) {
        if let Ok(mut views) = self.views.lock()
            && views.is_used()
            && interrupt::flow().is_continue()
        {
            views.show(image);
        }
    }

    /// Tells the rendering to stop after a signal, or after a change of its files.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.is_outdated() { ControlFlow::Break(()) } else { interrupt::flow() }
    }

    /// True if a file of the scene has changed since it was read.
    pub fn is_outdated(&self) -> bool {
        self.watch.as_ref().is_some_and(Watch::has_changed)
    }
}

impl Views {
    fn is_used(&self) -> bool {
        self.terminal.is_some() || self.tev.is_some()
    }

    fn show(&mut self, image: &Image) {
        self.terminal.iter_mut().for_each(|terminal| terminal.show(image));
        self.on_tev(|tev| tev.update(image));
    }

    /// Does something with tev. Warns and goes on without it if that fails.
    fn on_tev(&mut self, act: impl FnOnce(&mut Tev) -> Result<(), String>) {
        if let Some(Err(warning)) = self.tev.as_mut().map(act) {
            self.tev = None;
            // The message moves the lines of the terminal.
            self.terminal.iter_mut().for_each(Terminal::begin);
            crate::say(&warning);
        }
    }
}
