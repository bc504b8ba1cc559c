//! What is found of each scene.

use std::collections::BTreeMap;

use lookat_image::Measured;
use serde::{Serialize, Serializer};
use serde_json::Value;

use crate::readable::count;
use crate::verify::page::picture::Picture;

/// The result for one scene, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Agrees with its reference.
    Agrees,
    /// Has no reference.
    New,
    /// The differences may be light that samples rarely hit.
    Undecided,
    /// Could not be compared.
    Failed,
    /// Differs from its reference.
    Differs,
}

impl Verdict {
    /// In the order of the summary line.
    pub const ALL: [Verdict; 5] =
        [Verdict::Agrees, Verdict::Differs, Verdict::Undecided, Verdict::New, Verdict::Failed];

    /// The word for one scene.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::New => "new",
            Verdict::Undecided => "undecided",
            Verdict::Failed => "failed",
            Verdict::Differs => "differs",
        }
    }

    /// The word for `count` scenes.
    pub fn word_for(self, count: usize) -> &'static str {
        match self {
            Verdict::Agrees if count > 1 => "agree",
            Verdict::Differs if count > 1 => "differ",
            Verdict::New => "without a reference",
            _ => self.word(),
        }
    }
}

/// One scene with its verdict: what `--json` prints, and what the table and the report show.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The file name without `.pbrt`.
    pub scene: String,
    /// `agrees`, `differs`, `undecided`, `new` or `failed`.
    pub verdict: Verdict,
    /// Why, in words.
    pub reason: String,
    /// True if the reference was written.
    pub updated: bool,
    /// The metrics by name.
    #[serde(serialize_with = "by_name")]
    pub metrics: Vec<Measured>,
    /// Smallest bias of the mean that the noise tests would find, in the picture's unit, or null.
    pub visible_in_mean: Option<f64>,
    /// Samples per pixel of the render, or null.
    pub samples_per_pixel: Option<u32>,
    /// The time to render, or null.
    pub seconds: Option<f64>,
    /// The messages of the scene file, as in `check`.
    pub diagnostics: Value,
    /// The messages of the scene file as text. Empty without messages.
    #[serde(skip)]
    pub messages: String,
    /// The mean value of the reference. `None` if there are not two pictures of one size.
    #[serde(skip)]
    pub mean: Option<f64>,
    /// With `--report`: the two pictures over each other, or each one alone if they cannot be compared.
    #[serde(skip)]
    pub pictures: Vec<Picture>,
}

/// Metrics with their values, in the order of their names.
fn by_name<S: Serializer>(metrics: &[Measured], serializer: S) -> Result<S::Ok, S::Error> {
    let values: BTreeMap<_, _> = metrics.iter().map(|line| (line.metric.name(), line.value)).collect();
    values.serialize(serializer)
}

/// "20 scenes: 18 agree, 1 differs, 1 failed". `mark` takes the words of each verdict.
pub fn summary(verdicts: &[Verdict], mark: impl Fn(Verdict, String) -> String) -> String {
    let words = |verdict: Verdict| {
        let count = verdicts.iter().filter(|other| **other == verdict).count();
        (count > 0).then(|| mark(verdict, format!("{count} {}", verdict.word_for(count))))
    };
    let words: Vec<String> = Verdict::ALL.into_iter().filter_map(words).collect();
    format!("{}: {}", count(verdicts.len() as u64, "scene"), words.join(", "))
}
