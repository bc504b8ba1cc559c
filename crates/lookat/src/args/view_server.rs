//! The arguments of `lookat view`.

use std::path::PathBuf;

use clap::Args;

use super::{Memory, whole};

#[derive(Debug, Args)]
#[command(
    after_help = "Only this computer can open the page, and only with the address that the command prints. Ctrl-C ends it."
)]
pub struct View {
    /// The scene file
    pub scene: PathBuf,
    /// Compare with this picture: .exr, .pfm, .png, .tga, .jpg or .hdr
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Port of the page at 127.0.0.1; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Open the page in the browser
    #[arg(long)]
    pub open: bool,
    /// Editor command for the page's links; {file}, {line} and {column} stand for the place [default: VISUAL or
    /// EDITOR, else a link to VS Code]
    #[arg(long, value_name = "COMMAND")]
    pub editor: Option<String>,
    /// Number of threads [default: one per processor]
    #[arg(long, visible_alias = "nthreads", value_name = "N", allow_negative_numbers = true, value_parser = whole(1_u16, 1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub memory: Memory,
}
