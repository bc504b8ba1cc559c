//! Names beside marks, where nothing else is.

use std::ops::Range;

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy)]
struct Rectangle {
    x: [i32; 2],
    y: [i32; 2],
}

/// What is taken.
pub(super) struct Labels {
    bounds: Rectangle,
    taken: Vec<Rectangle>,
}

impl Rectangle {
    /// The area that both have, in pixels.
    fn overlap(&self, other: &Rectangle) -> i64 {
        let common = |a: [i32; 2], b: [i32; 2]| i64::from((a[1].min(b[1]) - a[0].max(b[0])).max(0));
        common(self.x, other.x) * common(self.y, other.y)
    }
}

impl Labels {
    /// Within these pixels.
    pub fn new(x: Range<i32>, y: Range<i32>) -> Labels {
        let bounds = Rectangle { x: [x.start, x.end], y: [y.start, y.end] };
        Labels { bounds, taken: Vec::new() }
    }

    /// Keeps labels off a mark.
    pub fn avoid(&mut self, (x, y): (i32, i32), radius: i32) {
        self.taken.push(Rectangle { x: [x - radius, x + radius], y: [y - radius, y + radius] });
    }

    /// The upper left corner of a label of this size beside its mark: the place that hides least, the nearest of those.
    pub fn place(&mut self, (x, y): (i32, i32), (width, height): (i32, i32), gap: i32) -> (i32, i32) {
        let around = |gap: i32| {
            let (left, right, above, below, middle) = (-gap - width, gap, -gap - height, gap, -height / 2);
            let center = -width / 2;
            let beside = [[right, middle], [left, middle], [center, above], [center, below]];
            let corners = [[right, above], [right, below], [left, above], [left, below]];
            beside.into_iter().chain(corners)
        };
        let at = |offset: [i32; 2]| {
            let (left, top) = (x + offset[0], y + offset[1]);
            Rectangle { x: [left, left + width], y: [top, top + height] }
        };
        let hidden = |offset: &[i32; 2]| {
            let label = at(*offset);
            let outside = label.overlap(&label) - label.overlap(&self.bounds);
            10 * outside + self.taken.iter().map(|taken| label.overlap(taken)).sum::<i64>()
        };
        let places = [1, 2, 4, 6].into_iter().flat_map(|times| around(times * gap));
        let best = places.min_by_key(hidden).unwrap_or([gap, 0]);
        self.taken.push(at(best));
        (x + best[0], y + best[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_overlap() {
        let mut labels = Labels::new(0..400, 0..300);
        let marks = [(200, 150), (204, 152), (196, 148), (399, 1), (0, 299)];
        marks.iter().for_each(|mark| labels.avoid(*mark, 5));
        let marks_taken = labels.taken.len();
        for mark in marks {
            labels.place(mark, (60, 14), 8);
        }
        for (i, label) in labels.taken.iter().enumerate().skip(marks_taken) {
            assert_eq!(label.overlap(&labels.bounds), label.overlap(label), "{label:?} is cut");
            for other in &labels.taken[..i] {
                assert_eq!(label.overlap(other), 0, "{label:?} hides {other:?}");
            }
        }
    }
}
