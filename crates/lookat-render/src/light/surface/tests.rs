use super::*;
use crate::testing::baseline;

fn share(facing: &Facing, d: DVec3, spread: f64) -> f64 {
    baseline!(simd => facing.share(simd, Vec3x8::splat(simd, d), spread.simd_into(simd))[0])
}

fn patch(p: DVec3, emitting: DVec3) -> Patch {
    Patch { p, emitting, area: 1.0 }
}

#[test]
fn flat_shapes_have_a_dark_side() {
    let (middle, slanted) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.6, 0.8));
    let flat = [patch(middle + DVec3::X, DVec3::Z), patch(middle - DVec3::X, DVec3::Z)];
    let shares = |two_sided| {
        let facing = Facing::new(flat.into_iter(), middle, two_sided);
        [DVec3::Z, slanted, DVec3::X, -DVec3::Z].map(|d| share(&facing, d, 0.0))
    };
    assert_eq!(shares(false), [1.0, 0.8, 0.0, 0.0]);
    assert_eq!(shares(true), [1.0, 0.8, 0.0, 1.0]);
    // Steps are seen from between them.
    let steps = [patch(middle + slanted, DVec3::Z), patch(middle - slanted, DVec3::Z)];
    assert_eq!(share(&Facing::new(steps.into_iter(), middle, false), -DVec3::Z, 0.0), 0.25);
    // All around.
    let cube = DVec3::AXES.map(|axis| [axis, -axis]).concat();
    let cube = cube.iter().map(|n| patch(middle + n, *n));
    assert_eq!(share(&Facing::new(cube, middle, false), slanted, 0.0), 0.25);
    // From nearby, more of a large shape is seen than of its middle; from its plane nothing.
    let facing = Facing::new(flat.into_iter(), middle, false);
    let lifted = DVec3::new(1.0, 0.0, 1e-7);
    assert_eq!([slanted, DVec3::X, lifted].map(|d| share(&facing, d, 0.2)), [0.9, 0.0, 0.0]);
}
