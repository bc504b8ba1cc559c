//! Finds the features of the renderer that a scene uses, with the decisions of the renderer itself.

use fearless_simd::Level;
use lookat_scene::{DirectStrategy, Integrator, LightChoice, Material, View};
use serde::Serialize;

use crate::bsdf::most_lobes;
use crate::bvh::Node;
use crate::integrator::{SampleDimensions, SceneIntegrator, direct, path};
use crate::light::LightTable;
use crate::medium::cost::MediumCost;
use crate::prepare::Prepared;
use crate::render::{Settings, film_bytes};
use crate::traceable::{Group, NonTriangle};
use crate::triangle::Block;
use crate::triangle::Triangle;

/// The features of the renderer that a scene uses. Rendering skips the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// The bytes of the film during rendering: the sums of each pixel, and the resulting picture.
    pub film_bytes: u64,
    /// True if camera rays start on a lens.
    pub has_lens: bool,
    /// True if the filter gives a sample to several pixels.
    pub shares_samples: bool,
    /// The elements of the world.
    pub world: Elements,
    /// The elements of each object that has instances.
    pub objects: Vec<Elements>,
    /// True if shapes may have holes.
    pub has_cutouts: bool,
    /// True if rays traverse the BVH. False if eight rays at a time are tested against each shape directly.
    pub uses_bvh: bool,
    /// The materials. `None` if the integrator does not use them.
    pub surfaces: Option<Surfaces>,
    /// The media of the world.
    pub media: Vec<MediumCost>,
    /// The kind of each light. Infinite lights come last.
    pub lights: Vec<&'static str>,
    /// The number of infinite lights with the same radiance in all directions. BSDF samples find these lights. Light
    /// samples are taken only where BSDF samples do not reach them.
    pub constant_skies: usize,
    /// How lights are chosen at a surface.
    pub choice: Choice,
    /// The most sample dimensions at each surface of a path, by purpose.
    pub dimensions: Vec<SampleDimensions>,
    /// The most surfaces of a path.
    pub depth: u32,
}

/// The elements of one BVH.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Elements {
    /// Triangles with an area.
    pub triangles: usize,
    /// Spheres, disks and other quadrics.
    pub quadrics: usize,
    /// Pieces of curves.
    pub curve_pieces: usize,
    /// Object instances.
    pub instances: usize,
    /// Nodes of the BVH, each with up to eight children.
    pub nodes: usize,
    /// The most nodes on a path from the root to a leaf.
    pub depth: usize,
    /// Bytes of nodes and leaves.
    pub bytes: usize,
}

/// The materials in use, and the number of materials with each feature.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Surfaces {
    /// The type of each material.
    pub kinds: Vec<&'static str>,
    /// The most lobes of a material.
    pub most_lobes: usize,
    /// Materials with specular lobes.
    pub specular: usize,
    /// Materials that need texture coordinates.
    pub coordinates: usize,
    /// Materials with filtered textures.
    pub footprints: usize,
    /// Materials with bump mapping.
    pub bumps: usize,
}

/// How lights are chosen at a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// The integrator uses no lights.
    Unused,
    /// There is nothing to choose: the scene has at most one light.
    Nothing,
    /// Every light is sampled.
    All,
    /// One light is sampled, by this light sampler.
    One(LightChoice),
}

/// The instructions that samples are taken with on this processor: "AVX-512", "AVX2", "SSE2" or "NEON"; "none" on others.
pub fn simd() -> &'static str {
    match Level::new() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(_) => "AVX-512",
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(_) => "AVX2",
        _ if cfg!(target_arch = "x86_64") => "SSE2",
        _ if cfg!(target_arch = "aarch64") => "NEON",
        _ => "none",
    }
}

/// The features that a view of a world uses.
pub fn inspect(prepared: &Prepared, view: &View) -> Inspection {
    let Prepared { traceable, lights, .. } = prepared;
    let integrator = SceneIntegrator::new(&view.integrator, traceable, lights);
    let materials = surfaces(&integrator.world().materials.all);
    let (choice, dimensions, depth) =
        integration(&integrator, &view.integrator, lights, materials.specular > 0);
    let asks_materials = !matches!(view.integrator, Integrator::AmbientOcclusion { .. });
    Inspection {
        film_bytes: film_bytes(view, &Settings::default()),
        has_lens: view.camera.lens.is_some(),
        shares_samples: view.filter.shares_samples(),
        world: elements(&traceable.world),
        objects: traceable.objects.iter().map(elements).collect(),
        has_cutouts: traceable.has_cutouts(),
        uses_bvh: integrator.world().uses_bvh(),
        surfaces: asks_materials.then_some(materials),
        media: traceable
            .source
            .media
            .iter()
            .zip(&traceable.majorants)
            .map(|(medium, majorants)| MediumCost::of(medium, majorants.as_ref()))
            .collect(),
        lights: lights.kinds().collect(),
        constant_skies: lights.len() - lights.eligible(false),
        choice,
        dimensions,
        depth,
    }
}

/// How lights are chosen, the sample dimensions at each surface, and the most surfaces of a path.
fn integration(
    of_scene: &SceneIntegrator,
    integrator: &Integrator,
    lights: &LightTable,
    is_specular: bool,
) -> (Choice, Vec<SampleDimensions>, u32) {
    let one =
        |choice| if lights.is_choice(choice) { Choice::One(lights.rule(choice)) } else { Choice::Nothing };
    match *integrator {
        Integrator::Path { max_depth, light_choice, .. } => {
            let mut dimensions = path::dimensions(max_depth, lights, light_choice, of_scene.has_bodies());
            if of_scene.world().media.is_some() {
                let purpose = "way through media";
                dimensions.push(SampleDimensions { purpose, count: 2, surfaces: 0..max_depth.max(1) });
            }
            (one(light_choice), dimensions, max_depth)
        }
        Integrator::DirectLighting { strategy, max_depth } => {
            let choice = match strategy {
                DirectStrategy::All | DirectStrategy::EachOnce if lights.len() > 1 => Choice::All,
                DirectStrategy::All | DirectStrategy::EachOnce => Choice::Nothing,
                DirectStrategy::One => one(direct::CHOICE),
            };
            // Paths continue only along specular directions.
            let depth = if is_specular { max_depth.max(1) } else { 1 };
            (choice, direct::dimensions(lights, strategy, depth, is_specular), depth)
        }
        Integrator::AmbientOcclusion { samples, .. } => {
            let directions =
                SampleDimensions { purpose: "direction", count: samples.saturating_mul(2), surfaces: 0..1 };
            (Choice::Unused, vec![directions], 1)
        }
    }
}

fn elements(group: &Group) -> Elements {
    let count = |is: fn(&NonTriangle) -> bool| group.non_triangles.iter().filter(|other| is(other)).count();
    let nodes = group.bvh.nodes();
    Elements {
        triangles: group.triangles.len(),
        quadrics: count(|other| matches!(other, NonTriangle::Curved { .. })),
        curve_pieces: count(|other| matches!(other, NonTriangle::Curve { .. })),
        instances: count(|other| matches!(other, NonTriangle::Instance { .. })),
        nodes,
        depth: group.bvh.depth(),
        bytes: nodes * size_of::<Node>()
            + group.blocks.len() * size_of::<Block>()
            + group.triangles.len() * size_of::<Triangle>()
            + group.non_triangles.len() * size_of::<NonTriangle>(),
    }
}

fn surfaces(materials: &[&Material]) -> Surfaces {
    let count = |is: &dyn Fn(&Material) -> bool| materials.iter().filter(|material| is(material)).count();
    Surfaces {
        kinds: materials.iter().map(|material| material.kind().name()).collect(),
        most_lobes: materials.iter().map(|material| most_lobes(material).all).max().unwrap_or(0),
        specular: count(&|material| most_lobes(material).specular > 0),
        coordinates: count(&|material| material.needs().coordinates),
        footprints: count(&|material| material.needs().footprint),
        bumps: count(&|material| material.bump().is_some()),
    }
}
