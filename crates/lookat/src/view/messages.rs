//! The messages between the page and the program: JSON, and pictures as numbers.

use std::mem::discriminant;
use std::path::Path;

use lookat_render::Layer;
use lookat_scene::syntax::{FileId, Span};
use lookat_scene::{Sources, ViewOverride};
use serde::{Deserialize, Serialize};
use tungstenite::Message;

use crate::explain::ParameterFacts;
use crate::report;

/// What a page asks for. `by` is the page, by a random number of its own: it knows its answers by it. `number` counts its requests.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum Request {
    /// Sets the film instead of the file. Each such request reads the file again.
    Film {
        /// Also numbers that are not valid, which are refused in words.
        resolution: Option<[f64; 2]>,
        crop: Option<[f64; 4]>,
        samples_per_pixel: Option<f64>,
    },
    View(SetView),
    Change(Change),
    /// Changes the files.
    Edit {
        by: u32,
        action: Action,
    },
    /// Renders with or without error layers.
    Errors {
        is_on: bool,
    },
    /// Asks what the picture shows at a place, in pixels from the top left corner of the full picture.
    Pick {
        by: u32,
        number: u32,
        at: [f64; 2],
    },
    /// Asks for the depths at places in rows and columns.
    Depths {
        by: u32,
        number: u32,
        columns: u32,
        rows: u32,
    },
    /// Asks for the lines that writing changes.
    Show {
        by: u32,
    },
    /// Opens a place in the editor.
    Open {
        by: u32,
        at: At,
    },
    /// Sets the reference.
    Reference {
        from: ReferenceFrom,
    },
    /// Asks for a layer, as the view shows it now, by its number in [`LAYERS`].
    Layer {
        layer: u8,
    },
    /// Asks for the values of all layers at a place, in pixels from the top left corner of the full picture.
    Values {
        by: u32,
        number: u32,
        at: [f64; 2],
    },
}

impl Request {
    /// Whether it is answered beside the picture, which goes on.
    pub fn is_query(&self) -> bool {
        use Request::*;
        !matches!(self, Film { .. } | View(_) | Change(_) | Edit { .. } | Errors { .. })
    }

    /// Whether the answer takes the memory of another film.
    pub fn needs_film(&self) -> bool {
        matches!(self, Request::Layer { .. } | Request::Values { .. })
    }

    /// Whether the answer to it is of no use any more once a later request is made.
    pub fn is_outdated_by(&self, later: &Request) -> bool {
        use Request::*;
        discriminant(self) == discriminant(later)
            && match (self, later) {
                (Edit { .. }, _) => false,
                (Change(own), Change(later)) => {
                    (own.by, own.at, &own.name) == (later.by, later.at, &later.name)
                }
                (Layer { layer: own }, Layer { layer: later }) => own == later,
                _ => self.asker() == later.asker(),
            }
    }

    /// The page that is answered. `None` if all pages are.
    fn asker(&self) -> Option<u32> {
        use Request::*;
        match *self {
            Pick { by, .. } | Depths { by, .. } | Show { by } | Open { by, .. } | Values { by, .. } => {
                Some(by)
            }
            _ => None,
        }
    }
}

/// What the page sets of the camera instead of the file.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetView {
    pub by: u32,
    pub number: u32,
    pub camera: ViewOverride,
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

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum ReferenceFrom {
    /// The picture that is there now.
    Picture,
    /// The file that the command names, or else the one beside the scene.
    File,
    Nothing,
}

/// What the program tells.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum News<'a> {
    /// The file, as it was read last.
    Scene {
        name: &'a str,
        /// Errors, warnings and notes, as the terminal shows them.
        messages: &'a str,
        /// Whether there are errors. The page then shows the last scene without them.
        has_errors: bool,
        /// `None` until a file without errors has been read.
        film: Option<Film>,
        /// Why the film is not the one that a page asked for.
        film_refused: Option<&'a str>,
        /// The camera of the file.
        camera: Option<Camera>,
        /// Whether there is something written to undo, or to redo.
        can_undo: bool,
        can_redo: bool,
        /// Whether parameters have been changed and not written.
        has_unsaved: bool,
        /// Whether such changes are gone, because the file has changed.
        has_lost: bool,
        /// The lights without a shape.
        lights: Vec<Described>,
        /// Whether the program opens the editor; otherwise the page has links to one.
        has_editor: bool,
    },
    /// The camera as it is set.
    View {
        by: u32,
        number: u32,
        set: ViewOverride,
        camera: Camera,
        /// Why the request of the page changed nothing.
        refused: Option<&'a str>,
    },
    /// What the picture shows at a place. `None` where there is nothing.
    Picked { by: u32, number: u32, at: [f64; 2], hit: Option<Hit> },
    /// Depths row by row; `None` where there is nothing.
    Depths { by: u32, number: u32, columns: u32, depths: Vec<Option<f64>> },
    /// The answer to a change.
    Changed {
        by: u32,
        number: u32,
        directives: Vec<Described>,
        /// Why nothing has changed.
        refused: Option<String>,
    },
    /// The answer to an edit.
    Edited {
        by: u32,
        /// The lines that would change, or have changed.
        lines: Vec<ChangedLines>,
        /// Whether files have been written.
        is_written: bool,
        /// Why nothing has changed, or can be.
        refused: Option<String>,
    },
    /// The values of all layers at a place, in the order of [`LAYERS`]. Empty outside the picture.
    Values { by: u32, number: u32, at: [f64; 2], values: Vec<Vec<f32>> },
    /// How the pages look.
    Looking {
        /// Whether pictures have error layers.
        has_errors: bool,
        /// Why they do not have them.
        errors_refused: Option<&'a str>,
        /// The name of the reference.
        reference: Option<&'a str>,
        /// Whether its pixels follow.
        is_shown: bool,
        /// Why there is none, why it does not fit, or why it is not the newest one.
        reference_refused: Option<&'a str>,
        /// The file that can be the reference.
        file: Option<String>,
    },
    /// The finished picture and the reference.
    Compared {
        /// Of the view.
        generation: u32,
        /// What `lookat compare` prints, or why there is nothing to compare.
        text: String,
        /// Whether noise explains the differences. `None` if nobody can tell.
        agrees: Option<bool>,
    },
}

impl From<News<'_>> for Message {
    fn from(news: News) -> Message {
        Message::text(serde_json::to_string(&news).unwrap_or_default())
    }
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
    /// `perspective`, `orthographic`, `environment` or `realistic`.
    pub kind: &'static str,
    pub look_at: [f64; 9],
    /// Whether a `LookAt` alone places the camera of the file.
    pub has_look_at: bool,
    /// Whether the transformation before `LookAt` exchanges left and right, or top and bottom.
    pub mirrored: [bool; 2],
    pub fov: Option<f64>,
    /// Of a lens system: the angle of view along the shorter side, in degrees.
    pub view_angle: Option<f64>,
    /// The depth of the lens: of the entrance pupil of a lens system.
    pub lens_depth: f64,
    /// 0 for a pinhole.
    pub lens_radius: f64,
    /// `None` for a pinhole, unless the file has one all the same.
    pub focal_distance: Option<f64>,
    pub screen_window: [f64; 4],
    /// The instant of the picture. `None` for a shutter that is open for a while.
    pub time: Option<f64>,
    /// The start time and the end time of motion. `None` if nothing moves.
    pub times: Option<[f64; 2]>,
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
    pub shape_place: Option<TextPlace>,
    /// The type of the material, and its place.
    pub material: String,
    pub material_place: Option<TextPlace>,
    /// The directives of its material and its emission.
    pub directives: Vec<Described>,
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

/// The layers that a page can ask for, by their numbers in this list.
pub const LAYERS: [(&str, Layer); 8] = [
    ("depth", Layer::Depth),
    ("position", Layer::Position),
    ("normal", Layer::Normal),
    ("shading-normal", Layer::ShadingNormal),
    ("uv", Layer::Uv),
    ("albedo", Layer::Albedo),
    ("shape", Layer::Shape),
    ("material", Layer::Material),
];

/// A place of the text, as pages name it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct At {
    /// Counts how often the scene has been read. Another text has other places.
    pub reading: u32,
    pub file: u32,
    pub start: u32,
}

impl At {
    pub fn span(self) -> Span {
        Span { file: FileId(self.file), start: self.start, end: self.start.saturating_add(1) }
    }
}

/// A place of the text, as pages show it.
#[derive(Debug, Serialize)]
pub struct TextPlace {
    pub at: At,
    /// file:line:column
    pub text: String,
    /// The absolute path of the file.
    pub path: String,
    pub line: usize,
    pub column: usize,
}

impl TextPlace {
    pub fn new(span: Span, sources: &Sources, reading: u32) -> TextPlace {
        let found = sources.location(span);
        let path = std::path::absolute(found.path);
        TextPlace {
            at: At { reading, file: span.file.0, start: span.start },
            text: report::place(span, sources),
            path: path.as_deref().unwrap_or(Path::new("")).display().to_string(),
            line: found.line,
            column: found.column,
        }
    }
}

/// A directive with its parameters.
#[derive(Debug, Serialize)]
pub struct Described {
    pub directive: &'static str,
    /// The type, such as `matte`.
    pub kind: &'static str,
    /// The name of a named material.
    pub name: Option<String>,
    pub place: TextPlace,
    pub parameters: Vec<Parameter>,
}

#[derive(Debug, Serialize)]
pub struct Parameter {
    /// As in the schema that `explain --json` prints.
    pub facts: ParameterFacts,
    /// What the text gives it. `None` for the default.
    pub given: Option<TextValues>,
}

/// A parameter in the text.
#[derive(Debug, Serialize)]
pub struct TextValues {
    #[serde(rename = "type")]
    pub ty: &'static str,
    pub values: Values,
}

/// Numbers, or words: strings, names of textures and files, `true` and `false`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Values {
    Numbers(Vec<f64>),
    Words(Vec<String>),
}

/// Asks to give a parameter other values, without writing the file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Change {
    pub by: u32,
    pub number: u32,
    /// The directives that the page shows: the answer describes them again.
    pub shown: Vec<At>,
    pub at: At,
    pub name: String,
    /// The type of the values, as the text spells it.
    pub value_type: String,
    pub values: Values,
}

/// What a picture is.
#[derive(Debug, Clone, Copy)]
pub struct About {
    /// Counts the views.
    pub generation: u32,
    /// The number of the page's request that the view follows, or of the layer.
    pub number: u32,
    /// Samples of all pixels, done and in all.
    pub done: u64,
    pub total: u64,
    /// The time since this rendering began.
    pub seconds: f64,
    pub content: Content,
}

/// What the numbers of a picture stand for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Content {
    /// Colors of a picture that is not finished.
    Growing,
    /// Colors of the picture that `render` makes.
    Finished,
    Reference,
    Layer,
    Errors,
}

/// The bytes before the pixels of a picture: eight numbers.
const HEADER: usize = 64;

/// A picture as a message: width, height and `about` as `f64`, then three values of each pixel as `f32`, of colors linear red,
/// green and blue. Little-endian.
pub fn pixels([width, height]: [u32; 2], values: &[[f32; 3]], about: About) -> Message {
    let About { generation, number, done, total, seconds, content } = about;
    let header = [
        f64::from(width),
        f64::from(height),
        f64::from(generation),
        f64::from(number),
        done as f64,
        total as f64,
        seconds,
        f64::from(content as u8),
    ];
    let mut bytes = vec![0; HEADER + 12 * values.len()];
    let (head, body) = bytes.split_at_mut(HEADER);
    head.copy_from_slice(header.map(f64::to_le_bytes).as_flattened());
    for (place, value) in body.chunks_exact_mut(4).zip(values.as_flattened()) {
        place.copy_from_slice(&value.to_le_bytes());
    }
    Message::binary(bytes)
}
