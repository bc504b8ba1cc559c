//! The messages between the page and the program: JSON, and pictures as numbers.

mod looking;
mod parameters;
mod picture;

use lookat_scene::ViewOverride;
use serde::{Deserialize, Serialize};
use tungstenite::Message;

pub use looking::*;
pub use parameters::{At, Change, Changed, Described, Given, Open, Parameter, Place, Values};
pub use picture::{About, Content, pixels};

/// What the page asks for.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "camelCase")]
pub enum Request {
    Film(SetFilm),
    View(SetView),
    Change(Change),
    Edit(Edit),
    Errors(SetErrors),
    #[serde(untagged)]
    Query(Query),
}

/// What is answered beside the picture, which goes on.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(tag = "type", rename_all = "camelCase")]
pub enum Query {
    Pick(Pick),
    Depths(GetDepths),
    Show(Show),
    Open(Open),
    Reference(SetReference),
    Layer(GetLayer),
    Values(GetValues),
}

impl Query {
    /// Whether the answer takes the memory of another film.
    pub fn needs_film(&self) -> bool {
        matches!(self, Query::Layer(_) | Query::Values(_))
    }
}

/// What the page sets of the film instead of the file. Each of them reads the file again.
#[derive(Debug, Default, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SetFilm {
    /// Also numbers that are not valid, which are refused in words.
    pub resolution: Option<[f64; 2]>,
    pub crop: Option<[f64; 4]>,
    pub samples_per_pixel: Option<f64>,
}

/// What the page sets of the camera instead of the file.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SetView {
    /// The page, by a random number of its own. It knows by it what it asked for itself.
    pub by: u32,
    /// Counts the requests of the page.
    pub number: u32,
    pub camera: SetCamera,
}

/// The camera that the page sets; `None` as in the file.
#[derive(Debug, Default, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SetCamera {
    pub look_at: Option<[f64; 9]>,
    pub fov: Option<f64>,
    pub lens_radius: Option<f64>,
    pub focal_distance: Option<f64>,
    pub screen_window: Option<[f64; 4]>,
}

impl From<SetCamera> for ViewOverride {
    fn from(camera: SetCamera) -> ViewOverride {
        let SetCamera { look_at, fov, lens_radius, focal_distance, screen_window } = camera;
        ViewOverride { look_at, fov, lens_radius, focal_distance, screen_window }
    }
}

/// Asks what the picture shows at a place.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Pick {
    pub by: u32,
    pub number: u32,
    /// In pixels from the top left corner of the full picture.
    pub at: [f64; 2],
}

/// Asks for the depths at places in rows and columns.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct GetDepths {
    pub by: u32,
    pub number: u32,
    pub columns: u32,
    pub rows: u32,
}

/// Asks for the lines that writing changes.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Show {
    pub by: u32,
}

/// Asks to change the files.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Edit {
    pub by: u32,
    pub action: Action,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Action {
    /// Write the lines that this page was shown last.
    Write,
    /// Forget the changes of parameters that are not written.
    Discard,
    Undo,
    Redo,
}

/// What the program tells.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "camelCase")]
pub enum News<'a> {
    Scene(Scene<'a>),
    View(View<'a>),
    Picked(Picked),
    Depths(Depths),
    Changed(Changed),
    Edited(Edited),
    Values(LayerValues),
    Looking(Looking<'a>),
    Compared(Compared),
}

impl News<'_> {
    pub fn message(&self) -> Message {
        Message::text(serde_json::to_string(self).unwrap_or_default())
    }
}

/// The file, as it was read last.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Scene<'a> {
    pub name: &'a str,
    /// Errors, warnings and notes, as the terminal shows them.
    pub messages: &'a str,
    /// Whether there are errors. The page then shows the last scene without them.
    pub has_errors: bool,
    /// `None` until a file without errors has been read.
    pub film: Option<Film>,
    /// Why the film is not the one that a page asked for.
    pub film_refused: Option<&'a str>,
    /// The camera of the file.
    pub camera: Option<Camera>,
    /// Whether there is something written to undo, or to redo.
    pub can_undo: bool,
    pub can_redo: bool,
    /// Whether parameters have been changed and not written.
    pub has_unsaved: bool,
    /// Whether such changes are gone, because the file has changed.
    pub has_lost: bool,
    /// The lights without a shape.
    pub lights: Vec<Described>,
    /// Whether the program opens the editor; otherwise the page has links to one.
    pub has_editor: bool,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Film {
    pub resolution: [u32; 2],
    /// The rendered pixels: left, top, right and bottom edge.
    pub crop: [u32; 4],
    pub samples_per_pixel: u32,
}

/// A camera with all values.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Camera {
    /// `perspective`, `orthographic` or `environment`.
    pub kind: &'static str,
    pub look_at: [f64; 9],
    /// Whether a `LookAt` alone places the camera of the file.
    pub has_look_at: bool,
    /// Whether the transformation before `LookAt` exchanges left and right, or top and bottom.
    pub mirrored: [bool; 2],
    pub fov: Option<f64>,
    /// 0 for a pinhole.
    pub lens_radius: f64,
    /// `None` for a pinhole, unless the file has one all the same.
    pub focal_distance: Option<f64>,
    pub screen_window: [f64; 4],
}

/// The camera as it is set.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct View<'a> {
    pub by: u32,
    pub number: u32,
    pub set: SetCamera,
    pub camera: Camera,
    /// Why the request of the page changed nothing.
    pub refused: Option<&'a str>,
}

/// What the picture shows at a place.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Picked {
    pub by: u32,
    pub number: u32,
    pub at: [f64; 2],
    /// `None` where there is nothing.
    pub hit: Option<Hit>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Hit {
    /// The point in the world.
    pub p: [f64; 3],
    /// The same in the space of the points of `LookAt`, which transformations may follow.
    pub p_look_at: [f64; 3],
    /// The focal distance at which it is sharp.
    pub depth: f64,
    /// The type of the shape, and its place.
    pub shape: String,
    pub shape_place: Option<Place>,
    /// The type of the material, and its place.
    pub material: String,
    pub material_place: Option<Place>,
    /// The directives of its material and its emission.
    pub directives: Vec<Described>,
}

/// Depths row by row; `None` where there is nothing.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Depths {
    pub by: u32,
    pub number: u32,
    pub columns: u32,
    pub depths: Vec<Option<f64>>,
}

/// The answer to an edit.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Edited {
    pub by: u32,
    /// The lines that would change, or have changed.
    pub lines: Vec<ChangedLines>,
    /// Whether files have been written.
    pub is_written: bool,
    /// Why nothing has changed, or can be.
    pub refused: Option<String>,
}

/// Lines of a file before and after a change.
#[derive(Debug, Serialize)]
pub struct ChangedLines {
    pub file: String,
    /// The number of the first, from 1.
    pub line: usize,
    pub removed: Vec<String>,
    pub added: Vec<String>,
}
