//! From sums to a picture.

use std::ops::Deref;

use glam::DVec3;
use lookat_image::{Image, PixelError, Window};
use lookat_scene::PixelBounds;

use super::area::Area;
use super::sum::Scale;
use super::tile::Tile;

/// What turns the sums of a film into its picture.
pub(super) struct Developer<'f> {
    pub film: &'f lookat_scene::Film,
    /// The noise-equivalent area of the filter. `None` if each sample counts for one pixel.
    pub noise_area: Option<f64>,
    /// The light paths whose splats are in the sums.
    pub light_paths: u64,
    pub scale: Scale,
}

impl Developer<'_> {
    /// The value of a pixel of a tile: the mean of its samples, and what splats add.
    pub fn value(&self, tile: &Tile, at: usize) -> DVec3 {
        let splats = tile.splats.get(at);
        let splats =
            splats.map(|splats| splats.weighted(self.scale).truncate() / self.light_paths.max(1) as f64);
        tile.so_far(at).mean(self.scale) + splats.unwrap_or_default()
    }

    /// The picture of all tiles; `with_errors` adds the layers of its error if there are spreads.
    pub fn image(&self, tiles: impl Iterator<Item = impl Deref<Target = Tile>>, with_errors: bool) -> Image {
        let film = self.film;
        let crop = Area::of(film.crop);
        let mut planes = [(); 3].map(|()| vec![0.0; crop.size()]);
        let mut errors = Vec::new();
        for tile in tiles {
            for (own, pixel) in tile.bounds.pixels().enumerate() {
                let at = crop.index(pixel);
                // pbrt-v3 writes nothing below black, which filters with negative lobes give.
                let value = self.value(&tile, own).max(DVec3::ZERO) * film.scale;
                let value = value.clamp(DVec3::splat(f32::MIN.into()), DVec3::splat(f32::MAX.into()));
                for (plane, value) in planes.iter_mut().zip(value.as_vec3().to_array()) {
                    plane[at] = value;
                }
                if with_errors && let Some(spreads) = tile.spreads(own, self.scale) {
                    errors.resize(crop.size(), PixelError::default());
                    errors[at] = spreads.error(film, self.noise_area);
                }
            }
        }
        let window = |x: u32, y: u32, width, height| Window { x: x as i32, y: y as i32, width, height };
        let PixelBounds { x0, y0, .. } = film.crop;
        let data = window(x0, y0, film.crop.width(), film.crop.height());
        let display = window(0, 0, film.resolution[0], film.resolution[1]);
        let mut image = Image::from_planes(data, display, planes);
        if !errors.is_empty() {
            image.add_errors(&errors);
        }
        image
    }
}
