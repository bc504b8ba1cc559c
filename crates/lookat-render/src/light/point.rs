//! Light from a point.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_image::MipMap;

use super::tree::Emitter;
use crate::light::LightSample;
use crate::light::Receivers;
use crate::number::strength;
use crate::number::{LANES, V3, Vec3fx8, Vec3x8, bits, splat_f32, to_f32, to_f64, vectorized};
use crate::texture::trilinear::bilinear;
use crate::trace::rays::{POINT_LIGHT, Rays};
use crate::warp::longitude_latitude;

/// A light that is a point, relative to the origin.
pub(super) struct PointLight {
    pub position: DVec3,
    pub light_from_world: DMat3,
    pub intensity: Vec3,
    pub spread: Spread,
}

/// The distribution of light over directions of light space.
pub(super) enum Spread {
    Even,
    /// A spot: the cosines of its angles.
    Cone {
        total_width: f64,
        falloff_start: f64,
    },
    /// The intensity from a picture over all directions, with y as its axis as in pbrt-v3.
    Goniometric(Arc<MipMap<Vec3>>),
    /// A slide projector. `half_size`: half of the picture at z = 1 in light space.
    Projection {
        map: Option<Arc<MipMap<Vec3>>>,
        half_size: DVec2,
    },
}

/// The light that arrives from a point light at eight points.
pub(super) struct IncidentLight<S: Simd> {
    /// The points that the light reaches.
    is_valid: mask64x8<S>,
    wi: Vec3x8<S>,
    squared_distance: f64x8<S>,
    intensity: Vec3fx8<S>,
}

/// The least z in light space of directions that a projector lights, for directions of length one in the world, as in
/// pbrt-v3.
const NEAR: f64 = 1e-3;

/// A cone is one where transformations change angles by less than this.
const RIGID: f64 = 1e-6;

/// No estimate is larger, so that their sum is finite.
const MOST: f64 = 1e300;

impl PointLight {
    pub fn kind(&self) -> &'static str {
        match self.spread {
            Spread::Even => "point",
            Spread::Cone { .. } => "spot",
            Spread::Goniometric(_) => "goniometric",
            Spread::Projection { .. } => "projection",
        }
    }

    /// About its power.
    pub fn power(&self) -> f64 {
        match &self.spread {
            Spread::Even => 4.0 * PI * strength(self.intensity),
            Spread::Cone { total_width, falloff_start } => {
                2.0 * PI * (1.0 - 0.5 * (total_width + falloff_start)) * strength(self.intensity)
            }
            Spread::Goniometric(map) => 4.0 * PI * strength(self.intensity * map.mean()),
            Spread::Projection { map, half_size } => {
                // That of the cone around the picture, as pbrt-v3 has it.
                let solid_angle = TAU * (1.0 - half_size.extend(1.0).length().recip());
                solid_angle * strength(self.intensity * map.as_ref().map_or(Vec3::ONE, |map| map.mean()))
            }
        }
    }

    /// The emission of the light, for the light tree.
    pub fn emitter(&self) -> Emitter {
        let point = |intensity: Vec3| Emitter::point(self.position, strength(intensity));
        let cone = |intensity: Vec3, least_cosine: f64| {
            let axes = self.light_from_world.transpose();
            let axis = axes.z_axis.normalize_or(DVec3::Z);
            // Under other transformations it is no cone.
            let is_rigid = [axes.x_axis, axes.y_axis].iter().all(|side| {
                let ratio = side.length_squared() / axes.z_axis.length_squared();
                (ratio - 1.0).abs() < RIGID
                    && side.dot(axes.z_axis).abs() < RIGID * axes.z_axis.length_squared()
            });
            if is_rigid {
                Emitter::cone(self.position, strength(intensity), axis, least_cosine - RIGID)
            } else {
                point(intensity)
            }
        };
        match &self.spread {
            Spread::Even => point(self.intensity),
            Spread::Cone { total_width, .. } => cone(self.intensity, *total_width),
            Spread::Goniometric(map) => point(self.intensity * map.mean()),
            Spread::Projection { map, half_size } => {
                let mean = map.as_ref().map_or(Vec3::ONE, |map| map.mean());
                cone(self.intensity * mean, half_size.extend(1.0).length().recip())
            }
        }
    }

    #[inline(always)]
    fn incident<S: Simd>(&self, simd: S, p: Vec3x8<S>) -> IncidentLight<S> {
        let intensity = Vec3fx8::splat(simd, self.intensity);
        IncidentLight::new(
            Vec3x8::splat(simd, self.position) - p,
            #[inline(always)]
            |wi| intensity * self.factor(simd, -wi),
        )
    }

    /// True if the intensity is the same in all directions.
    pub fn is_even(&self) -> bool {
        matches!(self.spread, Spread::Even)
    }

    /// The factor of the intensity in directions of length one from the light.
    #[inline(always)]
    fn factor<S: Simd>(&self, simd: S, d: Vec3x8<S>) -> Vec3fx8<S> {
        let (d, white) = (d.by(&self.light_from_world), Vec3fx8::splat(simd, Vec3::ONE));
        match &self.spread {
            Spread::Even => white,
            Spread::Cone { total_width, falloff_start } => {
                let cos = d.normalize_or(DVec3::ZERO).z;
                let within = (cos - *total_width) / (falloff_start - total_width);
                let squared = within * within;
                let (none, one): (f64x8<S>, f64x8<S>) = (0.0.simd_into(simd), 1.0.simd_into(simd));
                let inside = cos.simd_ge(*falloff_start).select(one, squared * squared);
                white * to_f32(cos.simd_lt(*total_width).select(none, inside))
            }
            // The axis is y, and the picture's top its positive side.
            Spread::Goniometric(map) => {
                let st = longitude_latitude(V3 { x: d.x, y: d.z, z: d.y });
                bilinear::<S, Vec3>(map, st, bits(simd, 0xff))
            }
            Spread::Projection { map, half_size } => {
                let [x, y] = [d.x / d.z / half_size.x, d.y / d.z / half_size.y];
                let is_lit = d.z.simd_ge(NEAR) & x.abs().max(y.abs()).simd_le(1.0);
                let shown = match map {
                    Some(map) => bilinear::<S, Vec3>(map, [(x + 1.0) * 0.5, (y + 1.0) * 0.5], is_lit),
                    None => white,
                };
                shown.keep_where_wide(is_lit, Vec3fx8::splat(simd, Vec3::ZERO))
            }
        }
    }

    /// The approximate unoccluded irradiance at points.
    #[inline(always)]
    pub fn estimate<S: Simd>(&self, simd: S, at: &Receivers<S>) -> f64x8<S> {
        let IncidentLight { is_valid, wi, squared_distance, intensity } = self.incident(simd, at.surfaces.p);
        let irradiance = (intensity.strength() / squared_distance).min(MOST);
        let none = 0.0.simd_into(simd);
        is_valid.select(irradiance * to_f64(at.cosine(wi.narrow(), splat_f32(simd, 0.0))), none)
    }

    #[inline(never)]
    pub fn sample<S: Simd>(&self, simd: S, at: &Receivers<S>) -> LightSample<S> {
        vectorized!(simd, {
            self.incident(simd, at.surfaces.p).sample(Vec3x8::splat(simd, self.position), at)
        })
    }

    /// Samples a different light for each point. All these lights shine evenly in all directions.
    #[inline(never)]
    pub fn sample_even<S: Simd>(simd: S, lights: [&PointLight; LANES], at: &Receivers<S>) -> LightSample<S> {
        vectorized!(simd, {
            let (mut position, mut intensity) = (at.surfaces.p, Vec3fx8::splat(simd, Vec3::ZERO));
            for (lane, light) in lights.iter().enumerate() {
                position.set_lane(lane, light.position);
                intensity.set_lane(lane, light.intensity);
            }
            IncidentLight::new(position - at.surfaces.p, |_| intensity).sample(position, at)
        })
    }
}

impl<S: Simd> IncidentLight<S> {
    /// `intensity`: towards the points, from the directions that the light comes from.
    #[inline(always)]
    fn new(to_light: Vec3x8<S>, intensity: impl FnOnce(Vec3x8<S>) -> Vec3fx8<S>) -> Self {
        let squared_distance = to_light.length_squared();
        let (wi, is_apart) = to_light.try_normalize();
        let intensity = intensity(wi);
        IncidentLight { is_valid: is_apart & intensity.is_light(), wi, squared_distance, intensity }
    }

    #[inline(always)]
    fn sample(&self, position: Vec3x8<S>, at: &Receivers<S>) -> LightSample<S> {
        let way = at.surfaces.spawn_ray_to(position);
        let shadow = Rays { target: POINT_LIGHT.simd_into(self.squared_distance.token()), ..way };
        let is_valid = self.is_valid & self.squared_distance.is_finite();
        LightSample::of_delta(is_valid, self.intensity.scaled(1.0 / self.squared_distance), shadow)
    }
}

#[cfg(test)]
mod tests {
    use lookat_image::Wrap;

    use super::*;
    use crate::bsdf::Domain;
    use crate::testing::{baseline, surfaces_at};
    use fearless_simd::mask32x8;

    fn light(spread: Spread) -> PointLight {
        let (position, light_from_world) = (DVec3::ZERO, DMat3::IDENTITY);
        PointLight { position, light_from_world, intensity: Vec3::splat(2.0), spread }
    }

    fn factor(light: &PointLight, d: DVec3) -> Vec3 {
        baseline!(simd => light.factor(simd, Vec3x8::splat(simd, d)).lane(0))
    }

    /// Distances whose squares are beyond the range of `f32`.
    #[test]
    fn light_comes_from_any_distance() {
        for (distance, intensity) in [(3e19, 1e18), (1e-21, 1e-18), (1e-24, 1e-18)] {
            let light = PointLight {
                position: DVec3::Z * distance,
                intensity: Vec3::splat(intensity),
                ..light(Spread::Even)
            };
            let li = baseline!(simd => {
                let surfaces = &surfaces_at(simd, DVec3::ZERO);
                let none = mask32x8::splat(simd, false);
                let domain = Domain { n: surfaces.n, ns: surfaces.n, is_two_sided: none, is_diffuse: none };
                let sample = light.sample(simd, &Receivers { surfaces: *surfaces, domain, lunes: None });
                assert!(sample.is_valid.all_true());
                sample.li.lane(0).x
            });
            let expected = f64::from(intensity) / (distance * distance);
            assert!((f64::from(li) / expected - 1.0).abs() < 1e-6, "{distance}: {li} {expected}");
        }
    }

    /// The first row is up, by y, and the columns begin at x and go on to z.
    #[test]
    fn where_a_goniometric_picture_goes() {
        let gray = |i: usize| Vec3::splat(i as f32);
        let map = MipMap::new(4, 4, (0..16).map(gray).collect(), Wrap::Repeat);
        // The center of column 1 in row 1: longitude 135 degrees, 67.5 degrees from +y.
        let (sin, cos) = 67.5_f64.to_radians().sin_cos();
        let half = 0.5_f64.sqrt();
        let d = DVec3::new(-half * sin, cos, half * sin);
        let light = light(Spread::Goniometric(Arc::new(map)));
        assert!((factor(&light, d * 3.0).x - 5.0).abs() < 1e-5);
    }

    #[test]
    fn where_a_projected_picture_goes() {
        let map = MipMap::new(2, 2, vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE], Wrap::Repeat);
        let half_size = DVec2::new(0.8, 0.4);
        let light = light(Spread::Projection { map: Some(Arc::new(map)), half_size });
        // The first texel is at the left and at the bottom.
        let at = |x, y, z| factor(&light, DVec3::new(x, y, z).normalize());
        assert_eq!(at(-0.4, -0.2, 1.0), Vec3::X);
        assert_eq!(at(0.4, -0.2, 1.0), Vec3::Y);
        assert_eq!(at(-0.4, 0.2, 1.0), Vec3::Z);
        let outside = [at(0.81, 0.0, 1.0), at(0.0, 0.41, 1.0), at(-0.4, -0.2, -1.0)];
        assert_eq!(outside, [Vec3::ZERO; 3]);
        let solid_angle = TAU * (1.0 - 1.8_f64.sqrt().recip());
        assert!((light.power() - solid_angle * strength(Vec3::ONE)).abs() < 1e-6);
    }
}
