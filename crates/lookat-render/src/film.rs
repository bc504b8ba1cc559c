//! The film: exact sums of weighted samples in tiles of pixels. Samples count for all pixels that the filter reaches. One thread
//! collects the samples of a tile in an image block of its own, and then adds them to the tiles around.

pub(crate) mod sum;

use std::ops::Range;
use std::sync::{
    Mutex, MutexGuard, OnceLock, PoisonError, RwLock,
    atomic::{AtomicU64, Ordering},
};

use glam::{DVec2, DVec3, DVec4, Vec3};
use lookat_image::{Image, PixelError, Shared, Window};
use lookat_scene::{PixelBounds, View};

pub use crate::film::sum::{FilmSums, FilmSumsError, SumsHeader};
use crate::filter::PixelFilter;
use crate::number::luminance;
pub(crate) use sum::{Scale, ShortSum, Spread, Sum};

/// Replicates of each pixel when its error is asked for: with 16 of them intervals by Student's t hold what they promise,
/// with 4 and 8 they do not.
pub const REPLICATES: u32 = 16;

/// The picture while it is rendered.
#[derive(Debug)]
pub(crate) struct Film<'v> {
    pub settings: &'v lookat_scene::Film,
    pub filter: PixelFilter,
    /// Pixels on a side of the tiles.
    side: i32,
    /// True if the film keeps errors without the filter.
    has_unfiltered: bool,
    /// The scale of the sums, which is for a brightness of 1 until it is set.
    scale: OnceLock<Scale>,
    light_paths: AtomicU64,
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
}

/// A rectangle of the picture that one thread renders at a time.
#[derive(Debug)]
pub(crate) struct Tile {
    /// The pixels: none in tiles beyond the crop window.
    pub bounds: Area,
    /// The pixels in which its samples are taken. At the edges of the crop window, they extend beyond it by the reach of the
    /// filter.
    pub sources: Area,
    /// The samples taken in each source, row by row.
    pub counts: Vec<u32>,
    /// The sums of each pixel, row by row.
    pub sums: Vec<Sum>,
    /// The sums of the pass that is not merged yet. Empty if samples are added to `sums` at once.
    pub pass: Vec<Sum>,
    /// The sums of splats. Empty before the first.
    splats: Vec<Sum>,
    /// The spread of the replicates of each pixel; empty without estimates of errors.
    pub spreads: Vec<Spread>,
    /// The spread of the samples in each pixel itself, without the filter. Empty if the filter makes no difference.
    unfiltered: Vec<Spread>,
}

impl Tile {
    fn new(bounds: Area, sources: Area, keeps: Keeps, has_unfiltered: bool) -> Tile {
        let of = |is_kept: bool| if is_kept { bounds.size() } else { 0 };
        Tile {
            bounds,
            sources,
            counts: vec![0; sources.size()],
            sums: vec![Sum::default(); bounds.size()],
            pass: vec![Sum::default(); of(keeps != Keeps::Sums)],
            splats: Vec::new(),
            spreads: vec![Spread::default(); of(keeps == Keeps::Spreads)],
            unfiltered: vec![Spread::default(); of(has_unfiltered)],
        }
    }

    /// The samples taken in a pixel.
    pub fn count(&self, at: usize) -> u32 {
        self.counts[self.sources.index(self.bounds.pixel(at))]
    }

    /// True if samples count for a pixel.
    pub fn is_reached(&self, at: usize) -> bool {
        self.so_far(at).has_weight()
    }

    /// The sum of a pixel, including the pass that is not merged yet.
    fn so_far(&self, at: usize) -> Sum {
        let mut sum = self.sums[at];
        if let Some(pass) = self.pass.get(at) {
            sum += *pass;
        }
        sum
    }
}

impl<'v> Film<'v> {
    /// A film without samples: black.
    pub fn new(view: &'v View, keeps: Keeps) -> Self {
        let filter = PixelFilter::new(&view.filter);
        let crop = Area::of(view.film.crop);
        let side = tile_side(crop);
        let has_unfiltered = keeps == Keeps::Spreads && view.filter.shares_samples();
        let tiles = tiles(crop.grown(filter.reach()), side);
        let tiles = tiles
            .map(|sources| Mutex::new(Tile::new(sources.intersection(crop), sources, keeps, has_unfiltered)))
            .collect();
        Film {
            settings: &view.film,
            filter,
            side,
            has_unfiltered,
            scale: OnceLock::new(),
            light_paths: AtomicU64::new(0),
            adding: RwLock::new(()),
            tiles,
        }
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

    /// Sets the scale, before there are samples.
    pub fn set_scale(&self, scale: Scale) {
        let _ = self.scale.set(scale);
    }

    /// Adds the samples of an image block.
    pub fn add(&self, samples: &mut ImageBlock) {
        samples.carry();
        let _adding = self.adding.read().unwrap_or_else(PoisonError::into_inner);
        let ImageBlock { area, reached, carried, counts: more, unfiltered_carried, .. } = samples;
        for at in self.tiles_of(*reached) {
            let Tile { bounds, sources, counts, sums, pass, unfiltered, .. } = &mut *lock(&self.tiles[at]);
            let into = if pass.is_empty() { sums } else { pass };
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
                if bounds.contains(pixel) && !unfiltered.is_empty() && more[at] > 0 {
                    let sum = unfiltered_carried[at].weighted(self.scale());
                    unfiltered[bounds.index(pixel)].add(sum, more[at]);
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
        let _adding = self.adding.read().unwrap_or_else(PoisonError::into_inner);
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

    /// The values of the pixels so far, tile by tile.
    pub fn values(&self) -> impl Iterator<Item = DVec3> {
        let of_tile = |tile: &Mutex<Tile>| {
            let tile = lock(tile);
            (0..tile.bounds.size()).map(|at| self.value(&tile, at)).collect::<Vec<_>>()
        };
        self.tiles.iter().flat_map(of_tile)
    }

    /// The value of a pixel of a tile so far.
    fn value(&self, tile: &Tile, at: usize) -> DVec3 {
        sum::value(&tile.so_far(at), tile.splats.get(at), self.light_paths(), self.scale())
    }

    /// The error of a pixel of a tile with spreads.
    pub fn error(&self, tile: &Tile, at: usize) -> PixelError {
        let spread = &tile.spreads[at];
        let shared = tile.unfiltered.get(at).map(|unfiltered| Shared {
            unfiltered: unfiltered.standard_error().to_array(),
            noise_area: self.filter.noise_area() as f32,
        });
        PixelError {
            standard_error: spread.standard_error().to_array(),
            samples: spread.samples,
            replicates: spread.replicates,
            shared,
        }
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
        let crop = self.crop();
        let mut errors = Vec::new();
        let of_tile = |tile: &Mutex<Tile>| {
            let tile = lock(tile);
            if with_errors && !tile.spreads.is_empty() {
                errors.resize(crop.size(), PixelError::default());
                for (own, pixel) in tile.bounds.pixels().enumerate() {
                    errors[crop.index(pixel)] = self.scaled(self.error(&tile, own));
                }
            }
            let value = |(own, pixel)| (crop.index(pixel), self.value(&tile, own));
            tile.bounds.pixels().enumerate().map(value).collect::<Vec<_>>()
        };
        let mut image = develop(self.settings, self.tiles.iter().flat_map(of_tile));
        if !errors.is_empty() {
            image.add_errors(&errors);
        }
        image
    }

    /// An error on the scale of the picture.
    fn scaled(&self, error: PixelError) -> PixelError {
        let scaled = |errors: [f32; 3]| errors.map(|error| error * self.settings.scale.abs() as f32);
        let shared = error.shared.map(|shared| Shared { unfiltered: scaled(shared.unfiltered), ..shared });
        PixelError { standard_error: scaled(error.standard_error), shared, ..error }
    }
}

/// The picture of a film, from the values of its pixels by their numbers in the crop window.
fn develop(film: &lookat_scene::Film, values: impl Iterator<Item = (usize, DVec3)>) -> Image {
    let mut planes = [(); 3].map(|()| vec![0.0; Area::of(film.crop).size()]);
    for (at, value) in values {
        // pbrt-v3 writes nothing below black, which filters with negative lobes give.
        let value = value.max(DVec3::ZERO) * film.scale;
        let value = value.clamp(DVec3::splat(f32::MIN.into()), DVec3::splat(f32::MAX.into()));
        let value = value.as_vec3().to_array();
        for (plane, value) in planes.iter_mut().zip(value) {
            plane[at] = value;
        }
    }
    let window = |x: u32, y: u32, width, height| Window { x: x as i32, y: y as i32, width, height };
    let PixelBounds { x0, y0, .. } = film.crop;
    let data = window(x0, y0, film.crop.width(), film.crop.height());
    let display = window(0, 0, film.resolution[0], film.resolution[1]);
    Image::from_planes(data, display, planes)
}

/// Locks a value. A panic in another thread does not poison it.
pub(crate) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes of a pixel on a film while it is rendered, and of its values in the picture and in the copy that is written: until then, the
/// memory of the film is not given back.
pub(crate) fn pixel_bytes(keeps: Keeps, shares_samples: bool) -> usize {
    let spreads = if shares_samples { 2 } else { 1 };
    let sums = match keeps {
        Keeps::Sums => size_of::<Sum>(),
        Keeps::Passes => 2 * size_of::<Sum>(),
        Keeps::Spreads => 2 * size_of::<Sum>() + spreads * size_of::<Spread>() + 2 * size_of::<PixelError>(),
    };
    sums + size_of::<u32>() + 2 * size_of::<[f32; 3]>()
}

/// Pixels on a side of the tiles of a crop window: fewer where it is small, so that all threads have some.
fn tile_side(crop: Area) -> i32 {
    const FEWEST: usize = 64;
    [16, 8].into_iter().find(|side| crop.size() >= FEWEST * side * side).map_or(4, |side| side as i32)
}

/// Cuts an area into tiles, row by row.
fn tiles(area: Area, side: i32) -> impl Iterator<Item = Area> {
    area.squares(side).map(move |square| square.intersection(area))
}

/// A rectangle of pixels, y down: `x0 <= x < x1`, `y0 <= y < y1`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Area {
    pub x0: i32,
    pub y0: i32,
    pub x1: i32,
    pub y1: i32,
}

impl Area {
    pub fn of(PixelBounds { x0, y0, x1, y1 }: PixelBounds) -> Area {
        let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(u32::cast_signed);
        Area { x0, y0, x1, y1 }
    }

    pub fn width(self) -> usize {
        (self.x1 - self.x0).max(0) as usize
    }

    pub fn height(self) -> usize {
        (self.y1 - self.y0).max(0) as usize
    }

    /// The number of its pixels.
    pub fn size(self) -> usize {
        self.width() * self.height()
    }

    /// The pixels of the area, row by row.
    pub fn pixels(self) -> impl Iterator<Item = [i32; 2]> {
        (self.y0..self.y1).flat_map(move |y| (self.x0..self.x1).map(move |x| [x, y]))
    }

    pub fn contains(self, [x, y]: [i32; 2]) -> bool {
        (self.x0..self.x1).contains(&x) && (self.y0..self.y1).contains(&y)
    }

    pub fn pixel(self, at: usize) -> [i32; 2] {
        [self.x0 + (at % self.width()) as i32, self.y0 + (at / self.width()) as i32]
    }

    /// The index of a pixel in the area, row by row.
    pub fn index(self, [x, y]: [i32; 2]) -> usize {
        (y - self.y0) as usize * self.width() + (x - self.x0) as usize
    }

    /// The squares of a grid that it has pixels of, whole and row by row. The grid is aligned to the full picture.
    pub fn squares(self, side: i32) -> impl Iterator<Item = Area> {
        let [columns, rows] = self.grid(side);
        rows.flat_map(move |row| columns.clone().map(move |column| (column * side, row * side)))
            .map(move |(x0, y0)| Area { x0, y0, x1: x0 + side, y1: y0 + side })
    }

    /// The number among these squares of the one that a pixel is in.
    #[inline(always)]
    pub fn square_of(self, side: i32, [x, y]: [i32; 2]) -> usize {
        let [columns, rows] = self.grid(side);
        let (column, row) = (x.div_euclid(side) - columns.start, y.div_euclid(side) - rows.start);
        (row * (columns.end - columns.start) + column) as usize
    }

    /// The columns and rows of a grid that it has pixels of.
    #[inline(always)]
    fn grid(self, side: i32) -> [Range<i32>; 2] {
        let range = |from: i32, to: i32| from.div_euclid(side)..(to - 1).div_euclid(side) + 1;
        [range(self.x0, self.x1), range(self.y0, self.y1)]
    }

    /// The area with so many more pixels on each side.
    pub fn grown(self, [x, y]: [u32; 2]) -> Area {
        let [x, y] = [x, y].map(u32::cast_signed);
        Area { x0: self.x0 - x, y0: self.y0 - y, x1: self.x1 + x, y1: self.y1 + y }
    }

    pub fn intersection(self, other: Area) -> Area {
        Area {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }
}

/// The samples of an area, added up by the pixels around that they count for. Exact, as the sums of the film are: so the bits of a picture
/// depend on no tile, no crop window, and no order.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImageBlock {
    /// The sources.
    pub area: Area,
    /// The area and the pixels around that the filter reaches.
    reached: Area,
    /// The sums of the last samples for each of these pixels, row by row.
    sums: Vec<ShortSum>,
    /// The sums of the samples before those.
    carried: Vec<Sum>,
    /// The number of samples in them.
    waiting: u32,
    /// The samples taken in each source, row by row.
    pub counts: Vec<u32>,
    /// The sums of samples in each source, without the filter. Empty unless the film keeps errors.
    unfiltered: Vec<ShortSum>,
    unfiltered_carried: Vec<Sum>,
    /// Room for the weights of a sample, across and down.
    weights: [Vec<f64>; 2],
}

impl ImageBlock {
    /// Empties the block, and gives it an area.
    pub fn restart(&mut self, film: &Film, area: Area) {
        fn clear<T: Clone + Default>(all: &mut Vec<T>, size: usize) {
            all.clear();
            all.resize(size, T::default());
        }
        self.area = area;
        self.reached = area.grown(film.filter.reach());
        self.waiting = 0;
        let unfiltered = if film.has_unfiltered { area.size() } else { 0 };
        clear(&mut self.counts, area.size());
        clear(&mut self.sums, self.reached.size());
        clear(&mut self.carried, self.reached.size());
        clear(&mut self.unfiltered, unfiltered);
        clear(&mut self.unfiltered_carried, unfiltered);
    }

    /// Adds a sample of a source, which lies at `square` in its unit square: red, green, blue, and in `w` its weight, in the units of
    /// [`Scale::units`].
    #[inline(always)]
    pub fn add(&mut self, filter: &PixelFilter, source: [i32; 2], square: DVec2, units: DVec4) {
        if self.waiting == ShortSum::MOST {
            self.carry();
        }
        self.waiting += 1;
        let at = self.area.index(source);
        self.counts[at] += 1;
        if let Some(sum) = self.unfiltered.get_mut(at) {
            *sum += units;
        }
        let width = self.reached.width();
        // The first pixel that the sample counts for is as far from the corner as the source.
        let [x, y] = [source[0] - self.area.x0, source[1] - self.area.y0];
        let sums = &mut self.sums[y as usize * width + x as usize..];
        if self.reached == self.area {
            sums[0] += units * filter.own(square);
            return;
        }
        filter.weigh(square, &mut self.weights);
        let [across, down] = &self.weights;
        // A sample seldom reaches the pixels on both edges.
        for (row, down) in sums.chunks_mut(width).zip(down).filter(|(_, down)| **down != 0.0) {
            let units = units * *down;
            row.iter_mut().zip(across).for_each(|(sum, across)| *sum += units * *across);
        }
    }

    /// Makes room for more samples.
    #[inline(never)]
    fn carry(&mut self) {
        let kinds =
            [(&mut self.sums, &mut self.carried), (&mut self.unfiltered, &mut self.unfiltered_carried)];
        for (sums, carried) in kinds {
            for (sum, carried) in sums.iter_mut().zip(carried) {
                std::mem::take(sum).add_to(carried);
            }
        }
        self.waiting = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Settings;
    use crate::render::Stop;
    use crate::render::render;
    use crate::testing::scene;
    use rayon::prelude::*;
    use std::ops::ControlFlow;

    #[test]
    fn tiles_cover_an_area_once() {
        for (x1, y1) in [(70, 24), (6, 8), (6, 2000), (133, 135), (5, 7)] {
            let area = Area { x0: -5, y0: -7, x1, y1 };
            let size: usize = tiles(area, 8).map(Area::size).sum();
            assert_eq!(size, area.size());
        }
    }

    /// A crop window has the pixels of the whole, of any filter, with and without layers of its errors.
    #[test]
    fn crops_equal_the_whole() {
        let render = |filter: &str, crop: &str, stop: Stop| {
            let scene = scene(&format!(
                "LookAt 0 0 -4 0 0 0 0 1 0 Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 32 {crop}
                Camera \"perspective\" Sampler \"sobol\" \"integer pixelsamples\" 20 PixelFilter {filter}
                Integrator \"path\" WorldBegin LightSource \"infinite\" \"rgb L\" [.5 1 2]
                AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .3 WorldEnd"
            ));
            let settings = Settings { stop, ..Settings::default() };
            render(&scene, &settings, &|_| ControlFlow::Continue(())).image
        };
        for filter in [
            "\"box\"",
            "\"gaussian\"",
            "\"mitchell\" \"float xwidth\" 1.2",
            "\"sinc\"",
            "\"box\" \"float ywidth\" 7",
        ] {
            for error_layers in [false, true] {
                let stop = Stop::Samples { error_layers };
                let whole = render(filter, "", stop);
                let part = render(filter, "\"float cropwindow\" [.25 .75 .5 1]", stop);
                for (whole, part) in whole.channels.iter().zip(&part.channels) {
                    let rows = whole.samples.chunks(48).skip(16).map(|row| &row[12..36]);
                    assert!(rows.eq(part.samples.chunks(24)), "{filter} {}", whole.name);
                }
            }
        }
    }

    /// One sample lights the pixels that its filter reaches, by their weights; a flat picture stays flat.
    #[test]
    fn pixels_are_ratios_of_weighted_sums() {
        let scene = scene(
            "Film \"image\" \"integer xresolution\" 9 \"integer yresolution\" 9 Camera \"perspective\"
            PixelFilter \"mitchell\" WorldBegin Shape \"sphere\" WorldEnd",
        );
        let film = Film::new(&scene.view, Keeps::Sums);
        // Samples of a flat picture everywhere, and a bright one.
        let bright = ([4, 5], DVec2::new(0.9, 0.3));
        let places: Vec<([i32; 2], DVec2, f64)> = film
            .sources()
            .pixels()
            .map(|source| (source, DVec2::new(0.25, 0.5), 3.0))
            .chain([(bright.0, bright.1, 100.0)])
            .collect();
        let mut block = ImageBlock::default();
        block.restart(&film, film.sources());
        for (source, place, value) in &places {
            block.add(&film.filter, *source, *place, film.scale().units(DVec3::splat(*value).extend(1.0)));
        }
        film.add(&mut block);
        let image = film.develop(false).rgb().unwrap();
        for (pixel, found) in film.crop().pixels().zip(image) {
            let mut sum = [0.0; 2];
            for ([x, y], square, value) in &places {
                let off =
                    [f64::from(pixel[0] - x) + 0.5 - square.x, f64::from(pixel[1] - y) + 0.5 - square.y];
                let mitchell = |x: f64| match x.abs() {
                    x if x < 1.0 => 7.0 * x.powi(3) - 12.0 * x * x + 16.0 / 3.0,
                    x if x < 2.0 => -7.0 / 3.0 * x.powi(3) + 12.0 * x * x - 20.0 * x + 32.0 / 3.0,
                    _ => 0.0,
                };
                let weight = mitchell(off[0]) * mitchell(off[1]);
                sum = [sum[0] + weight * value, sum[1] + weight];
            }
            let expected = (sum[0] / sum[1]).max(0.0) as f32;
            assert!(
                (found[0] - expected).abs() < 1e-5 * expected.max(1.0),
                "{pixel:?}: {found:?} {expected}"
            );
            let is_far = pixel[0].abs_diff(4) > 2 || pixel[1].abs_diff(5) > 2;
            assert!(!is_far || found == [3.0; 3], "{pixel:?}");
        }
    }

    /// From several threads at once: each splat brings its value, in the mean over its places, and the bits do not depend on the order.
    #[test]
    fn splats_keep_their_energy() {
        for filter in ["box", "triangle", "gaussian", "mitchell", "sinc"] {
            let scene = scene(&format!(
                "Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 40 Camera \"perspective\"
                PixelFilter \"{filter}\" WorldBegin Shape \"sphere\" WorldEnd"
            ));
            // Over all places in a pixel, in the middle of the picture.
            let at = |step: i32, of: i32| f64::from(19) + (f64::from(step) + 0.5) / f64::from(of);
            let places: Vec<DVec2> =
                (0..32).flat_map(|y| (0..32).map(move |x| DVec2::new(at(x, 32), at(y, 32)))).collect();
            let sums = [false, true].map(|is_reversed| {
                let film = Film::new(&scene.view, Keeps::Sums);
                let splat = |place: &DVec2| assert!(film.add_splat(*place, Vec3::new(1.0, 1e-5, 3e4)));
                match is_reversed {
                    false => places.par_iter().for_each(splat),
                    true => places.iter().rev().for_each(splat),
                }
                film.add_light_paths(places.len() as u64);
                film.sums()
            });
            assert_eq!(sums[0], sums[1]);
            let image = sums[0].image();
            let total =
                |channel: usize| image.channels[channel].samples.iter().copied().map(f64::from).sum::<f64>();
            // What is below black is written as black.
            let is_signed = matches!(filter, "mitchell" | "sinc");
            for (channel, expected) in [1.0, 1e-5, 3e4].into_iter().enumerate() {
                let ratio = total(channel) / expected;
                let most = if is_signed { 1.3 } else { 1.0 + 1e-5 };
                assert!(ratio > 1.0 - 1e-5 && ratio < most, "{filter}: {ratio}");
            }
        }
    }

    /// Splats join the samples of the picture, at its edges too, and bad ones are refused.
    #[test]
    fn splats_join_samples() {
        let scene = scene(
            "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 Camera \"perspective\"
            PixelFilter \"box\" WorldBegin Shape \"sphere\" WorldEnd",
        );
        let film = Film::new(&scene.view, Keeps::Sums);
        let mut block = ImageBlock::default();
        block.restart(&film, film.sources());
        block.add(&film.filter, [3, 4], DVec2::splat(0.5), film.scale().units(DVec3::splat(2.0).extend(1.0)));
        film.add(&mut block);
        assert!(film.add_splat(DVec2::new(3.2, 4.9), Vec3::splat(6.0)));
        for far in [1e9, 1e10, -1e10, 1e300] {
            assert!(film.add_splat(DVec2::new(-0.1, far), Vec3::splat(6.0)));
        }
        assert!(!film.add_splat(DVec2::new(3.2, 4.9), Vec3::NAN));
        assert!(!film.add_splat(DVec2::new(f64::INFINITY, 4.9), Vec3::ONE));
        film.add_light_paths(4);
        let image = film.develop(false).rgb().unwrap();
        assert_eq!(image[4 * 8 + 3], [3.5; 3]);
        assert_eq!(image.iter().filter(|pixel| **pixel != [0.0; 3]).count(), 1);
    }
}
