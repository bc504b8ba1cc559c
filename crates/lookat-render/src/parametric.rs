//! The coordinates of a surface, and how position and normal change with them.

use glam::{DVec2, DVec3};

/// A point of a surface in terms of its coordinates u and v. Derivatives are in the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parametric {
    pub uv: DVec2,
    pub dpdu: DVec3,
    pub dpdv: DVec3,
    /// Of the unit normal.
    pub dndu: DVec3,
    pub dndv: DVec3,
}
