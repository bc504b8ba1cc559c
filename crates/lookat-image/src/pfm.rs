//! Portable FloatMap files: three lines of text, then the numbers, bottom row first.

use std::io::{BufRead, Read};

use crate::error::Fault;
use crate::image::room;
use crate::{Channel, Charge, Image, MemoryBudget, Precision, Window};

/// Writes little-endian numbers: three for each pixel ("PF") or one ("Pf").
#[cfg(feature = "write")]
pub(crate) fn write(image: &Image, out: &mut impl std::io::Write) -> Result<(), Fault> {
    let planes = image.visible_planes()?;
    let Window { width, height, .. } = image.data_window;
    let kind = if planes.len() == 3 { "PF" } else { "Pf" };
    // The sign of the scale says little-endian.
    write!(out, "{kind}\n{width} {height}\n-1.0\n")?;
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

/// A file whose header is read.
pub(crate) struct Opened<F> {
    file: F,
    names: &'static [&'static str],
    pub window: Window,
    /// Its sign tells the byte order; its absolute value is multiplied in, as in pbrt.
    scale: f32,
}

/// Reads the header of either kind.
pub(crate) fn open<F: BufRead>(mut file: F) -> Result<Opened<F>, Fault> {
    let names: &[&str] = match word(&mut file)?.as_str() {
        "PF" => &["R", "G", "B"],
        "Pf" => &["Y"],
        _ => return Err(Fault::Foreign(None)),
    };
    let (width, height) = (number(&mut file, "width")?, number(&mut file, "height")?);
    let scale: f32 = number(&mut file, "scale")?;
    if !scale.is_finite() || scale == 0.0 {
        return Err(Fault::Damaged(format!("its scale is {scale}")));
    }
    Ok(Opened { file, names, window: Window { x: 0, y: 0, width, height }.not_empty()?, scale })
}

impl<F: BufRead> Opened<F> {
    /// Reads the numbers.
    pub fn read(mut self, memory: &MemoryBudget) -> Result<(Image, Charge), Fault> {
        let (kinds, width) = (self.names.len(), self.window.width as usize);
        let row_bytes = 4 * kinds * width;
        let charge = self.window.reserve(4 * kinds as u64, row_bytes as u64, memory)?;
        let decode = if self.scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
        let planes = (0..kinds).map(|_| room(self.window.area() as usize));
        let mut planes = planes.collect::<Result<Vec<_>, _>>()?;
        let mut row = vec![0; row_bytes];
        for _ in 0..self.window.height {
            self.file.read_exact(&mut row)?;
            let values = row.as_chunks().0;
            for (kind, plane) in planes.iter_mut().enumerate() {
                plane.extend(
                    values.iter().skip(kind).step_by(kinds).map(|&four| decode(four) * self.scale.abs()),
                );
            }
        }
        planes.iter_mut().for_each(|plane| turn_over(plane, width));
        let channels = self.names.iter().zip(planes);
        let channels = channels.map(|(name, samples)| Channel { name: name.to_string(), samples }).collect();
        let image = Image {
            data_window: self.window,
            display_window: self.window,
            channels,
            metadata: None,
            layers: Vec::new(),
            precision: Precision::Single,
            has_windows: false,
        };
        Ok((image, charge))
    }
}

/// Brings the last row of a plane to the first place.
fn turn_over(plane: &mut [f32], width: usize) {
    let (top, bottom) = plane.split_at_mut(plane.len() / width / 2 * width);
    top.chunks_exact_mut(width).zip(bottom.rchunks_exact_mut(width)).for_each(|(a, b)| a.swap_with_slice(b));
}

/// The characters up to the next white space, which is passed over.
fn word(file: &mut impl BufRead) -> Result<String, Fault> {
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

fn number<T: std::str::FromStr>(file: &mut impl BufRead, what: &str) -> Result<T, Fault> {
    let word = word(file)?;
    word.parse().map_err(|_| Fault::Damaged(format!("its {what} is {word:?}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_bytes(bytes: &[u8]) -> Result<Image, String> {
        open(bytes)
            .and_then(|file| file.read(&MemoryBudget::new(1 << 30)))
            .map(|(image, _)| image)
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
        check(b"", "Foreign");
        check(b"P6\n1 1\n255\n...", "Foreign");
        check(&[0xff; 100], "Foreign");
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
