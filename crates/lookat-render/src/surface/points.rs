//! Points of surfaces side by side.

use fearless_simd::{Level, Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;
use lookat_scene::{Mesh, Primitive, Shape as SceneShape};

use super::{OFFSET, Surface, direction_across};
use crate::curved::Curved;
use crate::number::{LANES, Vec3x8, bits, side_by_side, those, three};
use crate::trace::rays::{Hits, Rays};
use crate::trace::{Element, Shape};
use crate::traceable::Traceable;
use crate::triangle::Triangle;
use crate::triangle::sheared::BoxedTriangle;

/// Points of surfaces, relative to the origin; as [`super::Surface`].
#[derive(Clone, Copy)]
pub(crate) struct Surfaces<S: Simd> {
    pub p: Vec3x8<S>,
    pub n: Vec3x8<S>,
    pub ns: Vec3x8<S>,
    pub magnitude: f64x8<S>,
    /// The numbers of the elements in their groups.
    pub element: f64x8<S>,
    /// Their instances.
    pub instance: f64x8<S>,
}

impl<S: Simd> Surfaces<S> {
    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        Surfaces {
            p: self.p.or(mask, others.p),
            n: self.n.or(mask, others.n),
            ns: self.ns.or(mask, others.ns),
            magnitude: mask.select(self.magnitude, others.magnitude),
            // Of the same hits.
            element: self.element,
            instance: self.instance,
        }
    }

    /// As [`super::Surface::leave`].
    #[inline(always)]
    pub fn leave(&self, d: Vec3x8<S>) -> Rays<S> {
        let offset = self.n * (self.magnitude * OFFSET).copysign(self.n.dot(d));
        let (leaving, leaving_instance) = (self.element, self.instance);
        Rays { leaving, leaving_instance, ..Rays::new(self.p + offset, d) }
    }

    /// Shadow rays to points of a light: from where rays leave the surface to just there. Were they to run beside the lines
    /// from the surface to the light, they would meet the plane that the light lies in before their end.
    #[inline(always)]
    pub fn towards(&self, light: Vec3x8<S>) -> Rays<S> {
        let start = self.leave(light - self.p);
        let way = light - start.o;
        let distance = way.length_squared().sqrt();
        Rays { d: way * (1.0 / distance.max(f64::MIN_POSITIVE)), t_max: distance, ..start }
    }

    /// The distances up to which shadow rays are blocked on their way to points whose coordinates are up to `magnitude`: all the way, but
    /// for rounding, so that what lies in the plane of a light does not hide it, and the light is not before the end.
    #[inline(always)]
    pub fn reach(&self, distance: f64x8<S>, magnitude: f64x8<S>) -> f64x8<S> {
        distance - self.rounding(magnitude)
    }

    /// The most that rounding and the offsets of rays change distances to points whose coordinates are up to `magnitude`.
    #[inline(always)]
    pub fn rounding(&self, magnitude: f64x8<S>) -> f64x8<S> {
        self.magnitude.max(magnitude) * 4.0 * OFFSET
    }

    /// Takes some from the space of their objects to the world.
    #[inline(never)]
    pub fn place_in_world(&mut self, scene: &Traceable, placed: mask64x8<S>) {
        for lane in those(placed) {
            let Some(instance) = scene.instance(self.instance[lane] as u32) else { continue };
            self.p.put(lane, instance.to_world(self.p.lane(lane)));
            self.magnitude[lane] = instance.magnitude(self.magnitude[lane]);
            self.n.put(lane, instance.normal_to_world(self.n.lane(lane)));
            self.ns.put(lane, instance.normal_to_world(self.ns.lane(lane)));
        }
    }

    /// Puts another surface in the place of one.
    pub fn put(&mut self, lane: usize, surface: &Surface) {
        self.p.put(lane, surface.p);
        self.n.put(lane, surface.n);
        self.ns.put(lane, surface.ns);
        self.magnitude[lane] = surface.magnitude;
    }
}

/// What points of an element of a list have in common.
pub(crate) struct Sheet<'s> {
    form: Form<'s>,
    magnitude: f64,
}

enum Form<'s> {
    /// A triangle, its corners as the mesh has them, and its normal.
    Flat { triangle: &'s Triangle, corners: [DVec3; 3], n: DVec3 },
    /// A sphere; whether its normal points inwards.
    Round { curved: &'s Curved, is_inward: bool },
}

impl<'s> Sheet<'s> {
    /// `None` of those that have shading normals.
    pub fn new(level: Level, element: &Element<'s>, primitive: &Primitive) -> Option<Self> {
        match (element.shape, &primitive.shape) {
            (Shape::Triangle(BoxedTriangle { triangle, .. }), SceneShape::TriangleMesh(mesh)) => {
                let corners = triangle.in_order();
                // Normal and magnitude are those of any point.
                let of_mesh = (&**mesh, element.id.index as usize, corners);
                let Point { magnitude, n, .. } = on_triangle(level, primitive, of_mesh, [1.0, 0.0, 0.0]);
                let form = Form::Flat { triangle, corners, n };
                mesh.normals().is_empty().then_some(Sheet { form, magnitude })
            }
            (Shape::Sphere(curved), _) => {
                let is_inward = primitive.reverse_orientation != primitive.mirrored;
                let form = Form::Round { curved, is_inward };
                Some(Sheet { form, magnitude: curved.magnitude() })
            }
            _ => None,
        }
    }

    /// Where the rays meet it.
    #[inline(always)]
    pub fn points<S: Simd>(&self, simd: S, rays: &Rays<S>, hits: &Hits<S>) -> Surfaces<S> {
        let (p, n) = match &self.form {
            Form::Flat { triangle, corners: [p0, p1, p2], n } => {
                let [b0, b1, b2] = triangle.weights(hits.sides);
                let (p0, p1, p2) =
                    (Vec3x8::splat(simd, *p0), Vec3x8::splat(simd, *p1), Vec3x8::splat(simd, *p2));
                (p0 * b0 + p1 * b1 + p2 * b2, Vec3x8::splat(simd, *n))
            }
            Form::Round { curved, is_inward } => {
                let (p, outward) = curved.on_sphere(rays.at(hits.t));
                (p, if *is_inward { -outward } else { outward })
            }
        };
        let Hits { element, instance, .. } = *hits;
        Surfaces { p, n, ns: n, magnitude: self.magnitude.simd_into(simd), element, instance }
    }
}

/// Triangles of any meshes, one for each point.
#[derive(Default)]
pub(crate) struct Triangles {
    corners: [[[f64; LANES]; 3]; 3],
    normals: [[[f64; LANES]; 3]; 3],
    /// Which of them have normals.
    has_normals: u64,
    /// Where the winding order gives the normals, the lanes that turn them.
    is_n: u64,
    /// The lanes that turn the normals on the side that emits.
    is_emitting: u64,
    /// Where the file gives the normals, the lanes that turn them.
    is_smooth: u64,
}

/// A point of a shape, or points; as in [`super::Surface`].
#[derive(Clone, Copy)]
pub(crate) struct Point<V = DVec3, N = f64> {
    pub p: V,
    pub magnitude: N,
    pub n: V,
    pub ns: V,
    pub emitting: V,
}

pub(crate) type Points<S> = Point<Vec3x8<S>, f64x8<S>>;

/// The point of a triangle, of a mesh and with these corners, that the corners weigh so much at.
pub(crate) fn on_triangle(
    level: Level,
    primitive: &Primitive,
    triangle: (&Mesh, usize, [DVec3; 3]),
    weights: [f64; 3],
) -> Point {
    let mut triangles = Triangles::default();
    triangles.put(0, primitive, triangle);
    side_by_side!(level, simd => {
        let weights = three!(corner, weights[corner].simd_into(simd));
        let Point { p, magnitude, n, ns, emitting } = triangles.points(simd, weights, bits(simd, 1));
        let [p, n, ns, emitting] = [p.lane(0), n.lane(0), ns.lane(0), emitting.lane(0)];
        Point { p, magnitude: magnitude[0], n, ns, emitting }
    })
}

impl Triangles {
    /// Puts a triangle of a primitive, a mesh, in its place.
    #[inline(always)]
    pub fn put(
        &mut self,
        lane: usize,
        primitive: &Primitive,
        (mesh, index, corners): (&Mesh, usize, [DVec3; 3]),
    ) {
        for (own, corner) in self.corners.iter_mut().zip(corners) {
            [own[0][lane], own[1][lane], own[2][lane]] = corner.into();
        }
        if !mesh.normals().is_empty() {
            self.has_normals |= 1 << lane;
            for (own, vertex) in self.normals.iter_mut().zip(mesh.triangle(index)) {
                [own[0][lane], own[1][lane], own[2][lane]] = mesh.normals()[vertex];
            }
        }
        let Primitive { reverse_orientation, mirrored, .. } = *primitive;
        // With tangents, pbrt-v3 reverses once more.
        let is_n = mirrored != (reverse_orientation && mesh.tangents().is_empty());
        self.is_n |= u64::from(is_n) << lane;
        self.is_emitting |= u64::from(mirrored != reverse_orientation) << lane;
        self.is_smooth |= u64::from(reverse_orientation) << lane;
    }

    /// The corners.
    #[inline(always)]
    pub fn corners<S: Simd>(&self, simd: S) -> [Vec3x8<S>; 3] {
        Vec3x8::three(simd, &self.corners)
    }

    /// Those that the corners weigh so much at; of the triangles that are there.
    #[inline(always)]
    pub fn points<S: Simd>(&self, simd: S, [b0, b1, b2]: [f64x8<S>; 3], there: mask64x8<S>) -> Points<S> {
        let [p0, p1, p2] = self.corners(simd);
        let p = p0 * b0 + p1 * b1 + p2 * b2;
        let magnitude = p0.magnitude().max(p1.magnitude()).max(p2.magnitude());
        let winding = across(p1 - p0, p2 - p0, there);
        let mut n = (-winding).or(bits(simd, self.is_n), winding);
        let (mut ns, mut emitting) = (n, (-winding).or(bits(simd, self.is_emitting), winding));
        if self.has_normals != 0 {
            let [n0, n1, n2] = Vec3x8::three(simd, &self.normals);
            let (smooth, is_there) = (n0 * b0 + n1 * b1 + n2 * b2).try_normalize();
            let is_there = is_there & bits(simd, self.has_normals);
            let turned = (-smooth).or(bits(simd, self.is_smooth), smooth);
            let own_n = (-winding).or(winding.dot(turned).simd_lt(0.0), winding);
            let own_emitting = (-winding).or(winding.dot(smooth).simd_lt(0.0), winding);
            n = own_n.or(is_there, n);
            ns = turned.or(is_there, ns);
            emitting = own_emitting.or(is_there, emitting);
        }
        Point { p, magnitude, n, ns, emitting }
    }
}

/// As [`direction_across`].
#[inline(always)]
fn across<S: Simd>(e1: Vec3x8<S>, e2: Vec3x8<S>, there: mask64x8<S>) -> Vec3x8<S> {
    let product = e1.cross(e2);
    let squared = product.length_squared();
    let mut direction = product * (1.0 / squared.sqrt());
    let is_usual = squared.simd_gt(1e-200) & squared.simd_lt(1e200);
    for lane in those(there & !is_usual) {
        direction.put(lane, direction_across(e1.lane(lane), e2.lane(lane)));
    }
    direction
}
