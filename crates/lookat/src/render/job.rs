//! Renders one scene: loads it, prepares it, and writes its picture, or its pictures by a moving camera.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use lookat_render::{FilmSums, Part, Prepared, Progress, Statistics};
use lookat_scene::syntax::Diagnostic;
use lookat_scene::{FilmOverride, LoadOptions, Loaded, Scene, as_json};
use lookat_sight::Numbered;

use crate::args::{Render, crop_edges};
use crate::failure::Failure;
use crate::light::note_linear;
use crate::live::Live;
use crate::output::{PARTIAL, check_inputs, check_output, check_unfinished, marked};
use crate::part::{Provenance, Work};
use crate::readable::quoted_file;
use crate::render::checkpoint::{self, Checkpoint, Lock, Resumed, linked};
use crate::render::fireflies::{self, Fireflies};
use crate::render::frames::{cameras, focus};
use crate::render::progress::Shown;
use crate::render::settings::{
    charge_memory, check_settings, new_picture, note_sampler, reserve, settings, stop,
};
use crate::render::summary::{self, JsonPicture, JsonTarget, explain_black, narrow_filter, summarize};
use crate::render::written::{Kept, Output, SoFar};
use crate::scene_result::SceneResult;
use crate::source::{load_scene, load_watched, replace_samples};
use crate::{interrupt, part, report};

/// True once there are samples to write.
static HAS_SAMPLES: AtomicBool = AtomicBool::new(false);

/// One scene of the command.
pub struct Job {
    /// The arguments for this scene alone.
    pub arguments: Render,
    /// The files that the scenes of the command read, if there are several. No picture replaces them.
    pub inputs: Rc<BTreeSet<PathBuf>>,
    /// The checkpoint that it goes on from.
    pub resumed: Option<Resumed>,
}

/// How a scene is loaded.
pub fn load_options(arguments: &Render) -> LoadOptions {
    let crop = crop_edges(arguments.crop.as_deref()).unwrap_or_default();
    let mut view = arguments.first_view();
    if arguments.focus.is_some() {
        // Any distance: --focus replaces it when the scene is prepared.
        view.focal_distance = Some(1.0);
    }
    LoadOptions {
        film: FilmOverride { resolution: arguments.resolution, quarter: arguments.quick, crop },
        view: view.options(),
        keep_going: arguments.keep_going,
        max_memory: arguments.memory.limit(),
        ..LoadOptions::default()
    }
}

/// Renders one scene. Returns the exit status.
pub fn render_scene(Job { arguments, inputs, resumed }: &Job, live: &Live) -> u8 {
    let path = &arguments.scenes[0];
    let options = load_options(arguments);
    let mut loaded = match &live.watch {
        Some(watch) => {
            let note = |file: &Path| {
                watch.note(file);
                None
            };
            load_watched(path, &options, arguments.report, &note, None)
        }
        None => load_scene(path, &options, arguments.report),
    };
    if loaded.scene.is_some() {
        loaded.inputs.extend(inputs.iter().cloned());
    }
    let (mut extended, mut _lock) = (None, None);
    if let (Some(more), Some(_)) = (arguments.more, &loaded.scene) {
        let picture = picture_file(arguments, &loaded.output);
        // Before it is read, so that nobody else adds samples meanwhile.
        let lock = picture.exists().then(|| linked(&picture).and_then(|picture| Lock::new(&picture)));
        let locked = lock.transpose().map(|lock| _lock = lock);
        extended = match resumed {
            // A checkpoint of this command has what it needs of the picture.
            Some(_) => locked.err().map(Err),
            None => {
                let stop = stop(arguments).unwrap_or_default();
                Some(locked.and_then(|()| Resumed::extended(&picture, more, &stop)))
            }
        };
    }
    let earlier = resumed.as_ref().or(extended.as_ref().and_then(|extended| extended.as_ref().ok()));
    let total = earlier.filter(|_| arguments.more.is_some()).map(|it| it.provenance.samples_per_pixel);
    let arguments = &Render { spp: total.or(arguments.spp), ..arguments.clone() };
    // If --spp is a maximum, the scene keeps its own number.
    let is_maximum = arguments.target_error.is_some() || arguments.time.is_some();
    let samples = arguments.spp.filter(|_| !is_maximum).or(arguments.quick.then_some(1));
    replace_samples(&mut loaded, samples);
    let mut diagnostics = Vec::new();
    if arguments.report.json {
        diagnostics = as_json(&loaded.diagnostics, &loaded.sources);
    } else {
        report::print(&loaded, arguments.quiet);
    }
    let mut result = SceneResult { diagnostics, ..SceneResult::without_scene(path) };
    let mut advice = Vec::new();
    let status = match (&loaded.scene, &loaded.override_error) {
        (None, Some(message)) if !report::has_errors(&loaded) => fail(&message.clone().into(), &mut result),
        (None, _) => {
            // Resume repeats the options as they were.
            if loaded.can_keep_going && resumed.is_none() && !arguments.report.json && !arguments.quiet {
                say!("not rendered; to skip directives with errors, use --keep-going");
            }
            report::failure(&loaded)
        }
        (Some(scene), _) => {
            let mut done = Vec::new();
            let rendered = extended.transpose().and_then(|extended| {
                let resumed = resumed.as_ref().or(extended.as_ref());
                let rendering = Rendering { arguments, loaded: &loaded, live, resumed };
                rendering.pictures(scene, &mut done, &mut advice)
            });
            if arguments.frames.is_used() {
                result.frames = done;
            } else {
                result.picture = done.pop();
            }
            match rendered {
                Ok(true) => 0,
                Ok(false) => interrupt::STATUS,
                Err(failure) => fail(&failure, &mut result),
            }
        }
    };
    result.diagnostics.extend(as_json(&advice, &loaded.sources));
    finish(arguments, &result, status)
}

/// Prints the result as JSON, if requested. Returns the exit status.
pub fn finish(arguments: &Render, result: &SceneResult, status: u8) -> u8 {
    let lost = arguments.report.json && crate::print_json(result).is_err();
    if lost { crate::lost() } else { status }
}

/// Reports an error outside the scene.
pub fn fail(failure: &Failure, result: &mut SceneResult) -> u8 {
    say!("error: {failure}");
    result.error = Some(failure.to_string());
    failure.status()
}

/// A scene, and how and where it is rendered.
struct Rendering<'a> {
    arguments: &'a Render,
    loaded: &'a Loaded,
    live: &'a Live,
    resumed: Option<&'a Resumed>,
}

/// A written picture, and whether it is where it was asked for.
type Written = (JsonPicture, Result<(), Failure>);

impl Rendering<'_> {
    /// Renders the picture or the pictures of a scene, and prepares its world once. False after an interruption.
    fn pictures(
        &self,
        scene: &Scene,
        done: &mut Vec<JsonPicture>,
        advice: &mut Vec<Diagnostic>,
    ) -> Result<bool, Failure> {
        let Rendering { arguments, loaded, .. } = *self;
        if interrupt::flow().is_break() {
            return Ok(false);
        }
        arguments.first_view().check_use(scene)?;
        let file = picture_file(arguments, &loaded.output);
        if !arguments.quiet {
            note_sampler(arguments, scene, loaded);
            note_linear(&file, arguments.tone);
        }
        let mut cameras = cameras(arguments, scene, loaded)?;
        let mut files = if arguments.frames.is_used() { numbered(&file, cameras.len()) } else { vec![file] };
        if let Some(only) = arguments.frames.only {
            let at = only as usize - 1;
            (cameras, files) = (vec![cameras.swap_remove(at)], vec![files.swap_remove(at)]);
        }
        // Check before hours of rendering, not after.
        let crop = scene.view.film.crop;
        for file in &files {
            check_output(file, [crop.width(), crop.height()])?;
            check_inputs(file, &loaded.inputs)?;
            check_inputs(&marked(file, PARTIAL), &loaded.inputs)?;
        }
        check_settings(arguments, scene, &files[0])?;
        let size = [crop.width(), crop.height()];
        let is_resumed = self.resumed.is_some_and(|resumed| resumed.broken_off.is_some());
        checkpoint::check(arguments, &files[0], size, &loaded.inputs, is_resumed)?;
        let settings = settings(arguments, &files[0]);
        let mut provenance = None;
        if settings.keep_sums {
            let own = Provenance::new(loaded, &scene.view, &settings)?;
            if arguments.focus.is_none() {
                self.check_provenance(&own)?;
            }
            provenance = Some(own);
        }
        if !arguments.force {
            part::check_kept_sums(&files[0], &settings)?;
        }
        self.check_unfinished(scene, &files[0])?;
        drop(charge_memory(scene, &settings, &loaded.memory)?);
        let notice = match arguments.checkpoint {
            Some(_) => "stopping; interrupt again to quit at once",
            None => "stopping; interrupt again to quit without a picture",
        };
        interrupt::stop_in_order((!arguments.quiet).then_some(notice), || {
            HAS_SAMPLES.load(Ordering::Relaxed)
        });
        let mut scene = scene.clone();
        scene.view.camera = cameras[0].clone();
        let mut prepared = Prepared::new(&scene);
        for (number, (camera, file)) in cameras.into_iter().zip(files).enumerate() {
            if interrupt::flow().is_break() && number > 0 {
                return Ok(false);
            }
            scene.view.camera = camera;
            if let Some(place) = arguments.focus {
                crate::say(&focus(&prepared, &mut scene.view, place)?);
            }
            if number == 0 && !arguments.quiet {
                *advice = lookat_sight::advise(loaded, &scene, &mut prepared);
                if !arguments.report.json {
                    report::print_each(advice, &loaded.sources);
                }
            }
            self.check_unfinished(&scene, &file)?;
            // Without a picture, the files of the scene have changed meanwhile.
            prepared.look(&scene.view.camera);
            let provenance = provenance.clone().map(|own| own.with_view(&scene.view));
            let Some((picture, written)) = self.picture(&scene, &prepared, file, provenance)? else {
                continue;
            };
            let is_complete = picture.complete;
            done.push(picture);
            written?;
            if !is_complete {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Fails if the samples so far are of another rendering than this one.
    fn check_provenance(&self, own: &Provenance) -> Result<(), Failure> {
        let Some(Resumed { file, provenance, broken_off, .. }) = self.resumed else { return Ok(()) };
        match (own.difference(provenance), broken_off) {
            (None, _) => Ok(()),
            (Some(difference), Some(_)) => {
                bail!("{} cannot be resumed: {difference}; render the scene again without it", file.display())
            }
            (Some(difference), None) => bail!(
                "nothing can be added to {}: {difference}; repeat the options of its rendering",
                file.display()
            ),
        }
    }

    /// Fails if the file is a finished picture and stays.
    fn check_unfinished(&self, scene: &Scene, file: &Path) -> Result<(), Failure> {
        if self.arguments.force {
            return Ok(());
        }
        let new = new_picture(scene, &settings(self.arguments, file));
        check_unfinished(file, new, "replace it with --force, or choose another name with -o")
    }

    /// Renders and writes a picture. `None` if the files of the scene have changed meanwhile.
    fn picture(
        &self,
        scene: &Scene,
        prepared: &Prepared,
        file: PathBuf,
        provenance: Option<Provenance>,
    ) -> Result<Option<Written>, Failure> {
        let Rendering { arguments, loaded, live, .. } = *self;
        let (settings, crop) = (settings(arguments, &file), scene.view.film.crop);
        let is_told = !arguments.quiet && !arguments.report.json;
        let new = new_picture(scene, &settings);
        // Only now where the lens has been focused.
        provenance.as_ref().map_or(Ok(()), |own| self.check_provenance(own))?;
        let _charge = charge_memory(scene, &settings, &loaded.memory)?;
        let started = Instant::now();
        let shown = Shown::new(arguments, crop.area());
        live.begin(&file, [crop.width(), crop.height()]);
        let mut checkpoint = None;
        if let Some(provenance) = &provenance {
            let bytes = self.resumed.map_or(0, |resumed| resumed.bytes);
            reserve(bytes, &loaded.memory)?.keep();
            if let Some(Resumed { file, sums, .. }) = self.resumed.filter(|_| is_told) {
                let samples = sums.borrow().as_ref().map_or(0.0, FilmSums::mean_samples);
                say!("{}: {samples:.1} samples per pixel so far", file.display());
            }
            checkpoint = Checkpoint::new(arguments, &settings, provenance, self.resumed)?;
        }
        let camera = &scene.view.camera;
        let output =
            Output { arguments, loaded, camera, settings: &settings, new, file, provenance, checkpoint };
        let so_far = Mutex::new(SoFar::default());
        let progress = |progress: Progress| {
            if progress.done > 0 {
                HAS_SAMPLES.store(true, Ordering::Relaxed);
                if let Ok(mut so_far) = so_far.try_lock() {
                    so_far.write_if_asked(&output, &progress);
                }
                if let Some(checkpoint) = &output.checkpoint {
                    checkpoint.write_if_due(&progress, || output.whole(Numbered::default()));
                }
            }
            shown.update(&progress);
            live.update(&progress);
            live.flow()
        };
        let mut rendered = match self.resumed {
            None => prepared.render(&scene.view, &settings, &progress),
            Some(Resumed { file, sums, .. }) => {
                let sums = sums.take().ok_or("the samples so far are gone")?;
                let resumed = prepared.resume(&scene.view, &settings, sums, &progress);
                resumed.map_err(|error| format!("{} cannot be resumed: {error}", file.display()))?
            }
        };
        shown.clear();
        if !rendered.complete && interrupt::flow().is_continue() {
            return Ok(None);
        }
        live.finish(&rendered.image);
        let luminances = if rendered.complete && !arguments.quiet {
            fireflies::luminances(&rendered.image, &scene.view.film, rendered.statistics.least)
        } else {
            None
        };
        let earlier = self.resumed.map(Resumed::work).unwrap_or_default();
        let work = earlier.and(started.elapsed().as_secs_f64(), &rendered.statistics);
        let numbered = Numbered::new(&rendered.image, prepared, &loaded.sources);
        let Kept { file, destination, kept, light, samples_per_pixel } =
            output.write(&mut rendered, numbered.clone()).map_err(|failure| match &output.checkpoint {
                Some(checkpoint) if checkpoint.is_left() => {
                    let file = quoted_file(checkpoint.file());
                    format!("{failure}; to go on from the last checkpoint: lookat resume {file}").into()
                }
                _ => failure,
            })?;
        if rendered.complete {
            so_far.into_inner().unwrap_or_else(PoisonError::into_inner).remove();
            if let (Some(checkpoint), Ok(())) = (&output.checkpoint, destination.result()) {
                checkpoint.remove();
            }
        }
        let black = light.is_some_and(|light| light.is_black(summary::residue(scene)));
        let Statistics { least, most, target, .. } = rendered.statistics;
        let Work { seconds, rays, rejected, clamped } = work;
        let fireflies = luminances
            .and_then(|luminances| Fireflies::find(&luminances, scene, prepared, &settings, &loaded.sources));
        let picture = JsonPicture {
            file: file.display().to_string(),
            width: rendered.image.data_window.width,
            height: rendered.image.data_window.height,
            samples_per_pixel,
            least_samples: least,
            most_samples: most,
            seconds,
            rays,
            rejected_samples: rejected,
            clamped_samples: clamped,
            complete: rendered.complete,
            black,
            light,
            numbered,
            fireflies,
            target: settings
                .target_error()
                .zip(target)
                .map(|(target, reached)| JsonTarget::new(target, reached)),
        };
        if let Some(why) = kept.filter(|_| !arguments.report.json) {
            say!("{why}; the new picture is in {}", picture.file);
        }
        if arguments.quiet && !picture.complete {
            say!("interrupted; the picture so far is in {}", picture.file);
        }
        if is_told {
            summarize(&picture, &rendered);
            let is_shown = rendered.complete
                && least > 0
                && !black
                && narrow_filter(&rendered, &scene.view.filter).is_none();
            if let Some(light) = light {
                light.print(&file, is_shown);
            }
            for line in picture.fireflies.iter().flat_map(Fireflies::lines) {
                crate::say(&line);
            }
            if arguments.adaptive && rendered.complete && least == most {
                // Where the noise is known early, half of the samples are not taken before.
                let least = if settings.is_extendable { 32 } else { 8 };
                say!(
                    "--adaptive had no effect: it needs noise, at least {least} samples per pixel, and 512 pixels"
                );
            }
        }
        // A picture that shows nothing is never what was meant: --quiet does not hide it.
        if !arguments.report.json {
            explain_black(&picture, &rendered, scene, prepared, &loaded.sources);
        }
        if output.checkpoint.is_some() && !picture.complete {
            // Where the checkpoint is, also if that is another folder.
            say!("to go on: lookat resume {}", quoted_file(&file));
        }
        live.wait();
        Ok(Some((picture, destination.result())))
    }
}

/// The file of the picture.
pub fn picture_file(arguments: &Render, film_name: &Path) -> PathBuf {
    // A draft replaces no finished picture.
    let mut own = if arguments.quick { marked(film_name, "quick") } else { film_name.into() };
    if let Some(Part { index, of }) = arguments.part {
        own = marked(&own, &format!("part-{index}-of-{of}"));
    }
    arguments.output.clone().unwrap_or(own)
}

/// The files of several pictures.
pub fn numbered(file: &Path, count: usize) -> Vec<PathBuf> {
    let digits = count.to_string().len().max(4);
    (1..=count).map(|number| marked(file, &format!("{number:0digits$}"))).collect()
}
