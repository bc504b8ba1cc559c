//! Files of parts and checkpoints: what they say beside their sums, of which rendering they are, and which samples they have.

use std::io::{self, BufRead, BufReader};
use std::ops::Range;
use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use lookat_image::{IntegerChannel, MemoryBudget, PictureFile, open_file, read_integers};
use lookat_render::{FilmSums, Settings, SumsHeader};
use lookat_scene::{Loaded, View};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::args::way_out;
use crate::failure::Failure;

/// The metadata of a part.
#[derive(Serialize, Deserialize)]
pub struct PartMetadata {
    /// The mean number of its samples.
    pub samples_per_pixel: f64,
    /// False if samples of its ranges are missing.
    pub complete: bool,
    pub part: Part,
    /// The metadata of the whole picture, as it is written.
    pub whole: String,
    /// The command that was broken off, in a checkpoint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub invocation: Option<Invocation>,
}

impl PartMetadata {
    /// As JSON.
    pub fn to_text(&self) -> Option<String> {
        serde_json::to_string(self).ok()
    }
}

/// True for the channels of sums in the file of a part.
pub fn is_of_sums(channel: &str) -> bool {
    channel.starts_with("sums.") || channel.starts_with("splats.")
}

/// Some of the samples of a rendering.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Part {
    pub rendering: Rendering,
    /// The indices of its samples, in order, with gaps between them.
    pub ranges: Vec<Range<u32>>,
    /// The header of its sums, in base 64: JSON holds no infinite numbers.
    sums: String,
    /// SHA-256 of the channels of its sums.
    hash: String,
}

impl Part {
    pub fn new(
        rendering: Rendering,
        ranges: Vec<Range<u32>>,
        sums: &FilmSums,
    ) -> (Self, Vec<IntegerChannel>) {
        let (header, channels) = sums.to_channels();
        let sums = BASE64_STANDARD.encode(header.to_bytes());
        (Part { rendering, ranges, sums, hash: hash_of(&channels) }, channels)
    }

    /// The number of its samples, once it is complete.
    pub fn samples(&self) -> u32 {
        self.ranges.iter().map(|range| range.len() as u32).sum()
    }

    /// True if its ranges are in order and within the rendering.
    fn is_sound(&self) -> bool {
        let Part { rendering, ranges, .. } = self;
        let mut end = 0;
        let is_next = |range: &Range<u32>| {
            let is_next = range.start >= end && range.start < range.end;
            end = range.end;
            is_next
        };
        !ranges.is_empty()
            && ranges.iter().all(is_next)
            && end <= rendering.samples_per_pixel
            && (1..=rendering.samples_per_pixel).contains(&rendering.parts)
    }
}

/// A command line of `lookat render`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Invocation {
    /// The working folder.
    pub folder: String,
    /// The words behind the name of the program.
    pub words: Vec<String>,
}

impl Invocation {
    /// The one of this process. `None` if its words or the name of its working folder are not Unicode.
    pub fn of_this_process() -> Option<Invocation> {
        let words = std::env::args_os().skip(1).map(|word| word.into_string().ok());
        let folder = std::env::current_dir().ok()?.into_os_string().into_string().ok()?;
        Some(Invocation { folder, words: words.collect::<Option<_>>()? })
    }
}

/// A file of a part, whose header has been read.
pub struct PartFile<'a> {
    pub path: &'a Path,
    pub metadata: PartMetadata,
    pub sums: SumsHeader,
}

impl PartFile<'_> {
    /// Reads the header of a part.
    pub fn open(path: &Path) -> Result<PartFile<'_>, Failure> {
        let opened = PictureFile::open(path, &MemoryBudget::default())?;
        let name = path.display();
        let Some(text) = opened.metadata().filter(|text| text.contains("\"part\":")) else {
            bail!(
                "{name} is no part of a rendering: only `lookat render --part`, `lookat render --checkpoint` and `lookat merge --partial` write parts"
            );
        };
        let read = || {
            let metadata: PartMetadata = serde_json::from_str(&text).ok()?;
            let part = &metadata.part;
            let sums = SumsHeader::from_bytes(&BASE64_STANDARD.decode(&part.sums).ok()?).ok()?;
            let has_samples = match metadata.complete {
                true => sums.samples() == Some(part.samples()),
                false => sums.most_samples() <= part.samples(),
            };
            (part.is_sound() && has_samples).then_some(PartFile { path, metadata, sums })
        };
        Ok(read().ok_or_else(|| format!("{name} is damaged, or of another version of lookat"))?)
    }

    /// Reads its sums, and charges them for good.
    pub fn read(&self, memory: &MemoryBudget) -> Result<FilmSums, Failure> {
        let name = self.path.display();
        let (channels, _charge) = read_integers(self.path, memory)?;
        if hash_of(&channels) != self.metadata.part.hash {
            bail!("{name} is damaged: its sums have changed");
        }
        memory
            .reserve(self.sums.bytes())
            .map_err(|shortage| format!("{name}: {}", way_out(shortage)))?
            .keep();
        let sums = FilmSums::from_channels(self.sums.clone(), &channels);
        sums.map_err(|error| format!("{}: {error}", self.path.display()).into())
    }
}

/// What all parts of a rendering have in common.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rendering {
    /// The version of lookat.
    pub version: String,
    /// The samples of each pixel in all parts together.
    pub samples_per_pixel: u32,
    /// The number of parts of the rendering.
    pub parts: u32,
    pub seed: u64,
    /// True if samples may be added later: see [`Settings::is_extendable`](lookat_render::Settings::is_extendable).
    pub is_extendable: bool,
    /// The files of the scene, the scene file first.
    pub files: Vec<HashedFile>,
    /// The hash of camera, film, filter, sampler and integrator, which options may have changed.
    pub view: String,
}

/// A file of a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HashedFile {
    /// Its name, without folders.
    pub name: String,
    /// SHA-256, in hexadecimal digits.
    pub hash: String,
}

impl Rendering {
    /// The rendering of a scene that has been loaded from files. Reads those again that are no text.
    pub fn new(loaded: &Loaded, view: &View, settings: &Settings) -> Result<Self, Failure> {
        let Settings { seed, part, is_extendable, .. } = *settings;
        let texts = &loaded.sources.files;
        let mut files: Vec<_> = texts.iter().map(|file| hashed(&file.path, hash(&file.text[..]))).collect();
        for path in loaded.inputs.iter().filter(|path| texts.iter().all(|file| file.path != **path)) {
            let read = || {
                let (mut hasher, mut file) = (Sha256::new(), BufReader::new(open_file(path)?));
                loop {
                    let bytes = file.fill_buf()?;
                    if bytes.is_empty() {
                        return io::Result::Ok(digits(hasher));
                    }
                    hasher.update(bytes);
                    let count = bytes.len();
                    file.consume(count);
                }
            };
            files.push(hashed(path, read().map_err(|error| Failure::io("read", path, &error))?));
        }
        Ok(Rendering {
            version: env!("CARGO_PKG_VERSION").into(),
            samples_per_pixel: view.sampler.samples_per_pixel,
            parts: part.map_or(1, |part| part.of),
            seed,
            is_extendable,
            files,
            // The number of samples stands by itself.
            view: hash(
                format!("{:?}", View { sampler: view.sampler.with_samples(1), ..view.clone() }).as_bytes(),
            ),
        })
    }

    /// Why something is not of the same rendering. `None` if it is.
    pub fn difference(&self, other: &Rendering) -> Option<String> {
        let named = |file: &HashedFile| format!("the file {} of the scene differs", file.name);
        let changed = self.files.iter().zip(&other.files).find(|(own, other)| own != other);
        if self.version != other.version {
            Some(format!("versions {} and {} of lookat may give other samples", self.version, other.version))
        } else if let Some((own, _)) = changed {
            Some(named(own))
        } else if self.files.len() != other.files.len() {
            Some("the scenes have other files".into())
        } else if self.seed != other.seed {
            Some(format!("the seeds {} and {} differ", self.seed, other.seed))
        } else if self.samples_per_pixel != other.samples_per_pixel {
            let [a, b] = [self, other].map(|of| of.samples_per_pixel);
            Some(format!("their pictures have {a} and {b} samples per pixel"))
        } else if self.is_extendable != other.is_extendable {
            Some("only one of them was rendered with --keep-sums".into())
        } else if self.view != other.view {
            Some("camera, film, filter or integrator differ".into())
        } else {
            None
        }
    }
}

fn hashed(path: &Path, hash: String) -> HashedFile {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    HashedFile { name, hash }
}

fn hash_of(channels: &[IntegerChannel]) -> String {
    let mut hasher = Sha256::new();
    let mut channels: Vec<_> = channels.iter().collect();
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    for IntegerChannel { name, samples } in channels {
        hasher.update(name);
        samples.iter().for_each(|word| hasher.update(word.to_le_bytes()));
    }
    digits(hasher)
}

fn hash(bytes: &[u8]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(bytes);
    digits(hasher)
}

fn digits(hasher: Sha256) -> String {
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
