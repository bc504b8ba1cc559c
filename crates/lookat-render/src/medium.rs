//! Participating media, prepared for rays: where light scatters along a ray, how much of it gets through, and into which directions it
//! scatters (PBR 11.2, 11.3, 15.2).

pub(crate) mod cost;
mod grid;
pub(crate) mod majorants;
mod phase;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*, u32x8};
use glam::{DVec3, Vec3};
use lookat_scene::{Density, Medium, MediumInterface, Primitive};

use crate::number::{LANES, Vec3fx8, bits, exp_minus, log_1_minus, set_lanes, splat_f32, to_f32, to_f64};
use crate::ray::ElementId;
use crate::trace::rays::Rays;
use crate::traceable::Traceable;
use grid::{GridSample, PreparedGrid, Random, RayPart};
use majorants::Majorants;
pub(crate) use phase::Phase;

/// The number of a medium: its index in the world plus 1.
pub(crate) type MediumNumber = u32;
/// The number of empty space.
pub(crate) const EMPTY: MediumNumber = 0;

/// The media of a world, and the primitives that separate them.
pub(crate) struct Media<'s> {
    media: Vec<PreparedMedium<'s>>,
    /// By primitive: the media inside and outside of those that separate media.
    interfaces: Vec<Option<[MediumNumber; 2]>>,
    /// The medium that the camera is in.
    pub of_camera: MediumNumber,
    /// Light from infinity comes through so much of the medium around the world: twice its radius, as in pbrt-v3.
    pub reach: f64,
}

/// A medium, with distances in units of the world.
struct PreparedMedium<'s> {
    scattering: Vec3,
    extinction: Vec3,
    asymmetry: f32,
    grid: Option<PreparedGrid<'s>>,
}

/// The random numbers of eight samples for a way through media.
pub(crate) struct SampleNumbers {
    /// The first ones, where the sampler gives any.
    pub first: [Option<[f64; 2]>; LANES],
    /// The seeds of the others.
    pub seeds: [u64; LANES],
}

/// What rays meet in media.
pub(crate) struct MediumSamples<S: Simd> {
    /// The rays that scatter before their ends.
    pub scatters: mask64x8<S>,
    /// The distances at which they do; of others, to their ends.
    pub t: f64x8<S>,
    /// The throughputs up to there, over their probabilities.
    pub weight: Vec3fx8<S>,
}

impl<'s> Media<'s> {
    /// `None` for a world in which nothing is in a medium.
    pub fn new(traceable: &'s Traceable) -> Option<Self> {
        let world = &traceable.source;
        let is_used = world.camera_medium.is_some() || world.shapes().any(|shape| shape.medium.is_some());
        if !is_used {
            return None;
        }
        let number = |medium: Option<u32>| medium.map_or(EMPTY, |index| index + 1);
        let of = |primitive: &Primitive| {
            let MediumInterface { inside, outside } = primitive.medium?;
            Some([number(inside), number(outside)])
        };
        Some(Media {
            media: world
                .media
                .iter()
                .zip(&traceable.majorants)
                .map(|(medium, majorants)| PreparedMedium::new(medium, majorants.as_ref(), traceable.origin))
                .collect(),
            interfaces: traceable.primitives().map(of).collect(),
            of_camera: number(world.camera_medium),
            reach: world.bounds().map_or(0.0, |[low, high]| (high - low).length()),
        })
    }

    /// The media inside and outside of a primitive, if it separates two.
    pub fn interface(&self, primitive: u32) -> Option<[MediumNumber; 2]> {
        self.interfaces[primitive as usize]
    }

    /// The media inside and outside of elements, of rays that come through other media.
    #[inline(always)]
    pub fn sides<S: Simd>(
        &self,
        elements: &[ElementId; LANES],
        before: u32x8<S>,
        is_hit: mask64x8<S>,
    ) -> [u32x8<S>; 2] {
        let mut sides = [before; 2];
        for lane in set_lanes(is_hit) {
            if let Some([inside, outside]) = self.interface(elements[lane].primitive) {
                (sides[0][lane], sides[1][lane]) = (inside, outside);
            }
        }
        sides
    }

    fn medium(&self, number: MediumNumber) -> Option<&PreparedMedium<'s>> {
        self.media.get(number.checked_sub(1)? as usize)
    }

    /// The asymmetry of a medium. 0 for empty space.
    pub fn asymmetry(&self, number: MediumNumber) -> f32 {
        self.medium(number).map_or(0.0, |medium| medium.asymmetry)
    }

    /// Samples where light that comes along the rays of paths scatters first, up to distances that may be infinite (PBR 15.2). `numbers`: those
    /// that the samples of the rays have for it.
    #[inline(always)]
    pub fn sample<S: Simd>(
        &self,
        (rays, media): (&Rays<S>, u32x8<S>),
        throughput: Vec3fx8<S>,
        t_max: f64x8<S>,
        (active, numbers): (mask64x8<S>, &SampleNumbers),
    ) -> MediumSamples<S> {
        let simd = t_max.token();
        let mut even = EvenMedia::new(simd);
        let (mut u, mut absorbs) = ([[0.5; LANES]; 2], 0);
        let mut grids: ArrayVec<(usize, GridSample), LANES> = ArrayVec::new();
        for lane in set_lanes(active) {
            let Some(medium) = self.medium(media[lane]) else { continue };
            let part = RayPart { o: rays.o.lane(lane), d: rays.d.lane(lane), t_max: t_max[lane] };
            let random = &mut Random::new(&part, numbers.seeds[lane], numbers.first[lane]);
            let is_absorber = medium.scattering == Vec3::ZERO;
            match &medium.grid {
                None => {
                    even.set_lane(lane, medium);
                    (u[0][lane], u[1][lane]) = (random.next(), random.next());
                    absorbs |= u64::from(is_absorber) << lane;
                }
                Some(grid) if is_absorber => {
                    let weight = grid.transmittance(medium, &part, random);
                    grids.push((lane, GridSample { t: None, weight }));
                }
                Some(grid) => grids.push((lane, grid.sample(medium, &part, throughput.lane(lane), random))),
            }
        }
        let mut samples = even.sample(throughput, u[1].simd_into(simd), u[0].simd_into(simd), t_max);
        if absorbs != 0 {
            // What scatters nothing ends no path: without chance, there is no noise.
            let absorbs = bits(simd, absorbs);
            let weight = even.transmittance(to_f32(t_max));
            samples.weight = weight.keep_where_wide(absorbs, samples.weight);
            samples.scatters &= !absorbs;
            samples.t = absorbs.select(t_max, samples.t);
        }
        for (lane, GridSample { t, weight }) in grids {
            samples.weight.set_lane(lane, weight);
            if let Some(t) = t {
                samples.t[lane] = t;
                samples.scatters |= bits(simd, 1 << lane);
            }
        }
        samples
    }

    /// The shares of light that get along rays to distances, or unbiased estimates of them.
    #[inline(always)]
    pub fn transmittance<S: Simd>(
        &self,
        (rays, media): (&Rays<S>, u32x8<S>),
        t_max: f64x8<S>,
        (active, seeds): (mask64x8<S>, &[u64; LANES]),
    ) -> Vec3fx8<S> {
        let simd = t_max.token();
        let mut even = EvenMedia::new(simd);
        let mut grids: ArrayVec<(usize, Vec3), LANES> = ArrayVec::new();
        for lane in set_lanes(active) {
            let Some(medium) = self.medium(media[lane]) else { continue };
            match &medium.grid {
                None => even.set_lane(lane, medium),
                Some(grid) => {
                    let part = RayPart { o: rays.o.lane(lane), d: rays.d.lane(lane), t_max: t_max[lane] };
                    let share = grid.transmittance(medium, &part, &mut Random::new(&part, seeds[lane], None));
                    grids.push((lane, share));
                }
            }
        }
        let mut shares = even.transmittance(to_f32(t_max));
        for (lane, share) in grids {
            shares.set_lane(lane, share);
        }
        shares
    }
}

/// Media of even density. In lanes without one: empty space.
struct EvenMedia<S: Simd> {
    extinction: Vec3fx8<S>,
    scattering: Vec3fx8<S>,
}

/// The share of light that gets through media to a distance, which may be infinite.
#[inline(always)]
fn share_beyond<S: Simd>(extinction: f32x8<S>, t: f32x8<S>) -> f32x8<S> {
    exp_minus(extinction.simd_gt(0.0).select(extinction * t, splat_f32(t.token(), 0.0)))
}

impl<S: Simd> EvenMedia<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let none = Vec3fx8::splat(simd, Vec3::ZERO);
        EvenMedia { extinction: none, scattering: none }
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, medium: &PreparedMedium) {
        self.extinction.set_lane(lane, medium.extinction);
        self.scattering.set_lane(lane, medium.scattering);
    }

    #[inline(always)]
    fn transmittance(&self, t: f32x8<S>) -> Vec3fx8<S> {
        let Vec3fx8 { x, y, z } = self.extinction;
        Vec3fx8 { x: share_beyond(x, t), y: share_beyond(y, t), z: share_beyond(z, t) }
    }

    /// Samples distances by the extinction of one channel each (PBR 15.2.1). Channels are chosen in proportion to the throughput of paths:
    /// it never grows in sum then. With even probabilities, as in pbrt-v3, the densest channel of a colored medium grows on some paths and is
    /// lost on most.
    #[inline(always)]
    fn sample(
        &self,
        throughput: Vec3fx8<S>,
        choice: f64x8<S>,
        u: f64x8<S>,
        t_max: f64x8<S>,
    ) -> MediumSamples<S> {
        let (extinction, Vec3fx8 { x, y, z }) = (self.extinction, throughput);
        // Below 1 also when rounded: a channel without throughput is never chosen.
        let choice = to_f32(choice) * (1.0 - f32::EPSILON) * (x + y + z);
        let sigma =
            choice.simd_lt(x).select(extinction.x, choice.simd_lt(x + y).select(extinction.y, extinction.z));
        // Without extinction, infinite or no number.
        let t = to_f64(-log_1_minus(u) / sigma);
        let scatters = t.simd_lt(t_max);
        let t = scatters.select(t, t_max);
        let transmittance = self.transmittance(to_f32(t));
        let mean = |v: Vec3fx8<S>| (v.x * x + v.y * y + v.z * z) / (x + y + z);
        let to_end = transmittance / mean(transmittance);
        let to_event = transmittance * self.scattering / mean(transmittance * extinction);
        MediumSamples { t, weight: to_event.keep_where_wide(scatters, to_end), scatters }
    }
}

/// Beyond this, a phase function is a single direction.
const MOST_ASYMMETRY: f64 = 0.9999;
/// Below this, a phase function counts as even: the formula that samples it divides by it.
const LEAST_ASYMMETRY: f32 = 1e-3;

impl<'s> PreparedMedium<'s> {
    fn new(medium: &'s Medium, majorants: Option<&'s Majorants>, origin: DVec3) -> Self {
        let Medium { absorption, scattering, asymmetry, ref density, .. } = *medium;
        let grid = match density {
            Density::Uniform => None,
            Density::Grid(grid) => majorants.map(|majorants| PreparedGrid { grid, majorants, origin }),
        };
        let asymmetry = asymmetry.clamp(-MOST_ASYMMETRY, MOST_ASYMMETRY) as f32;
        let asymmetry = if asymmetry.abs() < LEAST_ASYMMETRY { 0.0 } else { asymmetry };
        PreparedMedium { scattering, extinction: absorption + scattering, asymmetry, grid }
    }
}
