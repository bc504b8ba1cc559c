//! Writes a picture: whole, partial after an interruption, or so far after SIGUSR1.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lookat_render::{Progress, Rendered, Settings};
use lookat_scene::{Camera, Loaded};
use lookat_sight::{Metadata, Numbered};

use crate::args::Render;
use crate::failure::Failure;
use crate::interrupt;
use crate::light::{JsonLight, map_tones};
use crate::output::{Destination, Identity, NewPicture, PARTIAL, free_file, marked};
use crate::part::{About, Provenance};
use crate::render::checkpoint::Checkpoint;

/// Where a picture goes, and what its metadata and the rules about finished pictures need.
pub struct Output<'a> {
    pub arguments: &'a Render,
    pub loaded: &'a Loaded,
    pub camera: &'a Camera,
    pub settings: &'a Settings,
    pub new: NewPicture,
    pub file: PathBuf,
    /// The rendering that this is a part of, if it is to say so.
    pub provenance: Option<Provenance>,
    pub checkpoint: Option<Checkpoint>,
}

/// A written picture.
pub struct Kept {
    pub file: PathBuf,
    pub destination: Destination,
    /// Why the picture is in another file than its own.
    pub kept: Option<String>,
    pub light: Option<JsonLight>,
    pub samples_per_pixel: f64,
}

impl Output<'_> {
    /// The metadata of the picture.
    fn metadata(&self, samples_per_pixel: f64, complete: bool, numbered: Numbered) -> Option<String> {
        let Output { arguments, loaded, camera, settings, .. } = *self;
        let scene_file = &loaded.sources.files[0].path;
        let metadata = Metadata::new(scene_file, camera, arguments.seed, samples_per_pixel);
        metadata.with_settings(settings, complete, numbered).as_json()
    }

    /// The metadata of the whole picture, of all parts. Empty if nothing is kept of it.
    pub fn whole(&self, numbered: Numbered) -> String {
        let samples = self.provenance.as_ref().map(|provenance| provenance.samples_per_pixel.into());
        samples.and_then(|samples| self.metadata(samples, true, numbered)).unwrap_or_default()
    }

    /// Writes a picture, a partial one beside the file of the whole, or as checkpoint.
    pub fn write(&self, rendered: &mut Rendered, numbered: Numbered) -> Result<Kept, Failure> {
        let Output { arguments, loaded, settings, new, .. } = *self;
        let samples_per_pixel =
            rendered.statistics.samples_in_picture as f64 / (new.size[0] as f64 * new.size[1] as f64);
        if let (Some(checkpoint), false) = (&self.checkpoint, rendered.complete)
            && let Some(sums) = rendered.sums.take()
        {
            let whole = self.whole(numbered);
            let (file, destination) =
                checkpoint.write(&mut rendered.image, sums, &rendered.statistics, whole)?;
            return Ok(Kept { file, destination, kept: None, light: None, samples_per_pixel });
        }
        rendered.image.metadata = self.metadata(samples_per_pixel, rendered.complete, numbered.clone());
        let is_part = rendered.complete && (settings.part.is_some() || settings.is_extendable);
        if let (Some(provenance), Some(sums)) = (&self.provenance, rendered.sums.take().filter(|_| is_part)) {
            let all = provenance.samples_per_pixel;
            let ranges = vec![settings.part.map_or(0..all, |part| part.range(all))];
            // An extendable picture is whole by itself.
            let own = rendered.image.metadata.take().filter(|_| settings.part.is_none());
            let whole = own.unwrap_or_else(|| self.whole(numbered));
            About { provenance: provenance.clone(), ranges, complete: true, whole, broken_off: None }
                .put_into(&mut rendered.image, sums);
        }
        let light = map_tones(&mut rendered.image, &self.file, arguments.tone);
        let is_partial = !rendered.complete;
        let file = if is_partial { marked(&self.file, PARTIAL) } else { self.file.clone() };
        let new = NewPicture { samples_per_pixel: Some(samples_per_pixel), is_partial, ..new };
        let (file, kept) = if arguments.force { (file, None) } else { free_file(file, new, &loaded.inputs) };
        let mut destination = Destination::new(file.parent().unwrap_or(Path::new("")));
        let name = file.file_name().unwrap_or_default();
        let file = destination.write(name, |path| rendered.image.write(path))?;
        Ok(Kept { file, destination, kept, light, samples_per_pixel })
    }
}

/// The shortest time between two looks at the film.
const STEP: Duration = Duration::from_millis(100);

/// The pictures that this rendering has written so far.
#[derive(Default)]
pub struct SoFar {
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
                say!("the picture so far follows once each pixel has samples");
            }
            self.waits = true;
            return;
        }
        self.waits = false;
        let written = output.write(&mut rendered, Numbered::default());
        match written.and_then(|kept| kept.destination.result().map(|()| kept)) {
            Ok(Kept { file, samples_per_pixel, .. }) => {
                if !output.arguments.quiet {
                    say!(
                        "{}: the picture so far, {samples_per_pixel:.1} samples per pixel on average",
                        file.display()
                    );
                }
                self.files.retain(|(other, _)| *other != file);
                let identity = Identity::of(&file);
                self.files.push((file, identity));
            }
            Err(message) => say!("warning: {message}"),
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
