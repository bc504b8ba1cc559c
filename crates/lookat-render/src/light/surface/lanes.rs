//! Light from shapes, as they are seen from points side by side.

use std::f64::consts::TAU;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec3, Vec3};
use lookat_scene::{Mesh, Primitive, Shape};

use super::{SurfaceForm, SurfaceLight, element};
use crate::circle::lanes::at_turn;
use crate::frame::lanes::Frames;
use crate::lanes::{Colors, LANES, Vec3x8};
use crate::light::lanes::sample::LightSamples;
use crate::light::mesh::MeshAreas;
use crate::surface::lanes::{Surfaces, Triangles, Turned};
use crate::trace::lanes::{Labels, Rays};
use crate::triangle::corners;

/// A shape of the world that emits.
pub(crate) enum Lamp<'s> {
    Sphere(Ball),
    Mesh(MeshLamp<'s>),
}

/// A whole sphere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ball {
    center: DVec3,
    radius: f64,
    magnitude: f64,
    label: f64,
    /// Black where it shines inwards.
    radiance: Vec3,
}

pub(crate) struct MeshLamp<'s> {
    areas: &'s MeshAreas,
    mesh: &'s Mesh,
    area: f64,
    origin: DVec3,
    turned: Turned,
    two_sided: bool,
    /// That of its first triangle.
    label: f64,
    radiance: Vec3,
}

impl SurfaceLight {
    /// `None` of shapes that are sampled one by one. `origin`: the world position of the origin.
    pub fn lamp<'s>(&'s self, primitive: &'s Primitive, origin: DVec3, labels: Labels) -> Option<Lamp<'s>> {
        let emission = primitive.emission?;
        let label = labels.of(element(self.number, 0));
        match &self.form {
            SurfaceForm::Curved(shape) => {
                let sphere = shape.as_sphere().filter(|sphere| sphere.is_whole())?;
                let is_dark = primitive.reverse_orientation && !emission.two_sided;
                Some(Lamp::Sphere(Ball {
                    center: shape.center,
                    radius: sphere.world_radius?,
                    magnitude: shape.magnitude(),
                    label,
                    radiance: if is_dark { Vec3::ZERO } else { emission.radiance },
                }))
            }
            SurfaceForm::Mesh(areas) => {
                let Shape::TriangleMesh(mesh) = &primitive.shape else { return None };
                primitive.cutout.is_none().then_some(Lamp::Mesh(MeshLamp {
                    areas,
                    mesh,
                    area: self.area,
                    origin,
                    turned: Turned::new(primitive),
                    two_sided: emission.two_sided,
                    label,
                    radiance: emission.radiance,
                }))
            }
        }
    }
}

impl Lamp<'_> {
    /// As [`SurfaceLight::sample`], to the bit.
    #[inline(always)]
    pub fn samples<S: Simd>(&self, simd: S, from: &Surfaces<S>, u: [f64x8<S>; 2]) -> LightSamples<S> {
        match self {
            Lamp::Sphere(ball) => ball.samples(simd, from, u),
            Lamp::Mesh(mesh) => mesh.samples(simd, from, u),
        }
    }
}

impl Ball {
    /// As those of `VisibleCone`.
    #[inline(never)]
    fn samples<S: Simd>(&self, simd: S, from: &Surfaces<S>, [u, v]: [f64x8<S>; 2]) -> LightSamples<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let radius: f64x8<S> = self.radius.simd_into(simd);
                let to_center = Vec3x8::splat(simd, self.center) - from.p;
                let distance = to_center.length_squared().sqrt();
                let is_outside = !distance.simd_le(self.radius * (1.0 + 1e-9));
                let sine = radius / distance;
                let sin_squared = sine * sine;
                let one_minus_cos_max = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
                let axis = Vec3x8 {
                    x: to_center.x / distance,
                    y: to_center.y / distance,
                    z: to_center.z / distance,
                };
                let one_minus_cos = u * one_minus_cos_max;
                let sin_theta = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
                let [x, y] = at_turn(v);
                let local = Vec3x8 { x: x * sin_theta, y: y * sin_theta, z: 1.0 - one_minus_cos };
                let sin_squared = (1.0 - local.z) * (1.0 + local.z);
                let half = (radius * radius - distance * distance * sin_squared).max(0.0).sqrt();
                let wi = Frames::from_z(axis).to_world(local);
                let t_max = from.reach(distance * local.z - half, self.magnitude.simd_into(simd));
                let target = self.label.simd_into(simd);
                LightSamples {
                    is_there: is_outside & mask64x8::splat(simd, self.radiance != Vec3::ZERO),
                    li: Colors::splat(simd, self.radiance),
                    pdf: 1.0 / (TAU * one_minus_cos_max),
                    has_pdf: mask64x8::splat(simd, true),
                    shadow: Rays { t_max, target, ..from.leave(wi) },
                    is_open: !is_outside,
                }
            },
        )
    }
}

impl MeshLamp<'_> {
    #[inline(never)]
    fn samples<S: Simd>(&self, simd: S, from: &Surfaces<S>, [u, v]: [f64x8<S>; 2]) -> LightSamples<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let at = u * self.areas.total();
                let (mut before, mut own, mut target) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
                let mut triangles = Triangles::new();
                for lane in 0..LANES {
                    let (index, sums) = self.areas.at(at[lane]);
                    [before[lane], own[lane]] = sums;
                    triangles.put(
                        lane,
                        corners(self.mesh, index, self.origin),
                        self.mesh,
                        index,
                        self.turned,
                    );
                    target[lane] = self.label + index as f64;
                }
                let (before, own): (f64x8<S>, f64x8<S>) = (before.simd_into(simd), own.simd_into(simd));
                let rest = ((at - before) / (own - before)).max(0.0).min(1.0);
                let root = rest.sqrt();
                let (b0, b1) = (1.0 - root, v * root);
                let on_light = triangles.points(simd, [b0, b1, 1.0 - b0 - b1], mask64x8::splat(simd, true));
                let squared = (on_light.p - from.p).length_squared();
                let way = from.towards(on_light.p);
                let wi = way.d;
                let shines = mask64x8::splat(simd, self.two_sided) | on_light.emitting.dot(-wi).simd_gt(0.0);
                let pdf = squared / (on_light.n.dot(wi).abs() * self.area);
                let t_max = from.reach(way.t_max, on_light.magnitude);
                LightSamples {
                    is_there: shines & pdf.is_finite() & pdf.simd_gt(0.0),
                    li: Colors::splat(simd, self.radiance),
                    pdf,
                    has_pdf: mask64x8::splat(simd, true),
                    shadow: Rays { t_max, target: target.simd_into(simd), ..way },
                    is_open: mask64x8::splat(simd, false),
                }
            },
        )
    }
}
