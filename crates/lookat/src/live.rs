//! A picture shown while it is rendered: in the terminal, in the viewer tev, and again after each change of its files.

pub mod drawing;
mod protocol;
mod sixel;
mod terminal;
mod tev;
mod watch;

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use lookat_image::Image;
use lookat_render::Progress;

use crate::args::{LiveView, Tone};
use crate::lock::lock;
use crate::{interrupt, standard_error};
use terminal::Terminal;
use tev::Tev;
pub use watch::Watch;

/// The shortest time between two updates. The picture takes at most a tenth of the time of a thread.
const STEP: Duration = Duration::from_millis(250);

/// Where the picture is shown.
pub struct Live {
    views: Mutex<Views>,
    tone: Tone,
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
    pub fn new(arguments: &LiveView, tone: Tone) -> Result<Live, String> {
        let terminal = arguments.show.map(Terminal::new).transpose()?;
        let tev = arguments.tev.as_deref().and_then(Tev::connect);
        let views = Mutex::new(Views { terminal, tev, next: Instant::now() });
        Ok(Live { views, tone, watch: arguments.watch.then(|| Watch::new(|| ())) })
    }

    /// Begins a picture of this file and size.
    pub fn begin(&self, file: &Path, size: [u32; 2]) {
        let mut views = lock(&self.views);
        views.next = Instant::now() + STEP;
        views.terminal.iter_mut().for_each(Terminal::begin);
        views.tev.iter_mut().for_each(|tev| tev.begin(file, size));
    }

    /// Shows the picture so far, a few times per second, where the one before is shown.
    pub fn update(&self, progress: &Progress) {
        // Another thread is showing the picture.
        let Ok(mut views) = self.views.try_lock() else { return };
        let started = Instant::now();
        if started < views.next || !views.any_is_idle() || interrupt::flow().is_break() {
            return;
        }
        views.show(progress.snapshot(), self.tone);
        views.next = Instant::now() + STEP.max(10 * started.elapsed());
    }

    /// Shows the finished picture.
    pub fn finish(&self, image: &Image) {
        let views = lock(&self.views);
        if views.is_used() && interrupt::flow().is_continue() {
            views.show(image.clone(), self.tone);
        }
    }

    /// Waits until the picture is shown, unless its viewer does not read.
    pub fn wait(&self) {
        crate::wait_for_messages();
        lock(&self.views).tev.iter().for_each(Tev::wait);
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

    /// True if a view would show a picture at once.
    fn any_is_idle(&self) -> bool {
        self.terminal.is_some() && standard_error::is_idle() || self.tev.as_ref().is_some_and(Tev::is_idle)
    }

    /// Shows the picture with the exposure and the tone curve of an 8-bit file.
    fn show(&self, mut image: Image, tone: Tone) {
        tone.mapping(&image).apply(&mut image);
        self.terminal.iter().for_each(|terminal| terminal.show(&image));
        self.tev.iter().for_each(|tev| tev.show(&image));
    }
}
