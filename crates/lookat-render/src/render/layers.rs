//! Fills the layers of a picture beside its colors, by a pass of its own over first hits.

mod means;
#[cfg(test)]
mod tests;

use std::sync::Mutex;

use glam::{DVec2, DVec3};
use lookat_image::{Channel, Image};
use lookat_scene::{Material, Primitive, View};
use rayon::prelude::*;

use super::layer_set::{Layer, Layers, TABLE};
use super::rounds;
use super::sample::{Context, Worker, corner_of};
use super::settings::Settings;
use crate::film::{Area, Tile, lock};
use crate::integrator::world::pass_interfaces;
use crate::prepare::Prepared;
use crate::shading;
use crate::shading::Materials;
use crate::surface::Surface;

/// The values of a pixel, by the numbers of the layers.
type Values = [DVec3; TABLE.len()];

/// The depth of pixels without a surface.
const FAR: f64 = 1e10;

/// Adds the layers to the picture of a film; nothing after an interruption, and then false.
pub(super) fn add(context: &Context, view: &View, settings: &Settings, image: &mut Image) -> bool {
    let Settings { stop, layers, .. } = *settings;
    let film = context.film;
    let passes = rounds::all(stop.layer_sampler(view), settings);
    let channels: Vec<_> = layers.channels().collect();
    let planes = Mutex::new(vec![vec![0.0; film.settings.crop.area() as usize]; channels.len()]);
    let add_tile = |worker: &mut Worker, tile: &Mutex<Tile>| {
        if context.control.is_interrupted() {
            return false;
        }
        let (bounds, mut values) = of_film(&lock(tile));
        if layers.has_any(Layers::OF_POINTS) {
            bounds.pixels().zip(&mut values).for_each(|(pixel, values)| context.look(pixel, values));
        }
        let has_means = layers.has_any(Layers::OF_SAMPLES);
        if has_means && !context.average(worker, &passes, bounds, &mut values) {
            return false;
        }
        for (plane, (layer, axis, _)) in lock(&planes).iter_mut().zip(&channels) {
            for (pixel, values) in bounds.pixels().zip(&values) {
                plane[film.crop().index(pixel)] =
                    values[*layer as usize][*axis].clamp(f32::MIN.into(), f32::MAX.into()) as f32;
            }
        }
        true
    };
    let tiles = film.tiles.par_iter().map_init(|| Worker::new(context), add_tile);
    if !tiles.all(|is_done| is_done) {
        return false;
    }
    for ((_, _, name), samples) in channels.iter().zip(std::mem::take(&mut *lock(&planes))) {
        if image.channel(name).is_none() {
            image.channels.push(Channel { name: (*name).into(), samples });
        }
    }
    true
}

/// The bounds of a tile, and what the film knows of its pixels.
fn of_film(tile: &Tile) -> (Area, Vec<Values>) {
    let of_pixel = |at| {
        let mut values = Values::default();
        values[Layer::Depth as usize].x = FAR;
        values[Layer::Samples as usize].x = tile.count(at).into();
        values
    };
    (tile.bounds, (0..tile.bounds.size()).map(of_pixel).collect())
}

impl Prepared {
    /// The shapes in the order of the numbers in [`Layer::Shape`].
    pub fn shapes(&self) -> impl ExactSizeIterator<Item = &Primitive> {
        self.traceable.primitives()
    }

    /// The materials in the order of the numbers in [`Layer::Material`].
    pub fn materials(&self) -> Vec<&Material> {
        Materials::new(&self.traceable).all
    }
}

impl Context<'_> {
    /// Looks through the middle of a pixel and of the lens, for the first surface with a material.
    fn look(&self, pixel: [i32; 2], values: &mut Values) {
        let scene = &self.prepared.traceable;
        let mut ray = self.camera.ray(corner_of(pixel) + 0.5, DVec2::splat(0.5));
        let mut found = scene.nearest(&ray);
        pass_interfaces(scene, &mut ray, &mut found, |hit| scene.is_passed(hit), |_, _| {});
        let Some(hit) = found else { return };
        let surface = Surface::new(scene, &ray, &hit);
        let shape = hit.element.primitive;
        let material = self.integrator.world().materials.number(shape);
        let number = |number: u32| DVec3::X * (f64::from(number) + 1.0);
        values[Layer::Depth as usize].x = self.camera.depth(surface.p);
        values[Layer::Position as usize] = surface.p + scene.origin;
        values[Layer::Uv as usize] = shading::uv(scene, &surface, &ray, &hit).extend(0.0);
        values[Layer::Shape as usize] = number(shape);
        values[Layer::Material as usize] = number(material);
    }
}
