//! What reaches a terminal: pictures, and names that are hostile to it.

use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;

use lookat_image::Channel;
use nix::pty::openpty;

use super::*;

/// Clears the screen, sets the title, rings, moves back, colors, turns the direction, breaks the line.
const HOSTILE: &str =
    "\u{1b}[2Jx\u{1b}]0;owned\u{7}\r\u{8}\u{7f}\u{9b}31m\u{202e}\u{2066}\u{2028}\u{200f}\u{61c}";
/// The same, as it is shown.
const SHOWN: &str = "␛[2Jx␛]0;owned␇␍␈␡\u{fffd}31m\u{fffd}\u{fffd}\u{fffd}\u{fffd}\u{fffd}";

/// What the program writes where standard output and standard error are a terminal.
fn on_terminal(folder: &Folder, arguments: &[&str]) -> String {
    let pair = openpty(None, None).unwrap();
    let slave = |fd: &OwnedFd| Stdio::from(fd.try_clone().unwrap());
    let mut command = folder.command(arguments);
    command.env("COLORTERM", "truecolor");
    let mut child = command.stdout(slave(&pair.slave)).stderr(slave(&pair.slave)).spawn().unwrap();
    // Those of this process are closed, so that reading ends with the program.
    drop((command, pair.slave));
    let (mut master, mut bytes, mut buffer) = (File::from(pair.master), Vec::new(), [0; 4096]);
    // Linux ends with an error.
    while let Ok(count @ 1..) = master.read(&mut buffer) {
        bytes.extend_from_slice(&buffer[..count]);
    }
    child.wait().unwrap();
    String::from_utf8(bytes).unwrap()
}

#[track_caller]
fn check(folder: &Folder, arguments: &[&str]) -> String {
    let text = check_safe(folder, arguments);
    assert!(text.contains(SHOWN), "{arguments:?}: {text:?}");
    text
}

/// The name is shown in some form and does not act on the terminal.
#[track_caller]
fn check_safe(folder: &Folder, arguments: &[&str]) -> String {
    let text = on_terminal(folder, arguments);
    assert!(text.contains("owned"), "{arguments:?}: {text:?}");
    for command in ["\u{1b}[2Jx", "\u{1b}]", "\u{7}", "\u{8}", "\u{7f}", "\u{9b}", "\u{2028}"] {
        assert!(!text.contains(command), "{arguments:?}: {command:?} in {text:?}");
    }
    let directions = ['\u{202e}', '\u{2066}', '\u{200f}', '\u{61c}'];
    assert!(!text.contains(directions), "{arguments:?}: {text:?}");
    text
}

#[test]
fn hostile_names_do_not_act_on_a_terminal() {
    let folder = Folder::new();
    let film = format!("{HOSTILE}.exr");
    folder.write("film.pbrt", &FINE.replace("fine.exr", &film));
    check(&folder, &["render", "film.pbrt"]);
    let scene = format!("{HOSTILE}.pbrt");
    folder.write(&scene, FINE);
    check(&folder, &["check", &scene]);
    check(&folder, &["inspect", &scene]);
    let styled = {
        let text = format!("NamedMaterial \"{HOSTILE}\" Shape \"sphrere\"");
        folder.write("material.pbrt", &FINE.replace("Shape \"sphere\"", &text));
        check(&folder, &["check", "material.pbrt"])
    };
    assert!(styled.contains("\u{1b}[1m") || styled.contains("\u{1b}[91m"), "styles stay: {styled:?}");
    folder.write("include.pbrt", &FINE.replace("Shape \"sphere\"", &format!("Include \"{HOSTILE}\"")));
    check(&folder, &["check", "include.pbrt"]);
    // Typed wrongly, by a program that passes names on.
    check(&folder, &["render", "fine.pbrt", "--spp", HOSTILE]);
    check_safe(&folder, &["compare", &format!("{HOSTILE}.png"), "nothing.exr"]);
}

#[test]
fn hostile_layers_do_not_act_on_a_terminal() {
    let folder = Folder::new();
    let mut image = folder.picture(&[]);
    let samples = image.channels[0].samples.clone();
    image.channels.push(Channel { name: format!("{HOSTILE}.Y"), samples });
    image.write(&folder.path("layers.exr")).unwrap();
    check_safe(&folder, &["compare", "layers.exr", "picture.exr", "--layer", "nothing"]);
    check_safe(&folder, &["compare", "picture.exr", "layers.exr", "--layer", HOSTILE]);
}

/// Columns count characters, and each has one in its place.
#[test]
fn quoted_source_keeps_its_columns() {
    let folder = Folder::new();
    folder.write("a.pbrt", &format!("WorldBegin # \nMaterial \"{HOSTILE}\""));
    let text = folder.run(&["check", "a.pbrt"]).err;
    let lines: Vec<&str> = text.lines().collect();
    let at = lines.iter().position(|line| line.starts_with("2 | ")).unwrap();
    assert_eq!(lines[at], format!("2 | Material \"{SHOWN}\""));
    let marks = lines[at + 1].trim_start_matches("  | ");
    assert_eq!(marks.matches('^').count(), SHOWN.chars().count() + 2, "{text}");
}

/// The end of a line in a Windows file is no part of the line.
#[test]
fn carriage_returns_at_line_ends_are_not_shown() {
    let folder = Folder::new();
    folder.write("wrong.pbrt", &FINE.replace("\"sphere\"", "\"sphrere\"").replace('\n', "\r\n"));
    let text = folder.run(&["check", "wrong.pbrt"]).err;
    assert!(text.contains("9 | Shape \"sphrere\"\n") && !text.contains('␍'), "{text}");
}

#[test]
fn json_is_safe_to_print() {
    let folder = Folder::new();
    let scene = format!("{HOSTILE}.pbrt");
    folder.write(&scene, FINE);
    let run = folder.run(&["check", "--json", &scene]);
    assert!(run.out.trim_end().chars().all(|c| ('\u{20}'..'\u{7f}').contains(&c)), "{:?}", run.out);
    assert_eq!(json_lines(&run)[0]["scene"], scene.as_str());
}

/// A picture of two by two pixels, in two half blocks: its colors, and the bar below.
#[test]
fn a_picture_is_drawn_in_half_blocks() {
    let folder = Folder::new();
    // Emitters that fill the screen, seen straight on: a color for each quarter.
    let light = |color: &str, at: &str| {
        format!(
            "AttributeBegin Translate {at} 0 AreaLightSource \"diffuse\" \"rgb L\" [{color}] \"bool twosided\" \"true\" \
            Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0] AttributeEnd "
        )
    };
    let lights = [("1 0 0", "-1 0"), ("0 1 0", "0 0"), ("0 0 1", "-1 -1"), ("1 1 0.5", "0 -1")]
        .map(|(color, at)| light(color, at));
    folder.write(
        "colors.pbrt",
        &format!(
            "LookAt 0 0 -4 0 0 0 0 1 0 Camera \"orthographic\" Sampler \"sobol\" \"integer pixelsamples\" 4 Integrator \"path\" \
            Film \"image\" \"integer xresolution\" 2 \"integer yresolution\" 2 \"string filename\" \"colors.exr\" \
            WorldBegin {} WorldEnd",
            lights.concat()
        ),
    );
    let text = on_terminal(&folder, &["render", "colors.pbrt", "--show=blocks"]);
    let drawn = "\u{1b}[38;2;255;0;0;48;2;0;0;255m▀\u{1b}[38;2;0;255;0;48;2;255;255;188m▀\u{1b}[0m\r\n";
    let (_, after) = text.split_once(drawn).unwrap_or_else(|| panic!("{text:?}"));
    assert!(after.contains("colors.exr: 2 x 2 pixels"), "{text:?}");
    // The drawing has the exposure and the tone curve of an 8-bit file.
    let tone = ["--exposure", "1", "--tone", "aces"];
    let text = on_terminal(
        &folder,
        &[&["render", "colors.pbrt", "--show=blocks", "-o", "colors.png"][..], &tone].concat(),
    );
    let file = std::io::BufReader::new(File::open(folder.path("colors.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let color = |at: usize| bytes[3 * at..3 * at + 3].iter().map(u8::to_string).collect::<Vec<_>>().join(";");
    let column = |at: usize| format!("\u{1b}[38;2;{};48;2;{}m▀", color(at), color(at + 2));
    let drawn = format!("{}{}\u{1b}[0m\r\n", column(0), column(1));
    assert!(text.contains(&drawn) && !drawn.contains("38;2;255;0;0"), "{drawn:?} {text:?}");
    // A picture of several updates is drawn over itself.
    let arguments = ["render", "colors.pbrt", "--show=blocks", "--time", "1.5"];
    let text = on_terminal(&folder, &arguments);
    let drawings = text.matches("▀\u{1b}[0m\r\n").count();
    assert!(drawings >= 3 && text.matches("\u{1b}[1A\r").count() >= drawings - 1, "{text:?}");
}
