//! Parametric derivatives of surfaces (PBR 3.6).

use fearless_simd::{Simd, mask64x8, prelude::*};
use glam::{DMat3, DVec2, DVec3};

use crate::number::{Vec2x8, Vec3x8};

/// The parametric derivatives of a surface at a point, by pbrt-v3's parameters u and v. In the world, or in the space of an
/// object.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Parametric<P = DVec2, V = DVec3> {
    /// The parameters; 0 to 1 on the shape.
    pub uv: P,
    /// Change of the position with u and with v. One is 0 where a surface ends in a point, as at the poles of a sphere.
    pub dpdu: V,
    pub dpdv: V,
    /// Change of the unit normal of object space, as it is before it is flipped; transformed like a normal, as in pbrt-v3, so
    /// that it is that of the unit normal of the world only where that space is not scaled.
    pub dndu: V,
    pub dndv: V,
}

/// Parametric derivatives of eight points.
pub(crate) type Parametrics<S> = Parametric<Vec2x8<S>, Vec3x8<S>>;

impl<S: Simd> Parametrics<S> {
    /// The value in one lane.
    pub fn lane(&self, lane: usize) -> Parametric {
        Parametric {
            uv: DVec2::new(self.uv[0][lane], self.uv[1][lane]),
            dpdu: self.dpdu.lane(lane),
            dpdv: self.dpdv.lane(lane),
            dndu: self.dndu.lane(lane),
            dndv: self.dndv.lane(lane),
        }
    }

    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(&self, mask: mask64x8<S>, others: &Self) -> Self {
        let ([u, v], [other_u, other_v]) = (self.uv, others.uv);
        Parametric {
            uv: [mask.select(u, other_u), mask.select(v, other_v)],
            dpdu: self.dpdu.keep_where(mask, others.dpdu),
            dpdv: self.dpdv.keep_where(mask, others.dpdv),
            dndu: self.dndu.keep_where(mask, others.dndu),
            dndv: self.dndv.keep_where(mask, others.dndv),
        }
    }

    /// Replaces the value in one lane.
    pub fn set_lane(&mut self, lane: usize, other: &Parametric) {
        [self.uv[0][lane], self.uv[1][lane]] = other.uv.into();
        self.dpdu.set_lane(lane, other.dpdu);
        self.dpdv.set_lane(lane, other.dpdv);
        self.dndu.set_lane(lane, other.dndu);
        self.dndv.set_lane(lane, other.dndv);
    }
}

/// A parametric point in the space of an implicit surface f(p) = 0, with derivatives of f.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Local {
    pub uv: DVec2,
    pub dpdu: DVec3,
    pub dpdv: DVec3,
    /// Half the gradient of f, on the side of `dpdu x dpdv`.
    pub gradient: DVec3,
    /// The change of `gradient` along each axis: half the Hessian of f, which is diagonal.
    pub bend: DVec3,
}

impl Local {
    /// In the world. `normals` takes normals of object space there. The derivatives of the normal are what the Weingarten
    /// equations give (PBR 3.2).
    pub fn placed(&self, world_from_local: DMat3, normals: DMat3) -> Parametric {
        let length = self.gradient.length();
        let unit = self.gradient / length;
        let turn = |dp: DVec3| {
            let change = self.bend * dp / length;
            let across = normals * (change - unit * unit.dot(change));
            // The tip of a cone has no normal.
            if across.is_finite() { across } else { DVec3::ZERO }
        };
        Parametric {
            uv: self.uv,
            dpdu: world_from_local * self.dpdu,
            dpdv: world_from_local * self.dpdv,
            dndu: turn(self.dpdu),
            dndv: turn(self.dpdv),
        }
    }
}
