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

/// A higher limit never starts fewer threads.
#[cfg(target_os = "linux")]
#[test]
fn more_memory_never_means_fewer_threads() {
    let folder = Folder::new();
    let mut most = 0;
    for kilobytes in (200_000..2_400_000).step_by(100_000) {
        let run = folder.run_within(
            &format!("-v {kilobytes}"),
            &["render", "fine.pbrt", "-o", "a.exr", "--threads", "8"],
        );
        let warning = run.err.lines().find_map(|line| line.strip_prefix("warning: "));
        let count = warning.map_or(8, |text| text.split(' ').next().unwrap().parse().unwrap());
        assert!(count >= most, "{kilobytes} kB: {count} threads, with less {most}");
        most = count;
    }
    assert_eq!(most, 8);
}
