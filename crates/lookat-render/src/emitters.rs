//! Where a ray may find what glows.

use crate::bounds::Bounds;
use crate::bvh::may_meet;
use crate::ray::Ray;

/// Boxes around all shapes that emit light.
#[derive(Debug, Default)]
pub(crate) struct Emitters(Vec<Bounds>);

/// With more boxes than that, looking at each costs about as much as tracing the ray.
const MOST: usize = 8;

impl Emitters {
    /// Those of so many shapes.
    pub fn new(bounds: Vec<Bounds>) -> Self {
        match bounds.len() <= MOST {
            true => Emitters(bounds),
            false => Emitters(vec![bounds.into_iter().fold(Bounds::EMPTY, Bounds::union)]),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a ray may meet one of them; it certainly does not if this is false.
    #[inline]
    pub fn may_be_met(&self, ray: &Ray) -> bool {
        let inverse = ray.d.recip();
        self.0.iter().any(|bounds| may_meet(ray.o, inverse, bounds))
    }
}
