//! PLY files, in text and binary, plain and packed: any bytes are a mesh, or a message says why not.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../one_file.rs"]
mod one_file;

fuzz_target!(|data: &[u8]| {
    one_file::load(r#"WorldBegin Shape "plymesh" "string filename" "mesh.ply" WorldEnd"#, data);
});
