//! Points of surfaces side by side.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;
use lookat_scene::{Primitive, Shape as SceneShape};

use super::{OFFSET, on_triangle};
use crate::curved::Curved;
use crate::lanes::Vec3x8;
use crate::ray::Hit;
use crate::trace::lanes::{Element, Hits, Rays, Shape};
use crate::triangle::Triangle;
use crate::triangle::lanes::BoxedTriangle;

/// What points of an element have in common.
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

/// Points of surfaces, relative to the eye; as [`super::Surface`], without shading normals of their own.
#[derive(Clone, Copy)]
pub(crate) struct Surfaces<S: Simd> {
    pub p: Vec3x8<S>,
    pub n: Vec3x8<S>,
    magnitude: f64x8<S>,
    element: f64x8<S>,
}

impl<'s> Sheet<'s> {
    /// `None` of those that have shading normals.
    pub fn new(element: &Element<'s>, primitive: &Primitive) -> Option<Self> {
        match (element.shape, &primitive.shape) {
            (Shape::Triangle(BoxedTriangle { triangle, .. }), SceneShape::TriangleMesh(mesh)) => {
                let corners = triangle.in_order();
                // Normal and magnitude are those of any point.
                let surface =
                    on_triangle(primitive, mesh, element.id, Hit::NO_PLACE, corners, [1.0, 0.0, 0.0]);
                let form = Form::Flat { triangle, corners, n: surface.n };
                mesh.normals.is_empty().then_some(Sheet { form, magnitude: surface.magnitude })
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
        Surfaces { p, n, magnitude: self.magnitude.simd_into(simd), element: hits.element }
    }
}

impl<S: Simd> Surfaces<S> {
    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        Surfaces {
            p: self.p.or(mask, others.p),
            n: self.n.or(mask, others.n),
            magnitude: mask.select(self.magnitude, others.magnitude),
            // Of the same hits.
            element: self.element,
        }
    }

    /// As [`super::Surface::leave`].
    #[inline(always)]
    pub fn leave(&self, d: Vec3x8<S>) -> Rays<S> {
        let offset = self.n * (self.magnitude * OFFSET).copysign(self.n.dot(d));
        let t_max = f64::INFINITY.simd_into(self.magnitude.token());
        Rays { o: self.p + offset, d, t_max, leaving: self.element }
    }

    /// As [`super::reach`].
    #[inline(always)]
    pub fn reach(&self, distance: f64x8<S>, magnitude: f64) -> f64x8<S> {
        distance - self.magnitude.max(magnitude) * 4.0 * OFFSET
    }
}
