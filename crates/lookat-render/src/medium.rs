//! Participating media, prepared for rays: where light scatters along a ray, how much of it gets through, and into which directions it
//! scatters (PBR 11.2, 11.3, 15.2).

use std::f64::consts::PI;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*, u32x8};
use glam::{DVec3, Vec3};
use lookat_scene::{Density, DensityGrid, Medium, MediumInterface, Primitive};

use crate::frame::Frames;
use crate::number::{LANES, Vec3fx8, bits, exp_minus, log_1_minus, set_lanes, splat_f32, to_f32, to_f64};
use crate::ray::ElementId;
use crate::sampler::{mix, unit};
use crate::trace::rays::Rays;
use crate::traceable::Traceable;
use crate::warp::at_turn;

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

struct PreparedGrid<'s> {
    grid: &'s DensityGrid,
    origin: DVec3,
    /// The largest density.
    majorant: f32,
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

/// What a ray meets in a medium.
struct MediumSample {
    /// The distance at which it scatters. `None` if it gets to its end.
    t: Option<f64>,
    /// The throughput up to there, over its probability.
    weight: Vec3,
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
            media: world.media.iter().map(|medium| PreparedMedium::new(medium, traceable.origin)).collect(),
            interfaces: traceable.primitives().map(of).collect(),
            of_camera: number(world.camera_medium),
            reach: world.bounds().map_or(0.0, |[low, high]| (high - low).length()),
        })
    }

    /// The media inside and outside of a primitive, if it separates two.
    pub fn interface(&self, primitive: u32) -> Option<[MediumNumber; 2]> {
        self.interfaces[primitive as usize]
    }

    /// The medium that a ray in direction `d` is in behind a point of a primitive with geometric normal `n`, if it was in `before`.
    pub fn beyond(&self, primitive: u32, n: DVec3, d: DVec3, before: MediumNumber) -> MediumNumber {
        match self.interface(primitive) {
            Some([_, outside]) if n.dot(d) > 0.0 => outside,
            Some([inside, _]) => inside,
            None => before,
        }
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

    /// Samples where light that comes along rays scatters first, up to distances that may be infinite (PBR 15.2).
    #[inline(always)]
    pub fn sample<S: Simd>(
        &self,
        (rays, numbers): (&Rays<S>, u32x8<S>),
        t_max: f64x8<S>,
        active: mask64x8<S>,
    ) -> MediumSamples<S> {
        let simd = t_max.token();
        let mut even = EvenMedia::new(simd);
        let mut u = [[0.5; LANES]; 2];
        let mut grids: ArrayVec<(usize, MediumSample), LANES> = ArrayVec::new();
        for lane in set_lanes(active) {
            let Some(medium) = self.medium(numbers[lane]) else { continue };
            let (o, d) = (rays.o.lane(lane), rays.d.lane(lane));
            let random = &mut Random::new(o, d);
            match &medium.grid {
                None => {
                    even.set_lane(lane, medium);
                    (u[0][lane], u[1][lane]) = (random.next(), random.next());
                }
                Some(grid) => grids.push((lane, grid.sample(medium, (o, d, t_max[lane]), random))),
            }
        }
        let mut samples = even.sample(u[0].simd_into(simd), u[1].simd_into(simd), t_max);
        for (lane, MediumSample { t, weight }) in grids {
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
        (rays, numbers): (&Rays<S>, u32x8<S>),
        t_max: f64x8<S>,
        active: mask64x8<S>,
    ) -> Vec3fx8<S> {
        let simd = t_max.token();
        let mut even = EvenMedia::new(simd);
        let mut grids: ArrayVec<(usize, Vec3), LANES> = ArrayVec::new();
        for lane in set_lanes(active) {
            let Some(medium) = self.medium(numbers[lane]) else { continue };
            match &medium.grid {
                None => even.set_lane(lane, medium),
                Some(grid) => {
                    let (o, d) = (rays.o.lane(lane), rays.d.lane(lane));
                    let share = grid.transmittance(medium, (o, d, t_max[lane]), &mut Random::new(o, d));
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

    /// Samples distances by the extinction of one channel each, chosen at random (PBR 15.2.1).
    #[inline(always)]
    fn sample(&self, channel: f64x8<S>, u: f64x8<S>, t_max: f64x8<S>) -> MediumSamples<S> {
        let extinction = self.extinction;
        let channel = to_f32(channel) * 3.0;
        let sigma = channel
            .simd_lt(1.0)
            .select(extinction.x, channel.simd_lt(2.0).select(extinction.y, extinction.z));
        // Without extinction, infinite or no number.
        let t = to_f64(-log_1_minus(u) / sigma);
        let scatters = t.simd_lt(t_max);
        let t = scatters.select(t, t_max);
        let transmittance = self.transmittance(to_f32(t));
        let mean = |v: Vec3fx8<S>| (v.x + v.y + v.z) * (1.0 / 3.0);
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
    fn new(medium: &'s Medium, origin: DVec3) -> Self {
        let Medium { absorption, scattering, asymmetry, ref density } = *medium;
        let grid = match density {
            Density::Uniform => None,
            Density::Grid(grid) => {
                let majorant = grid.values.iter().copied().fold(0.0, f32::max);
                Some(PreparedGrid { grid, origin, majorant })
            }
        };
        let asymmetry = asymmetry.clamp(-MOST_ASYMMETRY, MOST_ASYMMETRY) as f32;
        let asymmetry = if asymmetry.abs() < LEAST_ASYMMETRY { 0.0 } else { asymmetry };
        PreparedMedium { scattering, extinction: absorption + scattering, asymmetry, grid }
    }
}

impl PreparedGrid<'_> {
    /// The part of a ray that is in the box, and the ray in its space.
    fn within(&self, o: DVec3, d: DVec3, t_max: f64) -> Option<(DVec3, DVec3, [f64; 2])> {
        let grid_from_world = &self.grid.grid_from_world;
        let (o, d) = (grid_from_world.point(o + self.origin), grid_from_world.vector(d));
        let (mut near, mut far) = (0.0_f64, t_max);
        for axis in 0..3 {
            let ends = [-o[axis] / d[axis], (1.0 - o[axis]) / d[axis]];
            if d[axis] == 0.0 {
                if !(0.0..=1.0).contains(&o[axis]) {
                    return None;
                }
                continue;
            }
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        (near < far).then_some((o, d, [near, far]))
    }

    /// The density at a point of the unit cube.
    fn density(&self, p: DVec3) -> f32 {
        let DensityGrid { resolution, values, .. } = self.grid;
        let count = DVec3::from(resolution.map(|cells| cells as f64));
        let at = p * count - 0.5;
        let (first, rest) = (at.floor(), (at - at.floor()).as_vec3());
        let first = first.to_array().map(|first| first as i64);
        let value = |x: i64, y: i64, z: i64| {
            let cell = [first[0] + x, first[1] + y, first[2] + z];
            let is_in = (0..3).all(|axis| (0..resolution[axis] as i64).contains(&cell[axis]));
            let [x, y, z] = cell.map(|cell| cell as usize);
            if is_in { values[(z * resolution[1] + y) * resolution[0] + x] } else { 0.0 }
        };
        let lerp = |share: f32, a: f32, b: f32| a * (1.0 - share) + b * share;
        let along_x = |y, z| lerp(rest.x, value(0, y, z), value(1, y, z));
        let along_y = |z| lerp(rest.y, along_x(0, z), along_x(1, z));
        lerp(rest.z, along_y(0), along_y(1))
    }

    /// Delta tracking. Where the channels differ, a collision is real with the mean probability of what is left of them, and weights make up
    /// for the difference (Kutz et al., "Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes", SIGGRAPH 2017).
    fn sample(
        &self,
        medium: &PreparedMedium,
        (o, d, t_max): (DVec3, DVec3, f64),
        random: &mut Random,
    ) -> MediumSample {
        let (mut weight, mut collisions) = (Vec3::ONE, self.collisions(medium, (o, d, t_max)));
        while let Some((t, real)) = collisions.next(random)
            && weight != Vec3::ZERO
        {
            // The channels count by what they have left.
            let probability = (weight * real).element_sum() / weight.element_sum();
            if random.next() < f64::from(probability) {
                let albedo = medium.scattering / medium.extinction.max(Vec3::splat(f32::MIN_POSITIVE));
                return MediumSample { t: Some(t), weight: weight * real * albedo / probability };
            }
            weight *= (Vec3::ONE - real) / (1.0 - probability);
        }
        MediumSample { t: None, weight }
    }

    /// Ratio tracking, with roulette once little gets through.
    fn transmittance(
        &self,
        medium: &PreparedMedium,
        (o, d, t_max): (DVec3, DVec3, f64),
        random: &mut Random,
    ) -> Vec3 {
        let (mut share, mut collisions) = (Vec3::ONE, self.collisions(medium, (o, d, t_max)));
        while let Some((_, real)) = collisions.next(random) {
            share *= Vec3::ONE - real;
            let most = share.max_element();
            if most < 0.1 {
                let survival = most.min(0.95);
                if random.next() >= f64::from(survival) {
                    return Vec3::ZERO;
                }
                share /= survival;
            }
        }
        share
    }

    /// The collisions of a ray with a medium that is as dense everywhere in the box as it is anywhere.
    fn collisions(&self, medium: &PreparedMedium, (o, d, t_max): (DVec3, DVec3, f64)) -> Collisions<'_> {
        let extinction = medium.extinction;
        let largest = extinction.max_element() * self.majorant;
        let within = self.within(o, d, t_max).filter(|_| largest > 0.0);
        let (o, d, [near, far]) = within.unwrap_or((o, d, [0.0; 2]));
        Collisions {
            grid: self,
            extinction,
            largest,
            o: o + d * near,
            d,
            near,
            t: 0.0,
            end: far - near,
            count: 0,
        }
    }
}

/// Collisions along a ray. In the space of the grid, but distances are those of the world.
struct Collisions<'g> {
    grid: &'g PreparedGrid<'g>,
    extinction: Vec3,
    /// The largest extinction.
    largest: f32,
    /// Where the ray enters the box, and its direction.
    o: DVec3,
    d: DVec3,
    /// The distance to there.
    near: f64,
    /// Distances from there: of the last collision, and where the ray leaves the box.
    t: f64,
    end: f64,
    /// The number of collisions so far.
    count: u32,
}

/// After so many collisions that were not real, about half a millisecond, the next one is: in a grid where that happens, one density is far
/// beyond all others, and rays would never come to their ends.
const MOST_COLLISIONS: u32 = 10_000;

impl Collisions<'_> {
    /// The distance of the next collision, and the share of each channel that really collides there.
    fn next(&mut self, random: &mut Random) -> Option<(f64, Vec3)> {
        if self.t >= self.end {
            return None;
        }
        self.t -= libm::log(1.0 - random.next()) / f64::from(self.largest);
        self.count += 1;
        let Collisions { grid, extinction, largest, o, d, near, t, end, count } = *self;
        let real = |t: f64| match count {
            ..MOST_COLLISIONS => extinction * (grid.density(o + d * t) / largest),
            _ => Vec3::ONE,
        };
        (t < end).then(|| (near + t, real(t)))
    }
}

/// Random numbers for tracking in media, as many as it takes.
pub(crate) struct Random(u64);

impl Random {
    /// Numbers that depend on a ray alone. No two rays of a picture are the same, and other seeds give other rays.
    pub fn new(o: DVec3, d: DVec3) -> Self {
        let numbers = o.to_array().into_iter().chain(d.to_array());
        Random(numbers.fold(0, |hash, number| mix(hash ^ number.to_bits())))
    }

    /// A number from 0 to 1, below 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        unit(mix(self.0))
    }
}

/// Phase functions of Henyey and Greenstein (PBR 11.2), at points that light leaves towards `wo`.
#[derive(Clone, Copy)]
pub(crate) struct Phase<S: Simd> {
    pub wo: Vec3fx8<S>,
    /// Above -1 and below 1.
    pub asymmetry: f32x8<S>,
}

impl<S: Simd> Phase<S> {
    /// The phase function, which is also the density of [`Phase::sample`] by solid angle.
    #[inline(always)]
    pub fn p(&self, wi: Vec3fx8<S>) -> f32x8<S> {
        let g = self.asymmetry;
        // 1 + g² + 2 g cos, without cancellation.
        let towards = wi + self.wo * splat_f32(g.token(), 1.0).copysign(g);
        let below = (1.0 - g.abs()) * (1.0 - g.abs()) + g.abs() * towards.length_squared();
        (1.0 - g * g) * (1.0 / (4.0 * PI) as f32) / (below * below.sqrt())
    }

    /// Samples a direction.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [f64x8<S>; 2]) -> Vec3fx8<S> {
        let (simd, g) = (u.token(), self.asymmetry);
        let (u, turn) = (to_f32(u), to_f32(v));
        let is_even: mask32x8<S> = g.simd_eq(0.0);
        let root = (1.0 - g * g) / (1.0 + g - 2.0 * g * u);
        let cos = -(1.0 + g * g - root * root) / (2.0 * is_even.select(splat_f32(simd, 1.0), g));
        let cos = is_even.select(1.0 - 2.0 * u, cos).max(-1.0).min(1.0);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let [x, y] = at_turn(turn);
        let Frames { x: a, y: b, .. } = Frames::from_z(self.wo);
        (a * (x * sin) + b * (y * sin) + self.wo * cos).normalize()
    }
}
