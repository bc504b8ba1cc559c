//! Lights and triangles of lights, chosen by a tree.

use std::array::from_fn;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use super::{Chosen, share};
use crate::light::LightTable;
use crate::light::leaves::Leaves;
use crate::light::receiver::Receivers;
use crate::light::tree::{Place, Step};
use crate::number::{LANES, those, vectorized};

/// Chooses a leaf of the tree of lights, or a light beside it, for each of some points.
pub(super) struct TreeSampler<'v, S: Simd> {
    leaves: &'v Leaves,
    /// The lights beside the tree.
    beside: &'v [usize],
    /// The estimates of these, and of the entries of the tree's cut.
    estimates: Vec<f64x8<S>>,
    places: [Place; LANES],
    total: f64x8<S>,
}

impl<'v, S: Simd> TreeSampler<'v, S> {
    /// `count`: how many of the lights there are to sample.
    #[inline(never)]
    pub fn new(
        simd: S,
        (leaves, beside): (&'v Leaves, &'v [usize]),
        (table, count): (&'v LightTable, f64x8<S>),
        at: &Receivers<S>,
    ) -> Self {
        vectorized!(simd, Self::estimated(simd, (leaves, beside), (table, count), at))
    }

    #[inline(always)]
    fn estimated(
        simd: S,
        (leaves, beside): (&'v Leaves, &'v [usize]),
        (table, count): (&'v LightTable, f64x8<S>),
        at: &Receivers<S>,
    ) -> Self {
        let mut total: f64x8<S> = 0.0.simd_into(simd);
        let mut estimates = Vec::with_capacity(beside.len() + leaves.tree.entries());
        for number in beside {
            let estimate = table.lights[*number].estimate(simd, at);
            let estimate = count.simd_gt(*number as f64).select(estimate, 0.0.simd_into(simd));
            total += estimate;
            estimates.push(estimate);
        }
        leaves.tree.estimates(
            simd,
            at,
            #[inline(always)]
            |estimate| {
                total += estimate;
                estimates.push(estimate);
            },
        );
        let [two_sided, diffuse] =
            [at.domain.is_two_sided, at.domain.is_diffuse].map(|mask| mask.to_bitmask());
        let (n, ns) = (at.domain.n.narrow(), at.domain.ns.narrow());
        let places = from_fn(
            #[inline(always)]
            |lane| Place {
                p: at.surfaces.p.lane(lane),
                n: n.lane(lane),
                ns: ns.lane(lane),
                is_two_sided: two_sided >> lane & 1 == 1,
                is_diffuse: diffuse >> lane & 1 == 1,
            },
        );
        TreeSampler { leaves, beside, estimates, places, total }
    }

    /// A light for each of the points that are active, by a number.
    #[inline(always)]
    pub fn choose(&self, u: f64x8<S>, active: mask64x8<S>) -> Chosen<S> {
        let simd = u.token();
        let none: f64x8<S> = 0.0.simd_into(simd);
        let (mut entry, mut estimate, mut start) = (none, none, none);
        let (mut rest, mut open) = (u * self.total, active);
        for (number, own) in self.estimates.iter().enumerate() {
            // If rounding passes all, the last one with light.
            let is_chosen = open & own.simd_gt(0.0);
            entry = is_chosen.select((number as f64).simd_into(simd), entry);
            estimate = is_chosen.select(*own, estimate);
            start = is_chosen.select(rest, start);
            rest -= *own;
            open &= !rest.simd_lt(0.0);
        }
        let is_there = active & estimate.simd_gt(0.0);
        let u = (start / estimate).max(0.0).min(1.0);
        let (mut light, mut triangle, mut below) = (none, none, none);
        let mut steps = [Step::NONE; LANES];
        for lane in those(is_there) {
            match (entry[lane] as usize).checked_sub(self.beside.len()) {
                Some(entry) => steps[lane] = self.leaves.tree.begin(entry, u[lane]),
                None => (light[lane], below[lane]) = (self.beside[entry[lane] as usize] as f64, 1.0),
            }
        }
        // Side by side, because each step waits for the one before.
        while steps.iter().any(|step| !step.is_done()) {
            for (step, place) in steps.iter_mut().zip(&self.places) {
                self.leaves.tree.go_on(simd, place, step);
            }
        }
        for (lane, step) in steps.iter().enumerate() {
            let Some(leaf) = step.leaf() else { continue };
            let leaf = self.leaves.of(leaf);
            (light[lane], triangle[lane]) = (leaf.light as f64, leaf.triangle as f64);
            below[lane] = step.probability;
        }
        let probability = share(estimate, self.total) * below;
        Chosen { is_there, light, triangle: Some(triangle), probability }
    }

    /// The probabilities with which [`TreeSampler::choose`] gives lights and their triangles.
    #[inline(always)]
    pub fn probability(&self, (light, triangle): (f64x8<S>, f64x8<S>), active: mask64x8<S>) -> f64x8<S> {
        let simd = light.token();
        let mut estimate: f64x8<S> = 0.0.simd_into(simd);
        for lane in those(active) {
            let number = light[lane] as usize;
            estimate[lane] = match self.leaves.find(number, triangle[lane] as usize) {
                Some(leaf) => match self.leaves.tree.find(simd, &self.places[lane], leaf) {
                    Some((entry, below)) => self.estimates[self.beside.len() + entry][lane] * below,
                    None => 0.0,
                },
                None => {
                    let entry = self.beside.iter().position(|beside| *beside == number);
                    entry.map_or(0.0, |entry| self.estimates[entry][lane])
                }
            };
        }
        share(estimate, self.total)
    }
}
