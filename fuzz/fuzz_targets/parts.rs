//! The sums of parts and checkpoints: any bytes of a header with any integers are sums, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lookat_image::IntegerChannel;
use lookat_render::{FilmSums, SumsHeader};

/// The most pixels: more only take longer.
const MOST: u64 = 4096;

fuzz_target!(|data: &[u8]| {
    let Some((length, data)) = data.split_first() else { return };
    let (header, words) = data.split_at(data.len().min(usize::from(*length)));
    let Ok(header) = SumsHeader::from_bytes(header) else { return };
    let crop = header.film.crop;
    let size = u64::from(crop.x1.saturating_sub(crop.x0)) * u64::from(crop.y1.saturating_sub(crop.y0));
    let mut words = words.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).cycle();
    let mut channels = Vec::new();
    for kind in ["sums", "splats"] {
        for color in ["R", "G", "B", "weight"] {
            for word in 0..4 {
                let samples = (0..size.min(MOST)).map(|_| words.next().unwrap_or(0)).collect();
                channels.push(IntegerChannel { name: format!("{kind}.{color}.{word}"), samples });
            }
        }
    }
    if let Ok(mut sums) = FilmSums::from_channels(header, &channels) {
        sums.image();
        let other = sums.clone();
        let _ = sums.add(&other);
        sums.to_channels();
    }
});
