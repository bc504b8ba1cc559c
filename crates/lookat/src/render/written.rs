//! Writes a picture, whole or as far as it is rendered.

use std::path::{Path, PathBuf};

use lookat_render::{Rendered, Settings};
use lookat_scene::{Camera, Loaded};

use super::layers::Numbered;
use super::summary::Metadata;
use crate::args::Render;
use crate::finished::{NewPicture, free_file, marked};
use crate::light::{JsonLight, map_tones};
use crate::output::Destination;

/// The mark of a picture that is not complete, in its name.
pub(super) const PARTIAL: &str = "partial";

/// Where a picture goes, and what its metadata and the rules about finished pictures need.
pub(super) struct Output<'a> {
    pub arguments: &'a Render,
    pub loaded: &'a Loaded,
    pub camera: &'a Camera,
    pub settings: &'a Settings,
    pub new: NewPicture,
    pub file: PathBuf,
}

/// A written picture.
pub(super) struct Kept {
    pub file: PathBuf,
    pub destination: Destination,
    /// Why the picture is in another file than its own.
    pub kept: Option<String>,
    pub light: Option<JsonLight>,
    pub samples_per_pixel: f64,
}

impl Output<'_> {
    /// Writes a picture, a partial one beside the file of the whole.
    pub fn write(&self, rendered: &mut Rendered, numbered: Numbered) -> Result<Kept, String> {
        let Output { arguments, loaded, camera, settings, new, .. } = *self;
        let samples_per_pixel =
            rendered.statistics.samples_in_picture as f64 / (new.size[0] as f64 * new.size[1] as f64);
        let scene_file = &loaded.sources.files[0].path;
        let metadata = Metadata::new(scene_file, camera, arguments.seed, samples_per_pixel);
        let metadata = metadata.with_settings(settings, rendered.complete).with_numbers(numbered);
        rendered.image.metadata = metadata.as_json();
        let light = map_tones(&mut rendered.image, &self.file, arguments.tone);
        let is_partial = !rendered.complete;
        let file = if is_partial { marked(&self.file, PARTIAL) } else { self.file.clone() };
        let new = NewPicture { samples_per_pixel: Some(samples_per_pixel), is_partial, ..new };
        let (file, kept) = match arguments.force {
            true => (file, None),
            false => free_file(file, new, &loaded.inputs),
        };
        let mut destination = Destination::new(file.parent().unwrap_or(Path::new("")));
        let name = file.file_name().unwrap_or_default();
        let file = destination.write(name, |path| rendered.image.write(path))?;
        Ok(Kept { file, destination, kept, light, samples_per_pixel })
    }
}
