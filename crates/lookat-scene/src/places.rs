//! Where the text says how a scene is seen and lit.

use glam::DVec3;
use lookat_syntax::Span;

use crate::Transform;

/// The places of what a view consists of, and of the lights. `None` where the text leaves a default.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// The type of `Camera`.
    pub camera: Option<Span>,
    /// The `LookAt` that alone places the camera.
    pub look_at: Option<LookAt>,
    /// The numbers of `screenwindow`.
    pub screen_window: Option<Span>,
    /// The number of `lensradius`.
    pub lens_radius: Option<Span>,
    /// The number of `focaldistance`.
    pub focal_distance: Option<Span>,
    /// The numbers of `cropwindow`.
    pub crop_window: Option<Span>,
    /// `WorldBegin`.
    pub world_begin: Option<Span>,
    /// The types of `LightSource`, in the order of [`World::lights`](crate::World::lights).
    pub lights: Vec<Span>,
}

/// A `LookAt`, in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookAt {
    /// The directive.
    pub span: Span,
    /// The position of the eye.
    pub eye: DVec3,
    /// The point that it looks at.
    pub look: DVec3,
    /// The direction that is up in the picture.
    pub up: DVec3,
}

impl LookAt {
    pub(crate) fn new(span: Span, points: [f64; 9]) -> Self {
        let [eye, look, up] = [0, 3, 6].map(|at| DVec3::from_slice(&points[at..at + 3]));
        LookAt { span, eye, look, up }
    }

    /// Whether it alone places a camera.
    pub(crate) fn places(&self, world_from_camera: &Transform) -> bool {
        Transform::look_at(self.eye, self.look, self.up).is_ok_and(|it| it.inverse() == *world_from_camera)
    }
}
