//! The resolution of pictures that move.

use std::time::Duration;

use lookat_scene::{Film, PixelBounds, View};

/// The time to render a picture, so that 30 appear in a second.
const FRAME: Duration = Duration::from_millis(26);
/// The longer side of a picture is at least so many pixels.
const SHORTEST: f64 = 128.0;
/// The longer side of the first picture, before anything is known of the scene.
const FIRST: f64 = 256.0;

/// How much lower the resolution is: each step halves the number of pixels.
#[derive(Default)]
pub struct Pace(Option<i32>);

impl Pace {
    /// The view in the resolution for which there is time, with one sample per pixel.
    pub fn view(&mut self, view: &View) -> View {
        View { film: self.film(&view.film), sampler: view.sampler.with_samples(1), ..view.clone() }
    }

    /// The film of the next picture.
    fn film(&mut self, film: &Film) -> Film {
        let longer = f64::from(film.crop.width().max(film.crop.height()));
        let steps = |side: f64| (2.0 * (longer / side).log2()).max(0.0);
        let step = self.0.unwrap_or(steps(FIRST).ceil() as i32).clamp(0, steps(SHORTEST).ceil() as i32);
        self.0 = Some(step);
        smaller(film, 0.5_f64.powf(0.5 * f64::from(step)).max(SHORTEST / longer).min(1.0))
    }

    /// Learns how long a picture took.
    pub fn learn(&mut self, took: Duration) {
        let share = took.as_secs_f64() / FRAME.as_secs_f64();
        let change =
            if share > 1.0 { share.log2().ceil() } else { (0.8 / share.max(1e-3)).log2().floor().max(0.0) };
        let change = if share > 1.0 { change } else { -change };
        self.0 = self.0.map(|step| step + change as i32);
    }
}

/// A film of the same picture with fewer pixels.
fn smaller(film: &Film, scale: f64) -> Film {
    if scale == 1.0 {
        return film.clone();
    }
    let side = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).max(1);
    let resolution = film.resolution.map(side);
    let edges = |from: u32, to: u32, axis: usize| {
        let ratio = f64::from(resolution[axis]) / f64::from(film.resolution[axis]);
        let from = ((f64::from(from) * ratio).round() as u32).min(resolution[axis] - 1);
        (from, ((f64::from(to) * ratio).round() as u32).max(from + 1))
    };
    let ((x0, x1), (y0, y1)) = (edges(film.crop.x0, film.crop.x1, 0), edges(film.crop.y0, film.crop.y1, 1));
    Film { resolution, crop: PixelBounds { x0, y0, x1, y1 }, ..film.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_resolution_follows_the_time() {
        let full = Film::new([1024, 512]);
        let mut pace = Pace::default();
        assert_eq!(pace.film(&full).resolution, [256, 128]);
        pace.learn(FRAME / 8);
        assert_eq!(pace.film(&full).resolution, [512, 256]);
        pace.learn(FRAME * 9 / 10);
        assert_eq!(pace.film(&full).resolution, [512, 256]);
        pace.learn(FRAME * 3 / 2);
        assert_eq!(pace.film(&full).resolution, [362, 181]);
        pace.learn(FRAME * 1000);
        assert_eq!(pace.film(&full).resolution, [128, 64]);
        pace.learn(FRAME / 1000);
        assert_eq!(pace.film(&full), full);
        let odd = Film::new([800, 500]);
        pace.learn(FRAME * 1000);
        assert_eq!(pace.film(&odd).resolution, [128, 80]);
        pace.learn(FRAME * 1000);
        assert_eq!(pace.film(&Film::new([60, 40])).resolution, [60, 40]);
    }

    #[test]
    fn crop_windows_shrink_alike() {
        let crop = PixelBounds { x0: 400, y0: 40, x1: 800, y1: 50 };
        let film = Film { crop, ..Film::new([1000, 100]) };
        let small = smaller(&film, 0.25);
        assert_eq!(small.resolution, [250, 25]);
        assert_eq!(small.crop, PixelBounds { x0: 100, y0: 10, x1: 200, y1: 13 });
        assert_eq!(smaller(&film, 1e-9).crop.area(), 1);
    }
}
