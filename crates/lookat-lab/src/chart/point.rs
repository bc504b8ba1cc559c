//! Single pictures, what the pictures of all seeds say together, and the results of other renderers.

use lookat_image::{Means, means};

use super::estimate::{Estimate, mean, median, positive_mean};
use super::level::Level;
use super::reference::{Fitted, Reference};

/// One picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Picture {
    /// Which of the methods.
    pub method: usize,
    /// Samples per pixel that were asked for.
    pub rung: u32,
    /// Samples per pixel that were taken.
    pub samples: f64,
    /// Chose the random numbers.
    pub seed: u64,
    /// Wall time of rendering.
    pub seconds: f64,
    /// Wall time of what comes before the first sample, in seconds.
    pub preparation: f64,
    /// Its errors.
    pub means: Means,
}

/// The pictures of one method and number of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Samples per pixel that were asked for.
    pub rung: u32,
    /// Samples per pixel that were taken, the mean over the seeds.
    pub samples: f64,
    /// The median over the seeds.
    pub seconds: Estimate,
    /// The root of the mean over the seeds of the squared error.
    pub rmse: Estimate,
    /// The mean over the seeds.
    pub relative_mse: Estimate,
    /// The mean over the seeds of the mean signed error; the reference has one too, which this interval does not hold.
    pub error: Estimate,
    /// The part of the squared error that is the same for all seeds.
    pub level: Level,
    /// The squared errors of the seeds.
    pub(super) squares: Vec<f64>,
}

impl Point {
    /// Of the rows of one method and number of samples.
    pub(super) fn new(rows: &[Picture], level: Level) -> Point {
        let all = |value: fn(&Picture) -> f64| rows.iter().map(value).collect::<Vec<f64>>();
        let squares = all(|row| row.means.rmse * row.means.rmse);
        Point {
            rung: rows[0].rung,
            samples: all(|row| row.samples).iter().sum::<f64>() / rows.len() as f64,
            seconds: median(&all(|row| row.seconds)),
            rmse: positive_mean(&squares).map(f64::sqrt),
            relative_mse: positive_mean(&all(|row| row.means.relative_mse)),
            error: mean(&all(|row| row.means.error)),
            level,
            squares,
        }
    }

    /// The squared error.
    pub(super) fn square(&self) -> f64 {
        self.rmse.value.powi(2)
    }
}

/// What another renderer has reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Its name.
    pub name: String,
    /// The wall time that it was given with, in seconds.
    pub seconds: f64,
    /// The errors of its picture.
    pub means: Means,
    /// Its picture is stored as integers: rounded, and cut to what a display shows.
    pub rounded: bool,
}

impl Marker {
    /// Measures a picture.
    pub fn new(name: &str, seconds: f64, picture: &Fitted, reference: &Reference) -> Marker {
        let means = means(&picture.pixels, &reference.pixels);
        Marker { name: name.into(), seconds, means, rounded: picture.rounded }
    }
}
