//! Which way a shape that emits is turned.

use glam::DVec3;

use super::receiver::LEAST_COSINE;

/// A patch of a shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    pub p: DVec3,
    /// The unit normal on the side that emits.
    pub emitting: DVec3,
    pub area: f64,
}

/// The direction in which most of a shape emits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    /// The mean of the normals: of length one where all are the same, 0 where they go everywhere alike.
    mean: DVec3,
    /// Whether all lies in one plane.
    is_flat: bool,
    /// How many sides emit.
    pub sides: f64,
}

/// What may be off by rounding, relative to the size of a shape.
const ROUNDING: f64 = 1e-6;

impl Facing {
    /// That of a shape with these patches around a centre.
    pub fn new(patches: &[Patch], center: DVec3, two_sided: bool) -> Self {
        let area: f64 = patches.iter().map(|patch| patch.area).sum();
        let mean = patches.iter().map(|patch| patch.emitting * patch.area).sum::<DVec3>() / area;
        let height = |patch: &Patch| (patch.p - center).dot(mean).abs();
        let is_in_plane = |patch: &Patch| patch.area == 0.0 || height(patch) <= ROUNDING * area.sqrt();
        let is_flat = mean.length() > 1.0 - ROUNDING && patches.iter().all(is_in_plane);
        Facing { mean, is_flat, sides: if two_sided { 2.0 } else { 1.0 } }
    }

    /// About the share of the area that shines in a direction, foreshortened; 0 on the dark side of what is flat.
    #[inline]
    pub fn share(&self, d: DVec3) -> f64 {
        let along = if self.sides > 1.0 { self.mean.dot(d).abs() } else { self.mean.dot(d) };
        match self.is_flat {
            true if along <= 0.0 => 0.0,
            true => along.max(LEAST_COSINE),
            // A closed convex shape shows a quarter.
            false => along.max(0.25 * self.sides),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(p: DVec3, emitting: DVec3) -> Patch {
        Patch { p, emitting, area: 1.0 }
    }

    #[test]
    fn flat_shapes_have_a_dark_side() {
        let (middle, slanted) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.6, 0.8));
        let flat = [patch(middle + DVec3::X, DVec3::Z), patch(middle - DVec3::X, DVec3::Z)];
        let shares = |two_sided| {
            let facing = Facing::new(&flat, middle, two_sided);
            [DVec3::Z, slanted, DVec3::X, -DVec3::Z].map(|d| facing.share(d))
        };
        assert_eq!(shares(false), [1.0, 0.8, 0.0, 0.0]);
        assert_eq!(shares(true), [1.0, 0.8, 0.0, 1.0]);
        // Steps are seen from between them.
        let steps = [patch(middle + slanted, DVec3::Z), patch(middle - slanted, DVec3::Z)];
        assert_eq!(Facing::new(&steps, middle, false).share(-DVec3::Z), 0.25);
        // All around.
        let cube = DVec3::AXES.map(|axis| [axis, -axis]).concat();
        let cube: Vec<Patch> = cube.iter().map(|n| patch(middle + n, *n)).collect();
        assert_eq!(Facing::new(&cube, middle, false).share(slanted), 0.25);
    }
}
