//! Rectangles of pixels, and how a picture is cut into tiles.

use std::ops::Range;

use lookat_scene::PixelBounds;

/// A rectangle of pixels, y down: `x0 <= x < x1`, `y0 <= y < y1`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Area {
    pub x0: i32,
    pub y0: i32,
    pub x1: i32,
    pub y1: i32,
}

impl Area {
    pub fn of(PixelBounds { x0, y0, x1, y1 }: PixelBounds) -> Area {
        let [x0, y0, x1, y1] = [x0, y0, x1, y1].map(u32::cast_signed);
        Area { x0, y0, x1, y1 }
    }

    pub fn width(self) -> usize {
        self.x1.saturating_sub(self.x0).max(0) as usize
    }

    pub fn height(self) -> usize {
        self.y1.saturating_sub(self.y0).max(0) as usize
    }

    /// The number of its pixels.
    pub fn size(self) -> usize {
        self.width() * self.height()
    }

    /// The pixels of the area, row by row.
    pub fn pixels(self) -> impl Iterator<Item = [i32; 2]> {
        (self.y0..self.y1).flat_map(move |y| (self.x0..self.x1).map(move |x| [x, y]))
    }

    pub fn contains(self, [x, y]: [i32; 2]) -> bool {
        (self.x0..self.x1).contains(&x) && (self.y0..self.y1).contains(&y)
    }

    pub fn pixel(self, at: usize) -> [i32; 2] {
        [self.x0 + (at % self.width()) as i32, self.y0 + (at / self.width()) as i32]
    }

    /// The index of a pixel in the area, row by row.
    pub fn index(self, [x, y]: [i32; 2]) -> usize {
        (y - self.y0) as usize * self.width() + (x - self.x0) as usize
    }

    /// The squares of a grid that it has pixels of, whole and row by row. The grid is aligned to the full picture.
    pub fn squares(self, side: i32) -> impl Iterator<Item = Area> {
        let [columns, rows] = self.grid(side);
        rows.flat_map(move |row| columns.clone().map(move |column| (column * side, row * side)))
            .map(move |(x0, y0)| Area { x0, y0, x1: x0 + side, y1: y0 + side })
    }

    /// The number among these squares of the one that a pixel is in.
    #[inline(always)]
    pub fn square_of(self, side: i32, [x, y]: [i32; 2]) -> usize {
        let [columns, rows] = self.grid(side);
        let (column, row) = (x.div_euclid(side) - columns.start, y.div_euclid(side) - rows.start);
        (row * (columns.end - columns.start) + column) as usize
    }

    /// The columns and rows of a grid that it has pixels of.
    #[inline(always)]
    fn grid(self, side: i32) -> [Range<i32>; 2] {
        let range = |from: i32, to: i32| from.div_euclid(side)..(to - 1).div_euclid(side) + 1;
        [range(self.x0, self.x1), range(self.y0, self.y1)]
    }

    /// The area with so many more pixels on each side.
    pub fn grown(self, [x, y]: [u32; 2]) -> Area {
        let [x, y] = [x, y].map(u32::cast_signed);
        Area { x0: self.x0 - x, y0: self.y0 - y, x1: self.x1 + x, y1: self.y1 + y }
    }

    pub fn intersection(self, other: Area) -> Area {
        Area {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }
}

/// Pixels on a side of the tiles of a crop window: fewer where it is small, so that all threads have some.
pub(super) fn tile_side(crop: Area) -> i32 {
    const FEWEST: usize = 64;
    [16, 8].into_iter().find(|side| crop.size() >= FEWEST * side * side).map_or(4, |side| side as i32)
}

/// Cuts an area into tiles, row by row.
pub(super) fn tiles(area: Area, side: i32) -> impl Iterator<Item = Area> {
    area.squares(side).map(move |square| square.intersection(area))
}

/// Copies the values of the pixels that two areas share, from `other` into `own`. Does nothing if `from` is empty.
pub(super) fn copy<T: Copy + Default>(from: &[T], into: &mut Vec<T>, [own, other]: [Area; 2]) {
    if from.is_empty() {
        return;
    }
    into.resize(own.size(), T::default());
    let both = own.intersection(other);
    for y in (both.y0..both.y1).filter(|_| both.width() > 0) {
        let [own, other] = [own, other].map(|area| area.index([both.x0, y]));
        into[own..][..both.width()].copy_from_slice(&from[other..][..both.width()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_an_area_once() {
        for (x1, y1) in [(70, 24), (6, 8), (6, 2000), (133, 135), (5, 7)] {
            let area = Area { x0: -5, y0: -7, x1, y1 };
            let size: usize = tiles(area, 8).map(Area::size).sum();
            assert_eq!(size, area.size());
        }
    }
}
