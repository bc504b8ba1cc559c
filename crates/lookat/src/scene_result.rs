//! The JSON of a scene, by `render`, `check` and `inspect`.

use std::path::Path;

use lookat_scene::{JsonDiagnostic, Loaded, as_json};
use serde::Serialize;

use crate::inspect::needs::Needs;
use crate::render::summary::JsonPicture;

/// The JSON of a scene, by `render`, `check` and `inspect`.
#[derive(Default, Serialize)]
pub struct SceneResult<'a> {
    /// The scene file, as you named it.
    pub scene: String,
    /// Errors, warnings and notes in reading order.
    pub diagnostics: Vec<JsonDiagnostic<'a>>,
    /// `check --fast`: number of references to files that were not read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unread: Option<usize>,
    /// `inspect`, unless the scene has errors: what the scene needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub needs: Option<Needs>,
    /// `render`: the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<JsonPicture>,
    /// `render --turntable` and `--animate`: the finished pictures, instead of `picture`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<JsonPicture>,
    /// `render`: why there is no picture although the scene is fine, or why it is not where you wanted it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

impl<'a> SceneResult<'a> {
    /// The diagnostics of a scene file alone.
    pub fn new(scene: &Path, loaded: &'a Loaded) -> Self {
        SceneResult {
            diagnostics: as_json(&loaded.diagnostics, &loaded.sources),
            ..SceneResult::without_scene(scene)
        }
    }

    /// Nothing is known of the scene yet.
    pub fn without_scene(scene: &Path) -> Self {
        SceneResult { scene: scene.display().to_string(), ..SceneResult::default() }
    }
}
