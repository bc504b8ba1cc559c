//! Any bytes are read without a panic, and what is read keeps the reader's promises.
//!
//! The input is the scene file. The files that it names are parts of the input too: a number in the name says where the
//! part begins, so that the fuzzer can build included files and PLY files of its own.

#![no_main]

use std::cell::Cell;
use std::io::{Error, ErrorKind};
use std::path::Path;

use libfuzzer_sys::fuzz_target;

#[path = "../../tests/promises.rs"]
mod promises;

/// Enough for files that include each other, few enough to stay fast.
const MOST_READS: usize = 20;

fuzz_target!(|data: &[u8]| {
    let reads = Cell::new(0);
    let read = |path: &Path| {
        reads.set(reads.get() + 1);
        if reads.get() == 1 {
            return Ok(data.to_vec());
        }
        let name = path.as_os_str().as_encoded_bytes();
        let missing = Error::from(ErrorKind::NotFound);
        if reads.get() > MOST_READS || name.first() == Some(&b'-') {
            return Err(missing);
        }
        // PLY files begin where the text says so; others anywhere.
        let ply = data.windows(4).position(|window| window == b"ply\n" || window == b"ply\r");
        let digits = name.iter().filter(|byte| byte.is_ascii_digit());
        let number = digits.fold(0_usize, |n, digit| (n * 10 + usize::from(digit - b'0')) % 100_000);
        let start = if name.ends_with(b"ply") { ply.ok_or(missing)? } else { number.min(data.len()) };
        Ok(data[start..].to_vec())
    };
    promises::round_trip(data);
    promises::check(&lookat_scene::load(Path::new("scene.pbrt"), &read, &Default::default()));
});
