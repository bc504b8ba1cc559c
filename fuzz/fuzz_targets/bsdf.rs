//! Tables of `fourier`: any bytes are a BSDF, or a message says why not.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lookat_fuzz::check_file;

fuzz_target!(|data: &[u8]| check_file(
    r#"WorldBegin Material "fourier" "string bsdffile" "paint.bsdf" Shape "sphere" WorldEnd"#,
    data
));
