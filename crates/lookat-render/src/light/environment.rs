//! Light from a picture of all directions (PBR 14.2.4).

mod table;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_image::MipMap;
use lookat_scene::Transform;

use super::lune::Lune;
use table::{DirectionTable, TableSample};

/// An infinite light with a picture.
pub(super) struct Environment {
    map: Arc<MipMap<Vec3>>,
    /// Factor of the picture.
    scale: Vec3,
    world_from_light: DMat3,
    light_from_world: DMat3,
    /// By how much a volume grows from light space to the world.
    growth: f64,
    table: DirectionTable,
    pub samples: u32,
}

/// A direction of the world that has been sampled.
pub(super) struct EnvironmentSample {
    /// Of length one.
    pub wi: DVec3,
    /// From there.
    pub radiance: Vec3,
    /// Density by solid angle.
    pub pdf: f64,
}

impl Environment {
    pub fn new(map: &Arc<MipMap<Vec3>>, scale: Vec3, world_from_light: &Transform, samples: u32) -> Self {
        let [matrix, inverse] = [world_from_light.matrix(), world_from_light.inverse_matrix()];
        let [world_from_light, light_from_world] = [matrix, inverse].map(DMat3::from_mat4);
        Environment {
            map: map.clone(),
            scale,
            world_from_light,
            light_from_world,
            growth: world_from_light.determinant().abs(),
            table: DirectionTable::new(map, scale),
            samples,
        }
    }

    /// The radiance from direction `wi` of the world.
    pub fn radiance(&self, wi: DVec3) -> Vec3 {
        self.shown(place(self.light_from_world * wi))
    }

    /// The radiance from a place on the picture.
    fn shown(&self, st: DVec2) -> Vec3 {
        self.scale * self.map.bilinear(st)
    }

    /// A direction, about in proportion to how much brighter it is than the mean, or one of the lune. `None` if neither is
    /// to be had.
    pub fn sample(&self, lune: Option<&Lune>, u: DVec2) -> Option<EnvironmentSample> {
        let Some(lune) = lune else { return self.sample_bright(u) };
        let share = self.lune_share(lune);
        if u.x < share {
            let wi = lune.sample(DVec2::new(u.x / share, u.y));
            let (radiance, pdf) = self.evaluate(Some(lune), wi);
            return (pdf > 0.0).then_some(EnvironmentSample { wi, radiance, pdf });
        }
        let sample = self.sample_bright(DVec2::new((u.x - share) / (1.0 - share), u.y))?;
        let pdf = mixed(share, lune.pdf(sample.wi), sample.pdf);
        Some(EnvironmentSample { pdf, ..sample })
    }

    fn sample_bright(&self, u: DVec2) -> Option<EnvironmentSample> {
        let TableSample { d, st, pdf } = self.table.sample(u)?;
        let in_world = self.world_from_light * d;
        let wi = in_world.try_normalize()?;
        // In light space, `wi` is `d` over that length.
        let pdf = pdf / self.stretch(in_world.length().recip());
        (pdf > 0.0).then(|| EnvironmentSample { wi, radiance: self.shown(st), pdf })
    }

    /// The radiance from `wi`, of length one, and the density of [`Environment::sample`] by solid angle there.
    pub fn evaluate(&self, lune: Option<&Lune>, wi: DVec3) -> (Vec3, f64) {
        let in_light = self.light_from_world * wi;
        let st = place(in_light);
        let bright = self.table.pdf(st) / self.stretch(in_light.length());
        let pdf = lune.map_or(bright, |lune| mixed(self.lune_share(lune), lune.pdf(wi), bright));
        (self.shown(st), pdf)
    }

    /// The share of a lune in the samples: that in the light which they are for.
    fn lune_share(&self, lune: &Lune) -> f64 {
        lune.share() / (lune.share() + self.share_above())
    }

    /// The solid angle that a direction of light space covers in the world, given the length of the world's there.
    fn stretch(&self, length_in_light: f64) -> f64 {
        self.growth * length_in_light.powi(3)
    }

    /// Whether it is everywhere alike, or nearly so, and not sampled but in a lune.
    pub fn is_even(&self) -> bool {
        self.table.mean_above() <= 0.0
    }

    /// The share of its light that is brighter than the mean.
    pub fn share_above(&self) -> f64 {
        if self.is_even() { 0.0 } else { self.table.mean_above() / self.table.mean() }
    }

    /// The mean luminance over all directions of light space.
    pub fn brightness(&self) -> f64 {
        self.table.mean()
    }
}

/// The density where a share of all samples has the density `a`, and the others have `b`.
fn mixed(share: f64, a: f64, b: f64) -> f64 {
    share * a + (1.0 - share) * b
}

/// The place of a direction, of any length, on a picture: longitude from +x by way of +y and latitude from +z, each from
/// 0 to 1.
pub(super) fn place(d: DVec3) -> DVec2 {
    let phi = d.y.atan2(d.x) / TAU;
    let theta = d.truncate().length().atan2(d.z) / PI;
    DVec2::new(if phi < 0.0 { phi + 1.0 } else { phi }, theta)
}

#[cfg(test)]
mod tests {
    use glam::DMat4;
    use lookat_image::Wrap;

    use super::*;
    use crate::bsdf::Domain;
    use crate::color::luminance;

    /// Turns, shears and mirrors.
    fn skewed() -> Transform {
        let skew = DMat3::from_cols_array(&[0.3, 1.2, 0.0, -0.5, 0.4, 0.9, 0.8, 0.1, 0.7]);
        Transform::from_matrix(DMat4::from_mat3(skew)).expect("it has an inverse")
    }

    /// A sky with a small sun.
    fn with<R>(world_from_light: Transform, check: impl Fn(&Environment) -> R) -> R {
        let mut texels: Vec<Vec3> = (0..32 * 16).map(|i| Vec3::splat((i * 37 % 11) as f32 * 0.1)).collect();
        texels[5 * 32 + 7] = Vec3::new(300.0, 200.0, 100.0);
        let map = MipMap::new(32, 16, texels, Wrap::Repeat);
        check(&Environment::new(&Arc::new(map), Vec3::new(1.0, 0.5, 2.0), &world_from_light, 1))
    }

    fn grid(side: u32) -> impl Iterator<Item = DVec2> {
        let cell = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        (0..side * side).map(move |i| DVec2::new(cell(i % side), cell(i / side)))
    }

    fn on_sphere(u: DVec2) -> DVec3 {
        let z = 1.0 - 2.0 * u.y;
        DVec2::from_angle(TAU * u.x).extend(0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
    }

    #[test]
    fn the_density_has_an_integral_of_one() {
        with(skewed(), |light| {
            let sum: f64 = grid(1500).map(|u| light.evaluate(None, on_sphere(u)).1).sum();
            let integral = sum * 4.0 * PI / (1500.0 * 1500.0);
            assert!((integral - 1.0).abs() < 0.01, "{integral}");
        });
    }

    /// Chi-square: as many samples fall into each part of the sphere as the density says.
    #[test]
    fn samples_follow_the_density() {
        let part = |d: DVec3| {
            let st = place(d);
            ((st.y * 8.0) as usize).min(7) * 16 + ((st.x * 16.0) as usize).min(15)
        };
        with(skewed(), |light| {
            let (mut expected, mut found) = (vec![0.0_f64; 128], vec![0.0_f64; 128]);
            let (side, samples) = (2000, 300);
            let each = 4.0 * PI / f64::from(side * side) * f64::from(samples * samples);
            for u in grid(side) {
                let d = on_sphere(u);
                expected[part(d)] += light.evaluate(None, d).1 * each;
            }
            for u in grid(samples) {
                let EnvironmentSample { wi, pdf, .. } = light.sample(None, u).expect("it is not dark");
                found[part(wi)] += 1.0;
                // No sample of this grid is so near to the border of a cell that rounding takes it across.
                assert!((pdf / light.evaluate(None, wi).1 - 1.0).abs() < 1e-9, "{wi}");
            }
            let chi: f64 = expected.iter().zip(&found).map(|(e, f)| (f - e).powi(2) / e.max(5.0)).sum();
            // Of 127 random degrees of freedom one in a million is beyond 215; a grid is nearer.
            assert!(chi < 215.0, "{chi}");
        });
    }

    /// No sample counts for more than four times its share: there are no fireflies. As weighed against directions that are
    /// all alike, which find what is not brighter than the mean.
    #[test]
    fn weights_are_bounded() {
        with(Transform::from_matrix(DMat4::from_rotation_y(1.0)).expect("a rotation"), |light| {
            let shown = |d| luminance(light.radiance(d));
            let mean = grid(1500).map(|u| shown(on_sphere(u))).sum::<f64>() / (1500.0 * 1500.0);
            assert!((light.brightness() / mean - 1.0).abs() < 0.01);
            for u in grid(300) {
                let EnvironmentSample { wi, radiance, pdf } = light.sample(None, u).expect("it is not dark");
                // What is told with the sample is what is told of its direction.
                assert!((radiance - light.radiance(wi)).abs().max_element() < 1e-3 * radiance.max_element());
                let all_alike = 1.0 / (4.0 * PI);
                assert!(shown(wi) / (pdf + all_alike) < 4.01 * 4.0 * PI * light.brightness());
            }
        });
    }

    /// With a lune the density is that of the samples too, also where the sky is everywhere alike.
    #[test]
    fn samples_in_a_lune_have_the_density_of_both() {
        let n = DVec3::new(0.6, 0.0, 0.8);
        let lune = Lune::new(&Domain { n, ns: DVec3::Z, is_two_sided: false, is_diffuse: false }).unwrap();
        // A number and a size with which sums are rounded.
        let even = MipMap::new(63, 31, vec![Vec3::splat(0.2); 63 * 31], Wrap::Repeat);
        let light = Environment::new(&Arc::new(even), Vec3::ONE, &skewed(), 1);
        assert!(light.is_even() && light.sample(None, DVec2::splat(0.5)).is_none());
        let share = |light: &Environment| {
            let (mut inside, side) = (0, 200);
            for u in grid(side) {
                let EnvironmentSample { wi, pdf, .. } = light.sample(Some(&lune), u).unwrap();
                assert!((pdf / light.evaluate(Some(&lune), wi).1 - 1.0).abs() < 1e-9, "{wi}");
                inside += u32::from(lune.pdf(wi) > 0.0);
            }
            f64::from(inside) / f64::from(side * side)
        };
        assert_eq!(share(&light), 1.0);
        with(skewed(), |light| {
            let sum: f64 = grid(1500).map(|u| light.evaluate(Some(&lune), on_sphere(u)).1).sum();
            let integral = sum * 4.0 * PI / (1500.0 * 1500.0);
            assert!((integral - 1.0).abs() < 0.01, "{integral}");
            let within = |u| lune.pdf(on_sphere(u)) / lune.inside_pdf();
            let expected: f64 =
                grid(1500).map(|u| light.evaluate(Some(&lune), on_sphere(u)).1 * within(u)).sum::<f64>()
                    * 4.0
                    * PI
                    / (1500.0 * 1500.0);
            assert!((share(light) / expected - 1.0).abs() < 0.02, "{} {expected}", share(light));
        });
    }

    #[test]
    fn places_are_those_of_pbrt() {
        assert_eq!(place(DVec3::Z), DVec2::ZERO);
        assert_eq!(place(DVec3::Y * 3.0), DVec2::new(0.25, 0.5));
        assert_eq!(place(-DVec3::Y), DVec2::new(0.75, 0.5));
        assert_eq!(place(-DVec3::Z).y, 1.0);
    }

    #[test]
    fn darkness_is_not_sampled() {
        let map = MipMap::new(4, 2, vec![Vec3::ZERO; 8], Wrap::Repeat);
        let light = Environment::new(&Arc::new(map), Vec3::ONE, &Transform::IDENTITY, 1);
        assert!(light.sample(None, DVec2::splat(0.5)).is_none());
        assert_eq!((light.evaluate(None, DVec3::X).1, light.brightness()), (0.0, 0.0));
    }
}
