//! Tests of all materials.
