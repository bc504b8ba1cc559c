//! Trees, secondary rays, samples and whole pictures: V1 to V15.

mod adaptive;
mod boxes;
mod brute_force;
mod crowds;
mod offsets;
mod pictures;
mod samples;
mod shadows;

use crate::coverage::{edges, lens};
use crate::stability::prelude::*;
pub(super) use pictures::same_on_threads;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("V1", boxes::faces),
    ("V2", brute_force::agreement),
    ("V3", crowds::one_place),
    ("V4", crowds::giant),
    ("V5", offsets::by_size),
    ("V5b", offsets::by_distance),
    ("V6", offsets::thin),
    ("V7", shadows::close_to_light),
    ("V8", samples::slopes),
    ("V9", samples::thousand),
    ("V10", samples::neighbors),
    ("V11", |_| adaptive::against(edges)),
    ("V12", |_| adaptive::against(lens)),
    ("V13", adaptive::rare),
    ("V14", pictures::degenerate),
    ("V15", pictures::threads),
];
