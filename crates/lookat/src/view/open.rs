//! Opens the page in the browser.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Duration;

/// How long a browser may take to start.
const UNTIL_READ: Duration = Duration::from_secs(30);

/// Opens an address in the browser, and waits until it has read it. The browser gets a file that leads there, because others on this computer can
/// see the command line, and the address is a secret.
pub fn in_browser(address: &str) -> Result<(), String> {
    let page = format!(
        "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url={address}\"><title>lookat</title>"
    );
    let mut file = tempfile::Builder::new()
        .prefix("lookat-")
        .suffix(".html")
        .tempfile()
        .map_err(|error| lookat_image::io_reason(&error))?;
    file.write_all(page.as_bytes()).map_err(|error| lookat_image::io_reason(&error))?;
    let path = file.into_temp_path();
    let quiet = Stdio::null;
    match Command::new(OPENER).arg(&path).stdin(quiet()).stdout(quiet()).stderr(quiet()).status() {
        // The explorer of Windows always fails.
        Ok(status) if status.success() || cfg!(windows) => {}
        Ok(status) => return Err(format!("{OPENER}: {status}")),
        Err(error) => return Err(format!("{OPENER}: {}", lookat_image::io_reason(&error))),
    }
    // The browser may read it after its program has ended. The end of this function removes it.
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
