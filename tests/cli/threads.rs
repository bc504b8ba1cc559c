//! Threads that the system does not give.

use super::*;

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
                &["render", "fine.pbrt", "-o", "a.exr", "--threads", &threads.to_string()],
            );
            assert_eq!(run.status, 0, "{kilobytes} kB, {threads} threads: {}", run.err);
            let is_warned =
                run.err.contains(&format!(" of {threads} threads could be started; lower --threads"));
            assert!(is_warned || kilobytes > 1_000_000, "{kilobytes} kB, {threads} threads: {}", run.err);
            assert_eq!(Image::read(&folder.path("a.exr")).unwrap().channels, expected);
        }
    }
    assert!(!folder.run(&["render", "fine.pbrt", "--threads", "3"]).err.contains("could be started"));
    // Commands without --threads use one thread per processor.
    folder.picture(&[]);
    let run = folder.run_within("-v 150000", &["compare", "picture.exr", "picture.exr"]);
    assert_eq!(run.status, 0, "{}", run.err);
}
