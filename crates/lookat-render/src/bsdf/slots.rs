//! The lobes at points side by side: a lobe of a kind, where it is, and how likely it is to be sampled.

use fearless_simd::{Simd, f32x8, mask32x8, mask64x8, prelude::*};
use glam::Vec3;
use smallvec::SmallVec;

use super::lobe::{Lobe, Lobes, PointLobe};
use crate::number::{Colors, narrow, splat_f32, vectorized};

/// A lobe.
#[derive(Clone, Copy)]
pub(super) struct Slot<S: Simd> {
    pub lobe: Lobes<S>,
    /// Where it is.
    pub mask: mask32x8<S>,
    /// The probability that a sample of all lobes is one of it.
    pub probability: f32x8<S>,
}

/// All lobes; the lobes of a point are in order. Few materials have more than six.
pub(crate) struct Slots<S: Simd>(pub(super) SmallVec<[Slot<S>; 6]>);

/// The lobes of a material at a point.
#[derive(Debug, Default)]
pub(crate) struct PointLobes(pub(super) SmallVec<[PointLobe; 8]>);

impl<S: Simd> Slots<S> {
    /// Of points without any.
    #[inline(always)]
    pub fn new() -> Self {
        Slots(SmallVec::new())
    }

    /// Adds the lobes of points that are alike, and have none yet.
    #[inline(never)]
    pub fn add(&mut self, simd: S, lobes: &PointLobes, points: mask64x8<S>) {
        vectorized!(simd, {
            let (own, mut from) = (narrow(points), 0);
            for lobe in &lobes.0 {
                self.push(Lobe::splat(simd, lobe), own, &mut from);
            }
        })
    }

    /// Adds lobes at some points, whose lobes so far are in slots before `from`.
    #[inline(always)]
    pub(super) fn push(&mut self, lobe: Lobes<S>, own: mask32x8<S>, from: &mut usize) {
        let at = self.0[*from..].iter().position(|slot| slot.lobe.kind == lobe.kind);
        let at = at.map_or(self.0.len(), |at| *from + at);
        match self.0.get_mut(at) {
            Some(slot) => {
                slot.lobe = lobe.or(own, slot.lobe);
                slot.mask |= own;
            }
            None => self.0.push(Slot { lobe, mask: own, probability: splat_f32(own.token(), 1.0) }),
        }
        *from = at + 1;
    }

    /// About what all lobes scatter, in all, of light that comes along the normals.
    #[inline(always)]
    pub fn albedo(&self, simd: S) -> Colors<S> {
        let black = Colors::splat(simd, Vec3::ZERO);
        let mut sum = black;
        for slot in &self.0 {
            sum = sum + slot.lobe.albedo(splat_f32(simd, 1.0)).or(slot.mask, black);
        }
        sum
    }

    /// The lobes of the first point.
    pub(super) fn first(&self) -> PointLobes {
        let own = self.0.iter().filter(|slot| slot.mask.to_bitmask() & 1 == 1);
        PointLobes(own.map(|slot| slot.lobe.first()).collect())
    }
}
