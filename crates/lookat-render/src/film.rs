//! The film: exact sums of weighted samples in tiles of pixels. Samples count for all pixels that the filter reaches. One thread
//! collects the samples of a tile in an image block of its own, and then adds them to the tiles around.

#[cfg(test)]
mod tests;

pub(crate) mod area;
mod channels;
mod develop;
pub(crate) mod film_sums;
pub(crate) mod image_block;
pub(crate) mod spread;
pub(crate) mod sum;
pub(crate) mod tile;

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, RwLock, RwLockReadGuard};

use glam::{DVec2, DVec3, Vec3};
use lookat_image::{Image, PixelError};
use lookat_scene::View;

pub(crate) use crate::film::area::Area;
pub use crate::film::channels::SumsHeader;
use crate::film::develop::Developer;
pub use crate::film::film_sums::{FilmSums, FilmSumsError};
pub(crate) use crate::film::film_sums::{PolicyState, PolicyStates};
pub(crate) use crate::film::image_block::ImageBlock;
pub(crate) use crate::film::spread::Spread;
use crate::film::sum::PixelSums;
pub(crate) use crate::film::sum::{Scale, Sum};
pub(crate) use crate::film::tile::Tile;
use crate::filter::PixelFilter;
use crate::number::luminance;

/// Replicates of each pixel when its error is asked for: with 16 of them intervals by Student's t hold what they promise,
/// with 4 and 8 they do not.
pub const REPLICATES: u32 = 16;

/// The picture while it is rendered.
#[derive(Debug)]
pub(crate) struct Film<'v> {
    pub settings: &'v lookat_scene::Film,
    pub filter: PixelFilter,
    view_filter: lookat_scene::Filter,
    pub keeps: Keeps,
    /// Pixels on a side of the tiles.
    side: i32,
    /// The scale of the sums, which is for a brightness of 1 until it is set.
    scale: OnceLock<Scale>,
    light_paths: AtomicU64,
    /// The replicate that samples belong to, if the film keeps sums of replicates.
    replicate: AtomicUsize,
    /// True if sums are to hold what the policy knows, for going on after a break.
    pub keeps_policy: bool,
    /// What the policy knows, once it has begun.
    pub policy_states: OnceLock<Arc<dyn PolicyStates>>,
    /// Held for reading while samples are added, and for writing while there must be none that is added by half.
    adding: RwLock<()>,
    /// Row by row. Threads add to them, and take snapshots of them, at any time: a thread locks one tile, and neither takes samples nor
    /// calls back while it does.
    pub tiles: Vec<Mutex<Tile>>,
}

/// The data that the film keeps beside the sums of all samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Keeps {
    /// Nothing.
    Sums,
    /// The sums of each pass over the picture, until they are merged.
    Passes,
    /// The sums of passes, and the variance between replicates.
    Spreads,
    /// The sums of each replicate.
    Replicates,
}

impl Keeps {
    /// True if the error of pixels is known.
    fn has_errors(self) -> bool {
        matches!(self, Keeps::Spreads | Keeps::Replicates)
    }
}

impl<'v> Film<'v> {
    /// A film without samples: black. `keeps_policy`: see [`Film::keeps_policy`].
    pub fn new(view: &'v View, keeps: Keeps, keeps_policy: bool) -> Self {
        let filter = PixelFilter::new(&view.filter);
        let crop = Area::of(view.film.crop);
        let mut film = Film {
            settings: &view.film,
            filter,
            view_filter: view.filter,
            keeps,
            side: area::tile_side(crop),
            scale: OnceLock::new(),
            light_paths: AtomicU64::new(0),
            replicate: AtomicUsize::new(0),
            keeps_policy,
            policy_states: OnceLock::new(),
            adding: RwLock::new(()),
            tiles: Vec::new(),
        };
        let tile = |sources: Area| {
            Mutex::new(Tile::new(sources.intersection(crop), sources, keeps, film.has_unfiltered()))
        };
        film.tiles = area::tiles(film.sources(), film.side).map(tile).collect();
        film
    }

    /// True if samples are also added up without the filter, for errors.
    pub fn has_unfiltered(&self) -> bool {
        self.keeps.has_errors() && self.view_filter.shares_samples()
    }

    /// Sets the replicate that the next samples belong to.
    pub fn begin_replicate(&self, replicate: usize) {
        self.replicate.store(replicate, Ordering::Relaxed);
    }

    /// To hold while samples are added and noted: sums of the film have all of them or none.
    pub fn adding(&self) -> RwLockReadGuard<'_, ()> {
        self.adding.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The pixels of the picture.
    pub fn crop(&self) -> Area {
        Area::of(self.settings.crop)
    }

    /// The pixels in which samples are taken.
    pub fn sources(&self) -> Area {
        self.crop().grown(self.filter.reach())
    }

    /// The scale of all sums.
    pub fn scale(&self) -> Scale {
        *self.scale.get().unwrap_or(&Scale::ONE)
    }

    /// True if the scale is known.
    pub fn is_exposed(&self) -> bool {
        self.scale.get().is_some()
    }

    /// Sets the scale, before there are samples.
    pub fn set_scale(&self, scale: Scale) {
        let _ = self.scale.set(scale);
    }

    /// Adds the samples of an image block, under the lock of [`Film::adding`].
    pub fn add(&self, samples: &mut ImageBlock, _adding: &RwLockReadGuard<()>) {
        samples.carry();
        let ImageBlock { area, reached, carried, counts: more, unfiltered_carried, .. } = samples;
        let replicate = self.replicate.load(Ordering::Relaxed);
        for at in self.tiles_of(*reached) {
            let Tile { bounds, sources, counts, sums, pass, replicates, .. } = &mut *lock(&self.tiles[at]);
            let pass = replicates.get_mut(replicate).unwrap_or(pass);
            if self.keeps == Keeps::Replicates && pass.filtered.is_empty() {
                *pass = PixelSums::new(bounds.size(), self.has_unfiltered());
            }
            let into = if pass.filtered.is_empty() { sums } else { &mut pass.filtered };
            let part = reached.intersection(*bounds);
            for y in (part.y0..part.y1).filter(|_| part.width() > 0) {
                let (own, from) = (bounds.index([part.x0, y]), reached.index([part.x0, y]));
                for (into, sum) in into[own..][..part.width()].iter_mut().zip(&carried[from..]) {
                    *into += *sum;
                }
            }
            for pixel in sources.intersection(*area).pixels() {
                let at = area.index(pixel);
                counts[sources.index(pixel)] += more[at];
                if let (true, Some(sum)) = (bounds.contains(pixel), unfiltered_carried.get(at)) {
                    pass.unfiltered[bounds.index(pixel)] += *sum;
                }
            }
        }
    }

    /// Adds light that a path from a light brings to a position on the film, in pixels, to the pixels that the filter reaches. The integral
    /// of what it gives is the value, so that it joins what the samples of the pixels bring; the pixels that they become are divided by the
    /// number of [light paths](Film::add_light_paths). From any thread, and exact in any order. False, without adding it, if the value is
    /// infinite or not a number.
    #[cfg_attr(not(test), expect(dead_code, reason = "paths from lights are to use it"))]
    pub fn add_splat(&self, position: DVec2, value: Vec3) -> bool {
        if !value.is_finite() || !position.is_finite() {
            return false;
        }
        let value = self.limited(value) / self.filter.integral() as f32;
        let value = self.scale().clamped(value);
        let corner = position.floor();
        let [x, y] = corner.as_ivec2().to_array();
        if !self.sources().contains([x, y]) {
            return true;
        }
        let reached = Area { x0: x, y0: y, x1: x + 1, y1: y + 1 }.grown(self.filter.reach());
        let mut weights = Default::default();
        self.filter.weigh(position - corner, &mut weights);
        let _adding = self.adding();
        for at in self.tiles_of(reached) {
            let Tile { bounds, splats, .. } = &mut *lock(&self.tiles[at]);
            splats.resize(bounds.size(), Sum::default());
            for pixel in bounds.intersection(reached).pixels() {
                let weight = weights[0][(pixel[0] - reached.x0) as usize]
                    * weights[1][(pixel[1] - reached.y0) as usize];
                let light = self.scale().units((value * weight).extend(0.0));
                splats[bounds.index(pixel)] += Sum::new(light);
            }
        }
        true
    }

    /// Counts light paths, whether they have brought splats or not.
    #[cfg_attr(not(test), expect(dead_code, reason = "paths from lights are to use it"))]
    pub fn add_light_paths(&self, more: u64) {
        self.light_paths.fetch_add(more, Ordering::Relaxed);
    }

    fn light_paths(&self) -> u64 {
        self.light_paths.load(Ordering::Relaxed)
    }

    /// The numbers of the tiles that an area has pixels or sources of.
    fn tiles_of(&self, area: Area) -> impl Iterator<Item = usize> + use<> {
        let (side, all) = (self.side, self.sources());
        let squares = area.intersection(all).squares(side);
        squares.map(move |square| all.square_of(side, [square.x0, square.y0]))
    }

    fn developer(&self) -> Developer<'_> {
        Developer {
            film: self.settings,
            noise_area: noise_area(&self.view_filter, &self.filter),
            light_paths: self.light_paths(),
            scale: self.scale(),
        }
    }

    /// The values of the pixels so far, tile by tile.
    pub fn values(&self) -> impl Iterator<Item = DVec3> {
        let developer = self.developer();
        let of_tile = move |tile: &Mutex<Tile>| {
            let tile = lock(tile);
            (0..tile.bounds.size()).map(|at| developer.value(&tile, at)).collect::<Vec<_>>()
        };
        self.tiles.iter().flat_map(of_tile)
    }

    /// A sample no brighter than the film allows.
    #[inline(always)]
    pub fn limited(&self, radiance: Vec3) -> Vec3 {
        let brightness = luminance(radiance);
        if brightness <= self.settings.max_sample_luminance {
            return radiance;
        }
        radiance * (self.settings.max_sample_luminance / brightness) as f32
    }

    /// The picture so far; `with_errors` adds the layers of its error if there are spreads.
    pub fn develop(&self, with_errors: bool) -> Image {
        self.developer().image(self.tiles.iter().map(lock), with_errors)
    }
}

/// The noise-equivalent area of a filter. `None` if each sample counts for one pixel.
fn noise_area(filter: &lookat_scene::Filter, weights: &PixelFilter) -> Option<f64> {
    filter.shares_samples().then(|| weights.noise_area())
}

/// Locks a value. A panic in another thread does not poison it.
pub(crate) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes of a pixel on a film while it is rendered, and of its values in the picture. `replicates`: of how many there are samples.
pub(crate) fn pixel_bytes(keeps: Keeps, replicates: u32, shares_samples: bool) -> usize {
    let kinds = if shares_samples && keeps.has_errors() { 2 } else { 1 };
    let sums = kinds * size_of::<Sum>();
    let kept = match keeps {
        Keeps::Sums => 0,
        Keeps::Passes => sums,
        Keeps::Spreads => sums + kinds * size_of::<Spread>() + 2 * size_of::<PixelError>(),
        Keeps::Replicates => replicates as usize * sums + 2 * size_of::<PixelError>(),
    };
    size_of::<Sum>() + kept + size_of::<u32>() + size_of::<[f32; 3]>()
}
