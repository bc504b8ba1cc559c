//! What a scene needs of the renderer, by the decisions that rendering makes.

use std::sync::Arc;

use lookat_scene::{DirectStrategy, Integrator, LightChoice, Material, Scene};

use crate::arithmetic::{Precision, Simd};
use crate::bsdf::{lambert, most_lobes};
use crate::bvh::Node;
use crate::camera::CameraRays;
use crate::filter::FilterSampler;
use crate::integrator::lanes::Lanes;
use crate::integrator::{Draw, direct, path};
use crate::light::LightTable;
use crate::prepare::{Group, Other, Traceable};
use crate::render::{Settings, film_bytes};
use crate::triangle::block::Block;

/// What a scene needs. What it does not need is skipped in rendering.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inspection {
    /// Bytes of the film while it is rendered: the sums of each pixel, and the picture that they become.
    pub film_bytes: u64,
    /// Camera rays start on a lens.
    pub has_lens: bool,
    /// Places in a pixel are looked up in tables: the filter is not constant.
    pub has_filter_table: bool,
    /// Shapes of the world.
    pub world: Elements,
    /// Shapes of each object that has copies.
    pub objects: Vec<Elements>,
    /// Shapes may have holes.
    pub has_cutouts: bool,
    /// Where samples are taken eight side by side: the instructions for that, "AVX-512" or "AVX2".
    pub side_by_side: Option<&'static str>,
    /// Whether rays go down the tree; if not, eight at a time are tried against each shape.
    pub asks_tree: bool,
    /// What surfaces are made of; `None` where the integrator does not ask.
    pub surfaces: Option<Surfaces>,
    /// The kind of each light, infinite ones last.
    pub lights: Vec<&'static str>,
    /// How many of them are infinite, and everywhere alike: they are found by directions from the BSDF, and sampled only
    /// where those do not go.
    pub constant_skies: usize,
    /// How lights are chosen at a surface.
    pub choice: Choice,
    /// What is drawn at each surface that light is followed over, at most.
    pub draws: Vec<Draw>,
    /// Surfaces that light is followed over, at most.
    pub depth: u32,
}

/// The elements of one tree.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Elements {
    /// Triangles that have an area.
    pub triangles: usize,
    /// Spheres and the like.
    pub quadrics: usize,
    /// Pieces of curves.
    pub curve_pieces: usize,
    /// Copies of objects.
    pub instances: usize,
    /// Nodes of the tree, of up to eight children; 0 where a single leaf holds all.
    pub nodes: usize,
    /// The most nodes on a way from the root to a leaf.
    pub depth: usize,
    /// Bytes of the tree and of what its leaves hold.
    pub bytes: usize,
}

/// The materials in use, and how many of them need something.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Surfaces {
    /// The type of each, in the order of their first shapes.
    pub kinds: Vec<&'static str>,
    /// Those that are diffuse and nothing else, and go without a list of lobes.
    pub lambert: usize,
    /// The most lobes that one of the others has.
    pub most_lobes: usize,
    /// Those that have single directions: mirrors and smooth glass.
    pub specular: usize,
    /// Those that need texture coordinates.
    pub coordinates: usize,
    /// Those that need the distance to neighbouring camera rays, as their textures are filtered.
    pub footprints: usize,
    /// Those that bend normals.
    pub bumps: usize,
}

/// How lights are chosen at a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// The integrator asks for no light.
    Unused,
    /// There is one light or none.
    Nothing,
    /// All of them are sampled.
    All,
    /// One of them, by this rule.
    One(LightChoice),
}

/// The instructions that rays are traced with on this processor: "AVX-512", "AVX2" or "portable".
pub fn simd() -> &'static str {
    Simd::best().name()
}

/// Prepares a scene as rendering does, and says what it needs.
pub fn inspect(scene: &Scene) -> Inspection {
    let traceable = Traceable::new(scene, Precision::default());
    let lights = LightTable::new(scene, &traceable);
    let lanes = Lanes::new(scene, &traceable, &lights);
    let materials = surfaces(&traceable);
    let (choice, draws, depth) = integration(&scene.integrator, &lights, materials.specular > 0);
    let asks_materials = !matches!(scene.integrator, Integrator::AmbientOcclusion { .. });
    Inspection {
        film_bytes: film_bytes(&scene.film, &Settings::default()),
        has_lens: CameraRays::new(&scene.camera, &scene.film).has_lens(),
        has_filter_table: FilterSampler::new(&scene.filter).has_tables(),
        world: elements(&traceable.world),
        objects: traceable.objects.iter().map(elements).collect(),
        has_cutouts: traceable.has_cutouts,
        side_by_side: lanes.as_ref().map(Lanes::name),
        asks_tree: lanes.as_ref().is_none_or(Lanes::asks_tree),
        surfaces: asks_materials.then_some(materials),
        lights: lights.kinds().collect(),
        constant_skies: lights.len() - lights.eligible(None),
        choice,
        draws,
        depth,
    }
}

/// How lights are chosen, what is drawn at each surface, and over how many surfaces light is followed.
fn integration(integrator: &Integrator, lights: &LightTable, is_specular: bool) -> (Choice, Vec<Draw>, u32) {
    let one = |choice| if lights.len() < 2 { Choice::Nothing } else { Choice::One(lights.rule(choice)) };
    match *integrator {
        Integrator::Path { max_depth, light_choice, .. } => {
            (one(light_choice), path::draws(max_depth, lights), max_depth)
        }
        Integrator::DirectLighting { strategy, max_depth } => {
            let choice = match strategy {
                DirectStrategy::All | DirectStrategy::EachOnce if lights.len() > 1 => Choice::All,
                _ => one(LightChoice::Uniform),
            };
            // Only single directions are followed.
            let depth = if is_specular { max_depth.max(1) } else { 1 };
            (choice, direct::draws(lights, strategy, depth, is_specular), depth)
        }
        Integrator::AmbientOcclusion { samples, .. } => {
            let directions = Draw { of: "direction", numbers: samples.saturating_mul(2), surfaces: 0..1 };
            (Choice::Unused, vec![directions], 1)
        }
    }
}

fn elements(group: &Group) -> Elements {
    let count = |is: fn(&Other) -> bool| group.others.iter().filter(|other| is(other)).count();
    let nodes = group.bvh.nodes();
    Elements {
        triangles: group.triangles().count(),
        quadrics: count(|other| matches!(other, Other::Curved { .. })),
        curve_pieces: count(|other| matches!(other, Other::Curve { .. })),
        instances: count(|other| matches!(other, Other::Instance { .. })),
        nodes,
        depth: group.bvh.depth(),
        bytes: nodes * size_of::<Node>()
            + group.blocks.len() * size_of::<Block>()
            + group.others.len() * size_of::<Other>(),
    }
}

fn surfaces(traceable: &Traceable) -> Surfaces {
    let mut materials: Vec<&Material> = Vec::new();
    let mut known = std::collections::HashSet::new();
    for primitive in &traceable.primitives {
        if known.insert(Arc::as_ptr(&primitive.material)) {
            materials.push(&primitive.material);
        }
    }
    let count = |is: &dyn Fn(&Material) -> bool| materials.iter().filter(|material| is(material)).count();
    let others = materials.iter().filter(|material| lambert(&material.kind).is_none());
    Surfaces {
        kinds: materials.iter().map(|material| material.kind.name()).collect(),
        lambert: count(&|material| lambert(&material.kind).is_some()),
        most_lobes: others.map(|material| most_lobes(material).all).max().unwrap_or(0),
        specular: count(&|material| most_lobes(material).specular > 0),
        coordinates: count(&|material| material.needs.coordinates),
        footprints: count(&|material| material.needs.footprint),
        bumps: count(&|material| material.bump.is_some()),
    }
}
