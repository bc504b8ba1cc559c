//! Measures lookat against formulas of others, and against the truth. The results stand in `docs/`.

pub mod chart;
pub mod plot;

pub mod coverage;
pub mod stability;
