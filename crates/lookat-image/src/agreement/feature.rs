//! Features that one picture lacks, such as a small lamp: several pixels that are brighter by about the same amount.
//!
//! Light that samples rarely hit looks different. Where the expected picture has hit it a few times in each pixel, the numbers of hits
//! are Poisson distributed, and neighbors differ by about as much as they are bright. A filter spreads one hit over its footprint, but
//! unevenly: the darkest of 3 x 3 pixels has at most 2 % of the brightest one under the default `gaussian`, 25 % under `triangle`.
//! Where nine pixels agree within a third, each has about ten hits or more. Then the actual picture has hit this light, too, unless it
//! has less than a tenth of the samples; one hit in a tile is noise enough to hide the block.

/// Width and height of blocks of nine or ten pixels.
const BLOCKS: [[usize; 2]; 5] = [[3, 3], [5, 2], [2, 5], [9, 1], [1, 9]];
/// The least that the darkest pixel of a block has of the brightest one.
const SHARE: f64 = 2.0 / 3.0;

/// How much of the excess of each pixel of a picture belongs to a feature: the largest excess that all pixels of a block around it
/// have, if they agree; else 0. `excess` is 0 where noise explains it.
pub(super) fn levels(excess: &[f64], width: usize) -> Vec<f64> {
    let mut levels = vec![0.0_f64; excess.len()];
    let height = excess.len() / width;
    for [w, h] in BLOCKS {
        for first in starts(height, h).flat_map(|y| starts(width, w).map(move |x| y * width + x)) {
            let block = || (0..w * h).map(|i| first + i / w * width + i % w);
            if block().any(|pixel| excess[pixel] <= 0.0) {
                continue;
            }
            let least = block().fold(f64::INFINITY, |least, pixel| least.min(excess[pixel]));
            if block().all(|pixel| least >= SHARE * excess[pixel]) {
                block().for_each(|pixel| levels[pixel] = levels[pixel].max(least));
            }
        }
    }
    levels
}

/// Where blocks of some size begin.
fn starts(size: usize, block: usize) -> std::ops::Range<usize> {
    0..(size + 1).saturating_sub(block)
}
