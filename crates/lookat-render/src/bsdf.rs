//! BSDFs at eight points side by side: their lobes, how a lobe is chosen for a sample, and what they scatter. Directions are in
//! the world and point away from the surface.

mod disney;
mod fourier;
mod fresnel;
mod hair;
mod lobe;
mod material;
mod microfacet;
#[cfg(test)]
mod tests;

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*, u32x8};
use glam::Vec3;
use smallvec::SmallVec;

use crate::frame::Frames;
use crate::number::{Vec3fx8, Vec3x8, bits, narrow, splat_f32, to_f32, to_f64, vectorized, widen};
pub(crate) use lobe::BsdfSample;
use lobe::{Lobe, LobeKind, Lobes, PointLobe};
pub(crate) use material::most_lobes;

/// Selects lobes by whether they are delta distributions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LobeFilter {
    All,
    /// Lobes that scatter into all directions.
    NonDelta,
    /// Delta lobes, which scatter into single directions. Light samples cannot reach these directions.
    Delta,
}

impl LobeFilter {
    fn holds(self, kind: LobeKind) -> bool {
        match self {
            LobeFilter::All => true,
            LobeFilter::NonDelta => !kind.is_delta(),
            LobeFilter::Delta => kind.is_delta(),
        }
    }
}

/// The directions from which non-delta lobes scatter light.
#[derive(Clone, Copy)]
pub(crate) struct Domain<S: Simd> {
    /// The geometric normals on the side of `wo`.
    pub n: Vec3fx8<S>,
    /// The shading normals on the side of `wo`: the BSDF samples directions on the same side of them.
    pub ns: Vec3fx8<S>,
    /// The points where light also comes through from behind.
    pub is_two_sided: mask32x8<S>,
    /// The points whose only lobe is Lambertian: all directions count by their cosine.
    pub is_diffuse: mask32x8<S>,
}

/// The scattering of light at points, each towards one direction, `wo`.
#[derive(Clone, Copy)]
pub(crate) struct Bsdf<'s, S: Simd> {
    /// The geometric normals on the side of `wo`: they decide which directions are on the same side.
    n: Vec3fx8<S>,
    /// The shading normals and frames.
    ns: Vec3x8<S>,
    frames: Frames<f32x8<S>>,
    wo: Vec3x8<S>,
    /// `wo` in the shading frames.
    local_o: Vec3fx8<S>,
    slots: &'s [LobeSlot<'s, S>],
}

/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

impl<'s, S: Simd> Bsdf<'s, S> {
    /// The BSDFs at points with geometric normals `n` and shading normals `ns`. Sets the probabilities of the lobes.
    #[inline(always)]
    pub fn new<'m: 's>(
        n: Vec3fx8<S>,
        ns: Vec3x8<S>,
        frames: Frames<f32x8<S>>,
        wo: Vec3x8<S>,
        slots: &'s mut LobeSlots<'m, S>,
    ) -> Self {
        let (local_o, n) = (frames.to_local(wo.narrow()), n.face_forward(wo.narrow()));
        weigh(&mut slots.lobes, local_o.z);
        Bsdf { n, ns, frames, wo, local_o, slots: &slots.lobes }
    }

    /// The points with lobes that pass the filter.
    #[inline(always)]
    pub fn has(&self, filter: LobeFilter) -> mask64x8<S> {
        widen(self.of(|kind| filter.holds(kind)))
    }

    /// The points with lobes of some kinds.
    #[inline(always)]
    fn of(&self, holds: impl Fn(LobeKind) -> bool) -> mask32x8<S> {
        let mut all = mask32x8::splat(self.local_o.z.token(), false);
        for slot in self.slots.iter().filter(|slot| holds(slot.lobe.kind)) {
            all |= slot.mask;
        }
        all
    }

    /// The domain of incident light for non-delta lobes.
    #[inline(always)]
    pub fn domain(&self) -> Domain<S> {
        Domain {
            n: self.n,
            ns: (-self.frames.z).keep_where(self.local_o.z.simd_lt(0.0), self.frames.z),
            is_two_sided: self.of(|kind| kind.transmits()),
            is_diffuse: !self.of(|kind| kind != LobeKind::Lambert),
        }
    }

    /// The BSDF times the cosine between `wi` and the shading normal, and the density by solid angle with which
    /// [`Bsdf::sample`] gives `wi`. Delta lobes do not count.
    #[inline(always)]
    pub fn f_cos_pdf(&self, wi: Vec3fx8<S>, filter: LobeFilter) -> (Vec3fx8<S>, f32x8<S>) {
        self.at(wi, self.frames.to_local(wi), filter)
    }

    /// Evaluates the BSDF times cosine and the density, for a direction in the world that is `local_i` in the shading
    /// frames. The geometric normal decides the side, so that bumps let no light through.
    #[inline(never)]
    fn at(&self, wi: Vec3fx8<S>, local_i: Vec3fx8<S>, filter: LobeFilter) -> (Vec3fx8<S>, f32x8<S>) {
        let simd = wi.x.token();
        vectorized!(simd, {
            let (none, black) = (splat_f32(simd, 0.0), Vec3fx8::splat(simd, Vec3::ZERO));
            let (wo, side) = (self.local_o, wi.dot(self.n));
            let is_seen = wo.z.simd_ne(0.0);
            let above = side.simd_gt(0.0) & is_seen;
            let through = side.simd_lt(0.0) & is_seen;
            let same_side = (wo.z * local_i.z).simd_gt(0.0);
            let (mut f, mut pdf) = (black, none);
            for slot in self.slots.iter().filter(|slot| !slot.lobe.kind.is_delta()) {
                let (own_f, own_pdf) = slot.lobe.f_pdf(wo, local_i, above, slot.mask & is_seen);
                let (side, sampled) = match slot.lobe.kind {
                    LobeKind::RoughGlass | LobeKind::Hair | LobeKind::Fourier(_) => {
                        (above | through, is_seen)
                    }
                    kind if kind.transmits() => (through, !same_side),
                    _ => (above, same_side),
                };
                f = f + own_f.keep_where(side & slot.mask, black);
                pdf += (sampled & slot.mask).select(slot.probability * own_pdf, none);
            }
            if filter == LobeFilter::NonDelta {
                let all = probability(simd, self.slots, filter);
                pdf = all.simd_gt(0.0).select(pdf / all, none);
            }
            (f * local_i.z.abs(), pdf)
        })
    }

    /// Samples directions of one lobe, with a probability that grows with its albedo.
    #[inline(never)]
    pub fn sample(&self, [u, v]: [f64x8<S>; 2], filter: LobeFilter) -> BsdfSample<S> {
        let simd = u.token();
        vectorized!(simd, {
            let choice = choose(self.slots, filter, u);
            let one = splat_f32(simd, 1.0);
            // What is left of the number beyond the 24 bits that directions take.
            let fine = choice.rest * 16_777_216.0;
            let fine = to_f32(fine - fine.floor()).min(BELOW_ONE);
            let square = [to_f32(choice.rest).min(BELOW_ONE), to_f32(v).min(BELOW_ONE)];
            let none = mask32x8::splat(simd, false);
            let (mut local, mut radiance_scale, mut is_smooth) = (self.local_o, one, none);
            let mut delta: Option<(mask64x8<S>, BsdfSample<S>)> = None;
            for (number, slot) in self.slots.iter().enumerate() {
                let own = choice.slot.simd_eq(number as u32);
                if !own.any_true() {
                    continue;
                }
                if slot.lobe.kind.is_delta() {
                    let sample = slot.lobe.delta_sample(self.ns, self.wo, choice.rest);
                    let own = widen(own);
                    delta = Some(match delta {
                        Some((others, all)) => (own | others, sample.keep_where(own, all)),
                        None => (own, sample),
                    });
                } else {
                    let (wi, is_valid) = slot.lobe.sample(self.local_o, square, fine, own);
                    local = wi.keep_where(own, local);
                    is_smooth |= own & is_valid;
                    radiance_scale =
                        own.select(slot.lobe.radiance_scale(self.local_o.z, wi.z), radiance_scale);
                }
            }
            let mut sample = self.non_delta(local, is_smooth, filter);
            sample.radiance_scale = radiance_scale;
            if let Some((own, mut delta)) = delta {
                let pdf = delta.pdf * choice.probability;
                delta.is_valid &= delta.weight.is_light() & widen(pdf.simd_gt(0.0));
                delta.weight = delta.weight / pdf;
                delta.pdf = pdf;
                sample = delta.keep_where(own, sample);
            }
            sample.is_valid &= widen(self.local_o.z.simd_ne(0.0));
            sample
        })
    }

    /// All delta samples that [`Bsdf::sample`] chooses from at each point, in the order of the lobes. Their weights are not
    /// divided by the probabilities.
    #[inline(never)]
    pub fn delta_samples(&self) -> SmallVec<[BsdfSample<S>; 2]> {
        let simd = self.local_o.z.token();
        vectorized!(simd, {
            let all = probability(simd, self.slots, LobeFilter::Delta);
            let is_seen = widen(self.local_o.z.simd_ne(0.0));
            let mut samples: SmallVec<[BsdfSample<S>; 2]> = SmallVec::new();
            for slot in self.slots.iter().filter(|slot| slot.lobe.kind.is_delta()) {
                let mut own = widen(slot.mask) & is_seen;
                // Glass reflects for small numbers, and refracts for large ones.
                for u in [0.0, 1.0 - f64::EPSILON] {
                    let mut sample = slot.lobe.delta_sample(self.ns, self.wo, u.simd_into(simd));
                    let rest = own & widen(sample.pdf.simd_lt(1.0));
                    sample.pdf *= slot.probability / all;
                    sample.is_valid &= own & sample.weight.is_light();
                    for earlier in &mut samples {
                        let free = sample.is_valid & !earlier.is_valid;
                        *earlier = sample.keep_where(free, *earlier);
                        sample.is_valid &= !free;
                    }
                    if sample.is_valid.any_true() {
                        samples.push(sample);
                    }
                    own = rest;
                }
            }
            samples
        })
    }

    /// Completes samples of directions in the shading frames.
    #[inline(always)]
    fn non_delta(&self, local: Vec3fx8<S>, is_valid: mask32x8<S>, filter: LobeFilter) -> BsdfSample<S> {
        let simd = local.x.token();
        let wi = self.frames.to_world(local).normalize();
        let (weight, pdf) = if is_valid.any_true() {
            let (f_cos, pdf) = self.at(wi, local, filter);
            (f_cos / pdf, pdf)
        } else {
            (Vec3fx8::splat(simd, Vec3::ZERO), splat_f32(simd, 1.0))
        };
        let is_valid = widen(is_valid & pdf.simd_gt(0.0)) & weight.is_light();
        let (is_delta, radiance_scale) = (bits(simd, 0), splat_f32(simd, 1.0));
        BsdfSample { is_valid, wi: wi.widen(), pdf, weight, is_delta, radiance_scale }
    }
}

/// The share of samples that lobes have alike, whatever they scatter: a lobe may scatter more than it seems to, or what it
/// scatters may be brighter (defensive mixtures; Hesterberg, "Weighted average importance sampling and defensive mixture
/// distributions", Technometrics 37(2), 1995).
const UNIFORM_SHARE: f32 = 0.25;

/// Sets the probabilities of lobes by their albedo at an angle of cosine `cos_o`.
#[inline(always)]
fn weigh<S: Simd>(slots: &mut [LobeSlot<S>], cos_o: f32x8<S>) {
    if slots.len() < 2 {
        return;
    }
    let none = splat_f32(cos_o.token(), 0.0);
    let (mut sum, mut count) = (none, none);
    for slot in slots.iter_mut() {
        // Reflectances of more than 1 may make something negative of it.
        slot.probability = slot.mask.select(slot.lobe.albedo(cos_o).amount(), none);
        sum += slot.probability;
        count += slot.mask.select(splat_f32(none.token(), 1.0), none);
    }
    // Textures may give more than can be added up.
    let usable = sum.simd_gt(0.0) & sum.is_finite();
    let alike = 1.0 / count;
    for slot in slots {
        let own =
            usable.select(alike * UNIFORM_SHARE + slot.probability / sum * (1.0 - UNIFORM_SHARE), alike);
        slot.probability = slot.mask.select(own, none);
    }
}

/// The probability that a sample of all lobes passes the filter.
#[inline(always)]
fn probability<S: Simd>(simd: S, slots: &[LobeSlot<S>], filter: LobeFilter) -> f32x8<S> {
    if filter == LobeFilter::All {
        return splat_f32(simd, 1.0);
    }
    let mut sum = splat_f32(simd, 0.0);
    for (_, slot) in of(slots, filter) {
        sum += slot.probability;
    }
    sum
}

fn of<'s, S: Simd>(
    slots: &'s [LobeSlot<'s, S>],
    filter: LobeFilter,
) -> impl Iterator<Item = (usize, &'s LobeSlot<'s, S>)> {
    slots.iter().enumerate().filter(move |(_, slot)| filter.holds(slot.lobe.kind))
}

/// The index of no slot.
const NO_SLOT: u32 = u32::MAX;

/// A choice of one lobe at each point.
struct LobeChoice<S: Simd> {
    /// The index of the slot, or [`NO_SLOT`] without a lobe.
    pub slot: u32x8<S>,
    /// The probability of the choice among the lobes that pass the filter.
    pub probability: f32x8<S>,
    /// The rest of the random number, rescaled to 0..1.
    pub rest: f64x8<S>,
}

/// Chooses a lobe that passes the filter at each point: the first where the sum of probabilities exceeds `u` times the
/// total, or the last.
#[inline(always)]
fn choose<S: Simd>(slots: &[LobeSlot<S>], filter: LobeFilter, u: f64x8<S>) -> LobeChoice<S> {
    let simd = u.token();
    let all = probability(simd, slots, filter);
    let mut rest = u * to_f64(all);
    let mut open = mask32x8::splat(simd, true);
    let mut choice = LobeChoice { slot: NO_SLOT.simd_into(simd), probability: all, rest };
    for (number, slot) in of(slots, filter) {
        let own = open & slot.mask;
        choice.slot = own.select((number as u32).simd_into(simd), choice.slot);
        choice.probability = own.select(slot.probability, choice.probability);
        choice.rest = widen(own).select(rest, choice.rest);
        rest -= to_f64(slot.probability);
        open &= !(own & narrow(rest.simd_lt(0.0)));
    }
    choice.rest = (choice.rest / to_f64(choice.probability)).min(1.0 - f64::EPSILON);
    choice.probability /= all;
    choice
}

/// A lobe and the points that have it.
#[derive(Clone, Copy)]
struct LobeSlot<'m, S: Simd> {
    pub lobe: Lobes<'m, S>,
    /// The points that have the lobe.
    pub mask: mask32x8<S>,
    /// The probability that a sample of all lobes is of this lobe.
    pub probability: f32x8<S>,
}

/// The lobes of all points. The lobes of each point are in order. Few materials have more than six.
pub(crate) struct LobeSlots<'m, S: Simd> {
    lobes: SmallVec<[LobeSlot<'m, S>; 6]>,
    /// Of materials with a medium inside.
    inside: Option<Inside<S>>,
}

/// The media inside of points: see [`bssrdf`](crate::bssrdf).
#[derive(Clone, Copy)]
pub(crate) struct Inside<S: Simd> {
    /// The points with one.
    pub mask: mask32x8<S>,
    /// The two colors that describe it: see [`Body`](crate::bssrdf::Body).
    pub colors: [Vec3fx8<S>; 2],
    /// The index of refraction.
    pub eta: f32x8<S>,
}

/// The medium inside of a point.
#[derive(Debug, Clone, Copy)]
struct PointInside {
    colors: [Vec3; 2],
    eta: f32,
}

/// The lobes of a material at a point.
#[derive(Debug, Default)]
pub(crate) struct PointLobes<'m> {
    lobes: Box<[PointLobe<'m>]>,
    inside: Option<PointInside>,
}

impl<'m, S: Simd> LobeSlots<'m, S> {
    /// An empty list of lobes.
    #[inline(always)]
    pub fn new() -> Self {
        LobeSlots { lobes: SmallVec::new(), inside: None }
    }

    /// Adds the lobes of points that are alike, and have none yet.
    #[inline(never)]
    pub fn add(&mut self, simd: S, lobes: &PointLobes<'m>, points: mask64x8<S>) {
        vectorized!(simd, {
            let (own, mut from) = (narrow(points), 0);
            for lobe in &lobes.lobes {
                self.push(Lobe::splat(simd, lobe), own, &mut from);
            }
            if let Some(PointInside { colors: [a, b], eta }) = lobes.inside {
                let colors = [Vec3fx8::splat(simd, a), Vec3fx8::splat(simd, b)];
                self.set_inside(Inside { mask: own, colors, eta: splat_f32(simd, eta) });
            }
        })
    }

    /// Adds lobes at some points, whose lobes so far are in slots before `from`.
    #[inline(always)]
    fn push(&mut self, lobe: Lobes<'m, S>, own: mask32x8<S>, from: &mut usize) {
        let at = self.lobes[*from..].iter().position(|slot| slot.lobe.kind == lobe.kind);
        let at = at.map_or(self.lobes.len(), |at| *from + at);
        match self.lobes.get_mut(at) {
            Some(slot) => {
                slot.lobe = lobe.keep_where(own, slot.lobe);
                slot.mask |= own;
            }
            None => self.lobes.push(LobeSlot { lobe, mask: own, probability: splat_f32(own.token(), 1.0) }),
        }
        *from = at + 1;
    }

    /// Adds media inside of points. Points that have one keep it.
    #[inline(always)]
    fn set_inside(&mut self, inside: Inside<S>) {
        let Some(before) = &mut self.inside else {
            self.inside = Some(inside);
            return;
        };
        let own = before.mask;
        for (before, color) in before.colors.iter_mut().zip(inside.colors) {
            *before = before.keep_where(own, color);
        }
        before.eta = own.select(before.eta, inside.eta);
        before.mask |= inside.mask;
    }

    /// The media inside of points, if any has one.
    #[inline(always)]
    pub fn inside(&self) -> Option<Inside<S>> {
        self.inside
    }

    /// Points of which only diffuse light comes from inside, through boundaries of index `eta`: see [`LobeKind::Exit`].
    #[inline(always)]
    pub fn exits(scale: f32x8<S>, eta: f32x8<S>, points: mask64x8<S>) -> Self {
        let color = Vec3fx8 { x: scale, y: scale, z: scale };
        let (lobe, mut slots) = (Lobe { eta, ..Lobe::new(LobeKind::Exit, color) }, LobeSlots::new());
        slots.push(lobe, narrow(points), &mut 0);
        slots
    }

    /// About what all lobes scatter, in all, of light that comes along the normals.
    #[inline(always)]
    pub fn albedo(&self, simd: S) -> Vec3fx8<S> {
        let black = Vec3fx8::splat(simd, Vec3::ZERO);
        let mut sum = black;
        for slot in &self.lobes {
            sum = sum + slot.lobe.albedo(splat_f32(simd, 1.0)).keep_where(slot.mask, black);
        }
        sum
    }

    /// The lobes of the first point.
    fn first(&self) -> PointLobes<'m> {
        let own = self.lobes.iter().filter(|slot| slot.mask.to_bitmask() & 1 == 1);
        PointLobes {
            lobes: own.map(|slot| slot.lobe.first()).collect(),
            inside: self.inside.filter(|inside| inside.mask.to_bitmask() & 1 == 1).map(|inside| {
                PointInside { colors: inside.colors.map(|color| color.lane(0)), eta: inside.eta[0] }
            }),
        }
    }
}
