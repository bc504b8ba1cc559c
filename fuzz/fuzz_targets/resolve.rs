//! The meaning of a scene: any text is a valid scene, or its diagnostics say why not.
//!
//! The input is the scene file. Its includes are parts of the input: the digits of the name give the first byte of the
//! part. Meshes, pictures and spectrum files are missing: they have targets of their own.

#![no_main]

use std::cell::Cell;
use std::io::{Error, ErrorKind};
use std::path::Path;

use libfuzzer_sys::fuzz_target;
use lookat_fuzz::check_scene;

/// Enough for files that include each other, few enough to stay fast.
const MOST_READS: usize = 10;

fuzz_target!(|data: &[u8]| {
    let reads = Cell::new(0);
    let read = |path: &Path| {
        reads.set(reads.get() + 1);
        if reads.get() == 1 {
            return Ok(data.to_vec());
        }
        let name = path.as_os_str().as_encoded_bytes();
        let digits = name.iter().filter(|byte| byte.is_ascii_digit());
        let start = digits.fold(0_usize, |n, digit| (n * 10 + usize::from(digit - b'0')) % 100_000);
        match data.get(start..) {
            Some(part) if reads.get() <= MOST_READS && !name.contains(&b'.') => Ok(part.to_vec()),
            _ => Err(Error::from(ErrorKind::NotFound)),
        }
    };
    check_scene(&read);
});
