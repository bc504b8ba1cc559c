//! The grammar and its values: any bytes parse without a panic, and directives read back as they print.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lookat_fuzz::promises::round_trip;

fuzz_target!(|data: &[u8]| {
    round_trip(data);
});
