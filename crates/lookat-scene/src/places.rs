//! Where the text says how a scene is seen and lit.

use lookat_syntax::Span;

/// The places of what a view consists of, and of the lights. `None` where the text leaves a default.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// The type of `Camera`.
    pub camera: Option<Span>,
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
