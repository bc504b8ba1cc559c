//! Terminals and viewers that do not read: they end no picture and hold up no end.

use std::net::TcpListener;
use std::os::fd::OwnedFd;
use std::process::{Child, ExitStatus};
use std::time::{Duration, Instant};

use nix::pty::openpty;
use nix::sys::termios::{FlowArg, tcflow};

use super::*;

/// Waits for the end of a program, which has to come.
#[track_caller]
pub fn ended(child: &mut Child) -> ExitStatus {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if started.elapsed() > Duration::from_secs(100) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("it does not end");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Starts the program on a terminal that was stopped by Ctrl-S.
fn start(folder: &Folder, arguments: &[&str]) -> (Child, OwnedFd) {
    let pair = openpty(None, None).unwrap();
    tcflow(&pair.slave, FlowArg::TCOOFF).unwrap();
    let slave = || Stdio::from(pair.slave.try_clone().unwrap());
    let child = folder.command(arguments).stdout(slave()).stderr(slave()).spawn().unwrap();
    (child, pair.master)
}

#[test]
fn a_stopped_terminal_does_not_stop_the_deadline() {
    let folder = Folder::new();
    // The result for programs is lost, which the exit status says.
    for (option, status) in [("--force", 0), ("--show=blocks", 0), ("--json", 2)] {
        let arguments = ["render", "warns.pbrt", "-o", "a.exr", "--time", "1", option];
        let (mut child, _terminal) = start(&folder, &arguments);
        assert_eq!(ended(&mut child).code(), Some(status), "{option}");
        let image = Image::read(&folder.path("a.exr")).unwrap();
        let metadata: Value = serde_json::from_str(image.metadata.as_deref().unwrap()).unwrap();
        assert_eq!(metadata["complete"], true);
        std::fs::remove_file(folder.path("a.exr")).unwrap();
    }
}

#[test]
fn a_stopped_terminal_does_not_stop_signals() {
    let folder = Folder::new();
    for signal in ["-INT", "-TERM"] {
        for options in [&[][..], &["--show=blocks"]] {
            let is_kept = |after: &f32| {
                let arguments = [&["render", "fine.pbrt", "-o", "a.exr", "--spp", "100000000"], options];
                let (mut child, _terminal) = start(&folder, &arguments.concat());
                std::thread::sleep(Duration::from_secs_f32(*after));
                let id = child.id().to_string();
                assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
                let code = ended(&mut child).code();
                let is_kept = folder.path("a.partial.exr").exists();
                // Before it listens, the signal ends it.
                assert!(code == Some(130) || code.is_none() && !is_kept, "{signal} {options:?}: {code:?}");
                is_kept
            };
            // How soon it has its first samples depends on the machine.
            assert!([1.0, 4.0, 16.0].iter().any(is_kept), "{signal} {options:?}");
            std::fs::remove_file(folder.path("a.partial.exr")).unwrap();
        }
    }
}

/// `chart` too: Ctrl-C ends it.
#[test]
fn a_stopped_terminal_does_not_stop_a_chart() {
    let folder = Folder::new();
    let (mut child, _terminal) = start(&folder, &["chart", "fine.pbrt", "-o", "chart", "--budget", "1000"]);
    std::thread::sleep(Duration::from_secs(3));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert_eq!(ended(&mut child).code(), Some(130));
}

#[test]
fn a_stopped_viewer_does_not_stop_the_deadline() {
    let folder = Folder::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    // Larger than the system keeps for a connection.
    let mut command = folder.command(&[
        "render",
        "fine.pbrt",
        "-o",
        "a.exr",
        "--time",
        "2",
        "--resolution",
        "600x600",
        "--tev",
        &address,
    ]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let _connection = listener.accept().unwrap();
    assert_eq!(ended(&mut child).code(), Some(0));
    let run = Run::of(child.wait_with_output().unwrap());
    // The picture is written before anything waits for tev.
    let [written, waited] = ["a.exr: 600 x 600 pixels", "tev"].map(|text| run.err.find(text));
    assert!(written.is_some() && written < waited, "{}", run.err);
    assert!(folder.path("a.exr").exists());
}
