//! Control sequences that draw a picture in a terminal: the protocols of kitty and iTerm2, sixels, and half blocks.

use std::fmt::Display;
use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::args::Protocol;

/// A picture as it is drawn.
pub struct Drawing {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Columns and lines of the terminal.
    pub cells: [u32; 2],
    /// On the sRGB curve, row by row.
    pub pixels: Vec<[u8; 3]>,
    /// The number of the picture.
    pub id: u32,
    pub protocol: Protocol,
}

/// The best protocol that a terminal is known to have, by its environment variables. A terminal is not asked: its
/// answer would mix with what the user types.
pub fn known(variable: &impl Fn(&str) -> Option<String>) -> Protocol {
    let of = |name: &str| variable(name).unwrap_or_default();
    let (term, program) = (of("TERM"), of("TERM_PROGRAM"));
    let term_has = |names: &[&str]| names.iter().any(|name| term.contains(name));
    // Multiplexers pass no pictures on.
    if variable("TMUX").is_some() || variable("STY").is_some() || term_has(&["screen", "tmux"]) {
        return Protocol::Blocks;
    }
    if ["iTerm.app", "WezTerm", "mintty"].contains(&program.as_str()) || of("LC_TERMINAL") == "iTerm2" {
        return Protocol::Iterm;
    }
    let is_kitty = ["KITTY_WINDOW_ID", "KONSOLE_VERSION"].iter().any(|name| variable(name).is_some());
    if is_kitty || program == "ghostty" || term_has(&["kitty", "ghostty"]) {
        return Protocol::Kitty;
    }
    if variable("WT_SESSION").is_some() || term_has(&["sixel", "foot", "mlterm", "contour"]) {
        Protocol::Sixel
    } else {
        Protocol::Blocks
    }
}

impl Drawing {
    /// What draws the picture over a drawing of so many lines that ends above the cursor. The cursor ends on the line below.
    pub fn over(&self, lines: u32) -> Vec<u8> {
        let mut out = Vec::new();
        if lines > 0 {
            put(&mut out, format_args!("\x1b[{lines}A\r"));
        }
        if lines != self.cells[1] {
            put(&mut out, "\x1b[J");
        }
        self.draw(&mut out);
        out
    }

    /// Appends what draws the picture. The cursor ends on the line below.
    fn draw(&self, out: &mut Vec<u8>) {
        if let Protocol::Blocks | Protocol::Auto = self.protocol {
            let has_true_color =
                std::env::var("COLORTERM").is_ok_and(|it| it == "truecolor" || it == "24bit");
            return self.blocks(has_true_color, out);
        }
        let lines = self.cells[1];
        // Makes room, then draws from the first line.
        out.extend(std::iter::repeat_n(b'\n', lines as usize));
        put(out, format_args!("\x1b[{lines}A\x1b7"));
        match self.protocol {
            Protocol::Kitty => self.kitty(out),
            Protocol::Iterm => self.iterm(out),
            _ => self.sixels(out),
        }
        put(out, format_args!("\x1b8\x1b[{lines}B\r"));
    }

    /// Two pixels per character: the text color shows the upper one, the background color the lower one.
    fn blocks(&self, has_true_color: bool, out: &mut Vec<u8>) {
        let color = |[r, g, b]: [u8; 3]| {
            if has_true_color { format!("2;{r};{g};{b}") } else { format!("5;{}", color_of_256([r, g, b])) }
        };
        let width = self.size[0] as usize;
        for lines in self.pixels.chunks(2 * width) {
            let (upper, lower) = lines.split_at(width);
            for (column, pixel) in upper.iter().enumerate() {
                let below = lower.get(column).map_or("49".into(), |pixel| format!("48;{}", color(*pixel)));
                put(out, format_args!("\x1b[38;{};{below}m▀", color(*pixel)));
            }
            put(out, "\x1b[0m\n");
        }
    }

    /// The graphics protocol of kitty: <https://sw.kovidgoyal.net/kitty/graphics-protocol>. The same number replaces
    /// the picture; `q=2` asks for no answer, `C=1` leaves the cursor.
    fn kitty(&self, out: &mut Vec<u8>) {
        let ([width, height], [columns, lines]) = (self.size, self.cells);
        let text = STANDARD.encode(self.pixels.as_flattened());
        let mut keys = format!("a=T,f=24,s={width},v={height},c={columns},r={lines},i={},q=2,C=1,", self.id);
        let mut chunks = text.as_bytes().chunks(4096).peekable();
        while let Some(chunk) = chunks.next() {
            put(out, format_args!("\x1b_G{keys}m={};", u8::from(chunks.peek().is_some())));
            out.extend_from_slice(chunk);
            put(out, "\x1b\\");
            keys.clear();
        }
    }

    /// An inline picture of iTerm2: <https://iterm2.com/documentation-images.html>.
    fn iterm(&self, out: &mut Vec<u8>) {
        let Some(file) = self.png() else { return };
        let [columns, lines] = self.cells;
        put(
            out,
            format_args!(
                "\x1b]1337;File=inline=1;size={};width={columns};height={lines};preserveAspectRatio=1;doNotMoveCursor=1:{}\x07",
                file.len(),
                STANDARD.encode(&file)
            ),
        );
    }

    /// Sixels: columns of six pixels, color by color, as in the VT330/VT340 Programmer Reference Manual, volume 2, chapter 14.
    fn sixels(&self, out: &mut Vec<u8>) {
        let [width, height] = self.size;
        put(out, format_args!("\x1bP0;1;0q\"1;1;{width};{height}"));
        for color in 0..COLORS {
            let [r, g, b] =
                [color / LEVELS / LEVELS, color / LEVELS % LEVELS, color % LEVELS].map(|level| 20 * level);
            put(out, format_args!("#{color};2;{r};{g};{b}"));
        }
        let row = |(y, row): (usize, &[[u8; 3]])| -> Vec<u32> {
            row.iter().enumerate().map(|(x, pixel)| dithered(*pixel, x, y)).collect()
        };
        let rows: Vec<Vec<u32>> = self.pixels.chunks(width as usize).enumerate().map(row).collect();
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
                        short @ 1..4 => put(out, sixel.to_string().repeat(short)),
                        count => put(out, format_args!("!{count}{sixel}")),
                    }
                }
                put(out, '$');
            }
        }
        put(out, "\x1b\\");
    }

    fn png(&self) -> Option<Vec<u8>> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        encoder.write_header().ok()?.write_image_data(self.pixels.as_flattened()).ok()?;
        Some(file)
    }
}

/// Appends a text.
fn put(out: &mut Vec<u8>, text: impl Display) {
    let _ = write!(out, "{text}");
}

/// The nearest color of the cube of xterm's 256 colors.
fn color_of_256(color: [u8; 3]) -> u32 {
    const LEVELS: [u8; 6] = [0, 95, 135, 175, 215, 255];
    let level = |value: u8| (0..6).min_by_key(|level| LEVELS[*level as usize].abs_diff(value)).unwrap_or(0);
    color.into_iter().fold(0, |index, value| 6 * index + level(value)) + 16
}

/// The levels of each color: 216 colors in all, of the 256 that most terminals have.
const LEVELS: u32 = 6;
const COLORS: u32 = LEVELS * LEVELS * LEVELS;

/// Thresholds of ordered dither (Bayer 1973), of 16.
const BAYER: [[u32; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

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

    const COLORS: [[u8; 3]; 6] =
        [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [1, 2, 3], [250, 251, 252]];

    /// A picture of 2 by 3 pixels.
    fn drawing(protocol: Protocol) -> Drawing {
        Drawing { size: [2, 3], cells: [2, 2], pixels: COLORS.to_vec(), id: 9, protocol }
    }

    fn drawn(protocol: Protocol) -> String {
        let mut out = Vec::new();
        drawing(protocol).draw(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn half_blocks_have_the_colors_of_two_pixels() {
        let mut out = Vec::new();
        drawing(Protocol::Blocks).blocks(true, &mut out);
        let expected = "\x1b[38;2;255;0;0;48;2;0;0;255m▀\x1b[38;2;0;255;0;48;2;255;255;0m▀\x1b[0m\n\
            \x1b[38;2;1;2;3;49m▀\x1b[38;2;250;251;252;49m▀\x1b[0m\n";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
        let mut out = Vec::new();
        drawing(Protocol::Blocks).blocks(false, &mut out);
        let first =
            "\x1b[38;5;196;48;5;21m▀\x1b[38;5;46;48;5;226m▀\x1b[0m\n\x1b[38;5;16;49m▀\x1b[38;5;231;49m▀";
        assert!(String::from_utf8(out).unwrap().starts_with(first));
    }

    #[test]
    fn kitty_gets_the_pixels_in_chunks() {
        let text = drawn(Protocol::Kitty);
        let expected = format!(
            "\n\n\x1b[2A\x1b7\x1b_Ga=T,f=24,s=2,v=3,c=2,r=2,i=9,q=2,C=1,m=0;{}\x1b\\\x1b8\x1b[2B\r",
            STANDARD.encode(COLORS.as_flattened())
        );
        assert_eq!(text, expected);
        let mut out = Vec::new();
        let pixels = vec![[1, 2, 3]; 10_000];
        Drawing { size: [100, 100], cells: [9, 9], pixels, id: 1, protocol: Protocol::Kitty }.kitty(&mut out);
        let text = String::from_utf8(out).unwrap();
        let parts: Vec<&str> = text.split_terminator("\x1b\\").collect();
        assert!(
            parts[1].starts_with("\x1b_Gm=1;") && parts[9].starts_with("\x1b_Gm=0;") && parts.len() == 10
        );
        let data: String = parts.iter().map(|part| part.split_once(';').unwrap().1).collect();
        assert_eq!(STANDARD.decode(data).unwrap(), [[1, 2, 3]; 10_000].as_flattened());
    }

    #[test]
    fn iterm_gets_a_png_file() {
        let text = drawn(Protocol::Iterm);
        let start = text.find("\x1b]1337;File=inline=1;").unwrap();
        let (_, data) = text[start..text.find('\x07').unwrap()].split_once(':').unwrap();
        let file = STANDARD.decode(data).unwrap();
        assert!(text.contains(&format!("size={};width=2;height=2;", file.len())));
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, COLORS.as_flattened());
    }

    #[test]
    fn terminals_are_known_by_their_variables() {
        let of = |variables: &[(&str, &str)]| {
            known(&|name: &str| {
                variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.to_string())
            })
        };
        assert_eq!(of(&[("TERM", "xterm-256color")]), Protocol::Blocks);
        assert_eq!(of(&[("TERM", "xterm-kitty")]), Protocol::Kitty);
        assert_eq!(of(&[("TERM", "xterm-256color"), ("TERM_PROGRAM", "ghostty")]), Protocol::Kitty);
        assert_eq!(of(&[("TERM", "screen-256color"), ("KITTY_WINDOW_ID", "1")]), Protocol::Blocks);
        assert_eq!(of(&[("TERM_PROGRAM", "iTerm.app")]), Protocol::Iterm);
        assert_eq!(of(&[("LC_TERMINAL", "iTerm2")]), Protocol::Iterm);
        assert_eq!(of(&[("TERM", "foot")]), Protocol::Sixel);
        assert_eq!(of(&[("WT_SESSION", "1")]), Protocol::Sixel);
        assert_eq!(of(&[]), Protocol::Blocks);
    }

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
        Drawing { size, cells: [5, 2], pixels, id: 0, protocol: Protocol::Sixel }.sixels(&mut out);
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
