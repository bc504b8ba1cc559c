//! Shapes that emit: samples of their points, and in which directions they shine.

mod mesh;
mod spherical_cap;
mod spherical_disk;
mod spherical_rectangle;
mod spherical_triangle;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};
use std::iter::once;

use fearless_simd::{Level, Simd, f32x8, f64x8, mask64x8, prelude::*, u32x8};
use glam::{DVec3, Vec3};
use lookat_scene::{Primitive, Shape};

use super::tree::Emitter;
use super::{LEAST_COSINE, LightSample, Receivers};
use crate::curved::Curved;
use crate::curved::side_by_side::ShapeRays;
use crate::frame::flipped;
use crate::number::{
    LANES, Vec2x8, Vec3fx8, Vec3x8, bits, set_lanes, splat_f32, strength, to_f32, to_f64, vectorized,
};
use crate::ray::ElementId;
use crate::surface::{ShapePoint, ShapePoints, Surfaces};
use crate::trace::rays::Rays;
use crate::traceable::Traceable;
use mesh::MeshLight;
use spherical_cap::{OUTSIDE, Spheres};

/// A shape of the world that emits.
pub(super) struct SurfaceLight {
    /// The primitive of the world.
    pub number: u32,
    primitive: Primitive,
    pub form: SurfaceForm,
    /// The axes and the radius of a whole disk.
    disk: Option<([DVec3; 3], f64)>,
    /// The middle, and how far from it there is something.
    pub center: DVec3,
    pub radius: f64,
    pub area: f64,
    pub facing: Facing,
    /// Luminance of its radiance, about.
    pub brightness: f64,
    pub samples: u32,
    radiance: Vec3,
    two_sided: bool,
    /// The label of its first element.
    label: f64,
}

pub(super) enum SurfaceForm {
    Curved(Box<Curved>),
    Mesh(Box<MeshLight>),
}

/// Points of a light that rays have hit.
pub(crate) struct LightHits<S: Simd> {
    pub is_valid: mask64x8<S>,
    /// The directions of the rays.
    pub d: Vec3x8<S>,
    /// Positions and geometric normals.
    pub p: Vec3x8<S>,
    pub n: Vec3x8<S>,
    /// The numbers of the triangles of meshes, and whether these are chosen one by one.
    pub triangle: u32x8<S>,
    pub by_triangle: bool,
}

/// The density of sampled points of a light.
struct Density<S: Simd> {
    /// Samples are uniform on this area, or in this solid angle.
    area: f64x8<S>,
    solid_angle: f64x8<S>,
    is_by_angle: mask64x8<S>,
}

impl<S: Simd> Density<S> {
    #[inline(always)]
    fn by_area(area: f64x8<S>) -> Self {
        Density { area, solid_angle: area, is_by_angle: bits(area.token(), 0) }
    }

    /// The density by solid angle at points, from so far away, and at this cosine to their normals.
    #[inline(always)]
    fn pdf(&self, squared_distance: f64x8<S>, cosine: f64x8<S>) -> f32x8<S> {
        let (mut above, mut below) = (squared_distance, cosine.abs() * self.area);
        above = self.is_by_angle.select(1.0.simd_into(above.token()), above);
        below = self.is_by_angle.select(self.solid_angle, below);
        to_f32(above / below)
    }
}

impl SurfaceLight {
    /// The light that a shape of the world is, if it emits and has an area.
    pub fn new(number: u32, primitive: &Primitive, traceable: &Traceable) -> Option<Self> {
        let emission = primitive.emission.as_ref()?;
        let (origin, two_sided) = (traceable.origin, emission.two_sided);
        let (form, center, radius, area, facing) = match (&primitive.shape, traceable.curved(number)) {
            (Shape::TriangleMesh(mesh), _) => {
                let (mesh, center) = MeshLight::new(primitive, mesh, (traceable.level, origin));
                let (area, radius) = (mesh.area(), mesh.radius(center));
                let facing = Facing::new(mesh.patches(traceable.level, primitive), center, two_sided);
                (SurfaceForm::Mesh(Box::new(mesh)), center, radius, area, facing)
            }
            (Shape::Quadric(_), Some(shape)) => {
                let (center, radius) = (shape.center, shape.half_extent().length());
                let patches: Vec<Patch> = cells(primitive, shape).collect();
                let area = patches.iter().map(|patch| patch.area).sum();
                let facing = Facing::new(patches.into_iter(), center, two_sided);
                (SurfaceForm::Curved(Box::new(shape.clone())), center, radius, area, facing)
            }
            (Shape::Quadric(_), None) | (Shape::Curve(_), _) => return None,
        };
        let light = SurfaceLight {
            number,
            primitive: primitive.clone(),
            disk: traceable.curved(number).and_then(Curved::whole_disk),
            form,
            center,
            radius,
            area,
            facing,
            brightness: strength(emission.radiance),
            samples: emission.samples,
            radiance: emission.radiance,
            two_sided,
            label: traceable.labels.of(element(number, 0)),
        };
        (area > 0.0).then_some(light)
    }

    /// The approximate unoccluded irradiance from the light at surfaces.
    #[inline(always)]
    pub fn estimate<S: Simd>(&self, simd: S, at: &Receivers<S>) -> f64x8<S> {
        let offset = Vec3x8::splat(simd, self.center) - at.surfaces.p;
        let inverse = 1.0 / offset.length_squared().sqrt();
        let (wi, spread) = ((offset * inverse).narrow(), to_f32(inverse * self.radius));
        let share = to_f64(self.facing.share(simd, -wi, spread));
        let solid_angle = (inverse * inverse * self.area * share).min(PI);
        let estimate = solid_angle * self.brightness * to_f64(at.cosine(wi, spread));
        // No shape fills more than the sky, which it does from its middle.
        inverse.is_finite().select(estimate, (self.brightness * PI).simd_into(simd))
    }

    /// Directions from points of surfaces to the light. `leaving`: where the surface is the light itself.
    #[inline(always)]
    pub fn sample<S: Simd>(
        &self,
        simd: S,
        (at, leaving): (&Receivers<S>, mask64x8<S>),
        (triangles, u): (Option<u32x8<S>>, Vec2x8<S>),
    ) -> LightSample<S> {
        match &self.form {
            SurfaceForm::Mesh(mesh) => {
                let triangles = triangles.filter(|_| mesh.is_split());
                self.sample_mesh(simd, mesh, at, (triangles, u))
            }
            SurfaceForm::Curved(shape) => {
                if let Some(disk) = self.disk {
                    return self.sample_disk(simd, (shape, disk), at, u);
                }
                let Some(radius) = shape.whole_sphere() else {
                    return self.sample_points(simd, shape, (at, leaving), u);
                };
                let (seen, is_outside) = self.sample_cone(simd, (shape, radius), at, u);
                if is_outside.all_true() {
                    return seen;
                }
                seen.keep_where(is_outside, self.sample_points(simd, shape, (at, leaving), u))
            }
        }
    }

    /// Directions in which a whole sphere is seen from outside, and from where it is.
    #[inline(never)]
    fn sample_cone<S: Simd>(
        &self,
        simd: S,
        (shape, radius): (&Curved, f64),
        at: &Receivers<S>,
        u: Vec2x8<S>,
    ) -> (LightSample<S>, mask64x8<S>) {
        vectorized!(simd, {
            let spheres = Spheres {
                center: Vec3x8::splat(simd, shape.center),
                radius: radius.simd_into(simd),
                magnitude: shape.magnitude().simd_into(simd),
                label: self.label.simd_into(simd),
                radiance: Vec3fx8::splat(simd, self.radiance),
                shines: bits(simd, if self.shines_outwards() { 0xff } else { 0 }),
            };
            spheres.sample(at, u)
        })
    }

    /// Samples a different light for each point. All these lights are whole spheres. Only the points in `asked` count.
    #[inline(never)]
    pub fn sample_spheres<S: Simd>(
        simd: S,
        (lights, asked): ([&SurfaceLight; LANES], mask64x8<S>),
        (at, leaving): (&Receivers<S>, mask64x8<S>),
        u: Vec2x8<S>,
    ) -> LightSample<S> {
        vectorized!(simd, {
            let none: f64x8<S> = 0.0.simd_into(simd);
            let (mut center, mut radiance) = (at.surfaces.p, Vec3fx8::splat(simd, Vec3::ZERO));
            let (mut radius, mut magnitude, mut label, mut shines) = (none, none, none, 0);
            for (lane, light) in lights.iter().enumerate() {
                let Some((shape, own_radius)) = light.sphere() else { continue };
                center.set_lane(lane, shape.center);
                radiance.set_lane(lane, light.radiance);
                (radius[lane], magnitude[lane], label[lane]) = (own_radius, shape.magnitude(), light.label);
                shines |= u64::from(light.shines_outwards()) << lane;
            }
            let spheres = Spheres { center, radius, magnitude, label, radiance, shines: bits(simd, shines) };
            let (mut samples, is_outside) = spheres.sample(at, u);
            for lane in set_lanes(asked & !is_outside) {
                let Some((shape, _)) = lights[lane].sphere() else { continue };
                let own = lights[lane].sample_points(simd, shape, (at, leaving), u);
                samples = own.keep_where(bits(simd, 1 << lane), samples);
            }
            samples
        })
    }

    /// The shape and its radius in the world, if it is a whole sphere.
    pub fn sphere(&self) -> Option<(&Curved, f64)> {
        match &self.form {
            SurfaceForm::Curved(shape) => Some((&**shape, shape.whole_sphere()?)),
            SurfaceForm::Mesh(_) => None,
        }
    }

    fn shines_outwards(&self) -> bool {
        !self.primitive.reverse_orientation || self.two_sided
    }

    /// Directions to points of a curved shape.
    #[inline(never)]
    fn sample_points<S: Simd>(
        &self,
        simd: S,
        shape: &Curved,
        (at, leaving): (&Receivers<S>, mask64x8<S>),
        u: Vec2x8<S>,
    ) -> LightSample<S> {
        vectorized!(simd, {
            let (p, n, stretch) = shape.sample_all(u);
            let emitting = if self.primitive.reverse_orientation { -n } else { n };
            let magnitude = shape.magnitude().simd_into(simd);
            let on_light = ShapePoint { p, magnitude, n, ns: n, emitting };
            let density = Density::by_area(stretch);
            let mut sample = self.towards(at, &on_light, self.label.simd_into(simd), &density);
            let Rays { o, d, t_max, .. } = sample.shadow;
            // Another part of the same shape may be in front.
            let rays = ShapeRays { o, d, t_max, leaving, active: sample.is_valid };
            sample.is_valid &= !shape.hides_ends_of(&rays);
            sample
        })
    }

    /// The directions to points of the light, which are chosen with a density; `target`: the labels of their elements.
    #[inline(always)]
    fn towards<S: Simd>(
        &self,
        at: &Receivers<S>,
        on_light: &ShapePoints<S>,
        target: f64x8<S>,
        density: &Density<S>,
    ) -> LightSample<S> {
        let simd = target.token();
        let way = at.surfaces.spawn_ray_to(on_light.p);
        let squared_distance = (on_light.p - at.surfaces.p).length_squared();
        let height = on_light.emitting.dot(-way.d) * way.t_max;
        let height = if self.two_sided { height.abs() } else { height };
        // What lies in the plane of a light gets none, in spite of rounding.
        let shines = height.simd_gt(at.surfaces.rounding(on_light.magnitude));
        let pdf = density.pdf(squared_distance, on_light.n.dot(way.d));
        // The ray ends at the light, which does not block it.
        let t_max = at.surfaces.reach(way.t_max, on_light.magnitude);
        let shadow = Rays { t_max, target, ..way };
        LightSample::with_pdf(shines, Vec3fx8::splat(simd, self.radiance), pdf, shadow)
    }

    /// Densities by solid angle with which points of the light are sampled that are found from surfaces.
    #[inline(always)]
    pub fn pdf<S: Simd>(&self, simd: S, at: &Surfaces<S>, found: &LightHits<S>) -> f32x8<S> {
        let p = at.p;
        let squared_distance = (found.p - p).length_squared();
        let density = match &self.form {
            SurfaceForm::Mesh(mesh) => {
                mesh.density(simd, &self.primitive, at, (found.triangle, found.by_triangle))
            }
            SurfaceForm::Curved(shape) => 'density: {
                if let Some(disk) = self.disk {
                    break 'density self.disk_density(simd, (shape, disk), at, found);
                }
                let mut density = Density::by_area(0.0.simd_into(simd));
                for lane in set_lanes(found.is_valid) {
                    density.area[lane] = shape.stretch(found.p.lane(lane));
                }
                if let Some(radius) = shape.whole_sphere() {
                    let squared = (Vec3x8::splat(simd, shape.center) - p).length_squared();
                    let sin_squared = radius * radius / squared;
                    density.solid_angle = TAU * (sin_squared / (1.0 + (1.0 - sin_squared).max(0.0).sqrt()));
                    density.is_by_angle = squared.sqrt().simd_gt(radius * OUTSIDE);
                }
                density
            }
        };
        let pdf = density.pdf(squared_distance, found.n.dot(found.d));
        // Edge-on there is none.
        pdf.is_finite().select(pdf, splat_f32(simd, 0.0))
    }

    /// The number of leaves of the light in the light tree.
    pub fn leaves(&self) -> usize {
        match &self.form {
            SurfaceForm::Mesh(light) if light.is_split() => light.mesh.triangles(),
            _ => 1,
        }
    }

    /// The emission of each leaf; none of triangles without an area.
    pub fn emitters(&self) -> Box<dyn Iterator<Item = Option<Emitter>> + '_> {
        let (brightness, two_sided) = (self.brightness, self.two_sided);
        match &self.form {
            SurfaceForm::Mesh(mesh) if mesh.is_split() => {
                let patches = mesh.patches(Level::new(), &self.primitive);
                Box::new(patches.enumerate().map(move |(index, patch)| {
                    let squared = |corner: &DVec3| corner.distance_squared(patch.p);
                    let corners = mesh.corners(index);
                    let radius = corners.iter().map(squared).fold(0.0, f64::max).sqrt();
                    let facing = Facing::of_flat(patch.emitting, two_sided);
                    let emitter = || facing.emitter((patch.p, radius), (brightness, patch.area));
                    (patch.area > 0.0).then(emitter)
                }))
            }
            _ => {
                let ball = (self.center, self.radius);
                Box::new(once(Some(self.facing.emitter(ball, (brightness, self.area)))))
            }
        }
    }

    /// The light, or the first triangle of it.
    pub fn element(&self) -> ElementId {
        element(self.number, 0)
    }
}

/// The element that is triangle `index` of a primitive of the world, or the first.
fn element(number: u32, index: usize) -> ElementId {
    ElementId { instance: ElementId::WORLD, primitive: number, index: index as u32 }
}

/// Patches of a curved shape.
fn cells(primitive: &Primitive, shape: &Curved) -> impl Iterator<Item = Patch> {
    let is_reversed = primitive.reverse_orientation;
    shape.cells().map(move |(p, n, area)| Patch { p, emitting: flipped(n, is_reversed), area })
}

/// A patch of a shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    pub p: DVec3,
    /// The unit normal on the side that emits; 0 where that is not the same all over the patch.
    pub emitting: DVec3,
    pub area: f64,
}

/// The direction in which most of a shape emits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    /// The mean of the normals: of length one if all are the same, 0 if they point evenly in all directions.
    mean_normal: DVec3,
    /// True if the shape lies in one plane.
    is_flat: bool,
    /// The number of emitting sides.
    pub sides: f64,
}

/// The most rounding error, relative to the size of a shape.
const ROUNDING: f64 = 1e-6;
/// A cosine that rounding may make of 0. Light at less is left to samples of the BSDF.
const GRAZING: f32 = 1e-6;

impl Facing {
    /// The facing of a shape with these patches around a center.
    pub fn new(patches: impl Iterator<Item = Patch> + Clone, center: DVec3, two_sided: bool) -> Self {
        let patches = patches.filter(|patch| patch.area > 0.0);
        let (area, moment) = patches.clone().fold((0.0, DVec3::ZERO), |(area, moment), patch| {
            (area + patch.area, moment + patch.emitting * patch.area)
        });
        let mean_normal = moment / area;
        let mut same = patches.map(|patch| {
            let height = (patch.p - center).dot(mean_normal).abs();
            height <= ROUNDING * area.sqrt() && patch.emitting.dot(mean_normal) > 1.0 - ROUNDING
        });
        Facing { mean_normal, is_flat: same.all(|is_same| is_same), sides: if two_sided { 2.0 } else { 1.0 } }
    }

    /// The facing of a triangle from its normal on the emitting side. The normal is 0 if it varies over the triangle.
    pub fn of_flat(emitting: DVec3, two_sided: bool) -> Self {
        let sides = if two_sided { 2.0 } else { 1.0 };
        Facing { mean_normal: emitting, is_flat: emitting != DVec3::ZERO, sides }
    }

    /// The emission of a shape within a radius of a center, with this radiance and area.
    pub fn emitter(&self, ball: (DVec3, f64), radiance_area: (f64, f64)) -> Emitter {
        Emitter::surface(ball, radiance_area, self.mean_normal, (self.is_flat, self.sides > 1.0))
    }

    /// About the share of the area that shines in direction `d` from the center, foreshortened; 0 on the dark side of what is
    /// flat. `spread`: how large the shape is, over the distance that it is seen from.
    #[inline(always)]
    pub fn share<S: Simd>(&self, simd: S, d: Vec3fx8<S>, spread: f32x8<S>) -> f32x8<S> {
        let along = Vec3fx8::splat(simd, self.mean_normal.as_vec3()).dot(d);
        let along = if self.sides > 1.0 { along.abs() } else { along };
        if self.is_flat {
            // Parts of the shape are seen less aslant than its center.
            let share = (along + spread * 0.5).max(LEAST_COSINE).min(1.0);
            along.simd_gt(GRAZING).select(share, splat_f32(simd, 0.0))
        } else {
            // A closed convex shape shows a quarter of its area.
            along.max(0.25)
        }
    }
}
