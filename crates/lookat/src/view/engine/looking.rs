//! The error map and the reference.

use std::sync::MutexGuard;

use lookat_image::{Image, Window, luminance};
use lookat_render::{DARK, Settings, Stop};
use lookat_scene::{Film, PixelBounds};

use super::Engine;
use crate::lock::lock;
use crate::view::messages::{About, Content, Looking, News, ReferenceFrom, SetErrors, SetReference, pixels};
use crate::view::outbox::Kind;
use crate::view::reference::{References, over};

impl Engine {
    /// How the picture is rendered.
    pub(super) fn settings(&self) -> Settings {
        Settings { stop: Stop::Samples { error_layers: self.has_errors }, ..Settings::default() }
    }

    /// Renders the picture again, with or without error layers.
    pub(super) fn set_errors(&mut self, SetErrors { is_on }: SetErrors) {
        let samples = self.opened.as_ref().map_or(u32::MAX, |opened| opened.view.sampler.samples_per_pixel);
        let checked = if is_on { crate::render::check_error_layers(samples) } else { Ok(()) };
        let is_on = is_on && checked.is_ok();
        if is_on != self.has_errors && self.opened.is_some() {
            self.restart();
        }
        self.has_errors = is_on;
        self.hub.take_back(Kind::Errors);
        self.errors_refused = checked.err();
        self.tell_looking();
    }

    pub(super) fn references(&self) -> MutexGuard<'_, References> {
        lock(&self.references)
    }

    pub(super) fn set_reference(&self, SetReference { from }: SetReference) {
        let mut references = self.references();
        match (from, self.gallery.newest()) {
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
    pub(super) fn follow_reference(&self) {
        if self.references().has_changed() {
            self.references().read();
            self.show_reference();
        }
    }

    /// Data window and display window of the picture.
    pub(super) fn film_windows(&self) -> Option<[Window; 2]> {
        self.opened.as_ref().map(|opened| windows(&opened.view.film))
    }

    /// Shows the reference to the pages, and compares the picture with it.
    pub(super) fn show_reference(&self) {
        let film = self.film_windows();
        self.comparer.cancel();
        let mut references = self.references();
        self.hub.take_back(Kind::Reference);
        self.hub.take_back(Kind::Compared);
        (references.is_shown, references.misfit) = (false, None);
        if let (Some(reference), Some([data, display])) = (&references.current, film) {
            match over(&reference.image, data, display) {
                Ok(values) => {
                    let about = About { content: Content::Reference, ..self.about() };
                    self.hub.tell(Kind::Reference, pixels(data.size(), &values, about));
                    references.is_shown = true;
                }
                Err(reason) => references.misfit = Some(reason),
            }
        }
        drop(references);
        self.tell_looking();
        self.compare();
    }

    pub(super) fn tell_looking(&self) {
        let references = self.references();
        let looking = Looking {
            has_errors: self.has_errors,
            errors_refused: self.errors_refused.as_deref(),
            reference: references.current.as_ref().map(|reference| &*reference.name),
            is_shown: references.is_shown,
            reference_refused: references.misfit.as_deref().or(references.refused.as_deref()),
            file: references.file().map(|file| file.display().to_string()),
        };
        self.hub.tell(Kind::Looking, News::Looking(looking).message());
    }

    /// Compares the finished picture with the reference.
    pub(super) fn compare(&self) {
        self.comparer.cancel();
        let references = self.references();
        let (Some(reference), Some(picture)) = (&references.current, self.gallery.finished()) else { return };
        let pictures = [("picture".into(), picture), (reference.name.clone(), reference.image.clone())];
        let hub = self.hub.clone();
        let tell = move |compared| hub.tell(Kind::Compared, News::Compared(compared).message());
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
