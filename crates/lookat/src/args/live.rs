//! Options that show a picture as it grows, and keep it up to date.

use clap::{Args, ValueEnum};

/// Where to show the picture while it is rendered.
#[derive(Debug, Clone, Default, Args)]
pub struct LiveView {
    /// Draw the picture in the terminal as it grows
    #[arg(long, value_name = "PROTOCOL", num_args = 0..=1, require_equals = true, default_missing_value = "auto")]
    pub show: Option<Protocol>,
    /// Stream the picture to the viewer tev as it grows; tev listens at 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT", value_parser = address)]
    pub tev: Option<String>,
    /// Render again whenever the scene or a file that it uses is saved; end with Ctrl-C
    #[arg(long, conflicts_with_all = ["turntable", "animate"])]
    pub watch: bool,
}

/// How to draw a picture in a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Protocol {
    /// The best protocol that the terminal supports
    Auto,
    Kitty,
    Iterm,
    Sixel,
    /// Two pixels per character
    Blocks,
}

fn address(text: &str) -> Result<String, String> {
    let is_address =
        text.rsplit_once(':').is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
    if is_address { Ok(text.into()) } else { Err("expected a host and a port, as in 127.0.0.1:14158".into()) }
}
