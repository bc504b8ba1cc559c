//! A picture to draw on, and letters. A character that the font lacks is shown as a question mark.

use ab_glyph::{Font as _, FontRef, GlyphId, PxScale, ScaleFont, point};

/// A picture in 8-bit sRGB.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Canvas {
    pub width: usize,
    /// Row by row, top row first.
    pub pixels: Vec<[u8; 3]>,
}

impl Canvas {
    pub fn new(width: usize, height: usize, color: [u8; 3]) -> Self {
        Canvas { width, pixels: vec![color; width * height] }
    }

    /// The part of row `y` from column `x` on that is `width` wide. What is beyond the right border is left
    /// out; the row must exist.
    pub fn row(&mut self, x: usize, y: usize, width: usize) -> &mut [[u8; 3]] {
        let start = x.min(self.width);
        let end = (start + width).min(self.width);
        &mut self.pixels[y * self.width..][start..end]
    }

    pub fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2], color: [u8; 3]) {
        for y in y..y + height {
            self.row(x, y, width).fill(color);
        }
    }

    /// Copies a picture, each pixel `times` as wide and as high.
    pub fn paste(&mut self, [x, y]: [usize; 2], picture: &Canvas, times: usize) {
        for (i, source) in picture.pixels.chunks_exact(picture.width).enumerate() {
            for y in y + i * times..y + (i + 1) * times {
                let target = self.row(x, y, picture.width * times).chunks_mut(times);
                for (target, &color) in target.zip(source) {
                    target.fill(color);
                }
            }
        }
    }
}

/// A size: the height of a line, in pixels. All letters of a size are equally wide.
#[derive(Debug, Clone, Copy)]
pub(super) struct Font(pub usize);

impl Font {
    /// The height of a line, in pixels.
    pub fn height(self) -> usize {
        self.0
    }

    /// The width of a text, in pixels.
    pub fn width(self, text: &str) -> usize {
        text.chars().count() * self.advance()
    }

    fn advance(self) -> usize {
        let font = letters();
        font.as_scaled(self.scale()).h_advance(font.glyph_id('m')).round() as usize
    }

    fn scale(self) -> PxScale {
        PxScale::from(self.0 as f32)
    }

    /// Draws one line of text with its upper left corner at a place.
    pub fn draw(self, canvas: &mut Canvas, [x, y]: [usize; 2], text: &str, color: [u8; 3]) {
        let font = letters();
        let (advance, ascent) = (self.advance(), font.as_scaled(self.scale()).ascent());
        for (i, letter) in text.chars().enumerate() {
            let id = match font.glyph_id(letter) {
                GlyphId(0) => font.glyph_id('?'),
                id => id,
            };
            let glyph = id.with_scale_and_position(self.scale(), point(0.0, ascent));
            let Some(outline) = font.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, cover| {
                let [dx, dy] = [dx as f32 + corner.x, dy as f32 + corner.y].map(|d| d.max(0.0) as usize);
                if let (true, [pixel]) =
                    (dy < self.0, canvas.row(x + i * advance + dx, y + dy.min(self.0 - 1), 1))
                {
                    *pixel = std::array::from_fn(|c| mix(pixel[c], color[c], f64::from(cover)));
                }
            });
        }
    }

    /// The text, with "..." in place of its middle if it is wider than `width` pixels.
    pub fn fit(self, text: &str, width: usize) -> String {
        const DOTS: &str = "...";
        let letters: Vec<char> = text.chars().collect();
        let room = width / self.advance();
        if letters.len() <= room {
            return text.into();
        }
        let kept = room.saturating_sub(DOTS.len());
        let (start, end) = (&letters[..kept / 2], &letters[letters.len() - kept.div_ceil(2)..]);
        start.iter().copied().chain(DOTS.chars()).chain(end.iter().copied()).collect()
    }
}

/// # Panics
///
/// If the font of the program is damaged; a test rules that out.
fn letters() -> FontRef<'static> {
    FontRef::try_from_slice(dejavu::sans_mono::regular()).expect("the font is whole")
}

/// `a` for the share 0, `b` for 1.
pub(super) fn mix(a: u8, b: u8, share: f64) -> u8 {
    (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    const FONT: Font = Font(16);

    fn drawn(text: &str) -> Canvas {
        let mut canvas = Canvas::new(58, 16, [255; 3]);
        FONT.draw(&mut canvas, [2, 0], text, [0; 3]);
        canvas
    }

    #[test]
    fn letters_that_are_lacking_are_question_marks() {
        assert_eq!(drawn("a\u{1f600}\n"), drawn("a??"));
        assert_ne!(drawn("\u{fc}"), drawn("?"));
        assert_ne!(drawn("?"), drawn(" "));
    }

    #[test]
    fn text_ends_at_the_border() {
        assert_eq!(drawn("abcdefghijklmnopq"), drawn("abcdefghijkl"));
    }

    #[test]
    fn long_texts_lose_their_middle() {
        let check = |text, letters: usize, expected| {
            assert_eq!(FONT.fit(text, FONT.width("x") * letters), expected);
        };
        check("picture.exr", 11, "picture.exr");
        check("picture.exr", 10, "pic....exr");
        check("picture.exr", 9, "pic...exr");
        check("k\u{fc}\u{fc}\u{fc}\u{fc}\u{fc}che", 7, "k\u{fc}...he");
        check("picture", 2, "...");
    }
}
