//! Bounds of the densities in the parts of a grid, so that tracking takes few steps where the medium is thin.

use lookat_scene::{Density, DensityGrid, Medium};

/// The largest densities in the coarse cells of a grid: no interpolated one is larger.
pub(crate) struct Majorants {
    /// The number of cells along each axis.
    pub cells: [usize; 3],
    /// Along x first, then y.
    pub values: Vec<f32>,
}

/// The number of densities along a side of a coarse cell, by measurement.
const CELL: usize = 4;
/// The most coarse cells along an axis.
const MOST_CELLS: usize = 64;

impl Majorants {
    /// Those of a medium. `None` for one of even density.
    pub fn of(medium: &Medium) -> Option<Self> {
        match &medium.density {
            Density::Grid(grid) => Some(Majorants::new(grid)),
            Density::Uniform => None,
        }
    }

    pub fn new(grid: &DensityGrid) -> Self {
        let cells = grid.resolution.map(|count| count.div_ceil(CELL).clamp(1, MOST_CELLS));
        let mut values = vec![0.0_f32; cells.iter().product()];
        let [width, height, depth] = grid.resolution;
        // A density counts up to one and a half cells of the grid from its lower side.
        let range = |at: usize, axis: usize| {
            let (count, cells) = (grid.resolution[axis], cells[axis]);
            let cell = |place: f64| (place * cells as f64 / count as f64) as usize;
            cell(at as f64 - 0.5 - 1e-6)..=cell(at as f64 + 1.5 + 1e-6).min(cells - 1)
        };
        let ranges =
            [0, 1, 2].map(|axis| (0..grid.resolution[axis]).map(|at| range(at, axis)).collect::<Vec<_>>());
        for z in 0..depth {
            for y in 0..height {
                let row = &grid.values[(z * height + y) * width..][..width];
                for (x, density) in row.iter().enumerate().filter(|(_, density)| **density > 0.0) {
                    for cell_z in ranges[2][z].clone() {
                        for cell_y in ranges[1][y].clone() {
                            let first = (cell_z * cells[1] + cell_y) * cells[0];
                            for most in &mut values[first + ranges[0][x].start()..=first + ranges[0][x].end()]
                            {
                                *most = most.max(*density);
                            }
                        }
                    }
                }
            }
        }
        Majorants { cells, values }
    }
}
