//! Measures lookat against formulas of others, and against the truth. The results stand in `docs/`.

pub mod against;
pub mod bench;
pub mod chart;
mod coverage;
pub mod interval;
pub mod latency;
pub mod plot;
pub mod stability;
mod text_scene;
