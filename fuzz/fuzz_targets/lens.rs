//! Lens files: any bytes are a lens, or a message says why not.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lookat_fuzz::check_file;

fuzz_target!(|data: &[u8]| check_file(
    r#"Camera "realistic" "string lensfile" "lens.dat" WorldBegin WorldEnd"#,
    data
));
