//! The command that repeats this run, for a shell.

use std::ffi::OsStr;
use std::fmt::Write;

/// Goes to the working folder and runs lookat with the same arguments.
pub fn repeated() -> String {
    let folder = std::env::current_dir().unwrap_or_default();
    let mut command = format!("cd {} && lookat", quoted(folder.as_os_str()));
    for argument in std::env::args_os().skip(1) {
        let _ = write!(command, " {}", quoted(&argument));
    }
    command
}

/// An argument as one word of a POSIX shell.
pub fn quoted(argument: &OsStr) -> String {
    let text = argument.to_str().and_then(|text| shlex::try_quote(text).ok());
    text.map_or_else(|| printed(argument.as_encoded_bytes()), |text| text.into_owned())
}

/// A word that is not UTF-8, which a web page cannot hold, as its bytes in octal.
fn printed(bytes: &[u8]) -> String {
    let octal: String = bytes.iter().map(|byte| format!("\\{byte:03o}")).collect();
    format!("\"$(printf '{octal}')\"")
}

#[cfg(test)]
mod tests {
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
