//! The picture of a rendering that goes on, after SIGUSR1.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use lookat_render::Progress;

use super::layers::Numbered;
use super::written::{Kept, Output};
use crate::interrupt;
use crate::output::Identity;

/// The shortest time between two looks at the film.
const STEP: Duration = Duration::from_millis(100);

/// The pictures that this rendering has written so far.
#[derive(Default)]
pub(super) struct SoFar {
    files: Vec<(PathBuf, Option<Identity>)>,
    /// When the film was looked at last.
    looked: Option<Instant>,
    /// True if a picture was asked for before each pixel had a sample.
    waits: bool,
}

impl SoFar {
    /// Writes the picture if a signal asked for it and each pixel has a sample.
    pub fn write_if_asked(&mut self, output: &Output, progress: &Progress) {
        if self.looked.is_some_and(|looked| looked.elapsed() < STEP) || !interrupt::takes_picture() {
            return;
        }
        self.looked = Some(Instant::now());
        let mut rendered = progress.rendered(output.settings.stop.has_error_layers());
        if rendered.statistics.least == 0 {
            interrupt::ask_for_picture();
            if !self.waits && !output.arguments.quiet {
                crate::say("the picture so far follows once each pixel has samples");
            }
            self.waits = true;
            return;
        }
        self.waits = false;
        let written = output.write(&mut rendered, Numbered::default());
        match written.and_then(|kept| kept.destination.result().map(|()| kept)) {
            Ok(Kept { file, samples_per_pixel, .. }) => {
                if !output.arguments.quiet {
                    crate::say(&format!(
                        "{}: the picture so far, {samples_per_pixel:.1} samples per pixel on average",
                        file.display()
                    ));
                }
                self.files.retain(|(other, _)| *other != file);
                let identity = Identity::of(&file);
                self.files.push((file, identity));
            }
            Err(message) => crate::say(&format!("warning: {message}")),
        }
    }

    /// Removes these pictures, except where another program has put a file in their place.
    pub fn remove(self) {
        for (file, identity) in self.files {
            if Identity::of(&file) == identity {
                let _ = std::fs::remove_file(file);
            }
        }
    }
}
