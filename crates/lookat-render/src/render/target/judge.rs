//! How exact pixels are, by their replicates and their neighbors.

use glam::Vec3;
use rayon::prelude::*;

use super::Part;
use crate::film::{Area, Film, lock};
use crate::number::luminance;
use crate::render::sample::Seen;
use crate::render::stop::{Estimate, StopRule};

/// A sample is an outlier if it is this many times as bright as the brightest pixel around it.
const OUTLIER: f64 = 20.0;

/// Judges all unfinished pixels, which have `count` samples in each replicate, removes those that are done, and the sources that no
/// unfinished pixel asks for.
pub(super) fn judge(film: &Film, parts: &mut [Part], rule: &StopRule, count: u32) {
    let (reach, sources) = (film.filter.reach(), film.sources());
    let seen = around(&all_seen(film, parts), sources, reach.map(|reach| reach + 1));
    film.tiles.par_iter().zip(&mut *parts).for_each(|(tile, part)| {
        let tile = lock(tile);
        for active in &mut part.active {
            let standard_error = film.error(&tile, active.at).standard_error.into();
            let value = tile.sums[active.at].mean(film.scale());
            let around = seen[sources.index(tile.bounds.place(active.at))];
            active.excess = rule.excess(&Estimate { value, standard_error, count, around });
        }
        part.active.retain(|active| active.excess > 1.0 || active.excess.is_nan());
        part.active.shrink_to_fit();
    });
    let mut is_asked = vec![Seen::NOTHING; sources.size()];
    for (tile, part) in film.tiles.iter().zip(&*parts) {
        let bounds = lock(tile).bounds;
        for active in &part.active {
            is_asked[sources.index(bounds.place(active.at))] = Seen { least: Vec3::ZERO, most: Vec3::ZERO };
        }
    }
    let is_asked = around(&is_asked, sources, reach);
    film.tiles.par_iter().zip(parts).for_each(|(tile, part)| {
        let own = lock(tile).sources;
        let is_asked = |at: &u32| is_asked[sources.index(own.place(*at as usize))] != Seen::NOTHING;
        part.sources.retain(is_asked);
    });
}

/// The bounds of the samples of all sources, row by row.
fn all_seen(film: &Film, parts: &[Part]) -> Vec<Seen> {
    let mut all = vec![Seen::NOTHING; film.sources().size()];
    for (tile, part) in film.tiles.iter().zip(parts) {
        let own = lock(tile).sources;
        own.places().zip(&part.seen).for_each(|(place, seen)| all[film.sources().index(place)] = *seen);
    }
    all
}

/// For each pixel of an area the bounds of those up to so many pixels away, across and down.
fn around(seen: &[Seen], area: Area, [across, down]: [u32; 2]) -> Vec<Seen> {
    let union = |from: &[Seen], at: usize, (place, end, step): (usize, usize, usize), reach: u32| {
        let reach = reach as usize;
        let near = place.saturating_sub(reach)..=(place + reach).min(end - 1);
        near.map(|other| from[at + other * step - place * step]).fold(Seen::NOTHING, Seen::union)
    };
    let (width, height) = (area.width(), area.height());
    let all = 0..seen.len();
    let rows: Vec<Seen> =
        all.clone().into_par_iter().map(|at| union(seen, at, (at % width, width, 1), across)).collect();
    all.into_par_iter().map(|at| union(&rows, at, (at / width, height, width), down)).collect()
}

/// Counts the pixels that had a sample much brighter than the pixels around.
pub(super) fn count_outliers(film: &Film, parts: &[Part]) -> u64 {
    let (crop, sources, seen) = (film.crop(), film.sources(), all_seen(film, parts));
    let bright = |rgb: Vec3| if rgb.is_finite() { luminance(rgb) } else { 0.0 };
    let mut pixels = vec![Seen::NOTHING; crop.size()];
    for tile in &film.tiles {
        let tile = lock(tile);
        for (place, sum) in tile.bounds.places().zip(&tile.sums) {
            let value = Vec3::splat(bright(sum.mean(film.scale()).as_vec3()) as f32);
            pixels[crop.index(place)] = Seen { least: value, most: value };
        }
    }
    let around = around(&pixels, crop, [1, 1]);
    let is_outlier = |(place, around): &([i32; 2], &Seen)| {
        bright(seen[sources.index(*place)].most) > OUTLIER * f64::from(around.most.x.max(0.0))
    };
    crop.places().zip(&around).filter(is_outlier).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbors_are_found() {
        for (width, height, reach) in [(35, 18, [1, 1]), (3, 9, [2, 5]), (2, 2, [0, 3])] {
            let area = Area { x0: -5, y0: 7, x1: width - 5, y1: 7 + height };
            let number = |[x, y]: [i32; 2]| Vec3::new(x as f32, y as f32, 0.0);
            let seen: Vec<Seen> =
                area.places().map(|at| Seen { least: number(at), most: number(at) }).collect();
            for (found, [x, y]) in around(&seen, area, reach).iter().zip(area.places()) {
                let is_near = |[a, b]: &[i32; 2]| a.abs_diff(x) <= reach[0] && b.abs_diff(y) <= reach[1];
                let all = area.places().filter(is_near).map(|at| seen[area.index(at)]);
                assert_eq!(*found, all.fold(Seen::NOTHING, Seen::union));
            }
        }
    }
}
