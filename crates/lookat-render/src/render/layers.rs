//! Layers of a picture beside its colors: which there are, and how a pass of its own over first hits fills them.

mod means;
#[cfg(test)]
mod tests;

use std::sync::Mutex;

use glam::{DVec2, DVec3};
use lookat_image::{Channel, Image};
use lookat_scene::{Material, Primitive, View};
use rayon::prelude::*;

use super::rounds;
use super::sample::{Context, Worker, corner_of};
use super::settings::Settings;
use crate::film::{Area, Tile, lock};
use crate::integrator::MAX_PASSED;
use crate::prepare::Prepared;
use crate::shading;
use crate::shading::Materials;
use crate::surface::Surface;
use crate::view_facts::depth;

/// The values of a pixel, by the numbers of the layers.
type Values = [DVec3; TABLE.len()];

/// The depth of pixels without a surface.
const FAR: f64 = 1e10;

/// Adds the layers to the picture of a film; nothing after an interruption, and then false.
pub(super) fn add(context: &Context, view: &View, settings: &Settings, image: &mut Image) -> bool {
    let Settings { seed, stop, layers, .. } = *settings;
    let film = context.film;
    let passes = rounds::all(stop.layer_sampler(view), seed, stop.has_error_layers());
    let channels: Vec<_> = layers.channels().collect();
    let planes = Mutex::new(vec![vec![0.0; film.of.crop.area() as usize]; channels.len()]);
    let add_tile = |worker: &mut Worker, tile: &Mutex<Tile>| {
        if context.control.is_interrupted() {
            return false;
        }
        let (bounds, mut values) = of_film(&lock(tile));
        if layers.has_any(Layers::OF_POINTS) {
            bounds.places().zip(&mut values).for_each(|(place, values)| context.look(view, place, values));
        }
        let has_means = layers.has_any(Layers::OF_SAMPLES);
        if has_means && !context.average(worker, &passes, bounds, &mut values) {
            return false;
        }
        for (plane, (layer, axis, _)) in lock(&planes).iter_mut().zip(&channels) {
            for (place, values) in bounds.places().zip(&values) {
                plane[film.crop().index(place)] =
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
    fn look(&self, view: &View, place: [i32; 2], values: &mut Values) {
        let scene = &self.prepared.traceable;
        let mut ray = self.camera.ray(corner_of(place) + 0.5, DVec2::splat(0.5));
        let (mut found, mut passed) = (scene.nearest(&ray), 0);
        while let Some(hit) = found.filter(|hit| scene.is_passed(hit)) {
            ray = Surface::new(scene, &ray, &hit).spawn_ray(ray.d);
            passed += 1;
            found = if passed > MAX_PASSED { None } else { scene.nearest(&ray) };
        }
        let Some(hit) = found else { return };
        let surface = Surface::new(scene, &ray, &hit);
        let shape = hit.element.primitive;
        let material = self.integrator.world().materials.number(shape);
        let number = |number: u32| DVec3::X * (f64::from(number) + 1.0);
        values[Layer::Depth as usize].x = depth(view, surface.p - self.camera.eye);
        values[Layer::Position as usize] = surface.p + scene.origin;
        values[Layer::Uv as usize] = shading::uv(scene, &surface, (ray, hit)).extend(0.0);
        values[Layer::Shape as usize] = number(shape);
        values[Layer::Material as usize] = number(material);
    }
}

/// A layer of the picture beside its color. It describes the first surface with a material in each pixel. All layers but the
/// depth are 0 without such a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// z in camera space; 1e10 where there is no surface, as in Blender's files. Depth, position, texture coordinates, shape and
    /// material belong to the point behind the middle of the pixel, through the middle of the lens. A mean over an edge would
    /// belong to no surface.
    Depth,
    /// The point in the world.
    Position,
    /// The geometric normal in the world, on the side of the eye. Normals and albedo are means over the camera samples of the pixel,
    /// with its filter: a denoiser needs them.
    Normal,
    /// The shading normal, with bumps, on the same side.
    ShadingNormal,
    /// Texture coordinates, from 0 to 1 on most shapes.
    Uv,
    /// The reflectance and transmittance for light along the normal, at most 1. This color does not depend on light and
    /// view.
    Albedo,
    /// The number of the shape in [`Prepared::shapes`](crate::Prepared::shapes), counted from 1. An instance gives a shape of its object.
    Shape,
    /// The number of the material in [`Prepared::materials`](crate::Prepared::materials), counted from 1.
    Material,
    /// Camera samples of the picture.
    Samples,
}

/// All layers, in the order of their definition: names, and channels of an EXR file. `P`, `N` and `Ns` are pbrt-v4's names, `Z` is
/// OpenEXR's own, and the channels `U`, `V` and `I` are Mitsuba's.
const TABLE: [(Layer, &str, &[&str]); 9] = [
    (Layer::Depth, "depth", &["Z"]),
    (Layer::Position, "position", &["P.X", "P.Y", "P.Z"]),
    (Layer::Normal, "normal", &["N.X", "N.Y", "N.Z"]),
    (Layer::ShadingNormal, "shading-normal", &["Ns.X", "Ns.Y", "Ns.Z"]),
    (Layer::Uv, "uv", &["uv.U", "uv.V"]),
    (Layer::Albedo, "albedo", &["albedo.R", "albedo.G", "albedo.B"]),
    (Layer::Shape, "shape", &["shape.I"]),
    (Layer::Material, "material", &["material.I"]),
    // As in the layers of errors.
    (Layer::Samples, "samples", &["count.samples"]),
];

impl Layer {
    /// The layer of a name in [`Layers::names`]; none for a set.
    pub fn named(name: &str) -> Option<Layer> {
        TABLE.iter().find(|(_, known, _)| *known == name).map(|(layer, ..)| *layer)
    }

    /// The channels of an EXR file.
    pub fn channels(self) -> &'static [&'static str] {
        TABLE[self as usize].2
    }

    /// The name of the layer in an EXR file: the name of its only channel, or the part before the dot that its channels share.
    pub fn name_in_file(self) -> &'static str {
        match self.channels() {
            [only] => only,
            several => several[0].split('.').next().unwrap_or_default(),
        }
    }
}

/// A set of layers. The default is empty.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Layers(u16);

impl Layers {
    /// The auxiliary images of Open Image Denoise.
    pub const DENOISE: Layers = Layers(1 << Layer::Albedo as u16 | 1 << Layer::ShadingNormal as u16);
    /// Layers with the values of one point.
    pub(in crate::render) const OF_POINTS: Layers = Layers(
        1 << Layer::Depth as u16
            | 1 << Layer::Position as u16
            | 1 << Layer::Uv as u16
            | 1 << Layer::Shape as u16
            | 1 << Layer::Material as u16,
    );
    /// Layers with means over samples.
    pub(in crate::render) const OF_SAMPLES: Layers = Layers(Layers::DENOISE.0 | 1 << Layer::Normal as u16);

    /// All names, of layers and of the set for denoising.
    pub fn names() -> impl Iterator<Item = &'static str> {
        TABLE.iter().map(|(_, name, _)| *name).chain(["denoise"])
    }

    /// The layer, or the set, of a name.
    pub fn named(name: &str) -> Option<Layers> {
        let number = Layers::names().position(|known| known == name)?;
        Some(if number < TABLE.len() { Layers(1 << number) } else { Layers::DENOISE })
    }

    /// The layers of both sets.
    pub fn union(self, others: Layers) -> Layers {
        Layers(self.0 | others.0)
    }

    /// True if there are no layers.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    fn has_any(self, of: Layers) -> bool {
        self.0 & of.0 != 0
    }

    /// For each channel its layer, which coordinate of it, and its name.
    fn channels(self) -> impl Iterator<Item = (Layer, usize, &'static str)> {
        let own = TABLE.iter().filter(move |(layer, ..)| self.0 >> *layer as u16 & 1 == 1);
        own.flat_map(|(layer, _, names)| names.iter().enumerate().map(|(axis, name)| (*layer, axis, *name)))
    }

    /// Bytes of a pixel, with the copy that is written.
    pub(in crate::render) fn pixel_bytes(self) -> usize {
        2 * size_of::<f32>() * self.channels().count()
    }
}
