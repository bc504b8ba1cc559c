//! Checkpoints: the samples so far, in a file that `lookat resume` goes on from and `lookat merge` reads.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lookat_image::{Format, Image, MemoryBudget, PictureFile, remove_leftovers};
use lookat_render::{FilmSums, Progress};

use crate::args::Render;
use crate::failure::Failure;
use crate::output::{check_inputs, check_output, marked};
use crate::part::{Invocation, Part, PartFile, PartMetadata, Rendering};
use crate::writer::lock;

/// The time between two checkpoints, unless it is given.
const EVERY: Duration = Duration::from_secs(60);

/// The checkpoint of a rendering that was broken off.
pub struct Resumed {
    /// Its file.
    pub file: PathBuf,
    pub invocation: Invocation,
    pub rendering: Rendering,
    pub sums: FilmSums,
}

impl Resumed {
    /// Reads a checkpoint, or the one before it where there is none or it is damaged.
    pub fn read(file: &Path) -> Result<Resumed, Failure> {
        let read = |at: &Path| {
            let opened = PartFile::open(at)?;
            let Some(invocation) = opened.metadata.invocation.clone() else {
                bail!("{} is no checkpoint: only `lookat render --checkpoint` writes them", at.display());
            };
            let sums = opened.read(&MemoryBudget::default())?;
            let rendering = opened.metadata.part.rendering;
            Ok(Resumed { file: file.into(), invocation, rendering, sums })
        };
        read(file).or_else(|error: Failure| {
            let previous = previous(file);
            let resumed = read(&previous).map_err(|_| error.clone())?;
            say!("{error}; going on from {}", previous.display());
            Ok(resumed)
        })
    }
}

/// The name of the checkpoint before the last.
fn previous(file: &Path) -> PathBuf {
    marked(file, "previous")
}

/// The checkpoint file of a rendering.
pub struct Checkpoint {
    pub file: PathBuf,
    every: Duration,
    invocation: Invocation,
    rendering: Rendering,
    /// The samples of each pixel that the rendering is to take.
    range: std::ops::Range<u32>,
    state: Mutex<State>,
}

struct State {
    /// When the last checkpoint was begun.
    last: Instant,
    writing: Option<JoinHandle<Result<(), Failure>>>,
}

impl Checkpoint {
    /// The one that the arguments ask for.
    pub fn new(
        arguments: &Render,
        rendering: &Rendering,
        resumed: Option<&Resumed>,
    ) -> Result<Option<Checkpoint>, Failure> {
        let Some(file) = &arguments.checkpoint else { return Ok(None) };
        let invocation = resumed.map(|resumed| resumed.invocation.clone());
        let invocation = invocation.or_else(Invocation::of_this_process).ok_or(
            "a checkpoint holds the command line, but this one has names that are not Unicode: rename these files",
        )?;
        let all = rendering.samples_per_pixel;
        let range = arguments.part.map_or(0..all, |part| part.range(all));
        let state = Mutex::new(State { last: Instant::now(), writing: None });
        let every = arguments.every.unwrap_or(EVERY);
        let rendering = rendering.clone();
        Ok(Some(Checkpoint { file: file.clone(), every, invocation, rendering, range, state }))
    }

    /// Writes a checkpoint in the background if it is time for one, and the one before is written.
    pub fn write_if_due(&self, progress: &Progress, whole: impl FnOnce() -> Option<String>) {
        let Ok(mut state) = self.state.try_lock() else { return };
        let is_free = state.writing.as_ref().is_none_or(JoinHandle::is_finished);
        if state.last.elapsed() < self.every || !is_free {
            return;
        }
        report(state.writing.take());
        state.last = Instant::now();
        let sums = progress.sums();
        let mut image = sums.image();
        self.complete(&mut image, &sums, whole().unwrap_or_default());
        let (file, previous) = (self.file.clone(), previous(&self.file));
        let write = move || Ok(image.write_checkpoint(&file, &previous)?);
        // Without a thread there is none this time.
        state.writing = std::thread::Builder::new().spawn(write).ok();
    }

    /// Adds the sums and the metadata of a checkpoint to a picture. `whole`: the metadata of the finished picture.
    pub fn complete(&self, image: &mut Image, sums: &FilmSums, whole: String) {
        let (header, integers) = sums.to_channels();
        let metadata = PartMetadata {
            samples_per_pixel: sums.mean_samples(),
            complete: false,
            part: Part::new(self.rendering.clone(), vec![self.range.clone()], &header),
            whole,
            invocation: Some(self.invocation.clone()),
        };
        image.metadata = metadata.to_text();
        image.integers = integers;
    }

    /// Writes the last checkpoint of a rendering that is broken off.
    pub fn write(&self, image: &Image) -> Result<(), Failure> {
        self.wait();
        Ok(image.write_checkpoint(&self.file, &previous(&self.file))?)
    }

    /// Removes the checkpoints of a rendering that is finished.
    pub fn remove(&self) {
        self.wait();
        for file in [&self.file, &previous(&self.file)] {
            let _ = std::fs::remove_file(file);
        }
        remove_leftovers(self.file.parent().filter(|it| *it != Path::new("")).unwrap_or(Path::new(".")));
    }

    fn wait(&self) {
        report(lock(&self.state).writing.take());
    }
}

/// Warns if a checkpoint could not be written: the one before is still there.
fn report(writing: Option<JoinHandle<Result<(), Failure>>>) {
    if let Some(Ok(Err(error))) = writing.map(JoinHandle::join) {
        say!("warning: no checkpoint this time: {error}");
    }
}

/// Fails if the checkpoint of the arguments cannot be written, or would replace what is still of use. `picture`: the file of the picture.
pub fn check<'i>(
    arguments: &Render,
    picture: &Path,
    size: [u32; 2],
    inputs: impl IntoIterator<Item = &'i PathBuf>,
    is_resumed: bool,
) -> Result<(), Failure> {
    let Some(file) = &arguments.checkpoint else { return Ok(()) };
    let name = file.display();
    if Format::from_path(file) != Some(Format::Exr) {
        bail!("{name}: only an .exr file can store a checkpoint; choose another name");
    }
    check_output(file, size)?;
    check_inputs(file, inputs)?;
    let path = |file: &Path| std::path::absolute(file).ok();
    if path(file) == path(picture) {
        bail!("{name} is the picture: choose another name for the checkpoint");
    }
    let found = [file.clone(), previous(file)].into_iter().find(|file| file.exists());
    if let Some(found) = found.filter(|_| !is_resumed && !arguments.force) {
        let found = found.display();
        let opened = PictureFile::open(file, &MemoryBudget::default()).ok();
        match opened.and_then(|it| it.metadata()).is_some_and(|text| text.contains("\"invocation\":")) {
            true => bail!(
                "{found} is a checkpoint: start again with --force, or go on with `lookat resume {name}`"
            ),
            false => bail!("{found} is no checkpoint: choose another name, or replace it with --force"),
        }
    }
    Ok(())
}
