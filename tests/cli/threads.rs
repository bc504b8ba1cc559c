//! Threads that the system does not give.

use std::process::Command;

use super::*;

impl Folder {
    /// Runs the program with a limit of bash's `ulimit`.
    fn run_within(&self, limit: &str, arguments: &str) -> Run {
        let line = format!("ulimit {limit} && exec {} {arguments}", env!("CARGO_BIN_EXE_lookat"));
        Run::of(Command::new("bash").args(["-c", &line]).current_dir(self.0.path()).output().unwrap())
    }
}

/// With less memory than the threads take there are fewer threads, a warning, and the same picture.
#[cfg(target_os = "linux")]
#[test]
fn fewer_threads_than_asked_for_give_the_same_picture() {
    let folder = Folder::new();
    let expected = folder.picture(&[]).channels;
    for kilobytes in [150_000, 200_000, 300_000, 500_000, 1_000_000, 2_000_000] {
        for threads in [200, 1000] {
            let run = folder.run_within(
                &format!("-v {kilobytes}"),
                &format!("render fine.pbrt -o a.exr --threads {threads}"),
            );
            assert_eq!(run.status, 0, "{kilobytes} kB, {threads} threads: {}", run.err);
            let is_warned =
                run.err.contains(&format!(" of {threads} threads could be started; lower --threads"));
            assert!(is_warned || kilobytes > 1_000_000, "{kilobytes} kB, {threads} threads: {}", run.err);
            assert_eq!(Image::read(&folder.path("a.exr")).unwrap().channels, expected);
        }
    }
    assert!(!folder.run(&["render", "fine.pbrt", "--threads", "3"]).err.contains("could be started"));
    // Commands that ask for none use those of the processors, as before.
    folder.picture(&[]);
    let run = folder.run_within("-v 150000", "compare picture.exr picture.exr");
    assert_eq!(run.status, 0, "{}", run.err);
}
