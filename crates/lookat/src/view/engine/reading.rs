//! Reading the scene, and taking it over.

use std::path::Path;
use std::time::{Duration, Instant};

use lookat_scene::Loaded;

use super::Engine;
use super::opened::Opened;
use crate::args::Report;
use crate::output::is_among;
use crate::report;
use crate::source::{load_watched, replace_samples};
use crate::verify::beside;
use crate::view::messages::SetCamera;

/// A file with errors is read again if it changes within this time: it is just being saved.
const SAVING: Duration = Duration::from_millis(200);
/// The most times that it is read again, so that a file that is written all the time holds up nobody.
const MOST_READINGS: u32 = 10;

impl Engine {
    /// Reads the file.
    pub(super) fn read(&mut self) {
        self.has_lost = self.unsaved.forget_old();
        self.error = self.load().and_then(|loaded| self.open(loaded)).err();
        self.tell_scene(None);
    }

    /// Fails with the errors of the file.
    pub(super) fn load(&mut self) -> Result<Loaded, String> {
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
            let misfit = loaded.override_error.as_ref().map(|reason| format!("error: {reason}\n"));
            return Err(report::text(&loaded) + &misfit.unwrap_or_default());
        }
        Ok(loaded)
    }

    pub(super) fn load_once(&mut self) -> Loaded {
        self.watch.restart();
        let plain = Report { strict: false, json: false };
        let Engine { path, options, watch, unsaved, cache, .. } = self;
        let instead = |file: &Path| {
            watch.note(file);
            unsaved.text(file)
        };
        // The stamp of a file says nothing about a text that is not written.
        let stamp = |file: &Path| unsaved.text(file).is_none().then(|| watch.stamp(file)).flatten();
        let mut loaded = load_watched(path, options, plain, &instead, Some((cache, &stamp)));
        replace_samples(&mut loaded, self.samples_per_pixel);
        loaded
    }

    /// Takes a file without errors over. Fails if there is not enough memory.
    pub(super) fn open(&mut self, loaded: Loaded) -> Result<(), String> {
        let beside = beside(&self.path).find(|picture| !is_among(picture, &loaded.inputs));
        self.references().offer(beside);
        let film = self.film_windows();
        let opened = Opened::new(loaded, &mut self.opened);
        let mut opened = opened.map_err(|reason| format!("error: {reason}\n"))?;
        // A camera that was written into the file replaces the one that was set by hand.
        if opened.has_new_camera || opened.set(&self.set.camera).is_err() {
            self.set.camera = SetCamera::default();
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
