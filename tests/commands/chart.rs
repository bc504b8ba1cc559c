//! The command `lookat chart`.

use std::path::Path;
use std::process::{Command, Stdio};

use lookat_image::{Image, Window, means};
use serde_json::Value;

use crate::folder::{Folder, Run};

/// A sphere on a floor, which shine on each other.
const SCENE: &str = r#"LookAt 0 1 -5  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 32 "integer yresolution" 24 "string filename" "scene.exr"
Sampler "sobol" "integer pixelsamples" 4
Integrator "path" "integer maxdepth" 3
WorldBegin
LightSource "point" "point from" [3 4 -5] "rgb I" [30 30 30]
LightSource "infinite" "rgb L" [.2 .2 .2]
Material "matte" "rgb Kd" [.8 .8 .8]
Shape "sphere"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-5 -1 -5  -5 -1 5  5 -1 5  5 -1 -5]
WorldEnd
"#;

fn scene_folder() -> Folder {
    let folder = Folder::empty();
    folder.write("scene.pbrt", SCENE);
    folder
}

impl Folder {
    /// Charts the scene into a folder, and reads `chart.json`.
    #[track_caller]
    fn chart(&self, arguments: &[&str]) -> (Run, Value) {
        let run = self.run(&[&["chart", "scene.pbrt", "-o", "out"], arguments].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        let json = std::fs::read(self.path("out/chart.json")).unwrap();
        (run, serde_json::from_slice(&json).unwrap())
    }

    /// The lines of `chart.csv`, without the times.
    fn rows(&self) -> Vec<[String; 7]> {
        let text = std::fs::read_to_string(self.path("out/chart.csv")).unwrap();
        let columns = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            [0, 1, 2, 3, 5, 6, 7].map(|column| cells[column].to_owned())
        };
        text.lines().map(columns).collect()
    }

    fn render(&self, file: &str, arguments: &[&str]) {
        let run = self.run(&[&["render", "scene.pbrt", "-q", "-o", file], arguments].concat());
        assert_eq!(run.status, 0, "{}", run.err);
    }

    /// The root mean squared error of a picture against another.
    fn rmse(&self, actual: &str, expected: &str) -> f64 {
        let read = |name| Image::read(&self.path(name)).unwrap().rgb().unwrap();
        means(&read(actual), &read(expected)).rmse
    }

    fn has(&self, name: &str) -> bool {
        Path::exists(&self.path(name))
    }
}

fn method<'a>(json: &'a Value, name: &str) -> &'a Value {
    json["methods"].as_array().unwrap().iter().find(|method| method["name"] == name).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn everything_is_written_and_random_samples_converge_as_they_must() {
    let folder = scene_folder();
    // Straight light alone: few dimensions, which is where patterns serve.
    folder.write("scene.pbrt", &SCENE.replace("maxdepth\" 3", "maxdepth\" 1"));
    folder.render("other.exr", &["--spp", "16", "--seed", "99"]);
    let (run, json) =
        folder.chart(&["--spp", "64", "--methods", "random,sobol", "--point", "Other <1>=2.5,other.exr"]);
    assert!(
        run.err.starts_with("plan: 1 to 64 samples per pixel, 8 seeds each; a reference of 1024\n"),
        "{}",
        run.err
    );
    let svg = std::fs::read_to_string(folder.path("out/chart.svg")).unwrap();
    for text in ["scene.pbrt, 32 x 24 pixels", "random", "sobol", "Other &lt;1&gt;", "Pareto front"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(Image::read(&folder.path("out/chart.png")).unwrap().data_window.width >= 960);
    assert_eq!(folder.rows().len(), 1 + 2 * 7 * 8);

    assert_eq!((json["size"][0].as_u64(), json["seeds_per_point"].as_u64()), (Some(32), Some(8)));
    let slope = &method(&json, "random")["slope"];
    let [value, low, high] = [&slope["slope"], &slope["interval"][0], &slope["interval"][1]].map(number);
    // Twice the interval, since one of twenty does not hold.
    assert!((value + 0.5).abs() < high - low && high - low < 0.05, "{slope}");
    assert!(number(&method(&json, "sobol")["slope"]["slope"]) < -0.6);
    // Neither has a bias, and the noise of the reference is a quarter of the error of the last point of sobol.
    for name in ["random", "sobol"] {
        assert!(method(&json, name)["levels_off_at"].is_null(), "{name}");
    }
    let noise = number(&json["reference"]["rms_standard_error"]);
    let last = &method(&json, "sobol")["points"][6];
    let ratio = number(&last["rmse"]["value"]) / noise;
    assert!((ratio - 17.0_f64.sqrt()).abs() < 0.5, "{ratio}");

    let point = &json["points"][0];
    assert_eq!((point["name"].as_str(), number(&point["seconds"])), (Some("Other <1>"), 2.5));
    // As good as 16 samples of sobol, which took less than the time that was given.
    let ours = &method(&json, "sobol")["points"][4]["rmse"];
    assert!((number(&point["rmse"]) / number(&ours["value"]) - 1.0).abs() < 0.2, "{point} {ours}");
    assert!(number(&point["lookat_seconds_to_same_rmse"]["sobol"]) > 0.0);
    for line in
        ["\nrandom ", "\nOther <1> ", "\nPareto front ", "RMSE after equal times", "seconds to equal RMSE"]
    {
        assert!(run.out.contains(line), "{line}: {}", run.out);
    }
}

#[test]
fn errors_are_those_of_the_pictures_that_render_makes() {
    let folder = scene_folder();
    folder.render("reference.exr", &["--spp", "256", "--seed", "1000", "--error-layers"]);
    let arguments =
        ["--spp", "4", "--methods", "sobol,random", "--reference", "reference.exr", "--seed", "7"];
    let (run, json) = folder.chart(&arguments);
    assert!(
        !run.err.contains("a reference of")
            && !run.err.contains("warning")
            && run.out.contains("reference: reference.exr; its noise is ")
    );
    let noise = number(&json["reference"]["rms_standard_error"]);
    let rows = folder.rows();
    // The first of 2 samples per pixel: the 8 before had 1.
    let row = rows.iter().find(|row| row[0] == "sobol" && row[1] == "2").unwrap();
    assert_eq!((row[2].as_str(), row[3].as_str()), ("15", "2"));
    folder.render("same.exr", &["--spp", "2", "--seed", "15"]);
    let expected = folder.rmse("same.exr", "reference.exr");
    let found: f64 = row[4].parse().unwrap();
    assert!((found / expected - 1.0).abs() < 1e-9, "{found}, not {expected}");
    // A reference of the same samples as a picture would be no reference.
    folder.render("seven.exr", &["--seed", "7"]);
    let run =
        folder.run(&["chart", "scene.pbrt", "--seed", "7", "--reference", "seven.exr", "--budget", "1e-6"]);
    assert!(
        run.err.contains("seven.exr has the seed 7") && run.err.contains("--seed 143 avoids"),
        "{}",
        run.err
    );
    // Again, on another number of threads, and with a method less.
    let (_, again) = folder.chart(&[&arguments[..], &["--threads", "1"]].concat());
    assert_eq!(folder.rows(), rows);
    assert_eq!(number(&again["reference"]["rms_standard_error"]), noise);
    assert_eq!(again["threads"].as_u64(), Some(1));
}

#[test]
fn a_bias_is_named() {
    let folder = scene_folder();
    let (run, json) = folder.chart(&["--spp", "32", "--methods", "path,direct-all"]);
    assert!(method(&json, "path")["levels_off_at"].is_null());
    let level = number(&method(&json, "direct-all")["levels_off_at"]);
    // What it really is, by pictures that are almost free of noise.
    folder.render("path.exr", &["--spp", "1024"]);
    folder.write("direct.pbrt", &SCENE.replace(r#""path""#, r#""directlighting""#));
    assert_eq!(folder.run(&["render", "direct.pbrt", "-q", "-o", "direct.exr", "--spp", "1024"]).status, 0);
    let expected = folder.rmse("direct.exr", "path.exr");
    assert!((level / expected - 1.0).abs() < 0.02, "{level}, not {expected}");
    assert!(run.out.contains("levels off at"), "{}", run.out);
}

#[test]
fn a_budget_decides_how_far_it_goes() {
    let folder = scene_folder();
    // The fewest points take milliseconds, so that a busy machine has time for them too.
    let arguments = ["--methods", "random,stratified", "--resolution", "8x6", "--budget", "3"];
    let run = folder.run(&[&["chart", "scene.pbrt"], &arguments[..]].concat());
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(run.err.contains("samples per pixel") && run.err.contains("; about "), "{}", run.err);
    for name in ["svg", "png", "csv", "json"] {
        assert!(folder.has(&format!("scene-chart/chart.{name}")), "{name}");
    }
    for name in ["random", "stratified"] {
        assert!(run.out.contains(&format!("\n{name} ")), "{}", run.out);
    }
    let run = folder.run(&["chart", "scene.pbrt", "--budget", "1e-6"]);
    assert_eq!(run.status, 2);
    assert!(run.err.contains("the budget is 0.000001 s: raise --budget"), "{}", run.err);
}

#[test]
fn what_cannot_be_charted_is_refused() {
    let folder = scene_folder();
    folder.render("small.exr", &["--resolution", "16x12"]);
    folder.render("part.exr", &["--crop", "0", "0.5", "0", "1"]);
    folder.write("text.exr", "no picture");
    let window = Window { x: 0, y: 0, width: 32, height: 24 };
    let white = Image::from_rgb(window, window, &[[1.0; 3]; 32 * 24]);
    white.write(&folder.path("white.png")).unwrap();
    folder.write("black.pbrt", &SCENE.replace("LightSource", "# LightSource"));
    folder.write("wrong.pbrt", &SCENE.replace("\"sphere\"", "\"sphrere\""));
    let refused = |arguments: &[&str], message: &str| {
        let run = folder.run(&[&["chart", "-o", "out"], arguments].concat());
        assert_eq!((run.status, run.out.as_str()), (2, ""), "{arguments:?}: {}", run.err);
        assert!(run.err.contains(message), "{arguments:?}: {}", run.err);
        assert!(!folder.has("out/chart.svg") && !folder.has("out/chart.json"), "{arguments:?}");
    };
    let size = "small.exr: the picture has 16 x 12 pixels, but the scene has 32 x 24";
    refused(&["scene.pbrt", "--reference", "small.exr"], size);
    refused(&["scene.pbrt", "--point", "x=1,small.exr"], size);
    refused(&["scene.pbrt", "--reference", "part.exr"], "the picture has the pixels 16 x 24 from (0, 0)");
    refused(&["scene.pbrt", "--reference", "nothing.exr"], "cannot read nothing.exr");
    refused(&["scene.pbrt", "--point", "x=1,text.exr"], "text.exr");
    refused(&["scene.pbrt", "--point", "x=1"], "expected NAME=SECONDS,IMAGE");
    refused(&["scene.pbrt", "--point", "x=-1,small.exr"], "from 1e-9");
    refused(
        &["scene.pbrt", "--reference", "white.png"],
        "white.png: pixels at the largest value may be clipped",
    );
    refused(&["scene.pbrt", "--methods", "random,sobl"], "did you mean `sobol`?");
    for name in ["halton", "02sequence", "maxmindist"] {
        let hint = format!("unknown method `{name}`; lookat renders it as `sobol`; the methods are random,");
        refused(&["scene.pbrt", "--methods", name], &hint);
    }
    refused(&["scene.pbrt", "--methods", "sobol,bdpt"], "lookat renders it as `path`");
    refused(&["scene.pbrt", "--methods", "sobol,random,sobol"], "--methods names sobol twice");
    let name = format!("{}=1,small.exr", "x".repeat(41));
    refused(&["scene.pbrt", "--point", &name], "at most 40 letters");
    refused(&["scene.pbrt", "--spp", "12"], "power of two");
    refused(&["black.pbrt", "--spp", "4"], "there is nothing to chart");
    assert_eq!(folder.run(&["chart", "wrong.pbrt"]).status, 1);
    assert!(!folder.has("wrong-chart"));
}

/// Starts a chart of the scene, which takes hours, and interrupts it so long after it has told its plan.
#[cfg(unix)]
fn interrupted(folder: &Folder, arguments: &[&str], after: f32) -> Run {
    use std::io::{BufRead, BufReader, Read};
    let arguments = [&["chart", "scene.pbrt", "--spp", "65536", "-o", "out"], arguments].concat();
    let mut child = folder.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut err = BufReader::new(child.stderr.take().unwrap());
    let mut plan = String::new();
    err.read_line(&mut plan).unwrap();
    assert!(plan.starts_with("plan: "), "{plan}");
    std::thread::sleep(std::time::Duration::from_secs_f32(after));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let mut run = Run::of(child.wait_with_output().unwrap());
    err.read_to_string(&mut run.err).unwrap();
    assert_eq!(run.status, 130, "{}", run.err);
    run
}

#[cfg(unix)]
#[test]
fn an_interrupt_before_the_first_point_leaves_nothing() {
    let folder = scene_folder();
    let run = interrupted(&folder, &[], 0.0);
    assert!(run.err.ends_with("interrupted before the first point; nothing was written\n"), "{}", run.err);
    assert!(!folder.has("out") && run.out.is_empty());
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_was_measured() {
    let folder = scene_folder();
    folder.render("reference.exr", &["--spp", "64", "--seed", "1000000"]);
    let methods = ["--methods", "random,sobol", "--reference", "reference.exr", "--threads", "1"];
    folder.chart(&[&["--spp", "4"], &methods[..]].concat());
    let expected = folder.rows();
    std::fs::remove_dir_all(folder.path("out")).unwrap();
    // How soon it has its first points depends on the machine.
    let mut runs = [0.0, 1.0, 4.0, 16.0].into_iter().map(|after| interrupted(&folder, &methods, after));
    let run = runs.find(|_| folder.has("out")).unwrap();
    assert!(run.out.contains("\ninterrupted: ") && run.out.contains("\nPareto front "), "{}", run.out);
    for name in ["svg", "png", "csv", "json"] {
        assert!(folder.has(&format!("out/chart.{name}")), "{name}");
    }
    let json: Value = serde_json::from_slice(&std::fs::read(folder.path("out/chart.json")).unwrap()).unwrap();
    assert_eq!((&json["complete"], &json["interrupted"]), (&Value::Bool(false), &Value::Bool(true)));
    for method in ["random", "sobol"] {
        let points = self::method(&json, method)["points"].as_array().unwrap();
        assert!(points.len() < 17 && points.iter().all(|point| point["pictures"] == 8), "{points:?}");
    }
    // The title, and the pictures of the first point at least.
    let (rows, least) = (folder.rows(), 1 + 8);
    let same = rows.iter().zip(&expected).take_while(|(row, expected)| row == expected).count();
    assert!(same >= least, "{rows:?}");
}
