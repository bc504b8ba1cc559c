//! The picture that errors are measured by, and how far it can be trusted.

use std::path::PathBuf;

use lookat_image::{AlignError, Image, PixelError, Precision, Window, align};
use lookat_scene::Film;

/// The picture that is taken for the truth.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Linear RGB, row by row.
    pub pixels: Vec<[f32; 3]>,
    /// The root of the mean squared standard error over pixels and channels, in the unit of the picture; `None` if it is
    /// not known. It adds to the squares of all errors, and nothing takes it off.
    pub noise: Option<f64>,
    /// Where it comes from.
    pub origin: Origin,
}

/// A squared error is clear of the noise of the reference if it is at least 11 times as large: noise is then less than 5 % of the
/// error.
pub(super) fn is_clear(square: f64, noise_square: f64) -> bool {
    square >= 11.0 * noise_square
}

impl Reference {
    /// The mean squared noise; 0 if unknown.
    pub(super) fn noise_square(&self) -> f64 {
        self.noise.unwrap_or(0.0).powi(2)
    }
}

/// Where a reference comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Origin {
    /// Rendered for the purpose.
    Rendered {
        /// Samples per pixel.
        samples: u32,
        /// Its seed, that none of the measured pictures has.
        seed: u64,
        /// Wall time in seconds, with preparation.
        seconds: f64,
    },
    /// Read.
    File {
        /// Its name.
        path: PathBuf,
        /// It is stored as integers: rounded, and cut to what a display shows.
        rounded: bool,
    },
}

/// A picture that others are held against, or that is held against one.
#[derive(Debug)]
pub struct Fitted {
    /// Linear RGB, row by row.
    pub pixels: Vec<[f32; 3]>,
    /// As [`Reference::noise`].
    pub noise: Option<f64>,
    /// It is stored as integers.
    pub rounded: bool,
}

/// The reason why a picture does not fit a film. The text completes a sentence about the picture.
#[derive(Debug, thiserror::Error)]
pub enum Unfit {
    /// It has another size. The second one is that of the scene, the third that of the rendered part.
    #[error("has {} x {} pixels, but the scene has {} x {}{}", .0[0], .0[1], .1[0], .1[1], part(.1, .2))]
    Size([u32; 2], [u32; 2], [u32; 2]),
    /// It has other pixels than the scene renders.
    #[error("has the pixels {}, the scene renders {}", edges(.0), edges(.1))]
    Window(Window, Window),
    /// It has no colors.
    #[error("has neither the channels R, G and B nor Y")]
    Channels,
    /// It has no pixel in common with the film.
    #[error("does not fit the scene: {0}")]
    Apart(AlignError),
    /// So many of its pixels are infinite or not a number.
    #[error("has pixels that are infinite or not a number: {0}")]
    NotFinite(usize),
}

/// What of the scene is rendered, if that is not all.
fn part(whole: &[u32; 2], rendered: &[u32; 2]) -> String {
    let [width, height] = rendered;
    if whole == rendered { String::new() } else { format!(", of which {width} x {height} are rendered") }
}

fn edges(Window { x, y, width, height }: &Window) -> String {
    format!("{width} x {height} from ({x}, {y})")
}

/// The colors of a picture of exactly the pixels of a film.
///
/// # Errors
///
/// If the picture is of another size or crop window, has no colors, or values that are infinite or not a number.
pub fn fitted(image: &Image, film: &Film) -> Result<Fitted, Unfit> {
    let crop = film.crop;
    let [width, height] = film.resolution;
    let window = Window { x: crop.x0 as i32, y: crop.y0 as i32, width: crop.width(), height: crop.height() };
    let blank = vec![[0.0; 3]; crop.area() as usize];
    let blank = Image::from_rgb(window, Window { x: 0, y: 0, width, height }, &blank);
    let pair = align(image, &blank).map_err(|error| match error {
        AlignError::Size(size, _) => Unfit::Size(size, film.resolution, window.size()),
        AlignError::Channels(..) => Unfit::Channels,
        AlignError::Apart => Unfit::Apart(error),
    })?;
    if pair.left_out > 0 {
        return Err(Unfit::Window(image.data_window, window));
    }
    let broken = pair.actual.iter().filter(|pixel| pixel.iter().any(|value| !value.is_finite())).count();
    if broken > 0 {
        return Err(Unfit::NotFinite(broken));
    }
    let noise = pair.actual_errors.as_deref().and_then(noise);
    Ok(Fitted { pixels: pair.actual, noise, rounded: image.precision == Precision::Integer })
}

/// The root of the mean squared standard error; `None` where that of a pixel is unknown.
pub(super) fn noise(errors: &[PixelError]) -> Option<f64> {
    let squares = errors.iter().flat_map(|error| error.standard_error).map(|error| f64::from(error).powi(2));
    let root = (squares.sum::<f64>() / (3 * errors.len().max(1)) as f64).sqrt();
    root.is_finite().then_some(root)
}

#[cfg(test)]
mod tests {
    use lookat_scene::PixelBounds;

    use super::*;

    #[test]
    fn pictures_fit_their_film_or_are_refused() {
        let film = Film { crop: PixelBounds { x0: 1, y0: 0, x1: 3, y1: 3 }, ..Film::new([4, 3]) };
        let display = Window { x: 0, y: 0, width: 4, height: 3 };
        let part = Window { x: 1, y: 0, width: 2, height: 3 };
        let mut image = Image::from_rgb(part, display, &[[0.5; 3]; 6]);
        let fits = fitted(&image, &film).unwrap();
        assert_eq!((fits.pixels.len(), fits.noise, fits.rounded), (6, None, false));
        let error = |standard_error| PixelError {
            standard_error,
            samples: 16,
            replicates: 16,
            ..PixelError::default()
        };
        image.add_errors(&[[error([3.0; 3]); 3], [error([4.0; 3]); 3]].concat());
        assert_eq!(fitted(&image, &film).unwrap().noise, Some(12.5_f64.sqrt()));
        // The crop window alone, as formats other than .exr have it.
        let alone = Window { x: 0, y: 0, ..part };
        let plain = Image { has_windows: false, ..Image::from_rgb(alone, alone, &[[0.5; 3]; 6]) };
        assert_eq!(fitted(&plain, &film).unwrap().pixels.len(), 6);
        let refused = |image: &Image| fitted(image, &film).unwrap_err().to_string();
        let whole = Image::from_rgb(display, display, &[[0.5; 3]; 12]);
        assert_eq!(refused(&whole), "has the pixels 4 x 3 from (0, 0), the scene renders 2 x 3 from (1, 0)");
        let other = Window { width: 5, ..display };
        assert_eq!(
            refused(&Image::from_rgb(part, other, &[[0.5; 3]; 6])),
            "has 5 x 3 pixels, but the scene has 4 x 3, of which 2 x 3 are rendered"
        );
        let mut depth = Image::from_rgb(part, display, &[[0.5; 3]; 6]);
        depth.channels.iter_mut().for_each(|channel| channel.name += "2");
        assert_eq!(refused(&depth), "has neither the channels R, G and B nor Y");
        let broken = Image::from_rgb(part, display, &[[f32::NAN; 3]; 6]);
        assert_eq!(refused(&broken), "has pixels that are infinite or not a number: 6");
    }
}
