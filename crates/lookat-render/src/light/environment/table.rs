//! Directions in proportion to how much brighter a picture is there than its mean.

use std::f64::consts::{PI, TAU};

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::{DVec2, Vec3};
use lookat_image::MipMap;
use rayon::prelude::*;

use crate::number::luminance;
use crate::number::{LANES, V3, Vec3x8};
use crate::warp::sample_discrete;
use crate::warp::{angle, at_turn};

/// A density over the sphere that is the same within each cell of a grid over longitude and latitude: in proportion to
/// what is brighter there than the mean. What is not is left to BSDF samples (Karlik et al., "MIS Compensation",
/// ACM TOG 38(6), 2019).
///
/// A cell is half a texel wide and high, so the picture is bilinear in it, its mean is the value at its middle, and no
/// value is more than four times the mean: no sample counts for more than four times its share, once it is weighed against
/// the BSDF. Of large pictures a cell is more than that.
pub(super) struct DirectionTable {
    columns: usize,
    rows: usize,
    /// In each row, what is to be sampled of the luminance of the cells up to each.
    sums: Vec<f64>,
    /// The same times solid angle, of the rows up to each.
    row_sums: Vec<f64>,
    /// Of the latitudes between which rows lie.
    cosines: Vec<f64>,
    /// The mean luminance over the sphere.
    pub mean: f64,
}

/// Directions that have been sampled.
pub(super) struct TableSample<S: Simd> {
    /// Of length one.
    pub d: Vec3x8<S>,
    /// Their longitudes and latitudes, from 0 to 1.
    pub st: [f64x8<S>; 2],
    /// Densities by solid angle.
    pub pdf: f64x8<S>,
}

/// A sky that is nowhere brighter than this times its mean counts as everywhere alike: directions of the BSDF find it with a
/// relative variance of less than 0.08, so samples would add more noise than they save.
const ALIKE: f64 = 1.08;

/// The most cells: 64 MiB.
const MOST_CELLS: usize = 1 << 23;

impl DirectionTable {
    pub fn new(map: &MipMap<Vec3>, scale: Vec3) -> Self {
        let fine = [2 * map.width(), 2 * map.height()];
        let mut merged = 1;
        while (fine[0] / merged).max(1) * (fine[1] / merged).max(1) > MOST_CELLS {
            merged *= 2;
        }
        let [columns, rows] = fine.map(|side| (side / merged).max(1));
        let mut sums = vec![0.0; columns * rows];
        sums.par_chunks_mut(columns).enumerate().for_each(|(row, sums)| {
            for (column, cell) in sums.iter_mut().enumerate() {
                *cell = cell_mean(map, scale, [column, row], [columns, rows], fine);
            }
        });
        let cosines = (0..=rows).map(|edge| libm::cos(PI * edge as f64 / rows as f64)).collect();
        let mut table = DirectionTable { columns, rows, sums, row_sums: Vec::new(), cosines, mean: 0.0 };
        let of_row = |row| table.row(row).iter().sum::<f64>() * table.cell_angle(row);
        table.mean = (0..rows).map(of_row).sum::<f64>() / (4.0 * PI);
        let brightest = table.sums.iter().copied().fold(0.0, f64::max);
        table.sum_up(if brightest > table.mean * ALIKE { table.mean } else { brightest });
        table
    }

    /// From the luminance of the cells to the sums of what is above a level.
    fn sum_up(&mut self, level: f64) {
        let columns = self.columns;
        self.sums.par_chunks_mut(columns).for_each(|row| {
            let mut sum = 0.0;
            for cell in row {
                sum += (*cell - level).max(0.0);
                *cell = sum;
            }
        });
        let mut sum = 0.0;
        for row in 0..self.rows {
            sum += self.row(row)[columns - 1] * self.cell_angle(row);
            self.row_sums.push(sum);
        }
    }

    /// Directions; of no use if nothing is brighter than the rest.
    #[inline(always)]
    pub fn sample<S: Simd>(&self, simd: S, [u, v]: [f64x8<S>; 2]) -> TableSample<S> {
        let (rows, down) = sample_discrete(simd, [&self.row_sums; LANES], v);
        let (columns, along) = sample_discrete(simd, rows.map(|row| self.row(row)), u);
        let edge = |next: usize| -> f64x8<S> { f64x8::from_fn(simd, |lane| self.cosines[rows[lane] + next]) };
        let (top, bottom) = (edge(0), edge(1));
        let cos = top + (bottom - top) * down;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let column: f64x8<S> = f64x8::from_fn(simd, |lane| columns[lane] as f64);
        let longitude = (column + along) / self.columns as f64;
        let [x, y] = at_turn(longitude);
        TableSample {
            d: V3 { x: x * sin, y: y * sin, z: cos },
            st: [longitude, angle(sin, cos) * (1.0 / PI)],
            pdf: f64x8::from_fn(simd, |lane| self.cell_pdf(columns[lane], rows[lane])),
        }
    }

    /// Densities by solid angle of the directions at `st`, longitude and latitude from 0 to 1.
    #[inline(always)]
    pub fn pdf<S: Simd>(&self, simd: S, [s, t]: [f64x8<S>; 2]) -> f64x8<S> {
        let index = |x: f64, count: usize| ((x * count as f64) as usize).min(count - 1);
        f64x8::from_fn(simd, |lane| self.cell_pdf(index(s[lane], self.columns), index(t[lane], self.rows)))
    }

    #[inline(always)]
    fn cell_pdf(&self, column: usize, row: usize) -> f64 {
        let row = self.row(row);
        let before = if column == 0 { 0.0 } else { row[column - 1] };
        let total = self.total();
        if total > 0.0 { (row[column] - before) / total } else { 0.0 }
    }

    /// The mean of how much brighter it is than that, where it is brighter.
    pub fn mean_above(&self) -> f64 {
        self.total() / (4.0 * PI)
    }

    fn total(&self) -> f64 {
        self.row_sums[self.rows - 1]
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.sums[row * self.columns..][..self.columns]
    }

    /// The solid angle of a cell.
    fn cell_angle(&self, row: usize) -> f64 {
        (self.cosines[row] - self.cosines[row + 1]) * TAU / self.columns as f64
    }
}

/// The mean luminance of a cell: of the middles of the half texels in it.
fn cell_mean(map: &MipMap<Vec3>, scale: Vec3, cell: [usize; 2], cells: [usize; 2], fine: [usize; 2]) -> f64 {
    let [wide, high] = [fine[0] / cells[0], fine[1] / cells[1]];
    let mut sum = 0.0;
    for y in cell[1] * high..(cell[1] + 1) * high {
        for x in cell[0] * wide..(cell[0] + 1) * wide {
            let middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let st = middle / DVec2::new(fine[0] as f64, fine[1] as f64);
            sum += luminance(scale * map.bilinear(st)).max(0.0);
        }
    }
    sum / (wide * high) as f64
}
