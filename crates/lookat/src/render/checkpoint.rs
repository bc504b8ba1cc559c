//! Checkpoints: the samples so far, in a file that `lookat resume` goes on from and `lookat merge` reads.

use std::cell::RefCell;
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lookat_image::{Format, Image, ImageFault, MemoryBudget, io_reason, remove_leftovers, write_target};
use lookat_render::{FilmSums, Progress, Settings, Statistics, Stop};
use lookat_scene::MAX_SAMPLES;

use crate::args::Render;
use crate::failure::Failure;
use crate::output::{Destination, Identity, PARTIAL, check_inputs, check_output, marked, place};
use crate::part::{About, BrokenOff, Invocation, PartFile, Provenance, Work, stop_options, stops_differ};
use crate::readable::quoted_file;
use crate::writer::lock;

/// The time between two checkpoints, unless it is given.
const EVERY: Duration = Duration::from_secs(60);

/// What a rendering goes on from: a checkpoint, or a picture that samples are added to.
pub struct Resumed {
    /// Its file.
    pub file: PathBuf,
    /// What was broken off. `None` for a picture.
    pub broken_off: Option<BrokenOff>,
    pub provenance: Provenance,
    /// Bytes of its sums, about.
    pub bytes: u64,
    /// Its sums, until the rendering takes them.
    pub sums: RefCell<Option<FilmSums>>,
}

/// True if a checkpoint cannot be read however often one tries: there is none, or it is damaged.
fn is_lost(file: &Path, failure: &Failure) -> bool {
    let is_damaged = match failure {
        Failure::Damaged(_) => true,
        Failure::Picture(error) => {
            matches!(error.fault, ImageFault::Damaged(_) | ImageFault::WrongFormat(_))
        }
        _ => false,
    };
    is_damaged
        || match std::fs::metadata(file) {
            Ok(found) => found.is_file() && found.len() == 0,
            Err(error) => error.kind() == ErrorKind::NotFound,
        }
}

impl Resumed {
    /// Reads a checkpoint, or the one before it where there is none or it is damaged: that one then takes its name.
    pub fn read(file: &Path) -> Result<Resumed, Failure> {
        let read = |at: &Path| {
            let opened = PartFile::open(at)?;
            let Some(broken_off) = opened.metadata.broken_off.clone() else {
                bail!("{} is no checkpoint: only `lookat render --checkpoint` writes them", at.display());
            };
            let sums = RefCell::new(Some(opened.read(&MemoryBudget::default())?));
            let (provenance, bytes) = (opened.metadata.part.provenance, opened.sums.bytes());
            let (file, broken_off) = (file.into(), Some(broken_off));
            Ok(Resumed { bytes, file, broken_off, provenance, sums })
        };
        let previous = previous(file);
        let failure = match read(file) {
            Err(failure) if is_lost(file, &failure) => failure,
            other => return other,
        };
        let resumed = read(&previous).map_err(|other| match is_lost(&previous, &other) {
            true => Failure::NoCheckpoint(failure.to_string()),
            false => other,
        })?;
        say!("{failure}; going on from {}", previous.display());
        std::fs::rename(&previous, file).map_err(|error| Failure::io("rename", &previous, &error))?;
        Ok(resumed)
    }

    /// What the sittings before have taken.
    pub fn work(&self) -> Work {
        self.broken_off.as_ref().map(|it| it.work).unwrap_or_default()
    }

    /// Reads a picture that `more` samples per pixel are added to, by this rule.
    pub fn extended(file: &Path, more: u32, stop: &Stop) -> Result<Resumed, Failure> {
        let name = file.display();
        if !file.exists() {
            bail!(
                "there is no picture {name} to add samples to: render it with --keep-sums, and name it with -o"
            );
        }
        let opened = PartFile::open(file).map_err(|_| {
            format!("nothing can be added to {name}: only lookat render --keep-sums keeps what it needs")
        })?;
        if let Some(difference) = stops_differ(&stop_options(stop), &opened.metadata.part.provenance.stop) {
            bail!("nothing can be added to {name}: {difference}; repeat the options of its rendering");
        }
        let sums = RefCell::new(Some(opened.read(&MemoryBudget::default())?));
        let mut provenance = opened.metadata.part.provenance;
        if !provenance.is_extendable || !opened.metadata.complete {
            bail!("nothing can be added to {}: render it with --keep-sums", file.display());
        }
        let samples = provenance.samples_per_pixel.checked_add(more).filter(|all| *all <= MAX_SAMPLES);
        provenance.samples_per_pixel =
            samples.ok_or_else(|| format!("a picture has at most {MAX_SAMPLES} samples per pixel"))?;
        let bytes = opened.sums.bytes();
        Ok(Resumed { file: file.into(), broken_off: None, provenance, bytes, sums })
    }
}

/// The name of the checkpoint before the last.
fn previous(file: &Path) -> PathBuf {
    marked(file, "previous")
}

/// The file that a name stands for: links are followed. Fails if that has another format.
pub fn linked(file: &Path) -> Result<PathBuf, Failure> {
    if !file.is_symlink() {
        return Ok(file.into());
    }
    let (target, _) = write_target(file).map_err(|error| Failure::io("find", file, &error))?;
    if Format::from_path(&target) != Format::from_path(file) {
        let [file, target] = [file, &target].map(Path::display);
        bail!("{file} leads to {target}: give that the same ending");
    }
    Ok(target)
}

/// The checkpoint file of a rendering, which no other rendering uses at the same time.
pub struct Checkpoint {
    record: Arc<Record>,
    every: Duration,
    state: Mutex<State>,
    _lock: Lock,
}

/// What a checkpoint says beside its sums.
struct Record {
    file: PathBuf,
    invocation: Invocation,
    /// What the sittings before this one have taken, and when this one began.
    earlier: Work,
    started: Instant,
    provenance: Provenance,
    /// The samples of each pixel that the rendering is to take.
    range: Range<u32>,
    /// True if the picture has error layers.
    has_errors: bool,
}

struct State {
    /// True if there is one of this rendering.
    is_written: bool,
    /// When the last checkpoint was begun.
    last: Instant,
    writing: Option<JoinHandle<Result<(), Failure>>>,
}

impl Checkpoint {
    /// The one that the arguments ask for. Fails if another program writes it.
    pub fn new(
        arguments: &Render,
        settings: &Settings,
        provenance: &Provenance,
        resumed: Option<&Resumed>,
    ) -> Result<Option<Checkpoint>, Failure> {
        let Some(file) = &arguments.checkpoint else { return Ok(None) };
        let broken_off = resumed.and_then(|resumed| resumed.broken_off.clone());
        let invocation = broken_off.map(|it| it.invocation);
        let invocation = invocation.or_else(Invocation::of_this_process).ok_or(
            "a checkpoint holds the command line and the working folder, but one of them has a name that is not Unicode: rename it",
        )?;
        let all = provenance.samples_per_pixel;
        let range = settings.part.map_or(0..all, |part| part.range(all));
        let record = Record {
            file: file.clone(),
            invocation,
            earlier: resumed.map(Resumed::work).unwrap_or_default(),
            started: Instant::now(),
            provenance: provenance.clone(),
            range,
            has_errors: settings.stop.has_error_layers(),
        };
        let is_written = resumed.is_some_and(|resumed| resumed.broken_off.is_some());
        let state = Mutex::new(State { is_written, last: Instant::now(), writing: None });
        let every = arguments.every.unwrap_or(EVERY);
        Ok(Some(Checkpoint { record: Arc::new(record), every, state, _lock: Lock::new(file)? }))
    }

    /// Its file.
    pub fn file(&self) -> &Path {
        &self.record.file
    }

    /// Writes a checkpoint in the background if it is time for one, and the one before is written. `whole`: see [`About::whole`].
    pub fn write_if_due(&self, progress: &Progress, whole: impl FnOnce() -> String) {
        let Ok(mut state) = self.state.try_lock() else { return };
        let is_free = state.writing.as_ref().is_none_or(JoinHandle::is_finished);
        if state.last.elapsed() < self.every || !is_free {
            return;
        }
        state.is_written |= report(state.writing.take());
        state.last = Instant::now();
        let (record, sums, statistics, whole) =
            (self.record.clone(), progress.sums(), progress.statistics, whole());
        let write = move || {
            let mut image = sums.image(record.has_errors);
            record.put_into(&mut image, sums, &statistics, whole);
            Ok(image.write_checkpoint(&record.file, &previous(&record.file))?)
        };
        match std::thread::Builder::new().spawn(write) {
            Ok(writing) => state.writing = Some(writing),
            Err(error) => say!("warning: no checkpoint this time: {}", io_reason(&error)),
        }
    }

    /// Writes the last checkpoint of a rendering that is broken off, with its picture: into another folder if its own fails.
    pub fn write(
        &self,
        image: &mut Image,
        sums: FilmSums,
        statistics: &Statistics,
        whole: String,
    ) -> Result<(PathBuf, Destination), Failure> {
        self.wait();
        self.record.put_into(image, sums, statistics, whole);
        let file = self.file();
        let mut destination = Destination::new(file.parent().unwrap_or(Path::new("")));
        let name = file.file_name().unwrap_or_default();
        let file = destination.write(name, |path| image.write_checkpoint(path, &previous(path)))?;
        Ok((file, destination))
    }

    /// True if there is one of this rendering.
    pub fn is_left(&self) -> bool {
        self.wait();
        lock(&self.state).is_written
    }

    /// Removes the checkpoints of a rendering that is finished.
    pub fn remove(&self) {
        self.wait();
        let file = self.file();
        for file in [file, &previous(file)] {
            let _ = std::fs::remove_file(file);
        }
        remove_leftovers(file.parent().filter(|it| *it != Path::new("")).unwrap_or(Path::new(".")));
    }

    fn wait(&self) {
        let mut state = lock(&self.state);
        state.is_written |= report(state.writing.take());
    }
}

impl Record {
    /// Makes a checkpoint of the picture so far: gives it the sums and their metadata.
    fn put_into(&self, image: &mut Image, sums: FilmSums, statistics: &Statistics, whole: String) {
        let work = self.earlier.and(self.started.elapsed().as_secs_f64(), statistics);
        About {
            provenance: self.provenance.clone(),
            ranges: vec![self.range.clone()],
            complete: false,
            whole,
            broken_off: Some(BrokenOff { invocation: self.invocation.clone(), work }),
        }
        .put_into(image, sums);
    }
}

/// A file beside a checkpoint, or beside a picture that grows, that is locked while the rendering runs: empty. What a program that was
/// killed leaves is taken over.
pub struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    pub fn new(file: &Path) -> Result<Lock, Failure> {
        let path = Lock::path(file)?;
        let options = File::options().write(true).create(true).truncate(false).clone();
        // Some file systems may never give a file the same number twice.
        let mut tries = 0..100;
        loop {
            let opened = options.open(&path).map_err(|error| Failure::io("write", &path, &error))?;
            if let Err(TryLockError::WouldBlock) = opened.try_lock() {
                bail!("another rendering writes {}", file.display());
            }
            // Another rendering may have ended in between, and removed it.
            if Identity::of(&path) == Identity::of_open(&opened, &path) || tries.next().is_none() {
                return Ok(Lock { path, _file: opened });
            }
        }
    }

    /// Its name. Fails if that is a file of somebody else.
    fn path(file: &Path) -> Result<PathBuf, Failure> {
        let path = marked(file, "lock");
        if std::fs::metadata(&path).is_ok_and(|found| found.len() > 0) {
            let [path, file] = [&path, file].map(Path::display);
            bail!(
                "{path} is in the way: lookat locks it while it writes {file}; choose another name, or move it"
            );
        }
        Ok(path)
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// True if a checkpoint has been written. Warns if it could not: the one before is still there.
fn report(writing: Option<JoinHandle<Result<(), Failure>>>) -> bool {
    let Some(written) = writing.map(JoinHandle::join) else { return false };
    match &written {
        Ok(Err(error)) => say!("warning: no checkpoint this time: {error}"),
        Err(_) => say!("warning: no checkpoint this time: lookat has failed; please report it"),
        Ok(Ok(())) => {}
    }
    matches!(written, Ok(Ok(())))
}

/// Fails if the checkpoint of the arguments cannot be written, or would replace what is still of use. `picture`: the file of the picture.
pub fn check<'i>(
    arguments: &Render,
    picture: &Path,
    size: [u32; 2],
    inputs: impl IntoIterator<Item = &'i PathBuf> + Clone,
    is_resumed: bool,
) -> Result<(), Failure> {
    let Some(file) = &arguments.checkpoint else { return Ok(()) };
    if Format::from_path(file) != Some(Format::Exr) {
        let name = file.display();
        bail!("{name}: only an .exr file can store a checkpoint; choose another name");
    }
    check_output(file, size)?;
    Lock::path(file)?;
    let own = [file.clone(), previous(file)];
    let partial = marked(picture, PARTIAL);
    for own in &own {
        check_inputs(own, inputs.clone())?;
        if [picture, &partial].iter().any(|picture| place(picture) == place(own)) {
            let own = own.display();
            bail!("{own} would be a picture and a checkpoint: choose another name for the checkpoint");
        }
    }
    let Some(found) = own.iter().find(|file| file.exists()).filter(|_| !is_resumed && !arguments.force)
    else {
        return Ok(());
    };
    let is_checkpoint = PartFile::open(found).is_ok_and(|part| part.metadata.broken_off.is_some());
    let found = found.display();
    if is_checkpoint {
        let word = quoted_file(file);
        bail!("{found} is a checkpoint: start again with --force, or go on with `lookat resume {word}`");
    }
    bail!("{found} is no checkpoint: choose another name, or replace it with --force");
}
