//! The command that repeats this run, for a shell.

use std::fmt::Write;

use crate::args::quoted;

/// Goes to the working folder and runs lookat with the same arguments.
pub fn repeated() -> String {
    let folder = std::env::current_dir().unwrap_or_default();
    let mut command = format!("cd {} && lookat", quoted(folder.as_os_str()));
    for argument in std::env::args_os().skip(1) {
        let _ = write!(command, " {}", quoted(&argument));
    }
    command
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;
    use std::process::Command;

    use super::*;

    /// A shell makes the same argument of it.
    #[cfg(unix)]
    #[test]
    fn a_shell_reads_the_same_word() {
        use std::os::unix::ffi::OsStrExt;

        for word in [&b"plain"[..], b"", b"a b", b"it's", b"$HOME `x` \"y\" \\ \n!*~", b"caf\xe9 %s"] {
            let quoted = quoted(OsStr::from_bytes(word));
            let script = format!("printf %s {quoted}");
            let output = Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(output.stdout, word, "{quoted}");
        }
    }
}
