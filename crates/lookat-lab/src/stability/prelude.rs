//! Items that most cases use.

pub(super) use glam::{DMat3, DMat4, DVec2, DVec3};
pub(super) use lookat_render::{Probe, Ray};
pub(super) use lookat_scene::Scene;
pub(super) use rand::{RngExt, SeedableRng};
pub(super) use rand_pcg::Pcg64Mcg;

pub(super) use super::case::{Measure, Tally, Trial, tally};
pub(super) use super::random::{below, between, chance, direction, in_cube, in_triangle, leaving, magnitude};
pub(super) use crate::text_scene::{
    around_eye, load, mesh, pictured, probe, quads, render, scene, seen_from, square, transform, triangles,
    xyz,
};
