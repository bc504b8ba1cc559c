//! What a scene is once every name, default, unit and transformation is settled.

use std::sync::Arc;

use crate::{Camera, Cutout, Film, Filter, Integrator, Light, Material, Sampler, Shape, Transform};

/// A scene, ready to render. Lengths are in world units, but those of quadrics and curves in object space; angles are in
/// radians, where a field does not say degrees; colors are linear RGB, transformations `f64`. There is nothing left to look
/// up and nothing that can fail.
#[derive(Debug, Clone)]
pub struct Scene {
    /// How it is viewed.
    pub camera: Camera,
    /// The size of the picture and where it goes.
    pub film: Film,
    /// How samples are weighed into pixels.
    pub filter: Filter,
    /// How samples are placed, and how many.
    pub sampler: Sampler,
    /// How light is computed.
    pub integrator: Integrator,
    /// The shapes of the world.
    pub primitives: Vec<Primitive>,
    /// The copies of objects in the world.
    pub instances: Vec<Instance>,
    /// The lights without a shape; shapes that emit carry their emission themselves.
    pub lights: Vec<Light>,
}

/// A shape with what it is made of. Its coordinates are those of the world, or of the object that it is part of.
#[derive(Debug, Clone)]
pub struct Primitive {
    /// Its form and place.
    pub shape: Shape,
    /// `ReverseOrientation` was on: normals point the other way.
    pub reverse_orientation: bool,
    /// The transformation from the shape's own space mirrors.
    pub mirrored: bool,
    /// What it is made of.
    pub material: Arc<Material>,
    /// Where it has holes; meshes alone have any.
    pub cutout: Option<Cutout>,
    /// The light that it emits, if any.
    pub emission: Option<Emission>,
}

/// Light from a surface: `AreaLightSource "diffuse"`, the same radiance in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    /// Emitted radiance, linear RGB (parameters `L` times `scale`).
    pub radiance: glam::Vec3,
    /// Both sides emit. Default: only the side that the normal points to.
    pub two_sided: bool,
    /// Samples of direct light per camera sample, for the direct lighting integrator. Default 1.
    pub samples: u32,
}

impl Emission {
    /// Whether it gives no light.
    pub(crate) fn is_black(&self) -> bool {
        self.radiance == glam::Vec3::ZERO
    }
}

/// The shapes between `ObjectBegin` and `ObjectEnd`. As in pbrt-v3, those that
/// emit are seen to glow, but light nothing.
#[derive(Debug, Clone, Default)]
pub struct Object {
    /// Its shapes, in the object's own space.
    pub primitives: Vec<Primitive>,
}

/// A copy of an object.
#[derive(Debug, Clone)]
pub struct Instance {
    /// What is copied.
    pub object: Arc<Object>,
    /// Where it stands: the current transformation at `ObjectInstance`.
    pub world_from_object: Transform,
}
