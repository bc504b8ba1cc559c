//! The grammar and its values: any bytes parse without a panic, and directives read back as they print.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../tests/promises.rs"]
#[allow(dead_code)]
mod promises;

fuzz_target!(|data: &[u8]| {
    promises::round_trip(data);
});
