//! Direct lighting of samples side by side: in small worlds of plain materials.

use fearless_simd::{Level, Simd, mask64x8, prelude::*};
use glam::{DVec3, Vec3};
use lookat_scene::{DirectStrategy, Integrator, Projection, Scene};

use crate::arithmetic::Precision;
use crate::bsdf::lanes::{Bsdfs, Coat, Coats};
use crate::lanes::{Colors, level, name};
use crate::light::LightTable;
use crate::light::lanes::PlainLight;
use crate::prepare::Traceable;
use crate::sampler::lanes::Streams;
use crate::surface::lanes::{Sheet, Surfaces};
use crate::trace::lanes::{Hits, List, Rays};

/// A scene that [`Lanes::li`] serves for.
pub(crate) struct Lanes<'s> {
    pub level: Level,
    /// Those that are sampled.
    lights: Vec<PlainLight>,
    list: List<'s>,
    /// Of each element of the list its points and lobes.
    sheets: Vec<(Sheet<'s>, Coat)>,
    /// Whether all materials are diffuse and nothing else.
    pub is_lambert: bool,
    /// So many directions from the BSDF look for light.
    directions: u32,
    /// What one of these brings from where there is nothing, as its part of all.
    sky: Vec3,
    background: Vec3,
}

/// What samples have brought.
pub(crate) struct Brought<S: Simd> {
    pub radiance: Colors<S>,
    /// How many rays it took.
    pub rays: u64,
}

impl<'s> Lanes<'s> {
    /// `None` of scenes that have anything else, and of processors that have too little.
    pub fn new(scene: &Scene, traceable: &'s Traceable, lights: &LightTable) -> Option<Self> {
        let Integrator::DirectLighting { strategy, .. } = scene.integrator else { return None };
        let is_other = strategy == DirectStrategy::One
            || matches!(scene.camera.projection, Projection::Environment)
            || traceable.precision != Precision::Mixed
            || !traceable.emitters.is_empty();
        if is_other {
            return None;
        }
        let level = level()?;
        let sampled = lights.plain_lights()?;
        let list = List::new(traceable)?;
        let sheets = list.elements.iter().map(|element| {
            let primitive = traceable.primitives[element.id.primitive as usize];
            Some((Sheet::new(element, primitive)?, Coat::new(&primitive.material)?))
        });
        let sheets = sheets.collect::<Option<Vec<_>>>()?;
        let mut directions = 0;
        for count in super::directions(lights, sampled.len()) {
            if count > 1 {
                return None;
            }
            directions += count;
        }
        // Alike in all directions, of which none is sampled in another way.
        let sky = lights.skies(None, DVec3::Z).map(|(_, radiance, _)| radiance).sum::<Vec3>();
        Some(Lanes {
            level,
            lights: sampled,
            list,
            is_lambert: sheets.iter().all(|(_, coat)| coat.is_lambert),
            sheets,
            directions,
            sky: sky / directions as f32,
            background: lights.background(DVec3::Z),
        })
    }

    /// The instructions that it uses.
    pub fn name(&self) -> &'static str {
        name(self.level)
    }

    /// The radiance along those of the camera rays that are active; as [`super::li`], to the bit.
    #[inline(always)]
    pub fn li<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        rays: &Rays<S>,
        active: mask64x8<S>,
        streams: &mut Streams,
    ) -> Brought<S> {
        let hits = self.list.nearest(simd, rays, active);
        let mut brought = Brought { radiance: Colors::splat(simd, self.background), rays: count(active) };
        let Some((surfaces, coats)) = self.surfaces(simd, rays, &hits, active) else { return brought };
        let is_hit = hits.is_hit() & active;
        let bsdfs: Bsdfs<S, LAMBERT> = Bsdfs::new(surfaces.n, -rays.d, coats);
        let black = Colors::splat(simd, Vec3::ZERO);
        let mut radiance = black;
        for light in &self.lights {
            let sample = light.samples(simd, &surfaces);
            let reflected = bsdfs.f_cos(sample.shadow.d) * sample.li;
            let asked = sample.is_there & reflected.is_light() & is_hit;
            let is_free = !self.list.met(simd, &sample.shadow, asked);
            radiance = radiance + reflected.or(asked & is_free, black);
            brought.rays += count(asked);
        }
        for _ in 0..self.directions {
            let sample = bsdfs.sample(streams.next_2d(simd));
            let asked = sample.is_there & is_hit;
            let is_free = !self.list.met(simd, &surfaces.leave(sample.wi), asked);
            radiance = radiance + (sample.weight * Colors::splat(simd, self.sky)).or(asked & is_free, black);
            brought.rays += count(asked);
        }
        brought.radiance = radiance.or(is_hit, brought.radiance);
        brought
    }

    /// Where the rays have hit something, and the lobes there; `None` if there is no hit.
    #[inline(always)]
    fn surfaces<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        hits: &Hits<S>,
        active: mask64x8<S>,
    ) -> Option<(Surfaces<S>, Coats<S>)> {
        let mut all: Option<(Surfaces<S>, Coats<S>)> = None;
        let mut rest = hits.is_hit() & active;
        // Mostly it is one element.
        while rest.any_true() {
            let first = rest.to_bitmask().trailing_zeros() as usize;
            let is_same = hits.element.simd_eq(hits.element[first]);
            let (sheet, coat) = &self.sheets[hits.element[first] as usize];
            let own = (sheet.points(simd, rays, hits), Coats::splat(simd, coat));
            all = Some(match all {
                Some(others) => (own.0.or(is_same, others.0), own.1.or(is_same, others.1)),
                None => own,
            });
            rest &= !is_same;
        }
        all
    }
}

#[inline(always)]
fn count<S: Simd>(mask: mask64x8<S>) -> u64 {
    u64::from(mask.to_bitmask().count_ones())
}
