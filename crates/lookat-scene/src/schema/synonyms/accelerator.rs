//! Words for `Accelerator`.

use super::Table;

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "Accelerator",
    types: &[
        (&["grid"], "bvh", "\"grid\" is a type of an older pbrt"),
        (&["octree", "embree", "sah"], "bvh", ""),
    ],
    parameters: &[],
};
