//! Opens the page in the browser.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Duration;

use lookat_image::{TemporaryFile, TemporaryName, io_reason};

/// How long a browser may take to start.
const UNTIL_READ: Duration = Duration::from_secs(30);

/// The file that leads to the address.
const PAGE: TemporaryName = TemporaryName { prefix: "lookat-", suffix: ".html", is_private: true };

/// Opens an address in the browser, and waits until it has read it. The browser gets a file that leads there, because others on this computer can
/// see the command line, and the address is a secret.
pub fn in_browser(address: &str) -> Result<(), String> {
    let page = format!(
        "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url={address}\"><title>lookat</title>"
    );
    let mut file = TemporaryFile::new(&std::env::temp_dir(), PAGE).map_err(|error| io_reason(&error))?;
    file.file.write_all(page.as_bytes()).map_err(|error| io_reason(&error))?;
    let quiet = Stdio::null;
    match Command::new(OPENER).arg(file.path()).stdin(quiet()).stdout(quiet()).stderr(quiet()).status() {
        // The explorer of Windows always fails.
        Ok(status) if status.success() || cfg!(windows) => {}
        Ok(status) => return Err(format!("{OPENER}: {status}")),
        Err(error) => return Err(format!("{OPENER}: {}", io_reason(&error))),
    }
    // The browser may read it after its program has ended. The end of this function removes it, and so does the end of the program.
    std::thread::sleep(UNTIL_READ);
    Ok(())
}

/// The program that opens a file in the program of its type.
const OPENER: &str = if cfg!(target_os = "macos") {
    "open"
} else if cfg!(windows) {
    "explorer"
} else {
    "xdg-open"
};
