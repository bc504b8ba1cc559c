//! Rays against triangles: T1 to T10.

mod far;
mod grid;
mod leaks;
mod plane;

use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("T1", leaks::far_from_origin),
    ("T2", leaks::of_any_size),
    ("T3", far::horizon),
    ("T3b", far::seam),
    ("T4", far::small),
    ("T5", far::needles),
    ("T6", plane::no_area),
    ("T7", |_| refused("T7")),
    ("T8", plane::same_place),
    ("T9", plane::in_plane),
    ("T10", grid::grid),
];
