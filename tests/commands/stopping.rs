//! Samples until pixels are exact, or until the time is up.

use super::*;

/// Pixels are sampled until they are exact: those of the sky stop at once, those of edges and shadows do not.
#[test]
fn a_target_error_is_reached_pixel_by_pixel() {
    let folder = Folder::new();
    let run = folder.run(&["render", "fine.pbrt", "-o", "a.exr", "--target-error", "0.02", "--json"]);
    assert_eq!((run.status, run.err.as_str()), (0, ""));
    let picture = &json_lines(&run)[0]["picture"];
    let target = &picture["target"];
    let count = |name: &str| target[name].as_u64().unwrap();
    assert_eq!(count("within") + count("at_cap") + count("out_of_time"), 32 * 24);
    assert_eq!((target["error"].as_f64(), target["confidence"].as_f64()), (Some(0.02), Some(0.95)));
    assert_eq!(picture["least_samples"], 64);

    // The picture says it, and what it says holds: against one of many samples.
    let image = Image::read(&folder.path("a.exr")).unwrap();
    let metadata: Value = serde_json::from_str(image.metadata.as_deref().unwrap()).unwrap();
    assert_eq!(metadata["target_error"].as_f64(), Some(0.02));
    let errors = image.errors().unwrap();
    let samples: Vec<u32> = errors.iter().map(|error| error.samples).collect();
    assert_eq!(samples.iter().max().map(|most| u64::from(*most)), picture["most_samples"].as_u64());
    assert!(samples.iter().all(|count| count.is_power_of_two()) && samples.iter().any(|count| *count > 64));
    let truth = folder.picture(&["--spp", "4096", "--seed", "9"]).rgb().unwrap();
    let luminance = |rgb: &[f32; 3]| 0.2127 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    let found = image.rgb().unwrap();
    let off = found.iter().zip(&truth).filter(|(found, truth)| {
        let allowed = 0.02 * luminance(truth);
        found.iter().zip(*truth).any(|(a, b)| (a - b).abs() > allowed)
    });
    // One in twenty, and three deviations of that.
    assert!(off.count() <= 57);

    // More sure, more samples.
    let mean = |confidence: &str| {
        let run = folder.run(&[
            "render",
            "fine.pbrt",
            "-o",
            "b.exr",
            "--target-error",
            "0.02",
            "--confidence",
            confidence,
            "--json",
        ]);
        json_lines(&run)[0]["picture"]["samples_per_pixel"].as_f64().unwrap()
    };
    assert!(mean("0.6") < mean("0.999"));
}

#[test]
fn a_target_error_gives_the_same_picture_on_any_number_of_threads() {
    let folder = Folder::new();
    // Negative lobes, and an edge of tiles in the picture.
    folder.write("fine.pbrt", &FINE.replace("Integrator", "PixelFilter \"mitchell\" Integrator"));
    let bytes = |threads: &str| {
        folder.picture(&["--target-error", "0.05", "--spp", "1000", "--threads", threads]);
        std::fs::read(folder.path("picture.exr")).unwrap()
    };
    let one = bytes("1");
    assert!(bytes("2") == one && bytes("5") == one);
}

#[test]
fn pixels_at_the_cap_are_told_of() {
    let folder = Folder::new();
    let run = folder.run(&["render", "fine.pbrt", "--target-error", "0.001", "--spp", "100"]);
    assert_eq!(run.status, 0, "{}", run.err);
    // Replicates are of one size: 6 samples in each of 16.
    assert!(run.err.contains("above the target error after 96 samples"), "{}", run.err);
    assert!(
        run.err.contains(
            "within 0.1 % of the true brightness, per pixel at 95 % confidence, except light no sample hit"
        ),
        "{}",
        run.err
    );
    assert!(run.err.contains("64 to 96 samples each"), "{}", run.err);

    folder.write("random.pbrt", &FINE.replace("\"sobol\"", "\"random\""));
    let run = folder.run(&["render", "random.pbrt", "--target-error", "0.5"]);
    assert!(
        run.err.starts_with("random.pbrt: --target-error uses Sampler \"sobol\" instead of \"random\"\n"),
        "{}",
        run.err
    );
}

/// Noisy pixels take the samples that others do not need, by the same numbers on any number of threads.
#[test]
fn adaptive_samples_are_as_many_on_average() {
    let folder = Folder::new();
    let json = |arguments: &[&str]| {
        let run = folder.run(
            &[&["render", "fine.pbrt", "-o", "a.exr", "--force", "--json", "--adaptive"], arguments].concat(),
        );
        assert_eq!((run.status, run.err.as_str()), (0, ""));
        json_lines(&run)[0]["picture"].clone()
    };
    let picture = json(&["--spp", "24"]);
    let is_about = |picture: &Value, mean: f64| {
        let found = picture["samples_per_pixel"].as_f64().unwrap();
        assert!((found / mean - 1.0).abs() < 0.03, "{found} {mean}");
    };
    is_about(&picture, 24.0);
    assert!(picture["least_samples"].as_u64() == Some(12) && picture["most_samples"].as_u64() > Some(32));
    let image = Image::read(&folder.path("a.exr")).unwrap();
    let metadata: Value = serde_json::from_str(image.metadata.as_deref().unwrap()).unwrap();
    assert_eq!(metadata["adaptive"], true);
    // The Sampler's number; with a time the most on average.
    assert_eq!(json(&[])["samples_per_pixel"].as_f64(), Some(4.0));
    is_about(&json(&["--time", "3600", "--spp", "33"]), 33.0);

    folder.write("fine.pbrt", &FINE.replace("Integrator", "PixelFilter \"mitchell\" Integrator"));
    let bytes = |threads: &str| {
        folder.picture(&["--adaptive", "--spp", "20", "--threads", threads]);
        std::fs::read(folder.path("picture.exr")).unwrap()
    };
    let one = bytes("1");
    assert!(bytes("2") == one && bytes("5") == one);

    folder.write("cells.pbrt", &FINE.replace("\"sobol\" \"integer pixelsamples\" 4", "\"stratified\""));
    let run = folder.run(&["render", "cells.pbrt", "--adaptive", "--force", "-o", "a.exr"]);
    assert!(
        run.err.starts_with("cells.pbrt: --adaptive uses Sampler \"sobol\" instead of \"stratified\"\n"),
        "{}",
        run.err
    );
}

#[test]
fn adaptive_samples_that_are_all_alike_are_said_to_be() {
    let folder = Folder::new();
    let said = |arguments: &[&str]| {
        let run = folder
            .run(&[&["render", "fine.pbrt", "--adaptive", "--force", "-o", "a.exr"], arguments].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        run.err.contains("--adaptive had no effect")
    };
    assert!(said(&["--spp", "4"]));
    assert!(said(&["--spp", "64", "--resolution", "8x8"]));
    assert!(!said(&["--spp", "64"]));
}

/// A time ends the rendering, with a whole picture where it is long enough for one; how long it takes is not tested.
#[test]
fn a_time_ends_with_a_whole_picture() {
    let folder = Folder::new();
    let json = |arguments: &[&str]| {
        let run = folder.run(&[&["render", "fine.pbrt", "-o", "a.exr", "--json"], arguments].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        json_lines(&run)[0]["picture"].clone()
    };
    // What comes first ends it: the samples, the target, the time.
    let picture = json(&["--time", "3600", "--spp", "32"]);
    assert_eq!((picture["most_samples"].as_u64(), picture["complete"].as_bool()), (Some(32), Some(true)));
    assert_eq!(
        Image::read(&folder.path("a.exr")).unwrap().channels,
        folder.picture(&["--spp", "32"]).channels
    );
    let target = &json(&["--time", "3600", "--target-error", "0.2"])["target"];
    assert_eq!(target["out_of_time"], 0);
    let picture = json(&["--time", "0.001", "--target-error", "0.000001"]);
    assert_eq!(picture["complete"], true);
    assert!(picture["target"]["out_of_time"].as_u64() > Some(0));
    let picture = json(&["--time", "0.5"]);
    assert_eq!(picture["complete"], true);
    // More than the scene asks for.
    assert!(picture["most_samples"].as_u64() > Some(4));
}

/// Where standard error is no terminal, a line after a second tells how long it takes, as an interval.
#[test]
fn the_time_left_is_told_after_a_second() {
    let folder = Folder::new();
    let lines = |arguments: &[&str]| {
        let run = folder.run(&[&["render", "fine.pbrt", "-o", "a.exr", "--time", "2.5"], arguments].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        run.err.lines().filter(|line| line.ends_with(" left")).map(String::from).collect::<Vec<_>>()
    };
    let told = lines(&[]);
    assert!(!told.is_empty() && told[0].contains(" % done, "), "{told:?}");
    let told = lines(&["--target-error", "0.000001"]);
    assert!(!told.is_empty() && told[0].contains(" % of pixels done, "), "{told:?}");
    assert!(lines(&["--quiet"]).is_empty() && lines(&["--json"]).is_empty());
}

/// Ctrl-C, or another signal that ends programs, leaves the samples so far in a picture of another name.
#[cfg(unix)]
#[test]
fn a_rendering_that_is_broken_off_leaves_a_partial_picture() {
    let folder = Folder::new();
    // `timeout` sends twice at once. A closed terminal sends SIGHUP, and a limit of time SIGXCPU.
    for (signal, times) in
        [("-INT", 1), ("-TERM", 1), ("-TERM", 2), ("-HUP", 1), ("-HUP", 2), ("-QUIT", 1), ("-XCPU", 1)]
    {
        let stopped = |after: f32| {
            let mut command = folder.command(&["render", "fine.pbrt", "-o", "a.exr", "--spp", "100000000"]);
            let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(std::time::Duration::from_secs_f32(after));
            let to = vec![child.id().to_string(); times];
            let kill = Command::new("kill").arg(signal).args(to).status().unwrap();
            assert!(kill.success());
            let output = child.wait_with_output().unwrap();
            (output.status.code(), String::from_utf8(output.stderr).unwrap())
        };
        // How soon it listens, and has its first samples, depends on the machine.
        let is_left = || folder.path("a.partial.exr").exists();
        let (status, said) = [0.25, 1.0, 4.0, 16.0].into_iter().map(stopped).find(|_| is_left()).unwrap();
        assert!(status == Some(130) && said.contains("interrupted, partial picture"), "{said}");
        let picture = Image::read(&folder.path("a.partial.exr")).unwrap();
        assert_eq!((picture.data_window.width, picture.data_window.height), (32, 24));
        assert!(!folder.path("a.exr").exists());
        std::fs::remove_file(folder.path("a.partial.exr")).unwrap();
    }
}

/// A rendering that takes hours.
#[cfg(unix)]
struct Endless<'f> {
    folder: &'f Folder,
    child: std::process::Child,
}

#[cfg(unix)]
impl Endless<'_> {
    /// Starts it in a shell, after other commands.
    fn start<'f>(folder: &'f Folder, before: &str, options: &str) -> Endless<'f> {
        let mut command = Command::new("bash");
        let program = env!("CARGO_BIN_EXE_lookat");
        let text = format!("{before} exec {program} render fine.pbrt -o a.exr --spp 100000000 {options}");
        let child = command.args(["-c", &text]).current_dir(folder.0.path()).stderr(Stdio::piped());
        Endless { folder, child: child.spawn().unwrap() }
    }

    fn send(&self, signal: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
    }

    /// The samples per pixel of the partial picture. Waits until they are more than before.
    #[track_caller]
    fn samples(&self, before: f64) -> f64 {
        let started = std::time::Instant::now();
        loop {
            // The picture is whole whenever it is there.
            if self.folder.path("a.partial.exr").exists() {
                let image = Image::read(&self.folder.path("a.partial.exr")).unwrap();
                let metadata: Value = serde_json::from_str(image.metadata.as_deref().unwrap()).unwrap();
                assert_eq!(metadata["complete"], false);
                let found = metadata["samples_per_pixel"].as_f64().unwrap();
                if found > before {
                    return found;
                }
            }
            assert!(started.elapsed().as_secs() < 100);
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
    }

    fn end(mut self) -> (Option<i32>, String) {
        assert_eq!(self.child.try_wait().unwrap(), None);
        self.send("-TERM");
        let status = unread::ended(&mut self.child);
        let mut said = String::new();
        std::io::Read::read_to_string(&mut self.child.stderr.take().unwrap(), &mut said).unwrap();
        (status.code(), said)
    }
}

#[cfg(unix)]
impl Drop for Endless<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// SIGUSR1 writes the picture so far, as often as it comes, and rendering goes on.
#[cfg(unix)]
#[test]
fn a_signal_asks_for_the_picture_so_far() {
    for options in ["", "--target-error 0.000001"] {
        let folder = Folder::new();
        let endless = Endless::start(&folder, "", options);
        // Until it listens, the signal would end it.
        std::thread::sleep(std::time::Duration::from_secs(2));
        endless.send("-USR1");
        let first = endless.samples(-1.0);
        // There may be no more samples at once.
        std::thread::sleep(std::time::Duration::from_secs(1));
        endless.send("-USR1");
        endless.samples(if options.is_empty() { first } else { first - 1e-9 });
        let (status, said) = endless.end();
        assert!(status == Some(130) && said.contains("a.partial.exr: the picture so far"), "{said}");
        assert!(!folder.path("a.exr").exists());
    }
}

/// A replicate of the error layers takes hours here.
#[cfg(unix)]
#[test]
fn without_samples_there_is_no_picture_so_far() {
    let folder = Folder::new();
    let endless = Endless::start(&folder, "", "--error-layers");
    std::thread::sleep(std::time::Duration::from_secs(2));
    for _ in 0..5 {
        endless.send("-USR1");
        std::thread::sleep(std::time::Duration::from_millis(300));
        assert!(!folder.path("a.partial.exr").exists());
    }
    let (_, said) = endless.end();
    assert_eq!(said.matches("the picture so far follows once each pixel has samples").count(), 1, "{said}");
}

/// Before each pixel has a sample, the picture so far waits. It is gone once the picture is there.
#[cfg(unix)]
#[test]
fn the_picture_so_far_is_whole_and_goes_when_all_is_done() {
    let folder = Folder::new();
    // The first samples take seconds.
    let slow = "Integrator \"ambientocclusion\" \"integer nsamples\" 65536";
    folder.write("slow.pbrt", &FINE.replace("Integrator \"path\"", slow));
    let mut command = folder.command(&["render", "slow.pbrt", "-o", "a.exr", "--spp", "2"]);
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let is_there = || folder.path("a.partial.exr").exists();
    std::thread::sleep(std::time::Duration::from_secs(1));
    let mut least = None;
    while child.try_wait().unwrap().is_none() {
        let _ = Command::new("kill").args(["-USR1", &child.id().to_string()]).status();
        std::thread::sleep(std::time::Duration::from_millis(50));
        if least.is_none() && is_there() {
            let image = Image::read(&folder.path("a.partial.exr")).unwrap();
            let metadata: Value = serde_json::from_str(image.metadata.as_deref().unwrap()).unwrap();
            least = metadata["samples_per_pixel"].as_f64();
        }
    }
    assert!(child.wait().unwrap().success() && folder.path("a.exr").exists());
    assert!(least.is_some_and(|samples| samples >= 1.0), "{least:?}");
    assert!(!is_there());
}

/// A shell without job control ignores SIGINT and SIGQUIT for programs in the background. `kill` means them.
#[cfg(target_os = "linux")]
#[test]
fn background_jobs_end_by_any_signal_but_those_of_nohup() {
    for signal in ["-INT", "-QUIT"] {
        let folder = Folder::new();
        let mut endless = Endless::start(&folder, "trap '' INT QUIT;", "");
        std::thread::sleep(std::time::Duration::from_secs(2));
        endless.send(signal);
        assert_eq!(unread::ended(&mut endless.child).code(), Some(130));
        assert!(endless.samples(-1.0) > 0.0);
    }
}

/// `nohup` keeps a rendering alive after its terminal.
#[cfg(target_os = "linux")]
#[test]
fn ignored_signals_stay_ignored() {
    let folder = Folder::new();
    let endless = Endless::start(&folder, "trap '' HUP;", "");
    std::thread::sleep(std::time::Duration::from_secs(2));
    endless.send("-HUP");
    std::thread::sleep(std::time::Duration::from_millis(200));
    endless.send("-USR1");
    let first = endless.samples(-1.0);
    std::thread::sleep(std::time::Duration::from_secs(1));
    endless.send("-USR1");
    endless.samples(first);
    assert_eq!(endless.end().0, Some(130));
}

#[test]
fn targets_and_times_that_make_no_sense_are_refused() {
    let folder = Folder::new();
    for (arguments, message) in [
        (&["--target-error", "0"][..], "expected a number from 0.000001 to 1"),
        (&["--target-error", "-0.1"], "expected a number from 0.000001 to 1"),
        (&["--target-error", "nan"], "expected a number from 0.000001 to 1"),
        (&["--target-error", "0.1", "--confidence", "1"], "expected a number from 0.5 to 0.999999"),
        (&["--confidence", "0.9"], "--target-error <E>"),
        (&["--target-error", "0.1", "--quick"], "cannot be used with '--quick'"),
        (&["--target-error", "0.1", "--spp", "63"], "needs at least 64 samples per pixel"),
        (&["--adaptive", "--target-error", "0.1"], "cannot be used with"),
        (&["--adaptive", "--confidence", "0.9"], "cannot be used with"),
        (&["--adaptive", "--error-layers", "-o", "a.exr"], "cannot be used with"),
        (&["--adaptive", "--quick"], "cannot be used with"),
        (&["--time", "0"], "expected seconds"),
        (&["--time", "inf"], "expected seconds"),
        (&["--time", "1", "--quick"], "cannot be used with '--quick'"),
        (&["--time", "1", "--error-layers", "-o", "a.exr"], "with a target error: add --target-error"),
        (
            &["--target-error", "0.1", "--error-layers", "-o", "a.pfm"],
            "only an .exr file can store error layers",
        ),
    ] {
        let run = folder.run(&[&["render", "fine.pbrt"], arguments].concat());
        assert!(run.status == 2 && run.err.contains(message), "{arguments:?}: {}", run.err);
    }
}
