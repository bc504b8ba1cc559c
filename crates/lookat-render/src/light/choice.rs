//! Light samplers: which light a point samples, by equal probabilities, power, estimates of each light, or the tree of lights.

#[cfg(test)]
mod tests;

use std::array::from_fn;
use std::f64::consts::PI;

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*, u32x8};
use lookat_scene::LightChoice;
use smallvec::SmallVec;

use super::tree::{Receiver, Step};
use super::{LightTable, Receivers, SceneLight};
use crate::bsdf::Domain;
use crate::light::tree::Leaves;
use crate::number::{
    LANES, Vec3fx8, bits, narrow, set_lanes, splat_f32, strength, to_f32, to_f64, vectorized, widen,
};
use crate::traceable::Traceable;

/// With more lights and triangles of lights than this, "spatial" asks a tree of them: else it estimates each light at each point. With
/// more lights beside the tree, it chooses by power.
const MANY: usize = 32;

/// Lights that are chosen, and their probabilities.
#[derive(Clone, Copy)]
pub(crate) struct Chosen<S: Simd> {
    /// The lanes with a light to sample.
    pub is_valid: mask64x8<S>,
    /// The indices of the lights.
    pub light: u32x8<S>,
    /// The triangles of the lights, if triangles are chosen one by one.
    pub triangle: Option<u32x8<S>>,
    pub probability: f32x8<S>,
}

/// Chooses one light for each of some points.
pub(crate) struct LightSampler<'v, S: Simd> {
    table: &'v LightTable,
    rule: LightChoice,
    /// The number of lights to sample. They come first.
    count: u32x8<S>,
    estimates: &'v mut Estimates,
    /// The sum of the estimates, or the number of lights if all are alike.
    total: f64x8<S>,
    tree: Option<TreeSampler<'v, S>>,
}

/// With "spatial" the estimates of all lights, or of those beside the tree and then of the entries of its cut; with "power" only of skies.
/// In `f64`, which holds irradiance in worlds of any size. Plain numbers: memory that is aligned for vectors takes several times as long to get.
pub(crate) type Estimates = SmallVec<[[f64; LANES]; 12]>;

impl LightTable {
    /// The number of lights that a surface samples, with a lune or without. They come first.
    pub fn eligible(&self, has_lune: bool) -> usize {
        if has_lune { self.lights.len() } else { self.uneven }
    }

    /// The number of lights that each surface samples, depending on whether it has a lune.
    #[inline(always)]
    pub fn eligible_at<S: Simd>(&self, simd: S, at: &Receivers<S>) -> u32x8<S> {
        at.by_lune(simd, [false, true].map(|has_lune| self.eligible(has_lune) as u32))
    }

    /// The strategy that is used if `choice` is requested.
    pub fn rule(&self, choice: LightChoice) -> LightChoice {
        let has_many = self.lights.len() > MANY && self.beside.len() > MANY;
        if choice == LightChoice::Spatial && has_many { LightChoice::Power } else { choice }
    }

    /// True if lights are chosen at all under this strategy.
    pub fn is_choice(&self, choice: LightChoice) -> bool {
        self.len() > 1 || self.uses_bvh(choice)
    }

    /// Builds the tree, if `choice` asks one. Threads that render must find it there: one that waits for it may not take over the work of
    /// another one that does.
    pub fn prepare(&self, choice: LightChoice) {
        if self.uses_bvh(choice) {
            self.leaves();
        }
    }

    fn leaves(&self) -> &Leaves {
        self.leaves.get_or_init(|| Leaves::new(&self.lights, |_| true))
    }

    /// True if this strategy chooses lights by the tree.
    fn uses_bvh(&self, choice: LightChoice) -> bool {
        self.needs_tree && self.rule(choice) == LightChoice::Spatial
    }

    /// The total power share of all lights but skies.
    fn power_of_others(&self) -> f64 {
        self.power_cdf.last().copied().unwrap_or(0.0)
    }
}

/// The lights that are in no tree.
pub(super) fn beside(lights: &[SceneLight]) -> Vec<usize> {
    (0..lights.len()).filter(|light| lights[*light].leaves() == 0).collect()
}

/// True if "spatial" uses a tree of these lights: there are many, or some are triangles.
pub(super) fn needs_tree(lights: &[SceneLight]) -> bool {
    let leaves = || lights.iter().map(SceneLight::leaves);
    leaves().any(|leaves| leaves > 1) || lights.len() > MANY && leaves().any(|leaves| leaves > 0)
}

impl<'v, S: Simd> LightSampler<'v, S> {
    #[inline(never)]
    pub fn new(
        simd: S,
        (table, choice): (&'v LightTable, LightChoice),
        at: &'v Receivers<S>,
        estimates: &'v mut Estimates,
    ) -> Self {
        vectorized!(simd, {
            let (rule, count, total) = (table.rule(choice), table.eligible_at(simd, at), 0.0.simd_into(simd));
            estimates.clear();
            let mut sampler = LightSampler { table, rule, count, estimates, total, tree: None };
            if table.uses_bvh(choice) {
                sampler.add_tree(TreeSampler { leaves: table.leaves(), beside: &table.beside, at });
                return sampler;
            }
            // Without a choice there is nothing to estimate.
            if table.eligible(at.lunes.is_some()) < 2 {
                return sampler;
            }
            let first = match rule {
                LightChoice::Uniform => {
                    sampler.total = f64x8::from_fn(simd, |lane| f64::from(count[lane]));
                    return sampler;
                }
                LightChoice::Power => table.first_sky,
                LightChoice::Spatial => 0,
            };
            if rule == LightChoice::Power {
                sampler.total = table.power_of_others().simd_into(simd);
            }
            sampler.estimates.reserve(table.lights.len() - first);
            for (number, light) in table.lights.iter().enumerate().skip(first) {
                let estimate = match rule {
                    LightChoice::Power => {
                        light.sampled_share(simd, at.lunes.as_ref()) * table.power_shares[number]
                    }
                    _ => light.estimate(simd, at),
                };
                sampler.add(sampler.if_eligible(number, estimate));
            }
            sampler
        })
    }

    /// Chooses triangles of the lights that have too many to sample each.
    #[inline(always)]
    pub fn of_triangles(
        simd: S,
        table: &'v LightTable,
        at: &'v Receivers<S>,
        estimates: &'v mut Estimates,
    ) -> Self {
        let (rule, count, total) = (LightChoice::Spatial, table.eligible_at(simd, at), 0.0.simd_into(simd));
        estimates.clear();
        let mut sampler = LightSampler { table, rule, count, estimates, total, tree: None };
        if table.chooses_triangles() {
            sampler.add_tree(TreeSampler { leaves: table.triangles(), beside: &[], at });
        }
        sampler
    }

    /// Chooses by a tree.
    #[inline(never)]
    fn add_tree(&mut self, tree: TreeSampler<'v, S>) {
        let (simd, TreeSampler { leaves, beside, at }) = (self.count.token(), tree);
        vectorized!(simd, {
            for number in beside {
                self.add(self.if_eligible(*number, self.table.lights[*number].estimate(simd, at)));
            }
            leaves.tree.estimates(
                simd,
                at,
                #[inline(always)]
                |estimate| self.add(estimate),
            );
            self.tree = Some(tree);
        });
    }

    #[inline(always)]
    fn add(&mut self, estimate: f64x8<S>) {
        self.total += estimate;
        self.estimates.push(estimate.to_array());
    }

    /// An estimate of a light where it is one of those to sample.
    #[inline(always)]
    fn if_eligible(&self, light: usize, estimate: f64x8<S>) -> f64x8<S> {
        widen(self.count.simd_gt(light as u32)).select(estimate, 0.0.simd_into(estimate.token()))
    }

    /// The points where there is more than one light.
    #[inline(always)]
    pub fn has_choice(&self) -> mask64x8<S> {
        widen(self.count.simd_gt(u32::from(self.tree.is_none())))
    }

    /// True if triangles of lights are chosen one by one.
    pub fn by_triangle(&self) -> bool {
        self.tree.is_some()
    }

    /// A light for each of the points that are active, by a number.
    #[inline(never)]
    pub fn choose(&self, u: f64x8<S>, active: mask64x8<S>) -> Chosen<S> {
        let simd = u.token();
        vectorized!(simd, {
            if let Some(tree) = &self.tree {
                return tree.choose((self.estimates, self.total), u, active);
            }
            let (mut light, mut estimate) = (0.simd_into(simd), 1.0.simd_into(simd));
            if self.has_choice().any_true() {
                let mark = u * self.total;
                (light, estimate) = match self.rule {
                    LightChoice::Uniform => {
                        let last = |lane: usize| self.count[lane].saturating_sub(1);
                        (u32x8::from_fn(simd, |lane| (mark[lane] as u32).min(last(lane))), estimate)
                    }
                    LightChoice::Power => self.by_power(mark),
                    LightChoice::Spatial => self.pick(mark, (light, bits(simd, 0xff)), estimate),
                };
            }
            let probability = self.share(estimate);
            let is_valid = active & widen(self.count.simd_gt(0) & probability.simd_gt(0.0));
            Chosen { is_valid, light, triangle: None, probability }
        })
    }

    /// The light where the sum of all powers passes `mark`, and its power.
    #[inline(always)]
    fn by_power(&self, mark: f64x8<S>) -> (u32x8<S>, f64x8<S>) {
        let (simd, table) = (mark.token(), self.table);
        let (mut light, mut power): (u32x8<S>, f64x8<S>) = (0.simd_into(simd), 0.0.simd_into(simd));
        for lane in 0..LANES {
            let found = table.power_cdf.partition_point(|sum| *sum <= mark[lane]);
            light[lane] = found as u32;
            power[lane] = if found < table.first_sky { table.power_shares[found] } else { 0.0 };
        }
        let is_sky = widen(light.simd_ge(table.first_sky as u32));
        if !is_sky.any_true() {
            return (light, power);
        }
        self.pick(mark - table.power_of_others(), (light, is_sky), power)
    }

    /// The light where the sum of the estimates passes `mark`, or else the last, and its estimate; where `open`.
    #[inline(always)]
    fn pick(
        &self,
        mark: f64x8<S>,
        (mut light, mut open): (u32x8<S>, mask64x8<S>),
        mut estimate: f64x8<S>,
    ) -> (u32x8<S>, f64x8<S>) {
        let mut rest = mark;
        let first = self.table.lights.len() - self.estimates.len();
        for (number, own) in self.estimates.iter().enumerate() {
            let number: u32x8<S> = ((first + number) as u32).simd_into(mark.token());
            let is_eligible = open & widen(number.simd_lt(self.count));
            light = narrow(is_eligible).select(number, light);
            let own = (*own).simd_into(mark.token());
            estimate = is_eligible.select(own, estimate);
            rest -= own;
            open &= !rest.simd_lt(0.0);
        }
        (light, estimate)
    }

    /// The probabilities with which [`LightSampler::choose`] gives lights, or triangles of lights if it gives these.
    #[inline(always)]
    pub fn probability(&self, (light, triangle): (u32x8<S>, u32x8<S>), active: mask64x8<S>) -> f32x8<S> {
        let (simd, table) = (self.count.token(), self.table);
        if let Some(tree) = &self.tree {
            return tree.probability((self.estimates, self.total), (light, triangle), active);
        }
        let first = table.lights.len() - self.estimates.len();
        let mut estimate: f64x8<S> = 0.0.simd_into(simd);
        for lane in set_lanes(active & self.has_choice()) {
            let number = light[lane] as usize;
            estimate[lane] = match self.rule {
                LightChoice::Power if number < first => table.power_shares[number],
                LightChoice::Uniform => 1.0,
                // Where there is no choice, none is estimated.
                _ => number
                    .checked_sub(first)
                    .and_then(|at| self.estimates.get(at))
                    .map_or(0.0, |own| own[lane]),
            };
        }
        light.simd_lt(self.count).select(self.share(estimate), splat_f32(simd, 0.0))
    }

    /// The shares of estimates, or 1 where there is no choice.
    #[inline(always)]
    fn share(&self, estimate: f64x8<S>) -> f32x8<S> {
        narrow(self.has_choice()).select(share(estimate, self.total), splat_f32(estimate.token(), 1.0))
    }
}

/// The shares of estimates in the sums of all.
#[inline(always)]
fn share<S: Simd>(estimate: f64x8<S>, total: f64x8<S>) -> f32x8<S> {
    to_f32(total.simd_gt(0.0).select(estimate / total, 0.0.simd_into(total.token())))
}

/// This much of all samples goes to lights alike, so that a weak light next to what it lights is not forgotten over a
/// strong one far away.
const UNIFORM_SHARE: f64 = 0.01;

/// The share of each light in all samples, about that in their power, in a scene of the given radius.
pub(super) fn power_shares(lights: &[SceneLight], radius: f64) -> Vec<f64> {
    let power: Vec<f64> = lights.iter().map(|light| light.power(radius)).collect();
    let total: f64 = power.iter().sum();
    let alike = 1.0 / lights.len() as f64;
    // Where no light has power, or one has all too much, all are alike.
    if total <= 0.0 || !total.is_finite() {
        return vec![alike; lights.len()];
    }
    power.iter().map(|power| (1.0 - UNIFORM_SHARE) * power / total + UNIFORM_SHARE * alike).collect()
}

/// The sums of the shares up to each light.
pub(super) fn cumulated(shares: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let add = |share: &f64| {
        sum += share;
        sum
    };
    shares.iter().map(add).collect()
}

/// About the radius of the scene.
pub(super) fn radius(traceable: &Traceable) -> f64 {
    let (low, high) = traceable.world.bvh.bounds.corners();
    let radius = (high - low).length() * 0.5;
    if radius.is_finite() { radius } else { 1.0 }
}

impl SceneLight {
    /// The approximate unoccluded irradiance that light samples are for.
    #[inline(always)]
    fn estimate<S: Simd>(&self, simd: S, at: &Receivers<S>) -> f64x8<S> {
        match self {
            SceneLight::Distant { direction, radiance } => {
                let cosine = at.cosine(Vec3fx8::splat(simd, direction.as_vec3()), splat_f32(simd, 0.0));
                Vec3fx8::splat(simd, *radiance).strength() * to_f64(cosine)
            }
            SceneLight::Infinite { radiance, .. } => {
                self.sampled_share(simd, at.lunes.as_ref()) * (strength(*radiance) * PI)
            }
            SceneLight::Environment(environment) => {
                self.sampled_share(simd, at.lunes.as_ref()) * (environment.brightness() * PI)
            }
            SceneLight::Surface(surface) => surface.estimate(simd, at),
            SceneLight::Point(light) => light.estimate(simd, at),
        }
    }

    /// The approximate power of the light in a scene of the given radius.
    fn power(&self, radius: f64) -> f64 {
        match self {
            SceneLight::Point(light) => light.power(),
            SceneLight::Distant { radiance, .. } => PI * radius * radius * strength(*radiance),
            SceneLight::Infinite { radiance, .. } => PI * PI * radius * radius * strength(*radiance),
            SceneLight::Environment(environment) => PI * PI * radius * radius * environment.brightness(),
            SceneLight::Surface(surface) => surface.brightness * surface.facing.sides * surface.area * PI,
        }
    }
}

/// Chooses a leaf of the tree of lights, or a light beside it, for each of some points.
#[derive(Clone, Copy)]
struct TreeSampler<'v, S: Simd> {
    leaves: &'v Leaves,
    /// The lights beside the tree.
    beside: &'v [usize],
    at: &'v Receivers<S>,
}

impl<S: Simd> TreeSampler<'_, S> {
    #[inline(always)]
    fn receiver(&self, lane: usize) -> Receiver {
        let Domain { n, ns, is_two_sided, is_diffuse } = &self.at.domain;
        let [is_two_sided, is_diffuse] =
            [is_two_sided, is_diffuse].map(|mask| mask.to_bitmask() >> lane & 1 == 1);
        let [n, ns] = [n, ns].map(|n| n.lane(lane));
        Receiver { p: self.at.surfaces.p.lane(lane), n, ns, is_two_sided, is_diffuse }
    }

    /// A light for each of the points that are active, by a number.
    #[inline(always)]
    fn choose(
        &self,
        (estimates, total): (&Estimates, f64x8<S>),
        u: f64x8<S>,
        active: mask64x8<S>,
    ) -> Chosen<S> {
        let simd = u.token();
        let none: f64x8<S> = 0.0.simd_into(simd);
        let (zero, mut estimate, mut start): (u32x8<S>, _, _) = (0.simd_into(simd), none, none);
        let mut entry = zero;
        let (mut rest, mut open) = (u * total, active);
        for (number, own) in estimates.iter().enumerate() {
            let own: f64x8<S> = (*own).simd_into(simd);
            // If rounding passes all, the last one with light.
            let is_chosen = open & own.simd_gt(0.0);
            entry = narrow(is_chosen).select((number as u32).simd_into(simd), entry);
            estimate = is_chosen.select(own, estimate);
            start = is_chosen.select(rest, start);
            rest -= own;
            open &= !rest.simd_lt(0.0);
        }
        let is_valid = active & estimate.simd_gt(0.0);
        let u = (start / estimate).max(0.0).min(1.0);
        let (mut light, mut triangle, mut below) = (zero, zero, none);
        let mut steps = [Step::NONE; LANES];
        for lane in set_lanes(is_valid) {
            match (entry[lane] as usize).checked_sub(self.beside.len()) {
                Some(entry) => steps[lane] = self.leaves.tree.begin(entry, u[lane]),
                None => (light[lane], below[lane]) = (self.beside[entry[lane] as usize] as u32, 1.0),
            }
        }
        if steps.iter().any(|step| !step.is_done()) {
            let receivers: [Receiver; LANES] = from_fn(|lane| self.receiver(lane));
            // Side by side, because each step waits for the one before.
            while steps.iter().any(|step| !step.is_done()) {
                for (step, receiver) in steps.iter_mut().zip(&receivers) {
                    self.leaves.tree.descend(simd, receiver, step);
                }
            }
        }
        for (lane, step) in steps.iter().enumerate() {
            let Some(leaf) = step.leaf() else { continue };
            let leaf = self.leaves.of(leaf);
            (light[lane], triangle[lane]) = (leaf.light as u32, leaf.triangle as u32);
            below[lane] = step.probability;
        }
        let probability = share(estimate * below, total);
        let is_valid = is_valid & widen(probability.simd_gt(0.0));
        Chosen { is_valid, light, triangle: Some(triangle), probability }
    }

    /// The probabilities with which [`TreeSampler::choose`] gives lights and their triangles.
    #[inline(always)]
    fn probability(
        &self,
        (estimates, total): (&Estimates, f64x8<S>),
        (light, triangle): (u32x8<S>, u32x8<S>),
        active: mask64x8<S>,
    ) -> f32x8<S> {
        let simd = light.token();
        let mut estimate: f64x8<S> = 0.0.simd_into(simd);
        for lane in set_lanes(active) {
            let number = light[lane] as usize;
            estimate[lane] = match self.leaves.find(number, triangle[lane] as usize) {
                Some(leaf) => match self.leaves.tree.find(simd, &self.receiver(lane), leaf) {
                    Some((entry, below)) => estimates[self.beside.len() + entry][lane] * below,
                    None => 0.0,
                },
                None => {
                    let entry = self.beside.iter().position(|beside| *beside == number);
                    entry.map_or(0.0, |entry| estimates[entry][lane])
                }
            };
        }
        share(estimate, total)
    }
}
