//! Rays in a scene, for tools and measurements: what the renderer does with them, and nothing else.

use glam::{DVec2, DVec3};
use lookat_scene::Scene;

use crate::camera::CameraRays;
use crate::prepare::Prepared;
use crate::ray::{Hit, Ray};
use crate::surface::Surface;

/// A scene in which rays can be traced. All positions are relative to [`Probe::origin`].
pub struct Probe {
    prepared: Prepared,
    camera: CameraRays,
}

/// A point of a surface. Normals have length one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position.
    pub p: DVec3,
    /// The geometric normal.
    pub n: DVec3,
    /// The shading normal.
    pub ns: DVec3,
}

impl Probe {
    /// Prepares the scene as rendering does.
    pub fn new(scene: &Scene) -> Self {
        let prepared = Prepared::new(scene);
        let camera = prepared.camera(&scene.view);
        Probe { prepared, camera }
    }

    /// The eye: the position of a perspective camera, the middle of the window of an orthographic one.
    pub fn eye(&self) -> DVec3 {
        self.camera.eye
    }

    /// The world position that all others are relative to.
    pub fn origin(&self) -> DVec3 {
        self.prepared.traceable.origin
    }

    /// The camera ray through `film`, in pixels from the top left corner, and the point of the lens that `u`, in 0..1,
    /// chooses.
    pub fn camera_ray(&self, film: DVec2, u: DVec2) -> Ray {
        self.camera.ray(film, u)
    }

    /// The nearest hit.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        self.prepared.traceable.nearest(ray)
    }

    /// The nearest hit without trees, by testing every element in turn. `lookat stability` compares trees with it, to the
    /// bit, in V1 to V3. Only the renderer can compute it, because elements are rounded relative to [`Probe::origin`].
    pub fn nearest_by_all(&self, ray: &Ray) -> Option<Hit> {
        self.prepared.traceable.nearest_by_all(ray)
    }

    /// True if anything is in the way of a ray that ends at its `t_max`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.prepared.traceable.occluded(ray)
    }

    /// The point that a ray has hit.
    pub fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let Surface { p, n, ns, .. } = Surface::new(&self.prepared.traceable, ray, hit);
        SurfacePoint { p, n, ns }
    }

    /// The ray that leaves that point in direction `d`, of length one.
    pub fn spawn_ray(&self, ray: &Ray, hit: &Hit, d: DVec3) -> Ray {
        Surface::new(&self.prepared.traceable, ray, hit).spawn_ray(d)
    }
}
