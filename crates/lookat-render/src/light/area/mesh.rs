//! Meshes that emit.

use std::array::from_fn;
use std::sync::Arc;

use fearless_simd::{Level, Simd, f64x8, prelude::*, u32x8};
use glam::DVec3;
use lookat_scene::{Mesh, Primitive};

use super::spherical_rectangle::{Rectangle, SphericalRectangles};
use super::spherical_triangle::SphericalTriangles;
use super::{Density, Patch, SurfaceLight};
use crate::cutout::CutoutPoints;
use crate::light::{LightSample, Receivers};
use crate::number::{LANES, Vec2x8, Vec3x8, bits, vectorized};
use crate::surface::{Surfaces, Triangles, on_triangle};
use crate::triangle::corners;
use crate::warp::sample_discrete;

/// Meshes of more triangles are leaves of the tree of lights by their triangles. A rectangle is better sampled as one.
const MOST_WHOLE: usize = 2;

/// A mesh that emits.
pub(in crate::light) struct MeshLight {
    pub mesh: Arc<Mesh>,
    /// The world position of the origin.
    origin: DVec3,
    /// The areas of the triangles up to each, summed up.
    sums: Vec<f64>,
    /// The rectangle that the mesh is, if it is one without holes that emits on one side.
    rectangle: Option<Rectangle>,
}

impl MeshLight {
    /// The mesh, and its center of gravity.
    pub fn new(primitive: &Primitive, mesh: &Arc<Mesh>, (level, origin): (Level, DVec3)) -> (Self, DVec3) {
        let (mut total, mut moment) = (0.0, DVec3::ZERO);
        let sums = (0..mesh.triangles()).map(|index| {
            let [a, b, c] = corners(mesh, index, origin);
            let area = area_of([a, b, c]);
            total += area;
            moment += (a + b + c) / 3.0 * area;
            total
        });
        let mut light = MeshLight { mesh: mesh.clone(), origin, sums: sums.collect(), rectangle: None };
        light.rectangle = light.find_rectangle(level, primitive);
        (light, moment / total)
    }

    fn find_rectangle(&self, level: Level, primitive: &Primitive) -> Option<Rectangle> {
        if self.mesh.triangles() != 2 || primitive.cutout.is_some() {
            return None;
        }
        let [first, second] =
            [0, 1].map(|index| patch(level, primitive, (&self.mesh, index, self.corners(index))));
        let is_same_side = first.emitting.dot(second.emitting) > 0.0;
        Rectangle::new([0, 1].map(|index| self.corners(index)), first.emitting).filter(|_| is_same_side)
    }

    /// The sum of the areas.
    pub fn area(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// True if its triangles are leaves of the tree of lights, each of its own.
    pub fn is_split(&self) -> bool {
        self.mesh.triangles() > MOST_WHOLE
    }

    /// The largest distance of a vertex from `center`.
    pub fn radius(&self, center: DVec3) -> f64 {
        let squared = |p: &[f64; 3]| (DVec3::from(*p) - self.origin).distance_squared(center);
        self.mesh.positions().iter().map(squared).fold(0.0, f64::max).sqrt()
    }

    /// The triangles, as parts of a primitive.
    pub fn patches(&self, level: Level, primitive: &Primitive) -> impl Iterator<Item = Patch> + Clone {
        (0..self.mesh.triangles())
            .map(move |index| patch(level, primitive, (&self.mesh, index, self.corners(index))))
    }

    /// The corners of a triangle.
    pub fn corners(&self, index: usize) -> [DVec3; 3] {
        corners(&self.mesh, index, self.origin)
    }

    /// Triangles of these numbers. Those of other lights may be beyond the end.
    #[inline(always)]
    fn numbers<S: Simd>(&self, triangles: u32x8<S>) -> [usize; LANES] {
        let last = self.mesh.triangles() - 1;
        from_fn(
            #[inline(always)]
            |lane| (triangles[lane] as usize).min(last),
        )
    }

    /// Triangles of the mesh as points see them, and the densities of their samples. `are_chosen`: if something else than their areas chooses
    /// them.
    #[inline(always)]
    fn seen<S: Simd>(
        &self,
        at: &Surfaces<S>,
        corners: [Vec3x8<S>; 3],
        are_chosen: bool,
    ) -> (SphericalTriangles<S>, Density<S>) {
        let seen = SphericalTriangles::new(at, corners);
        let (mut area, mut solid_angle) = (seen.area, seen.solid_angle);
        if !are_chosen {
            area = self.area().simd_into(area.token());
            solid_angle = solid_angle * area / seen.area;
        }
        let density = Density { area, solid_angle, is_by_angle: seen.is_in_range };
        (seen, density)
    }

    /// The densities of samples of triangles.
    #[inline(never)]
    pub(super) fn density<S: Simd>(
        &self,
        simd: S,
        primitive: &Primitive,
        at: &Surfaces<S>,
        (triangles, are_chosen): (u32x8<S>, bool),
    ) -> Density<S> {
        vectorized!(simd, {
            if let Some(rectangle) = &self.rectangle {
                return self.of_rectangle(&rectangle.seen_from(simd, at));
            }
            let triangles = self.triangles(primitive, self.numbers(triangles));
            self.seen(at, triangles.corners(simd), are_chosen && self.is_split()).1
        })
    }

    /// The densities of samples of the rectangle that the mesh is.
    #[inline(always)]
    fn of_rectangle<S: Simd>(&self, seen: &SphericalRectangles<S>) -> Density<S> {
        let area = self.area().simd_into(seen.solid_angle.token());
        Density { area, solid_angle: seen.solid_angle, is_by_angle: seen.is_in_range }
    }

    /// The triangles with these indices of a primitive that is a mesh.
    #[inline(always)]
    fn triangles(&self, primitive: &Primitive, indices: [usize; LANES]) -> Triangles {
        let mut triangles = Triangles::default();
        for (lane, index) in indices.into_iter().enumerate() {
            triangles.set_lane(lane, primitive, (&self.mesh, index, self.corners(index)));
        }
        triangles
    }
}

impl SurfaceLight {
    /// Directions to points of a mesh. `chosen`: triangles, if these are chosen one by one.
    #[inline(never)]
    pub(super) fn sample_mesh<S: Simd>(
        &self,
        simd: S,
        mesh: &MeshLight,
        at: &Receivers<S>,
        (chosen, u): (Option<u32x8<S>>, Vec2x8<S>),
    ) -> LightSample<S> {
        vectorized!(simd, {
            match &mesh.rectangle {
                Some(rectangle) => {
                    let seen = rectangle.seen_from(simd, &at.surfaces);
                    let [s, t] = if seen.is_in_range.any_true() { seen.sample(u) } else { u };
                    let is_in_range = seen.is_in_range;
                    let shares = [is_in_range.select(s, u[0]), is_in_range.select(t, u[1])];
                    let (on_light, index) = rectangle.points(simd, shares);
                    self.towards(at, &on_light, index + self.label, &mesh.of_rectangle(&seen))
                }
                None => self.sample_triangles(simd, mesh, at, (chosen, u)),
            }
        })
    }

    #[inline(never)]
    fn sample_triangles<S: Simd>(
        &self,
        simd: S,
        mesh: &MeshLight,
        at: &Receivers<S>,
        (chosen, [u, v]): (Option<u32x8<S>>, Vec2x8<S>),
    ) -> LightSample<S> {
        vectorized!(simd, {
            let (indices, rest) = match chosen {
                Some(chosen) => (mesh.numbers(chosen), u),
                None => sample_discrete(simd, [&mesh.sums; LANES], u),
            };
            let triangles = mesh.triangles(&self.primitive, indices);
            let (seen, density) = mesh.seen(&at.surfaces, triangles.corners(simd), chosen.is_some());
            let is_by_angle = density.is_by_angle;
            // Points of a triangle, all alike (PBR 13.6.5).
            let root = rest.sqrt();
            let (mut b0, mut b1) = (1.0 - root, v * root);
            let mut b2 = 1.0 - b0 - b1;
            if is_by_angle.any_true() {
                let [a, b, c] = seen.sample([rest, v]);
                (b0, b1, b2) =
                    (is_by_angle.select(a, b0), is_by_angle.select(b, b1), is_by_angle.select(c, b2));
            }
            let on_light = triangles.points(simd, [b0, b1, b2], bits(simd, 0xff));
            let index: f64x8<S> = indices.map(|index| index as f64).simd_into(simd);
            let mut sample = self.towards(at, &on_light, index + self.label, &density);
            if self.primitive.cutout.is_some() {
                // No light comes out of a hole, as none is seen there.
                let (primitives, triangles) = ([&self.primitive; LANES], indices.map(|index| index as u32));
                let points = CutoutPoints { primitives, triangles, barycentric: [b0, b1], is_shadow: false };
                sample.is_valid = points.solid(sample.is_valid);
            }
            sample
        })
    }
}

/// The area of the triangle with these corners.
pub(super) fn area_of([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// A triangle of a primitive.
fn patch(level: Level, primitive: &Primitive, (mesh, index, corners): (&Mesh, usize, [DVec3; 3])) -> Patch {
    let middle = on_triangle(level, primitive, (mesh, index, corners), [1.0 / 3.0; 3]);
    // Normals of the file decide, at each point.
    let side = |vertex: usize| DVec3::from(mesh.normals()[vertex]).dot(middle.n);
    let sides = || mesh.triangle(index).map(side);
    let is_same = mesh.normals().is_empty()
        || sides().iter().all(|side| *side > 0.0)
        || sides().iter().all(|side| *side < 0.0);
    let emitting = if is_same { middle.emitting } else { DVec3::ZERO };
    Patch { p: middle.p, emitting, area: area_of(corners) }
}
