//! Spectrum files: any bytes are a color, or a message says why not.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../one_file.rs"]
mod one_file;

fuzz_target!(|data: &[u8]| {
    one_file::load(r#"WorldBegin LightSource "point" "spectrum I" "lamp.spd" WorldEnd"#, data);
});
