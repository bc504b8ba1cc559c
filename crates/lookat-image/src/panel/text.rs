//! Letters. A character that the font lacks is shown as a question mark.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::canvas::Canvas;
use super::colors::mix;

const WEIGHT: FontWeight = FontWeight::Regular;

/// All letters of a size are equally wide.
#[derive(Debug, Clone, Copy)]
pub(super) struct Font(pub RasterHeight);

impl Font {
    /// The height of a line, in pixels.
    pub fn height(self) -> usize {
        self.0.val()
    }

    /// The width of a text, in pixels.
    pub fn width(self, text: &str) -> usize {
        text.chars().count() * get_raster_width(WEIGHT, self.0)
    }

    /// Draws one line of text with its upper left corner at a place.
    pub fn draw(self, canvas: &mut Canvas, [x, y]: [usize; 2], text: &str, color: [u8; 3]) {
        let letters = text.chars().map(|c| get_raster(c, WEIGHT, self.0).or(get_raster('?', WEIGHT, self.0)));
        for (i, letter) in letters.flatten().enumerate() {
            for (dy, cover) in letter.rows().enumerate() {
                let pixels = canvas.row(x + i * letter.width(), y + dy, letter.width());
                for (pixel, &cover) in pixels.iter_mut().zip(cover) {
                    *pixel = std::array::from_fn(|c| mix(pixel[c], color[c], f64::from(cover) / 255.0));
                }
            }
        }
    }

    /// The text, with "..." in place of its middle if it is wider than `width` pixels.
    pub fn fit(self, text: &str, width: usize) -> String {
        const DOTS: &str = "...";
        let letters: Vec<char> = text.chars().collect();
        let room = width / get_raster_width(WEIGHT, self.0);
        if letters.len() <= room {
            return text.into();
        }
        let kept = room.saturating_sub(DOTS.len());
        let (start, end) = (&letters[..kept / 2], &letters[letters.len() - kept.div_ceil(2)..]);
        start.iter().copied().chain(DOTS.chars()).chain(end.iter().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FONT: Font = Font(RasterHeight::Size16);

    fn drawn(text: &str) -> Canvas {
        let mut canvas = Canvas::new(50, 16, [255; 3]);
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
