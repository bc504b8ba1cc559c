//! Pixels to draw on.

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

    pub fn height(&self) -> usize {
        self.pixels.len() / self.width
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
                target.zip(source).for_each(|(target, &color)| target.fill(color));
            }
        }
    }
}
