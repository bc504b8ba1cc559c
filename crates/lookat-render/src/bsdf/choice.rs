//! Which of its lobes a sample of a BSDF is of.

use glam::{DVec3, Vec3};

use super::Part;
use super::lobe::Lobe;
use crate::warp::pick;

/// A lobe, and the probability that a sample of all lobes is one of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct LikelyLobe {
    pub lobe: Lobe,
    pub probability: f64,
}

/// The share of samples that lobes have alike, whatever they scatter: a lobe may scatter more than it seems to, or what it
/// scatters may be brighter (defensive mixtures; Hesterberg, "Weighted average importance sampling and defensive mixture
/// distributions", Technometrics 37(2), 1995).
pub(super) const ALIKE: f64 = 0.25;

impl LikelyLobe {
    /// A lobe that is the only one as yet.
    pub fn alone(lobe: Lobe) -> Self {
        LikelyLobe { lobe, probability: 1.0 }
    }
}

/// Makes lobes the likelier, the more they scatter of what comes along `wo`.
pub(super) fn weigh(lobes: &mut [LikelyLobe], wo: DVec3) {
    if lobes.len() < 2 {
        return;
    }
    let mut sum = 0.0;
    for likely in lobes.iter_mut() {
        // Reflectances of more than 1 may make something negative of it.
        likely.probability = f64::from(likely.lobe.albedo(wo).max(Vec3::ZERO).dot(Vec3::ONE));
        sum += likely.probability;
    }
    // Textures may give more than can be added up.
    let usable = sum > 0.0 && sum.is_finite();
    let alike = 1.0 / lobes.len() as f64;
    for likely in lobes {
        likely.probability = match usable {
            true => alike * ALIKE + likely.probability / sum * (1.0 - ALIKE),
            false => alike,
        };
    }
}

/// The probability that a sample of all lobes is one of a part.
pub(super) fn probability(lobes: &[LikelyLobe], part: Part) -> f64 {
    match part {
        Part::All => 1.0,
        _ => of(lobes, part).map(|likely| likely.probability).sum(),
    }
}

fn of(lobes: &[LikelyLobe], part: Part) -> impl Iterator<Item = &LikelyLobe> {
    lobes.iter().filter(move |likely| part.holds(&likely.lobe))
}

/// One of the lobes of a part, its probability among them, and a number from 0 to 1 to go on with.
pub(super) fn choose(lobes: &[LikelyLobe], part: Part, u: f64) -> Option<(&Lobe, f64, f64)> {
    let all = probability(lobes, part);
    let (index, probability, rest) = pick(of(lobes, part).map(|likely| likely.probability), u * all)?;
    let lobe = &of(lobes, part).nth(index)?.lobe;
    Some((lobe, probability / all, (rest / probability).min(1.0 - f64::EPSILON)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lambert(reflectance: f32) -> LikelyLobe {
        LikelyLobe::alone(Lobe::Lambert { reflectance: Vec3::splat(reflectance) })
    }

    fn weighed(reflectances: &[f32]) -> Vec<LikelyLobe> {
        let mut lobes: Vec<_> = reflectances.iter().map(|r| lambert(*r)).collect();
        weigh(&mut lobes, DVec3::Z);
        lobes
    }

    /// A quarter is shared alike, the rest in proportion to what is reflected; alike where that says nothing.
    #[test]
    fn lobes_are_likely_by_what_they_reflect() {
        let probabilities = |reflectances: &[f32]| -> Vec<f64> {
            weighed(reflectances).iter().map(|likely| likely.probability).collect()
        };
        assert_eq!(probabilities(&[0.01]), [1.0]);
        let [a, b] = probabilities(&[0.25, 0.75])[..] else { panic!() };
        assert!((a - (0.125 + 0.25 * 0.75)).abs() < 1e-7 && (a + b - 1.0).abs() < 1e-15);
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
        let lobes = weighed(&[0.1, 0.2, 0.7]);
        let mut found = [(0, 0.0, 0.0); 3];
        for step in 0..STEPS {
            let (lobe, probability, rest) =
                choose(&lobes, Part::Smooth, (f64::from(step) + 0.5) / f64::from(STEPS)).unwrap();
            let index = lobes.iter().position(|likely| std::ptr::eq(&likely.lobe, lobe)).unwrap();
            assert!((0.0..1.0).contains(&rest));
            let (count, said, sum) = found[index];
            found[index] = (count + 1, said + probability, sum + rest);
        }
        for (count, said, sum) in found {
            let count = f64::from(count);
            assert!((said / count - count / f64::from(STEPS)).abs() < 1e-3);
            assert!((sum / count - 0.5).abs() < 1e-3);
        }
        assert!(choose(&lobes, Part::Specular, 0.5).is_none());
        assert!(choose(&lobes, Part::All, 1.0).unwrap().2 < 1.0);
    }
}
