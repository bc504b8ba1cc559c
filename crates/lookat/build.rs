//! Names the git commit in the version, if there is one.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let mut version = env!("CARGO_PKG_VERSION").to_owned();
    let git = Command::new("git")
        .args(["rev-parse", "--show-prefix", "--git-path", "logs/HEAD", "--short", "HEAD"])
        .output();
    let said = git.ok().filter(|git| git.status.success()).map(|git| git.stdout).unwrap_or_default();
    // The repository of another project may contain the sources.
    if let ["crates/lookat/", log, commit] = String::from_utf8_lossy(&said).lines().collect::<Vec<_>>()[..] {
        version += &format!(" ({commit})");
        if std::fs::exists(log).unwrap_or(false) {
            println!("cargo::rerun-if-changed={log}");
        }
    }
    println!("cargo::rustc-env=LOOKAT_VERSION={version}");
}
