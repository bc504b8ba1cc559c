//! Sixels: columns of six pixels, color by color, as in the VT330/VT340 Programmer Reference Manual, volume 2, chapter 14.

use super::drawing::{Drawing, put};

/// The levels of each color: 216 colors in all, of the 256 that most terminals have.
const LEVELS: u32 = 6;
const COLORS: u32 = LEVELS * LEVELS * LEVELS;

/// Thresholds of ordered dither (Bayer 1973), of 16.
const BAYER: [[u32; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// Appends a picture.
pub fn draw(drawing: &Drawing, out: &mut Vec<u8>) {
    let [width, height] = drawing.size;
    put(out, format_args!("\x1bP0;1;0q\"1;1;{width};{height}"));
    for color in 0..COLORS {
        let [r, g, b] =
            [color / LEVELS / LEVELS, color / LEVELS % LEVELS, color % LEVELS].map(|level| 20 * level);
        put(out, format_args!("#{color};2;{r};{g};{b}"));
    }
    let row = |(y, row): (usize, &[[u8; 3]])| -> Vec<u32> {
        row.iter().enumerate().map(|(x, pixel)| dithered(*pixel, x, y)).collect()
    };
    let rows: Vec<Vec<u32>> = drawing.pixels.chunks(width as usize).enumerate().map(row).collect();
    for (number, band) in rows.chunks(6).enumerate() {
        if number > 0 {
            put(out, '-');
        }
        // Of each color, the bits of its pixels in each column.
        let mut sixels = vec![Vec::new(); COLORS as usize];
        for (bit, row) in band.iter().enumerate() {
            for (x, color) in row.iter().enumerate() {
                let columns: &mut Vec<u8> = &mut sixels[*color as usize];
                columns.resize(width as usize, 0);
                columns[x] |= 1 << bit;
            }
        }
        for (color, columns) in sixels.iter().enumerate().filter(|(_, columns)| !columns.is_empty()) {
            put(out, format_args!("#{color}"));
            for run in columns.chunk_by(|a, b| a == b) {
                let sixel = char::from(0x3f + run[0]);
                match run.len() {
                    // The count is longer.
                    1..4 => run.iter().for_each(|_| put(out, sixel)),
                    count => put(out, format_args!("!{count}{sixel}")),
                }
            }
            put(out, '$');
        }
    }
    put(out, "\x1b\\");
}

/// The color of a pixel.
fn dithered(pixel: [u8; 3], x: usize, y: usize) -> u32 {
    let threshold = 2 * BAYER[y % 4][x % 4] + 1;
    pixel.into_iter().fold(0, |color, value| {
        // In 32nds of a level.
        let level = u32::from(value) * (LEVELS - 1) * 32 / 255;
        LEVELS * color + (level + threshold) / 32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Protocol;

    /// Decodes a picture as a terminal does.
    fn decoded(text: &str, [width, height]: [usize; 2]) -> Vec<[u32; 3]> {
        let (start, end) = (text.find('q').unwrap() + 1, text.rfind('\x1b').unwrap());
        let mut rest = text[start..end].strip_prefix(&format!("\"1;1;{width};{height}")).unwrap().to_owned();
        let numbers = |rest: &mut String| -> Vec<u32> {
            let end = rest.find(|c: char| !c.is_ascii_digit() && c != ';').unwrap_or(rest.len());
            let text: String = rest.drain(..end).collect();
            text.split(';').map(|number| number.parse().unwrap()).collect()
        };
        let (mut colors, mut color) = (std::collections::HashMap::new(), 0);
        let (mut x, mut y, mut out) = (0, 0, vec![[u32::MAX; 3]; width * height]);
        while !rest.is_empty() {
            match rest.remove(0) {
                '#' => match numbers(&mut rest)[..] {
                    [number] => color = number,
                    [number, 2, r, g, b] => drop(colors.insert(number, [r, g, b])),
                    _ => panic!("{rest}"),
                },
                c @ ('!' | '?'..='~') => {
                    let count = if c == '!' { numbers(&mut rest)[0] } else { 1 };
                    let sixel = if c == '!' { rest.remove(0) } else { c };
                    let bits = sixel as u8 - 0x3f;
                    for at in x..x + count as usize {
                        for bit in (0..6).filter(|bit| bits >> bit & 1 == 1) {
                            out[(y + bit) * width + at] = colors[&color];
                        }
                    }
                    x += count as usize;
                }
                '$' => x = 0,
                '-' => (x, y) = (0, y + 6),
                other => panic!("{other}"),
            }
        }
        out
    }

    #[test]
    fn sixels_have_the_colors_of_the_picture() {
        let size = [40, 20];
        let pixels: Vec<[u8; 3]> = (0..800).map(|at| [if at % 40 < 20 { 255 } else { 0 }, 102, 77]).collect();
        let mut out = Vec::new();
        draw(&Drawing { size, cells: [5, 2], pixels, id: 0, protocol: Protocol::Sixel }, &mut out);
        let found = decoded(&String::from_utf8(out).unwrap(), [40, 20]);
        let mean = |x: std::ops::Range<usize>, channel: usize| {
            let values =
                found.iter().enumerate().filter(|(at, _)| x.contains(&(at % 40))).map(|(_, it)| it[channel]);
            f64::from(values.sum::<u32>()) / 400.0
        };
        // In percent. Levels are exact, and dither gives the others on average.
        assert_eq!([mean(0..20, 0), mean(20..40, 0), mean(0..20, 1)], [100.0, 0.0, 40.0]);
        assert!((mean(0..40, 2) / 2.0 - 100.0 * 77.0 / 255.0).abs() < 1.0, "{}", mean(0..40, 2));
    }
}
