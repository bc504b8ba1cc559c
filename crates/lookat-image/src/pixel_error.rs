//! The error layers of a picture: how noisy each pixel is.

use crate::{Channel, Image};

/// The noise of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PixelError {
    /// The standard error of red, green and blue, in the unit of the picture: the standard deviation over the replicates,
    /// by the root of their number. Not negative; infinite if there are less than two replicates.
    pub standard_error: [f32; 3],
    /// The number of camera samples.
    pub samples: u32,
    /// The number of independent estimates that the samples were split into.
    pub replicates: u32,
    /// The noise that pixels share with their neighbors. `None`, the default, if each sample counts for one pixel.
    pub shared: Option<Shared>,
}

/// The noise that pixels share because their filter reaches the samples of their neighbors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shared {
    /// The standard errors of the mean of the samples in the pixel itself, without the filter. A mean over many pixels has the error
    /// that independent pixels with these errors would give it.
    pub unfiltered: [f32; 3],
    /// The noise-equivalent area of the filter in pixels, at least 1: the square of its integral over the integral of its square. About
    /// one of so many pixels is independent.
    pub noise_area: f32,
}

/// The channels of the error layers.
const NAMES: [&str; 5] = ["stderr.R", "stderr.G", "stderr.B", "count.samples", "count.replicates"];
/// The channels that hold [`Shared`].
const SHARED_NAMES: [&str; 4] = ["unfiltered.R", "unfiltered.G", "unfiltered.B", "count.noise-area"];

impl Image {
    /// Adds the layers `stderr` (channels R, G and B) and `count` (channels `samples` and `replicates`); where samples are shared, also
    /// `unfiltered` (R, G and B) and the channel `noise-area` of `count`. `errors` has one entry for each pixel of the data window, row
    /// by row.
    pub fn add_errors(&mut self, errors: &[PixelError]) {
        let is_shared = errors.iter().any(|error| error.shared.is_some());
        let names = NAMES.iter().chain(SHARED_NAMES.iter().filter(|_| is_shared));
        let planes = names.enumerate().map(|(i, name)| Channel {
            name: name.to_string(),
            samples: errors.iter().map(|error| error.values()[i]).collect(),
        });
        self.channels.extend(planes);
    }

    /// The error layers of [`Image::add_errors`], or `None` if one of the channels is missing. Impossible values, such as a negative
    /// error, count as infinite errors.
    pub fn errors(&self) -> Option<Vec<PixelError>> {
        let [r, g, b, samples, replicates] = NAMES.map(|name| self.channel(name));
        let (r, g, b, samples, replicates) = (r?, g?, b?, samples?, replicates?);
        let checked = |error: f32| if error >= 0.0 { error } else { f32::INFINITY };
        let [own_r, own_g, own_b, areas] = SHARED_NAMES.map(|name| self.channel(name));
        let shared = |i: usize| {
            let unfiltered = [own_r?[i], own_g?[i], own_b?[i]].map(checked);
            Some(Shared { unfiltered, noise_area: areas?[i].max(1.0) })
        };
        let pixel = |i: usize| PixelError {
            standard_error: [r[i], g[i], b[i]].map(checked),
            // The cast turns NaN and negative numbers into 0.
            samples: samples[i] as u32,
            replicates: replicates[i] as u32,
            shared: shared(i),
        };
        Some((0..r.len()).map(pixel).collect())
    }
}

impl PixelError {
    /// The standard errors that count in a mean over many pixels.
    pub fn of_means(&self) -> [f32; 3] {
        self.shared.map_or(self.standard_error, |shared| shared.unfiltered)
    }

    /// The number of pixels of which about one is independent.
    pub fn noise_area(&self) -> f32 {
        self.shared.map_or(1.0, |shared| shared.noise_area)
    }

    fn values(&self) -> [f32; 9] {
        let [r, g, b] = self.standard_error;
        let ([own_r, own_g, own_b], area) = (self.of_means(), self.noise_area());
        [r, g, b, self.samples as f32, self.replicates as f32, own_r, own_g, own_b, area]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Window;

    #[test]
    fn errors_go_along_in_the_file() {
        let window = Window { x: 3, y: 4, width: 2, height: 1 };
        let mut image = Image::from_rgb(window, window, &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert_eq!(image.errors(), None);
        let shared = Shared { unfiltered: [0.75, 0.5, 0.25], noise_area: 3.5 };
        let errors = [
            PixelError {
                standard_error: [0.5, 0.25, 0.0],
                samples: 100,
                replicates: 16,
                shared: Some(shared),
            },
            PixelError {
                standard_error: [f32::INFINITY; 3],
                samples: 3,
                replicates: 1,
                shared: Some(shared),
            },
        ];
        // Without what is shared, there are no layers of it.
        let alone = errors.map(|error| PixelError { shared: None, ..error });
        let mut other = image.clone();
        other.add_errors(&alone);
        assert_eq!((other.errors().as_deref(), other.channels.len()), (Some(&alone[..]), 8));
        image.add_errors(&errors);
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("a.exr");
        image.write(&file).unwrap();
        let mut back = Image::read(&file).unwrap();
        assert_eq!(back.errors().as_deref(), Some(&errors[..]));
        assert_eq!(back.rgb(), image.rgb());
        // What cannot be is not believed.
        let wrong = back.channels.iter_mut().find(|channel| channel.name == "stderr.R").unwrap();
        wrong.samples = vec![-1.0, f32::NAN];
        assert!(back.errors().unwrap().iter().all(|error| error.standard_error[0] == f32::INFINITY));
    }
}
