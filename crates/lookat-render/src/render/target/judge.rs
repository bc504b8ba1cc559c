//! How exact pixels are, by their replicates and their neighbors.

use std::sync::Mutex;

use glam::Vec3;
use lookat_scene::PixelBounds;
use rayon::prelude::*;

use super::{Active, Part};
use crate::color::luminance;
use crate::film::{Film, Tile, lock, tile_side};
use crate::render::sample::Seen;
use crate::render::stop::{Estimate, StopRule};

/// A sample is an outlier if it is this many times as bright as the brightest pixel around it.
const OUTLIER: f64 = 20.0;

impl Active {
    pub fn new(at: usize) -> Active {
        Active { at, count: 0, replicates: Default::default(), excess: f64::INFINITY }
    }

    /// The error of the pixel over the target error. `around` bounds the samples of the pixel and its neighbors.
    pub fn excess(&self, film: &Film, tile: &Tile, around: Seen, rule: &StopRule) -> f64 {
        if self.count == 0 {
            return f64::INFINITY;
        }
        let standard_error = film.error(tile, self.at).standard_error.into();
        let value = film.value(&tile.pixel(self.at));
        rule.excess(&Estimate { value, standard_error, count: self.count, around })
    }
}

/// Judges all unfinished pixels, and removes the finished pixels from the list.
pub(super) fn judge(film: &Film, parts: &mut [Part], rule: &StopRule) {
    let judge = |index: usize| -> Vec<f64> {
        let tile = lock(&film.tiles[index]);
        let pixels = parts[index].active().iter().map(|active| {
            let around = around(parts, (index, active.at)).map(|(index, at)| parts[index].seen[at]);
            active.excess(film, &tile, around.fold(Seen::NOTHING, Seen::union), rule)
        });
        pixels.collect()
    };
    let judged: Vec<_> = (0..parts.len()).into_par_iter().map(judge).collect();
    parts.par_iter_mut().zip(judged).for_each(|(part, judged)| {
        let Some(all_active) = &mut part.active else { return };
        all_active.iter_mut().zip(judged).for_each(|(active, excess)| active.excess = excess);
        all_active.retain(|active| active.excess > 1.0 || active.excess.is_nan());
        all_active.shrink_to_fit();
    });
}

/// Counts the pixels that had a sample much brighter than the pixels around.
pub(super) fn count_outliers(film: &Film, parts: &[Part]) -> u64 {
    let bright = |rgb: Vec3| if rgb.is_finite() { luminance(rgb) } else { 0.0 };
    let of_tile = |tile: &Mutex<Tile>| -> Vec<f64> {
        lock(tile).pixels().map(|pixel| bright(film.value(&pixel).as_vec3())).collect()
    };
    let luminances: Vec<Vec<f64>> = film.tiles.par_iter().map(of_tile).collect();
    let count = |index: usize| {
        let is_outlier = |at: &usize| {
            let around = around(parts, (index, *at)).map(|(index, at)| luminances[index][at]);
            bright(parts[index].seen[*at].most) > OUTLIER * around.fold(0.0, f64::max)
        };
        (0..parts[index].seen.len()).filter(is_outlier).count() as u64
    };
    (0..parts.len()).into_par_iter().map(count).sum()
}

/// A pixel of a tile, and its up to eight neighbors: their tiles, and their places there.
fn around(parts: &[Part], (index, at): (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    let bounds = parts[index].bounds;
    let (first, last) = (parts[0].bounds, parts[parts.len() - 1].bounds);
    let (x, y) = (bounds.x0 + at as u32 % bounds.width(), bounds.y0 + at as u32 / bounds.width());
    let side = tile_side(PixelBounds { x1: last.x1, y1: last.y1, ..first });
    let across = (last.x0 - first.x0) / side + 1;
    let columns = x.saturating_sub(1).max(first.x0)..=(x + 1).min(last.x1 - 1);
    let rows = y.saturating_sub(1).max(first.y0)..=(y + 1).min(last.y1 - 1);
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y))).map(move |(x, y)| {
        let (column, row) = (x - first.x0, y - first.y0);
        let index = (row / side * across + column / side) as usize;
        (index, (row % side * parts[index].bounds.width() + column % side) as usize)
    })
}

#[cfg(test)]
mod tests {
    use lookat_scene::Filter;

    use super::*;
    use crate::film::{Errors, places};
    use crate::filter::FilterSampler;
    use crate::testing::scene;

    /// `around` finds all neighbors of each pixel, also in other tiles.
    #[test]
    fn neighbors_are_found_across_tiles() {
        let mut of =
            scene("Film \"image\" Camera \"perspective\" WorldBegin Shape \"sphere\" WorldEnd").view.film;
        for (width, height) in [(35, 18), (3, 90), (2, 2)] {
            of.crop = PixelBounds { x0: 5, y0: 7, x1: 5 + width, y1: 7 + height };
            let film = Film::new(&of, &FilterSampler::new(&Filter::BOX), Errors::None);
            let number = |[x, y]: [u32; 2]| Vec3::new(x as f32, y as f32, 0.0);
            let part = |tile: &Mutex<Tile>| {
                let bounds = lock(tile).bounds;
                let seen = places(bounds).map(|at| Seen { least: number(at), most: number(at) });
                Part { bounds, seen: seen.collect(), active: None }
            };
            let parts: Vec<Part> = film.tiles.iter().map(part).collect();
            for (index, part) in parts.iter().enumerate() {
                for (at, [x, y]) in places(part.bounds).enumerate() {
                    let found = around(&parts, (index, at)).map(|(index, at)| parts[index].seen[at].least);
                    let all = places(of.crop).filter(|[a, b]| a.abs_diff(x) <= 1 && b.abs_diff(y) <= 1);
                    assert_eq!(found.collect::<Vec<_>>(), all.map(number).collect::<Vec<Vec3>>());
                }
            }
        }
    }
}
