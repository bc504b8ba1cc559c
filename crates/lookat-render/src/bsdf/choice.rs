//! Which of its lobes a sample of a BSDF is of.

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, prelude::*};

use super::Part;
use super::slots::Slot;
use crate::number::{narrow, splat_f32, to_f64, widen};

/// The share of samples that lobes have alike, whatever they scatter: a lobe may scatter more than it seems to, or what it
/// scatters may be brighter (defensive mixtures; Hesterberg, "Weighted average importance sampling and defensive mixture
/// distributions", Technometrics 37(2), 1995).
const ALIKE: f32 = 0.25;

/// Makes lobes the likelier, the more they scatter of what comes at an angle of cosine `cos_o`.
#[inline(always)]
pub(super) fn weigh<S: Simd>(slots: &mut [Slot<S>], cos_o: f32x8<S>) {
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
        let own = usable.select(alike * ALIKE + slot.probability / sum * (1.0 - ALIKE), alike);
        slot.probability = slot.mask.select(own, none);
    }
}

/// The probability that a sample of all lobes is one of a part.
#[inline(always)]
pub(super) fn probability<S: Simd>(simd: S, slots: &[Slot<S>], part: Part) -> f32x8<S> {
    if part == Part::All {
        return splat_f32(simd, 1.0);
    }
    let mut sum = splat_f32(simd, 0.0);
    for (_, slot) in of(slots, part) {
        sum += slot.probability;
    }
    sum
}

fn of<S: Simd>(slots: &[Slot<S>], part: Part) -> impl Iterator<Item = (usize, &Slot<S>)> {
    slots.iter().enumerate().filter(move |(_, slot)| part.holds(slot.lobe.kind))
}

/// Lobes of a part.
pub(super) struct Choice<S: Simd> {
    /// Their slots; -1 where there is none.
    pub slot: f32x8<S>,
    /// The probability of each among the lobes of the part.
    pub probability: f32x8<S>,
    /// Numbers from 0 to 1 to go on with.
    pub rest: f64x8<S>,
}

/// Chooses a lobe of a part at each point: the first where the sum of probabilities exceeds `u` times the total, or the last.
#[inline(always)]
pub(super) fn choose<S: Simd>(slots: &[Slot<S>], part: Part, u: f64x8<S>) -> Choice<S> {
    let simd = u.token();
    let all = probability(simd, slots, part);
    let mut rest = u * to_f64(all);
    let mut open = mask32x8::splat(simd, true);
    let mut choice = Choice { slot: splat_f32(simd, -1.0), probability: all, rest };
    for (number, slot) in of(slots, part) {
        let own = open & slot.mask;
        choice.slot = own.select(splat_f32(simd, number as f32), choice.slot);
        choice.probability = own.select(slot.probability, choice.probability);
        choice.rest = widen(own).select(rest, choice.rest);
        rest -= to_f64(slot.probability);
        open &= !(own & narrow(rest.simd_lt(0.0)));
    }
    choice.rest = (choice.rest / to_f64(choice.probability)).min(1.0 - f64::EPSILON);
    choice.probability /= all;
    choice
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::bsdf::Slots;
    use crate::bsdf::lobe::{Kind, Lobes};
    use crate::number::Colors;
    use crate::testing::baseline;

    /// Lambert lobes of these reflectances, seen from the normal.
    fn weighed<S: Simd>(simd: S, reflectances: &[f32]) -> Slots<S> {
        let (mut slots, mut from) = (Slots::new(), 0);
        for color in reflectances {
            let lobe = Lobes::new(Kind::Lambert, Colors::splat(simd, Vec3::splat(*color)));
            slots.push(lobe, mask32x8::splat(simd, true), &mut from);
        }
        weigh(&mut slots.0, splat_f32(simd, 1.0));
        slots
    }

    /// A quarter is shared alike, the rest in proportion to what is reflected; alike where that says nothing.
    #[test]
    fn lobes_are_likely_by_what_they_reflect() {
        let probabilities = |reflectances: &[f32]| -> Vec<f32> {
            baseline!(simd => {
                weighed(simd, reflectances).0.iter().map(|slot| slot.probability[0]).collect()
            })
        };
        assert_eq!(probabilities(&[0.01]), [1.0]);
        let [a, b] = probabilities(&[0.25, 0.75])[..] else { panic!() };
        assert!((a - (0.125 + 0.25 * 0.75)).abs() < 1e-6 && (a + b - 1.0).abs() < 1e-6);
        for nothing in [-0.5, f32::NAN] {
            assert_eq!(probabilities(&[nothing, 1.0]), [0.125, 0.875]);
        }
        for useless in [[0.0, 0.0], [-1.0, 0.0], [f32::MAX, f32::MAX], [f32::INFINITY, 1.0]] {
            assert_eq!(probabilities(&useless), [0.5, 0.5]);
        }
    }

    /// Over even numbers, lobes come up as often as is said, and what is left of the number is even again.
    #[test]
    fn choices_keep_their_probabilities() {
        const STEPS: u32 = 10_000;
        let mut found = [(0, 0.0, 0.0); 3];
        baseline!(simd => {
            let slots = &weighed(simd, &[0.1, 0.2, 0.7]).0;
            for step in 0..STEPS {
                let u = (f64::from(step) + 0.5) / f64::from(STEPS);
                let choice = choose(slots, Part::Smooth, f64x8::splat(simd, u));
                assert!((0.0..1.0).contains(&choice.rest[0]));
                let (count, said, sum) = found[choice.slot[0] as usize];
                found[choice.slot[0] as usize] =
                    (count + 1, said + f64::from(choice.probability[0]), sum + choice.rest[0]);
            }
            assert_eq!(choose(slots, Part::Specular, f64x8::splat(simd, 0.5)).slot[0], -1.0);
            assert!(choose(slots, Part::All, f64x8::splat(simd, 1.0)).rest[0] < 1.0);
        });
        for (count, said, sum) in found {
            let count = f64::from(count);
            assert!((said / count - count / f64::from(STEPS)).abs() < 1e-3);
            assert!((sum / count - 0.5).abs() < 1e-3);
        }
    }
}
