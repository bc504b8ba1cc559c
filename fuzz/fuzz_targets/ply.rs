//! PLY files, in text and binary, plain and packed: any bytes are a mesh, or a message says why not.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lookat_fuzz::check_file;

fuzz_target!(|data: &[u8]| check_file(
    r#"WorldBegin Shape "plymesh" "string filename" "mesh.ply" WorldEnd"#,
    data
));
