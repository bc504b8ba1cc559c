//! The places of everything.

use super::parts::{LEAST, Zoom};
use super::text::Font;

/// In pixels. A part is a picture and what is written above and below it; parts count from 0, from the left.
#[derive(Debug)]
pub(super) struct Layout {
    pub zoom: Zoom,
    /// The size of a picture as it is shown.
    pub picture: [usize; 2],
    /// The width of a part, which is more than that of a narrow picture.
    pub column: usize,
    pub title: Font,
    pub text: Font,
}

impl Layout {
    pub fn of(width: usize, height: usize) -> Layout {
        let zoom = Zoom::of(width, height);
        let picture = [width, height].map(|size| size.div_ceil(zoom.down) * zoom.up);
        let column = picture[0].max(LEAST);
        // A wide figure is made smaller to fit a page, and its letters too.
        let (title, text) = match column {
            0..480 => (20, 16),
            480..900 => (24, 20),
            _ => (32, 24),
        };
        Layout { zoom, picture, column, title: Font(title), text: Font(text) }
    }

    /// The empty space around all, and between parts.
    pub fn margin(&self) -> usize {
        self.text.height() * 5 / 4
    }

    /// Where a part begins.
    pub fn left(&self, part: usize) -> usize {
        self.margin() + part * (self.column + self.margin())
    }

    /// Where pictures begin, below two lines.
    pub fn top(&self) -> usize {
        self.margin() + self.title.height() + self.text.height() * 3 / 2
    }

    /// Where a line below the pictures begins.
    pub fn line(&self, line: usize) -> usize {
        self.top() + self.picture[1] + self.text.height() / 2 + line * self.text.height()
    }

    /// The width and height of the figure.
    pub fn size(&self) -> [usize; 2] {
        [self.left(3), self.line(3) + self.margin()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_figure_is_too_small_or_too_large() {
        let most = Layout::of(1280, 1280).size();
        assert_eq!(most, [3960, 1492]);
        let sizes =
            [(1, 1), (8, 6), (1281, 3), (1, 5000), (5000, 1), (1 << 28, 1), (1, 1 << 28), (16_384, 16_384)];
        for (width, height) in sizes {
            let size = Layout::of(width, height).size();
            assert!(
                size[0] >= 800 && size[0] <= most[0] && size[1] <= most[1],
                "{width} x {height}: {size:?}"
            );
        }
    }

    #[test]
    fn parts_are_side_by_side() {
        let layout = Layout::of(100, 50);
        assert_eq!((layout.picture, layout.column), ([300, 150], 300));
        assert_eq!([0, 1, 2].map(|part| layout.left(part)), [20, 340, 660]);
        assert_eq!(layout.size(), [980, 64 + 150 + 8 + 3 * 16 + 20]);
        // A narrow picture leaves room for the text.
        assert_eq!((Layout::of(1, 5000).picture, Layout::of(1, 5000).column), ([1, 1250], 256));
    }
}
