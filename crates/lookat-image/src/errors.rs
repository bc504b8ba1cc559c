//! The layers of a picture that say how noisy each pixel is.

use crate::{Channel, Image};

/// How well the value of a pixel is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelError {
    /// The standard error of red, green and blue, in the unit of the picture: the standard deviation over the replicates,
    /// by the root of their number. Not negative; infinite if there are less than two replicates.
    pub standard_error: [f32; 3],
    /// Camera samples.
    pub samples: u32,
    /// Independent estimates that the samples were split into.
    pub replicates: u32,
    /// The noise-equivalent area of the filter in pixels: the square of its integral over the integral of its square. The variance of
    /// a mean over many pixels is at most so many times that of independent ones, because neighbors share samples. 1, the default,
    /// for filters of one pixel.
    pub noise_area: f32,
}

impl Default for PixelError {
    fn default() -> Self {
        PixelError { standard_error: [0.0; 3], samples: 0, replicates: 0, noise_area: 1.0 }
    }
}

/// The channels of a picture that hold them.
const NAMES: [&str; 5] = ["stderr.R", "stderr.G", "stderr.B", "count.samples", "count.replicates"];
/// And the one that is left out where it is 1 everywhere.
const NOISE_AREA: &str = "count.noise-area";

impl Image {
    /// Adds the layers `stderr` (channels R, G and B) and `count` (channels `samples` and `replicates`, and `noise-area` where samples
    /// are shared). `errors` has one entry for each pixel of the data window, row by row.
    pub fn add_errors(&mut self, errors: &[PixelError]) {
        let is_shared = errors.iter().any(|error| error.noise_area != 1.0);
        let names = NAMES.iter().chain(is_shared.then_some(&NOISE_AREA));
        let planes = names.enumerate().map(|(i, name)| Channel {
            name: name.to_string(),
            samples: errors.iter().map(|error| error.values()[i]).collect(),
        });
        self.channels.extend(planes);
    }

    /// What [`Image::add_errors`] added, or `None` if one of the channels is missing. Values that cannot be right, such as
    /// a negative error, count as infinite errors.
    pub fn errors(&self) -> Option<Vec<PixelError>> {
        let [r, g, b, samples, replicates] = NAMES.map(|name| self.channel(name));
        let (r, g, b, samples, replicates) = (r?, g?, b?, samples?, replicates?);
        let right = |error: f32| if error >= 0.0 { error } else { f32::INFINITY };
        let area = |area: f32| if area >= 1.0 { area } else { 1.0 };
        let areas = self.channel(NOISE_AREA);
        let pixel = |i: usize| PixelError {
            standard_error: [r[i], g[i], b[i]].map(right),
            // Of what is no number or negative it makes 0.
            samples: samples[i] as u32,
            replicates: replicates[i] as u32,
            noise_area: areas.map_or(1.0, |areas| area(areas[i])),
        };
        Some((0..r.len()).map(pixel).collect())
    }
}

impl PixelError {
    /// Whether the error can be used, and rests on so many samples.
    #[cfg(feature = "compare")]
    pub(crate) fn is_known(&self, samples: u32) -> bool {
        self.replicates >= 2 && self.samples >= samples && self.standard_error.iter().all(|e| e.is_finite())
    }

    fn values(&self) -> [f32; 6] {
        let [r, g, b] = self.standard_error;
        [r, g, b, self.samples as f32, self.replicates as f32, self.noise_area]
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
        let errors = [
            PixelError { standard_error: [0.5, 0.25, 0.0], samples: 100, replicates: 16, noise_area: 3.5 },
            PixelError {
                standard_error: [f32::INFINITY; 3],
                samples: 3,
                replicates: 1,
                ..PixelError::default()
            },
        ];
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
