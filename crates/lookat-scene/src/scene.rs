//! The resolved scene.

use std::sync::Arc;

use lookat_syntax::Span;

use crate::{Camera, Cutout, Emission, Film, Filter, Integrator, Light, Material, Sampler, Shape, Transform};

/// A scene, ready to render: a view of a world. Lengths are in world units, except for quadrics and curves, which are in
/// object space. Angles are in radians unless a field says degrees. Colors are linear RGB; transformations are `f64`.
/// Nothing is left to look up, and nothing can fail.
#[derive(Debug, Clone)]
pub struct Scene {
    /// How the world is seen.
    pub view: View,
    /// What is seen. Views share it.
    pub world: Arc<World>,
}

/// The directives before `WorldBegin`: how a picture is taken.
#[derive(Debug, Clone)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The size of the picture.
    pub film: Film,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The sampler and its number of samples.
    pub sampler: Sampler,
    /// The light transport algorithm.
    pub integrator: Integrator,
}

/// The directives after `WorldBegin`: shapes and lights.
#[derive(Debug, Clone, Default)]
pub struct World {
    /// The shapes of the world.
    pub primitives: Vec<Primitive>,
    /// The object instances of the world.
    pub instances: Vec<Instance>,
    /// The lights without a shape. An emissive shape stores its own emission.
    pub lights: Vec<Light>,
}

impl View {
    /// A view by the box filter, the Halton sampler with 16 samples per pixel and path tracing up to depth 5: the defaults of
    /// pbrt-v3.
    pub fn new(camera: Camera, film: Film) -> View {
        View {
            camera,
            film,
            filter: Filter::BOX,
            sampler: Sampler::PBRT_DEFAULT,
            integrator: Integrator::PBRT_DEFAULT,
        }
    }
}

impl Scene {
    /// A view of a world.
    pub fn new(view: View, world: World) -> Scene {
        Scene { view, world: Arc::new(world) }
    }
}

impl Primitive {
    /// A shape of a material: without holes, and dark.
    pub fn new(shape: Shape, material: Arc<Material>) -> Primitive {
        Primitive {
            mirrored: shape.is_mirrored().unwrap_or(false),
            shape,
            span: None,
            reverse_orientation: false,
            material,
            cutout: None,
            emission: None,
        }
    }

    /// The same shape as an area light.
    pub fn with_emission(self, emission: Emission) -> Primitive {
        Primitive { emission: Some(emission), ..self }
    }

    /// Its emission, unless that is black.
    pub(crate) fn light(&self) -> Option<Emission> {
        self.emission.filter(|emission| !emission.is_black())
    }
}

/// A shape with its material and emission. Its space is the world, or the object that contains it.
#[derive(Debug, Clone)]
pub struct Primitive {
    /// The shape.
    pub shape: Shape,
    /// The Shape directive that made it. `None` for a shape made in code.
    pub span: Option<Span>,
    /// True under `ReverseOrientation`: normals are flipped.
    pub reverse_orientation: bool,
    /// True if the transformation from object space swaps handedness. For a mesh: the one that its vertices went through.
    pub mirrored: bool,
    /// The material.
    pub material: Arc<Material>,
    /// The alpha mask. Only meshes have one.
    pub cutout: Option<Cutout>,
    /// The emitted light.
    pub emission: Option<Emission>,
}

/// The shapes between `ObjectBegin` and `ObjectEnd`. As in pbrt-v3, an emissive shape of an object is visible but is
/// not a light source.
#[derive(Debug, Clone, Default)]
pub struct Object {
    /// The shapes, in object space.
    pub primitives: Vec<Primitive>,
}

/// An object instance.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The object.
    pub object: Arc<Object>,
    /// The current transformation at `ObjectInstance`.
    pub world_from_object: Transform,
}
