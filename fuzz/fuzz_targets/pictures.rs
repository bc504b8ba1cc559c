//! Picture files of every format: any bytes are a picture of the size in its header, or a message says why not.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use lookat_image::{MemoryBudget, PictureFile};

/// Each format's first bytes. TGA has none.
const FORMATS: [(&[u8], &str); 6] = [
    (b"\x89PNG", "a.png"),
    (b"\xFF\xD8", "a.jpg"),
    (b"\x76\x2F\x31\x01", "a.exr"),
    (b"#?", "a.hdr"),
    (b"P", "a.pfm"),
    (b"", "a.tga"),
];

fuzz_target!(|data: &[u8]| {
    let format = FORMATS.iter().find(|(magic, _)| data.starts_with(magic));
    let path = Path::new(format.map_or("a.tga", |(_, path)| path));
    let budget = MemoryBudget::new(1 << 26);
    let Ok(file) = PictureFile::of_bytes(path, data, &budget) else { return };
    let window = file.placement().data_window;
    if let Ok((image, _)) = file.read() {
        assert_eq!(image.data_window, window);
        assert!(image.channels.iter().all(|channel| channel.samples.len() as u64 == window.area()));
    }
});
