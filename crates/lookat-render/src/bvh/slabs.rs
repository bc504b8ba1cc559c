//! Rays against boxes: the test of a box is never no where the ray meets what is in it.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
pub(super) mod lanes;
pub(super) mod packet;

use glam::{DVec3, Vec3A};

use super::{Node, WIDTH};
#[cfg(test)]
use crate::bounds::round_down;
use crate::ray::Ray;

/// What the test in `f32` needs of a ray.
///
/// All is rounded to the side on which boxes are entered earlier or left later, so that the test says yes wherever that in
/// `f64` does.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slabs {
    /// The origin, for the planes where boxes are entered, and for those where they are left.
    near_o: Vec3A,
    far_o: Vec3A,
    /// One over the direction, likewise.
    near_inverse: Vec3A,
    far_inverse: Vec3A,
    /// Along each axis, which of the two planes of a box it is entered at; it is left at the other one.
    near: [usize; 3],
}

/// Covers the rounding of an inverse, a difference and a product, and more.
const SLACK: f32 = 5.0 * f32::EPSILON;

impl Slabs {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let (o, inverse) = (ray.o.as_vec3a(), ray.d.recip().as_vec3a());
        let (least, most) = (Vec3A::splat(f32::MIN_POSITIVE), Vec3A::splat(f32::MAX));
        // More than rounding takes. A box is entered earlier if the origin is moved along the ray.
        let along = (o.abs() * f32::EPSILON + least).copysign(inverse);
        // Too small to be rounded to one part in many.
        let is_tiny = inverse.abs().cmplt(least);
        let negative = inverse.is_negative_bitmask() as usize;
        Slabs {
            near_o: o + along,
            far_o: o - along,
            near_inverse: Vec3A::select(is_tiny, Vec3A::ZERO, (inverse * (1.0 - SLACK)).clamp(-most, most)),
            far_inverse: Vec3A::select(is_tiny, least.copysign(inverse), inverse * (1.0 + SLACK)),
            near: [negative & 1, negative >> 1 & 1, negative >> 2 & 1],
        }
    }

    /// Which boxes of a node the ray may meet before `t_max`, as bits, and from which distance on, not negative.
    ///
    /// A NaN, where infinity meets zero, drops out, because it compares as false.
    #[inline(always)]
    pub fn meet(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let (mut near, mut far) = ([0.0; WIDTH], [t_max; WIDTH]);
        for (axis, planes) in node.planes.iter().enumerate() {
            let (first, last) = (&planes[self.near[axis] & 1], &planes[!self.near[axis] & 1]);
            for lane in 0..WIDTH {
                let enter = (first[lane] - self.near_o[axis]) * self.near_inverse[axis];
                let leave = (last[lane] - self.far_o[axis]) * self.far_inverse[axis];
                near[lane] = if enter > near[lane] { enter } else { near[lane] };
                far[lane] = if leave < far[lane] { leave } else { far[lane] };
            }
        }
        let bit = |lane: usize| u32::from(near[lane] <= far[lane]) << lane;
        ((0..WIDTH).map(bit).sum(), near)
    }
}

/// The same in `f64`.
#[cfg(test)]
#[derive(Debug, Clone, Copy)]
pub(crate) struct DoubleSlabs {
    o: [f64; 3],
    inverse: [f64; 3],
}

/// Covers the rounding of both ends of the test (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013).
const PAD: f64 = 1.0 + 4.0 * f64::EPSILON;

#[cfg(test)]
impl DoubleSlabs {
    pub fn new(ray: &Ray) -> Self {
        DoubleSlabs { o: ray.o.to_array(), inverse: ray.d.recip().to_array() }
    }

    #[inline(always)]
    pub fn meet(&self, node: &Node, t_max: f32) -> (u32, [f32; WIDTH]) {
        let (mut hits, mut nears) = (0, [0.0; WIDTH]);
        for lane in 0..WIDTH {
            let box_planes = node.planes.map(|[low, high]| [low[lane], high[lane]].map(f64::from));
            let (near, far) = slabs(self.o, self.inverse, box_planes, f64::from(t_max) * PAD);
            hits |= u32::from(near <= far) << lane;
            nears[lane] = round_down(near);
        }
        (hits, nears)
    }
}

/// The distance of a hit of what lies between two corners, brought between those at which the ray enters and leaves their
/// box. It then agrees, to the bit, with the test of every box around that box: no tree skips what is hit. `None` where the
/// ray passes the box. `inverse` is one over the direction.
#[inline]
pub(crate) fn within_box(o: DVec3, inverse: DVec3, low: DVec3, high: DVec3, t: f64) -> Option<f64> {
    let planes = [[low.x, high.x], [low.y, high.y], [low.z, high.z]];
    let (near, far) = slabs(o.to_array(), inverse.to_array(), planes, f64::INFINITY);
    (near <= far).then(|| t.clamp(near, far))
}

/// Where a ray enters and leaves a box.
///
/// Near and far are told by the sign of the direction, before anything is compared; then a NaN, which a ray in the
/// plane of a side gives, drops out, because it compares as false.
#[inline(always)]
fn slabs(o: [f64; 3], inverse: [f64; 3], planes: [[f64; 2]; 3], t_max: f64) -> (f64, f64) {
    let (mut near, mut far) = (0.0_f64, t_max);
    for axis in 0..3 {
        let negative = inverse[axis].is_sign_negative();
        let (enter, leave) = slab(planes[axis], o[axis], inverse[axis], negative);
        near = if enter > near { enter } else { near };
        far = if leave < far { leave } else { far };
    }
    (near, far)
}

/// Where a ray enters and leaves what lies between two planes.
#[inline(always)]
fn slab([low, high]: [f64; 2], o: f64, inverse: f64, negative: bool) -> (f64, f64) {
    let (first, last) = if negative { (high, low) } else { (low, high) };
    ((first - o) * inverse, (last - o) * inverse * PAD)
}
