//! The film: exact sums of samples, pixel by pixel, in tiles.

pub(crate) mod sum;

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use glam::{DVec3, Vec3};
use lookat_image::{Image, PixelError, Window};
use lookat_scene::PixelBounds;

use crate::color::luminance;
use crate::filter::FilterSampler;
pub(crate) use sum::{Pixel, Scale, Sum};
use sum::{Products, Spread};

/// Replicates of each pixel when its error is asked for: with 16 of them intervals by Student's t hold what they promise,
/// with 4 and 8 they do not.
pub const REPLICATES: u32 = 16;

/// The picture while it is rendered.
#[derive(Debug)]
pub(crate) struct Film<'v> {
    pub of: &'v lookat_scene::Film,
    /// That of 1 until it is set.
    scale: OnceLock<Scale>,
    /// The integral of the filter's absolute value over its integral.
    pub weight: f64,
    /// Row by row. Threads add to them, and take snapshots of them, at any time: a thread locks one tile, and neither takes samples nor
    /// calls back while it does.
    pub tiles: Vec<Mutex<Tile>>,
}

/// How the film estimates the error of its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Errors {
    /// Not at all.
    None,
    /// By replicates whose sums are exact.
    Exact,
    /// By replicates whose sums are rounded.
    Rounded,
}

impl Errors {
    fn has_products(self, has_lobes: bool) -> bool {
        self == Errors::Rounded || self == Errors::Exact && has_lobes
    }
}

/// A rectangle of the picture that one thread renders at a time.
#[derive(Debug)]
pub(crate) struct Tile {
    pub bounds: PixelBounds,
    /// All samples of each pixel, row by row.
    all: Vec<Sum>,
    /// Those where the filter is negative; none if it nowhere is.
    negative: Vec<Sum>,
    /// The spread of the replicates of each pixel; empty without estimates of errors.
    spreads: Vec<Spread>,
    /// What the spreads need beside them; none where they need nothing.
    products: Vec<Products>,
}

impl Tile {
    fn new(bounds: PixelBounds, has_lobes: bool, errors: Errors) -> Tile {
        let area = bounds.area() as usize;
        Tile {
            bounds,
            all: vec![Sum::default(); area],
            negative: vec![Sum::default(); if has_lobes { area } else { 0 }],
            spreads: vec![Spread::default(); if errors == Errors::None { 0 } else { area }],
            products: vec![Products::default(); if errors.has_products(has_lobes) { area } else { 0 }],
        }
    }

    /// Samples of a pixel.
    pub fn count(&self, at: usize) -> u32 {
        self.all[at].count
    }

    /// The samples of a pixel.
    pub fn pixel(&self, at: usize) -> Pixel {
        Pixel { all: self.all[at], negative: self.negative.get(at).copied().unwrap_or_default() }
    }

    /// The pixels, row by row.
    pub fn pixels(&self) -> impl ExactSizeIterator<Item = Pixel> {
        (0..self.all.len()).map(|at| self.pixel(at))
    }

    /// Adds samples to a pixel.
    pub fn add(&mut self, at: usize, samples: &Pixel) {
        self.all[at] += samples.all;
        if let Some(negative) = self.negative.get_mut(at) {
            *negative += samples.negative;
        }
    }

    /// Takes all samples from a pixel.
    pub fn clear(&mut self, at: usize) {
        self.all[at] = Sum::default();
        self.negative.get_mut(at).into_iter().for_each(|sum| *sum = Sum::default());
    }

    /// True if the film estimates errors.
    pub fn has_spreads(&self) -> bool {
        !self.spreads.is_empty()
    }

    /// Forgets how far the replicates of a pixel lie apart.
    pub fn clear_spread(&mut self, at: usize) {
        self.spreads[at] = Spread::default();
        self.products.get_mut(at).into_iter().for_each(|spread| *spread = Products::default());
    }

    /// Adds a replicate to the spread of a pixel: the signed sum, the signed count and the count of its samples.
    pub fn spread(&mut self, at: usize, (signed, signs, count): (DVec3, f64, u32), scale: Scale) {
        self.spreads[at].add(signed, count, scale);
        self.products.get_mut(at).into_iter().for_each(|lobes| lobes.add(signed, signs, count, scale));
    }
}

impl<'v> Film<'v> {
    /// A film without samples: black.
    pub fn new(of: &'v lookat_scene::Film, filter: &FilterSampler, errors: Errors) -> Self {
        let weight = filter.weight();
        let tile = |bounds| Mutex::new(Tile::new(bounds, weight != 1.0, errors));
        Film { of, scale: OnceLock::new(), weight, tiles: tiles(of.crop).map(tile).collect() }
    }

    /// The scale of all sums.
    pub fn scale(&self) -> Scale {
        *self.scale.get().unwrap_or(&Scale::ONE)
    }

    /// Sets the scale, before there are samples.
    pub fn set_scale(&self, scale: Scale) {
        let _ = self.scale.set(scale);
    }

    /// The pixels so far, tile by tile.
    pub fn pixels(&self) -> impl Iterator<Item = Pixel> {
        self.tiles.iter().flat_map(|tile| lock(tile).pixels().collect::<Vec<_>>())
    }

    /// The value of a pixel.
    pub fn value(&self, pixel: &Pixel) -> DVec3 {
        pixel.value(self.weight, self.scale())
    }

    /// The error of a pixel of a tile with spreads.
    pub fn error(&self, tile: &Tile, at: usize) -> PixelError {
        let (pixel, spread, lobes) = (tile.pixel(at), tile.spreads[at], tile.products.get(at));
        PixelError {
            standard_error: spread.standard_error(lobes, &pixel, self.weight, self.scale()).to_array(),
            samples: pixel.all.count,
            replicates: spread.replicates,
        }
    }

    /// A sample no brighter than the film allows.
    #[inline(always)]
    pub fn limited(&self, radiance: Vec3) -> Vec3 {
        let brightness = luminance(radiance);
        if brightness <= self.of.max_sample_luminance {
            return radiance;
        }
        radiance * (self.of.max_sample_luminance / brightness) as f32
    }

    /// The picture so far; `with_errors` adds the layers of its error if there are spreads.
    pub fn develop(&self, with_errors: bool) -> Image {
        let crop = self.of.crop;
        let area = crop.area() as usize;
        let mut planes = [(); 3].map(|()| vec![0.0; area]);
        let mut errors = Vec::new();
        for tile in &self.tiles {
            let tile = lock(tile);
            for (at, pixel) in indices(tile.bounds, crop).zip(tile.pixels()) {
                // pbrt-v3 writes nothing below black, which filters with negative lobes give.
                let value = self.value(&pixel).max(DVec3::ZERO) * self.of.scale;
                let value = value.clamp(DVec3::splat(f32::MIN.into()), DVec3::splat(f32::MAX.into()));
                let value = value.as_vec3().to_array();
                planes.iter_mut().zip(value).for_each(|(plane, value)| plane[at] = value);
            }
            if !with_errors || tile.spreads.is_empty() {
                continue;
            }
            errors.resize(area, PixelError::default());
            for (own, at) in indices(tile.bounds, crop).enumerate() {
                let error = self.error(&tile, own);
                let standard_error = error.standard_error.map(|error| error * self.of.scale.abs() as f32);
                errors[at] = PixelError { standard_error, ..error };
            }
        }
        let window = |x: u32, y: u32, width, height| Window { x: x as i32, y: y as i32, width, height };
        let data = window(crop.x0, crop.y0, crop.width(), crop.height());
        let display = window(0, 0, self.of.resolution[0], self.of.resolution[1]);
        let mut image = Image::from_planes(data, display, planes);
        if !errors.is_empty() {
            image.add_errors(&errors);
        }
        image
    }
}

/// What no other thread uses meanwhile.
pub(crate) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes of a pixel on a film while it is rendered, and of its values in the picture.
pub(crate) fn pixel_bytes(has_lobes: bool, errors: Errors) -> usize {
    let sums = if has_lobes { size_of::<Pixel>() } else { size_of::<Sum>() };
    let spreads = if errors == Errors::None { 0 } else { size_of::<Spread>() + 2 * size_of::<PixelError>() };
    let products = if errors.has_products(has_lobes) { size_of::<Products>() } else { 0 };
    sums + size_of::<[f32; 3]>() + spreads + products
}

/// Pixels on a side of the tiles of a crop window: fewer where it is small, so that all threads have some.
pub(crate) fn tile_side(crop: PixelBounds) -> u32 {
    const FEWEST: u64 = 64;
    [16, 8, 4, 2].into_iter().find(|side| crop.area() >= FEWEST * side * side).unwrap_or(1) as u32
}

/// Cuts the crop window into tiles, row by row.
fn tiles(crop: PixelBounds) -> impl Iterator<Item = PixelBounds> {
    let side = tile_side(crop);
    let starts = move |from: u32, to: u32| (from..to).step_by(side as usize);
    starts(crop.y0, crop.y1).flat_map(move |y0| starts(crop.x0, crop.x1).map(move |x0| (x0, y0))).map(
        move |(x0, y0)| PixelBounds { x0, y0, x1: (x0 + side).min(crop.x1), y1: (y0 + side).min(crop.y1) },
    )
}

/// Pixels, row by row.
pub(crate) fn places(bounds: PixelBounds) -> impl Iterator<Item = [u32; 2]> {
    let PixelBounds { x0, y0, x1, y1 } = bounds;
    (y0..y1).flat_map(move |y| (x0..x1).map(move |x| [x, y]))
}

/// Where these pixels are among those of a picture, row by row.
pub(crate) fn indices(bounds: PixelBounds, picture: PixelBounds) -> impl Iterator<Item = usize> {
    let across = picture.width() as usize;
    places(bounds).map(move |[x, y]| (y - picture.y0) as usize * across + (x - picture.x0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_crop_window_once() {
        for (x1, y1, side) in [(70, 24, 4), (6, 8, 1), (6, 2000, 4), (133, 135, 16), (5, 7, 1)] {
            let crop = PixelBounds { x0: 5, y0: 7, x1, y1 };
            let area: u64 = tiles(crop).map(|bounds| bounds.area()).sum();
            assert_eq!((area, tile_side(crop)), (crop.area(), side));
        }
    }
}
