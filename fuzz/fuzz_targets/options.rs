//! The options of the program: any words are a command, or a message without control characters says why not.
//!
//! The words of the command line are the lines of the input.

#![no_main]

use clap::Parser as _;
use libfuzzer_sys::fuzz_target;

/// The files of the program that read a command line.
#[path = "../../crates/lookat/src"]
#[allow(dead_code, unused_imports)]
mod program {
    pub mod args;
    pub mod metric;
    pub mod visible;
    pub mod usage {
        pub mod tips;
    }
}
use program::usage::tips;
use program::{args, metric, visible};

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data);
    let typed: Vec<String> = ["lookat"].into_iter().chain(text.lines()).map(visible::visible).collect();
    if let Err(error) = args::Arguments::try_parse_from(&typed) {
        let shown = tips::with_tips(error, &typed).to_string();
        assert!(!shown.is_empty() && !shown.contains(|c| c != '\n' && visible::is_active(c)), "{shown:?}");
    }
});
