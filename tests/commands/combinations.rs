//! Options of `render` that show a picture and options that decide about its samples and layers, in all combinations.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::net::TcpListener;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use nix::pty::openpty;

use super::*;

/// Each option with its arguments.
const OPTIONS: [(&str, &[&str]); 9] = [
    ("--show", &["--show=blocks"]),
    ("--tev", &["--tev"]),
    ("--watch", &["--watch"]),
    ("--layers", &["--layers", "depth,normal,samples"]),
    ("--error-layers", &["--error-layers"]),
    ("--target-error", &["--target-error", "0.5"]),
    ("--adaptive", &["--adaptive"]),
    ("--time", &["--time", "0.3"]),
    ("--turntable", &["--turntable", "2"]),
];
/// Pairs that exclude each other.
const EXCLUDED: [[&str; 2]; 3] =
    [["--watch", "--turntable"], ["--adaptive", "--target-error"], ["--adaptive", "--error-layers"]];

/// A listener that reads everything, as tev does.
fn reader() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    std::thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            std::thread::spawn(move || std::io::copy(&mut stream, &mut std::io::sink()));
        }
    });
    address
}

/// Runs `render` on a terminal, and ends it once it watches for changes. Returns the exit status and what it said.
fn run(folder: &Folder, options: &[&str], tev: &str, number: usize) -> (Option<i32>, String) {
    let output = format!("{number}.exr");
    let mut arguments = vec!["render", "small.pbrt", "-o", output.as_str()];
    for option in options {
        let (_, own) = OPTIONS.iter().find(|(name, _)| name == option).unwrap();
        arguments.extend(*own);
        arguments.extend((*option == "--tev").then_some(tev));
    }
    let pair = openpty(None, None).unwrap();
    let slave = Stdio::from(pair.slave.try_clone().unwrap());
    let mut command = folder.command(&arguments);
    let mut child = command.stdout(Stdio::null()).stderr(slave).spawn().unwrap();
    drop((command, pair.slave));
    let (mut master, said, mut is_told) = (File::from(pair.master), Mutex::new(String::new()), false);
    let started = Instant::now();
    let status = std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut buffer = [0; 4096];
            // Linux ends with an error.
            loop {
                match master.read(&mut buffer) {
                    Ok(count @ 1..) => *said.lock().unwrap() += &String::from_utf8_lossy(&buffer[..count]),
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    _ => break,
                }
            }
        });
        loop {
            if let Some(status) = child.try_wait().unwrap() {
                return status.code();
            }
            if !is_told && said.lock().unwrap().contains("watching for changes") {
                is_told = true;
                let id = child.id().to_string();
                assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
            }
            if started.elapsed() > Duration::from_secs(120) {
                child.kill().unwrap();
                child.wait().unwrap();
                return None;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    });
    (status, said.into_inner().unwrap())
}

#[test]
fn all_combinations_end() {
    let folder = Folder::new();
    // Samples and layers take longer than it takes to the first picture on the terminal.
    folder.write("small.pbrt", &FINE.replace("pixelsamples\" 4", "pixelsamples\" 600"));
    let (tev, next) = (reader(), AtomicUsize::new(0));
    let check = |number: usize| {
        let is_on = |at: usize| number >> at & 1 == 1;
        let options: Vec<&str> = (0..OPTIONS.len()).filter(|at| is_on(*at)).map(|at| OPTIONS[at].0).collect();
        let has = |name: &str| options.contains(&name);
        let (status, said) = run(&folder, &options, &tev, number);
        let is_refused = EXCLUDED.iter().any(|pair| pair.iter().all(|name| has(name)))
            || has("--error-layers") && has("--time") && !has("--target-error");
        let expected = match (is_refused, has("--watch")) {
            (true, _) => 2,
            (false, true) => 130,
            (false, false) => 0,
        };
        assert_eq!(status, Some(expected), "{options:?}: {said}");
        assert!(!is_refused || said.contains("error"), "{options:?}: {said}");
        let last = if has("--turntable") { format!("{number}.0002.exr") } else { format!("{number}.exr") };
        assert_eq!(folder.path(&last).exists(), !is_refused, "{options:?}");
    };
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= 1 << OPTIONS.len() {
                        break;
                    }
                    check(number);
                }
            });
        }
    });
}
