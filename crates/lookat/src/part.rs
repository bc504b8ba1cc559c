//! Files of parts and checkpoints: what they say beside their sums, of which rendering they are, and which samples they have.

use std::fmt::Debug;
use std::io::{self, BufRead, BufReader};
use std::ops::Range;
use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use lookat_image::{Image, IntegerChannel, MemoryBudget, PictureFile, open_file, read_integers};
use lookat_render::{FilmSums, Settings, Statistics, Stop, SumsHeader, TargetError};
use lookat_scene::{Loaded, MAX_SAMPLES, View};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};

use crate::args::{MOST_PARTS, way_out};
use crate::failure::Failure;
use crate::render::settings::most_samples;

/// The metadata of a part.
#[derive(Serialize, Deserialize)]
pub struct PartMetadata {
    /// The mean number of its samples.
    pub samples_per_pixel: f64,
    /// False if samples of its ranges are missing.
    pub complete: bool,
    pub part: PartRecord,
    /// The metadata of the whole picture, as it is written.
    pub whole: String,
    /// What was broken off, in a checkpoint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub broken_off: Option<BrokenOff>,
}

/// A rendering that was broken off.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BrokenOff {
    /// The command.
    pub invocation: Invocation,
    pub work: Work,
}

/// What a rendering has taken so far, in all its sittings.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Work {
    pub seconds: f64,
    pub rays: u64,
    pub rejected: u64,
    pub clamped: u64,
}

impl Work {
    /// With what another sitting has taken.
    pub fn and(self, seconds: f64, statistics: &Statistics) -> Work {
        let Statistics { rays, rejected, clamped, .. } = *statistics;
        Work {
            seconds: self.seconds + seconds,
            rays: self.rays + rays,
            rejected: self.rejected + rejected,
            clamped: self.clamped + clamped,
        }
    }
}

/// Some of the samples of a rendering.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PartRecord {
    pub provenance: Provenance,
    /// The indices of its samples, in order, with gaps between them. With `--target-error`, up to the most samples.
    pub ranges: Vec<Range<u32>>,
    /// The header of its sums, in base 64: JSON holds no infinite numbers.
    sums: String,
    /// The CRC-32 of the channels of its sums, which finds damage.
    checksum: u32,
}

/// What a part is to say of its sums.
pub struct About {
    pub provenance: Provenance,
    /// See [`PartRecord::ranges`].
    pub ranges: Vec<Range<u32>>,
    /// See [`PartMetadata::complete`].
    pub complete: bool,
    /// See [`PartMetadata::whole`].
    pub whole: String,
    /// See [`PartMetadata::broken_off`].
    pub broken_off: Option<BrokenOff>,
}

impl About {
    /// Makes a part of a picture: gives it the sums and their metadata.
    pub fn put_into(self, image: &mut Image, sums: FilmSums) {
        let About { provenance, ranges, complete, whole, broken_off } = self;
        let samples_per_pixel = sums.mean_samples();
        let (header, channels) = sums.into_channels();
        let (sums, checksum) = (BASE64_STANDARD.encode(header.to_bytes()), checksum(&channels));
        let part = PartRecord { provenance, ranges, sums, checksum };
        let metadata = PartMetadata { samples_per_pixel, complete, part, whole, broken_off };
        image.metadata = serde_json::to_string(&metadata).ok();
        image.integers = channels;
    }
}

impl PartMetadata {
    /// The metadata of its picture without the sums. `None` if nothing is kept of it.
    pub fn of_picture(&self) -> Option<String> {
        let mut picture: Map<String, Value> = serde_json::from_str(&self.whole).ok()?;
        let is_whole = self.part.is_sound() && self.part.samples() == self.part.provenance.samples_per_pixel;
        picture.insert("samples_per_pixel".into(), self.samples_per_pixel.into());
        picture.insert("complete".into(), (self.complete && is_whole).into());
        serde_json::to_string(&picture).ok()
    }
}

impl PartRecord {
    /// The number of its samples, once it is complete.
    fn samples(&self) -> u32 {
        self.ranges.iter().map(|range| range.len() as u32).sum()
    }

    /// True if its ranges are in order and within the rendering.
    fn is_sound(&self) -> bool {
        let PartRecord { provenance, ranges, .. } = self;
        let mut end = 0;
        let is_next = |range: &Range<u32>| {
            let is_next = range.start >= end && range.start < range.end;
            end = range.end;
            is_next
        };
        !ranges.is_empty()
            && ranges.iter().all(is_next)
            && end <= provenance.samples_per_pixel
            && provenance.samples_per_pixel <= MAX_SAMPLES
            && (1..=provenance.samples_per_pixel.min(MOST_PARTS)).contains(&provenance.parts)
    }

    /// True if the sums can have these samples. Where noise decides about them, nothing is known of their numbers.
    fn has_samples(&self, sums: &SumsHeader, complete: bool) -> bool {
        match complete {
            _ if self.provenance.is_uneven() => true,
            true => sums.samples() == Some(self.samples()),
            false => sums.most_samples() <= self.samples(),
        }
    }
}

/// A command line of `lookat render`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Invocation {
    /// The working folder.
    pub folder: String,
    /// The words behind the name of the program.
    pub words: Vec<String>,
    /// The file of the picture, if it is not the one of these words: `lookat resume -o` has named it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<String>,
}

impl Invocation {
    /// The one of this process. `None` if its words or the name of its working folder are not Unicode.
    pub fn of_this_process() -> Option<Invocation> {
        let words = std::env::args_os().skip(1).map(|word| word.into_string().ok());
        let folder = std::env::current_dir().ok()?.into_os_string().into_string().ok()?;
        Some(Invocation { folder, words: words.collect::<Option<_>>()?, output: None })
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
            let is_sound = part.is_sound() && part.has_samples(&sums, metadata.complete);
            is_sound.then_some(PartFile { path, metadata, sums })
        };
        read().ok_or_else(|| Failure::Damaged(format!("{name} is damaged, or of another version of lookat")))
    }

    /// Reads its sums, and charges them for good.
    pub fn read(&self, memory: &MemoryBudget) -> Result<FilmSums, Failure> {
        let name = self.path.display();
        let (channels, _charge) = read_integers(self.path, memory)?;
        if checksum(&channels) != self.metadata.part.checksum {
            return Err(Failure::Damaged(format!("{name} is damaged: its sums have changed")));
        }
        memory
            .reserve(self.sums.bytes())
            .map_err(|shortage| format!("{name}: {}", way_out(shortage)))?
            .keep();
        let sums = FilmSums::from_channels(self.sums.clone(), &channels);
        sums.map_err(|error| Failure::Damaged(format!("{name}: {error}")))
    }
}

/// Fails if a new picture would replace a file with the sums of other samples: another part, or a picture that can grow.
pub fn check_kept_sums(file: &Path, settings: &Settings) -> Result<(), Failure> {
    let Ok(PartFile { metadata: PartMetadata { part, .. }, .. }) = PartFile::open(file) else {
        return Ok(());
    };
    let samples = part.provenance.samples_per_pixel;
    let is_same = match settings.part {
        Some(new) => part.ranges == [new.range(samples)],
        None => settings.is_extendable,
    };
    if !is_same {
        bail!(
            "{} is not replaced: it has the sums of other samples; choose another name with -o, or replace it with --force",
            file.display()
        );
    }
    Ok(())
}

/// What all parts of a rendering have in common.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// The version of lookat.
    pub version: String,
    /// The samples of each pixel in all parts together; their mean with `--adaptive`, the most with `--target-error`.
    pub samples_per_pixel: u32,
    /// The number of parts of the rendering.
    pub parts: u32,
    pub seed: u64,
    /// The option that decides about the samples of pixels. Empty if each has the same.
    pub stop: String,
    /// True if samples may be added later: see [`Settings::is_extendable`](lookat_render::Settings::is_extendable).
    pub is_extendable: bool,
    /// The files of the scene, the scene file first.
    pub files: Vec<HashedFile>,
    /// The hashes of camera, film, filter, sampler and integrator, which options may have changed.
    pub view: [String; 5],
}

/// The names of the parts of a view, as in [`Provenance::view`].
const OF_VIEW: [&str; 5] = ["cameras", "films", "filters", "samplers", "integrators"];

/// A file of a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HashedFile {
    /// Its name, without folders.
    pub name: String,
    /// SHA-256, in hexadecimal digits.
    pub hash: String,
}

impl Provenance {
    /// The rendering of a scene that has been loaded from files. Reads those again that are no text.
    pub fn new(loaded: &Loaded, view: &View, settings: &Settings) -> Result<Self, Failure> {
        let Settings { seed, part, stop, is_extendable, .. } = *settings;
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
        let provenance = Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            samples_per_pixel: most_samples(settings, view),
            parts: part.map_or(1, |part| part.of),
            seed,
            stop: stop_options(&stop),
            is_extendable,
            files,
            view: Default::default(),
        };
        Ok(provenance.with_view(view))
    }

    /// The rendering of another view of the scene.
    pub fn with_view(self, view: &View) -> Provenance {
        let View { camera, film, filter, sampler, integrator } = view;
        // The number of samples stands by itself.
        let of_view: [&dyn Debug; 5] = [camera, film, filter, &sampler.with_samples(1), integrator];
        Provenance { view: of_view.map(|part| hash(format!("{part:?}").as_bytes())), ..self }
    }

    /// True if pixels have different numbers of samples.
    fn is_uneven(&self) -> bool {
        !["", "--error-layers"].contains(&&*self.stop)
    }

    /// Why something is not of the same rendering. `None` if it is.
    pub fn difference(&self, other: &Provenance) -> Option<String> {
        let changed = self.files.iter().zip(&other.files).find(|(own, other)| own != other);
        if self.version != other.version {
            Some(format!("versions {} and {} of lookat may give other samples", self.version, other.version))
        } else if let Some((own, other)) = changed {
            let name = &own.name;
            Some(match *name == other.name {
                true => format!("the file {name} of the scene differs"),
                false => format!("their scenes have the files {name} and {}", other.name),
            })
        } else if self.files.len() != other.files.len() {
            Some("the scenes have other files".into())
        } else if self.seed != other.seed {
            Some(format!("the seeds {} and {} differ", self.seed, other.seed))
        } else if let Some(difference) = stops_differ(&self.stop, &other.stop) {
            Some(difference)
        } else if self.samples_per_pixel != other.samples_per_pixel {
            let [a, b] = [self, other].map(|of| of.samples_per_pixel);
            Some(format!("their pictures have {a} and {b} samples per pixel"))
        } else if self.is_extendable != other.is_extendable {
            Some("only one of them was rendered with --keep-sums".into())
        } else {
            let mut views = OF_VIEW.iter().zip(self.view.iter().zip(&other.view));
            views.find(|(_, (own, other))| own != other).map(|(name, _)| format!("the {name} differ"))
        }
    }
}

/// As [`Provenance::stop`].
pub fn stop_options(stop: &Stop) -> String {
    match *stop {
        Stop::Samples { error_layers: true } => "--error-layers".into(),
        Stop::Samples { error_layers: false } | Stop::Time { .. } => String::new(),
        Stop::Adaptive => "--adaptive".into(),
        Stop::TargetError { target: TargetError { relative, confidence }, .. } => {
            format!("--target-error {relative} --confidence {confidence}")
        }
    }
}

/// How two of them differ. `None` if they do not.
pub fn stops_differ(own: &str, other: &str) -> Option<String> {
    let with = |stop: &str| match stop {
        "" => "without --error-layers, --adaptive and --target-error".into(),
        stop => format!("with {stop}"),
    };
    (own != other).then(|| format!("one is rendered {}, and one {}", with(own), with(other)))
}

fn hashed(path: &Path, hash: String) -> HashedFile {
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    HashedFile { name, hash }
}

/// As [`PartRecord::checksum`].
fn checksum(channels: &[IntegerChannel]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    let mut channels: Vec<_> = channels.iter().collect();
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    for IntegerChannel { name, samples } in channels {
        hasher.update(name.as_bytes());
        // Some at a time: much faster than one by one.
        let mut bytes = [0; 4096];
        for words in samples.chunks(bytes.len() / 4) {
            let bytes = &mut bytes[..4 * words.len()];
            let own = bytes.as_chunks_mut().0.iter_mut();
            own.zip(words).for_each(|(bytes, word)| *bytes = word.to_le_bytes());
            hasher.update(bytes);
        }
    }
    hasher.finalize()
}

fn hash(bytes: &[u8]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(bytes);
    digits(hasher)
}

fn digits(hasher: Sha256) -> String {
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
