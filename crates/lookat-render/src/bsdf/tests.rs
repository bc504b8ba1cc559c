use super::Slots;
use super::lobe::{Kind, Lobes};
use super::*;
use crate::number::Colors;
use crate::testing::baseline;
use glam::Vec3;

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
