//! Rays, and the names of what they meet.

use glam::DVec3;

/// A ray in the world, or in the space of an object.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// Origin.
    pub o: DVec3,
    /// Direction; of length one in the world.
    pub d: DVec3,
    /// Hits beyond this distance, in lengths of `d`, do not count.
    pub t_max: f64,
    /// The element that the ray leaves: it is not hit again where it is flat or convex.
    pub leaving: ElementId,
    /// If that is a triangle, its [`Hit::place`], or else [`Hit::NO_PLACE`].
    pub leaving_place: u32,
    /// The element that a shadow ray goes to, or [`ElementId::POINT_LIGHT`]: it does not block. `t_max` does not go beyond it.
    pub target: ElementId,
    /// The instant: a share of the way from the start time of motion, 0, to its end time, 1.
    pub time: f64,
}

impl Ray {
    /// An unlimited ray that starts in free space.
    pub fn new(o: DVec3, d: DVec3) -> Self {
        Ray {
            o,
            d,
            t_max: f64::INFINITY,
            leaving: ElementId::NONE,
            leaving_place: Hit::NO_PLACE,
            target: ElementId::NONE,
            time: 0.0,
        }
    }

    /// The light that a shadow ray goes to, if that is a point.
    pub(crate) fn end(&self) -> DVec3 {
        self.at(self.t_max)
    }

    /// True if a hit may be the point light that the ray ends at, as far as its distance tells: that is less exact the more
    /// the surface is seen edge-on.
    #[inline(always)]
    pub(crate) fn may_end_at(&self, t: f64) -> bool {
        self.target == ElementId::POINT_LIGHT && t > self.t_max * NEAR_END
    }

    /// The point at a distance of `t` lengths of the direction.
    pub fn at(&self, t: f64) -> DVec3 {
        self.o + self.d * t
    }
}

/// From this share of its way on a ray is near its end.
pub(crate) const NEAR_END: f64 = 1.0 - 1.0 / 1024.0;

/// Names one triangle or curved shape of the scene, the same however the scene is sorted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ElementId {
    /// The index of the instance, or [`ElementId::WORLD`].
    pub instance: u32,
    /// The index of the primitive.
    pub primitive: u32,
    /// The index of the triangle in its mesh, or of the piece among all pieces of curves. 0 for other shapes.
    pub index: u32,
}

impl ElementId {
    /// The instance number of what stands in the world itself.
    pub const WORLD: u32 = u32::MAX;
    /// No element.
    pub const NONE: ElementId = ElementId { instance: u32::MAX, primitive: u32::MAX, index: u32::MAX };
    /// A light that is a point. A shadow ray to it ends just there, and what it lies in does not block.
    pub const POINT_LIGHT: ElementId = ElementId { index: u32::MAX - 1, ..ElementId::NONE };

    /// The shape that the element is a part of.
    pub fn shape(&self) -> ShapeId {
        if self.instance == ElementId::WORLD {
            ShapeId::Primitive(self.primitive)
        } else {
            ShapeId::Instance(self.instance)
        }
    }
}

/// Names a shape of the world, or an instance of an object as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ShapeId {
    /// The index of an instance, see [`ElementId::instance`].
    Instance(u32),
    /// The index in [`World::primitives`](lookat_scene::World::primitives).
    Primitive(u32),
}

/// The nearest hit of a ray so far.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f64,
    /// The element that is hit.
    pub element: ElementId,
    /// Weights of the first two vertices of a triangle, u and v of a curve, 0 for other shapes.
    pub barycentric: [f64; 2],
    /// The place of a triangle among those of the world, or of its object; [`Hit::NO_PLACE`] for other shapes.
    pub place: u32,
}

impl Hit {
    /// The index of non-triangles.
    pub const NO_PLACE: u32 = u32::MAX;

    /// True if a hit of `element` at `t` replaces this one: nearer, or as near and named earlier, so that the order of
    /// traversal does not matter.
    pub(crate) fn yields_to(&self, t: f64, element: ElementId) -> bool {
        t < self.t || (t == self.t && element < self.element)
    }
}
