//! Portable FloatMap files: three lines of text, then the numbers, bottom row first.

use std::io::{BufRead, Read, Write};

use crate::format::Opened;
use crate::image::{Pixels, Placement};
use crate::{Channel, Image, ImageFault, MemoryBudget, Window};

/// Writes little-endian numbers: three for each pixel ("PF") or one ("Pf").
pub(crate) fn write(image: &Image, out: &mut impl Write) -> Result<(), ImageFault> {
    let planes = image.visible_planes()?;
    let Window { width, height, .. } = image.data_window;
    let magic = if planes.len() == 3 { "PF" } else { "Pf" };
    // The sign of the scale says little-endian.
    write!(out, "{magic}\n{width} {height}\n-1.0\n")?;
    let width = width as usize;
    for y in (0..height as usize).rev() {
        for i in y * width..(y + 1) * width {
            for plane in &planes {
                out.write_all(&plane[i].to_le_bytes())?;
            }
        }
    }
    Ok(())
}

/// Reads the header. The sign of the scale is the byte order, and the numbers are multiplied by its magnitude, as in pbrt-v3.
pub(crate) fn open<'a>(mut file: impl BufRead + 'a) -> Result<Opened<'a>, ImageFault> {
    let names: &[&str] = match word(&mut file)?.as_str() {
        "PF" => &["R", "G", "B"],
        "Pf" => &["Y"],
        _ => return Err(ImageFault::WrongFormat(None)),
    };
    let (width, height) = (number(&mut file, "width")?, number(&mut file, "height")?);
    let scale: f32 = number(&mut file, "scale")?;
    if !scale.is_finite() || scale == 0.0 {
        return Err(ImageFault::Damaged(format!("its scale is {scale}")));
    }
    let placement = Placement::alone(Window { x: 0, y: 0, width, height }.not_empty()?);
    let read = move |memory: &MemoryBudget, _: bool| {
        let row_bytes = 4 * names.len() * width as usize;
        let charge = placement.data_window.reserve(4 * names.len() as u64, row_bytes as u64, memory)?;
        let decode = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
        let blank = |name: &&str| Channel::blank(name, placement.data_window.area() as usize);
        let mut channels = names.iter().map(blank).collect::<Result<Vec<_>, _>>()?;
        let mut row = vec![0; row_bytes];
        for y in (0..height as usize).rev() {
            file.read_exact(&mut row)?;
            for (i, channel) in channels.iter_mut().enumerate() {
                let values = row.as_chunks().0.iter().skip(i).step_by(names.len());
                for (sample, four) in channel.samples[y * width as usize..].iter_mut().zip(values) {
                    *sample = decode(*four) * scale.abs();
                }
            }
        }
        Ok((Pixels::Values(Image::new(placement, channels)), charge))
    };
    Ok(Opened { placement, metadata: None, channels_of_bytes: None, read: Box::new(read) })
}

/// The characters up to the next white space, which is consumed.
fn word(file: &mut impl BufRead) -> Result<String, ImageFault> {
    // No word of a header is longer; a file of another kind may go on without any white space.
    const LONGEST: usize = 32;
    let mut word = String::new();
    for byte in file.bytes().take(LONGEST) {
        match byte? {
            byte if byte.is_ascii_whitespace() => return Ok(word),
            byte => word.push(char::from(byte)),
        }
    }
    Ok(word)
}

fn number<T: std::str::FromStr>(file: &mut impl BufRead, what: &str) -> Result<T, ImageFault> {
    let word = word(file)?;
    word.parse().map_err(|_| ImageFault::Damaged(format!("its {what} is {word:?}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_bytes(bytes: &[u8]) -> Result<Image, String> {
        open(bytes)
            .and_then(|file| (file.read)(&MemoryBudget::new(1 << 30), false))
            .map(|(pixels, _)| pixels.into())
            .map_err(|fault| format!("{fault:?}"))
    }

    #[test]
    fn keeps_the_bits() {
        let window = Window { x: 0, y: 0, width: 2, height: 2 };
        let pixels = [[0.0, -1.5, 1e-40], [f32::MAX, f32::INFINITY, 0.1], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let color = Image { has_windows: false, ..Image::from_rgb(window, window, &pixels) };
        let mut gray = color.clone();
        gray.channels.truncate(1);
        gray.channels[0].name = "Y".into();
        for (image, start) in [(color, "PF\n2 2\n-1.0\n"), (gray, "Pf\n2 2\n-1.0\n")] {
            let mut bytes = Vec::new();
            write(&image, &mut bytes).unwrap();
            assert!(bytes.starts_with(start.as_bytes()));
            assert_eq!(read_bytes(&bytes).unwrap(), image);
        }
    }

    #[test]
    fn begins_with_the_bottom_row() {
        let bytes = [b"Pf 1 2 2.0\n".as_slice(), &3.0f32.to_be_bytes(), &5.0f32.to_be_bytes()].concat();
        assert_eq!(read_bytes(&bytes).unwrap().channel("Y"), Some([10.0, 6.0].as_slice()));
    }

    #[test]
    fn refuses_what_it_cannot_trust() {
        let check = |bytes: &[u8], expected: &str| {
            let error = read_bytes(bytes).unwrap_err();
            assert!(error.contains(expected), "{error}");
        };
        check(b"", "WrongFormat");
        check(b"P6\n1 1\n255\n...", "WrongFormat");
        check(&[0xff; 100], "WrongFormat");
        check(b"PF\n", "its width is");
        check(b"PF\n-1 1\n-1\n", "its width is");
        check(b"PF\n1 1\n0\n", "its scale is");
        check(b"PF\n0 1\n-1\n", "no pixels");
        check(b"PF\n4294967295 4294967295\n-1\n", "TooLarge");
        check(b"PF\n16384 16384\n-1\n1234", "TooLarge");
        check(b"PF\n8192 8192\n-1\n1234", "ends too early");
        check(b"Pf\n1 1\n-1\n123", "ends too early");
    }
}
