//! T10: rays through all vertices of a rough surface, and along its edges.

use std::ops::RangeInclusive;

use crate::stability::prelude::*;

/// About as many vertices as rays are asked for, up to a million.
pub(super) fn grid(effort: &Effort) -> Found {
    let cells = ((effort.rays as f64).sqrt() as usize).clamp(10, 1000);
    let mut tally = Tally::default();
    // With cells of size 1 the rays meet vertices exactly, and those at the rim count.
    cover(&Grid::new(cells, 1.0), 0..=cells, &mut tally);
    // With others it is up to rounding on which side they pass.
    cover(&Grid::new(cells, 0.1), 1..=cells - 1, &mut tally);
    Found::own(None, tally)
}

/// Sends rays through all vertices in a range, and to the edges between them.
fn cover(grid: &Grid, range: RangeInclusive<usize>, tally: &mut Tally) {
    let probe = grid.probe();
    let mut random = Pcg64Mcg::seed_from_u64(4000);
    for y in range.clone() {
        for x in range.clone() {
            grid.ask(&probe, tally, x as f64, y as f64);
            // A place on one of the edges that begin there.
            let step = random.random_range(1..1024) as f64 / 1024.0;
            let along = [(step, 0.0), (0.0, step), (step, step), (step, 1.0 - step)];
            let (dx, dy) = along[if grid.is_rising(x, y) { random.random_range(0..3) } else { 3 }];
            let (x, y) = (x as f64 + dx, y as f64 + dy);
            if x.max(y) <= *range.end() as f64 {
                grid.ask(&probe, tally, x, y);
            }
        }
    }
}

/// Squares of two triangles. Vertices are of random height.
struct Grid {
    cells: usize,
    size: f64,
    positions: Vec<DVec3>,
}

impl Grid {
    fn new(cells: usize, size: f64) -> Grid {
        let mut random = Pcg64Mcg::seed_from_u64(4001);
        let places = (0..=cells).flat_map(|y| (0..=cells).map(move |x| (x as f64, y as f64)));
        let point = |(x, y)| DVec3::new(x * size, y * size, random.random::<f64>());
        let positions = places.map(point).collect();
        Grid { cells, size, positions }
    }

    /// The diagonals of cells alternate.
    fn is_rising(&self, x: usize, y: usize) -> bool {
        (x + y).is_multiple_of(2)
    }

    /// The two triangles of a cell.
    fn cell(&self, x: usize, y: usize) -> [[usize; 3]; 2] {
        let at = |dx: usize, dy: usize| (y + dy) * (self.cells + 1) + x + dx;
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        if self.is_rising(x, y) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    }

    /// Seen from far above by a camera that has a pixel at each vertex.
    fn probe(&self) -> Probe {
        let range = 0..self.cells;
        let faces: Vec<[usize; 3]> =
            range.clone().flat_map(|y| range.clone().flat_map(move |x| self.cell(x, y))).collect();
        let (start, end) = (-0.5 * self.size, (self.cells as f64 + 0.5) * self.size);
        let camera = format!(
            "LookAt 0 0 -10  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [{start:?} {end:?} {start:?} {end:?}]"
        );
        let world = format!("LightSource \"infinite\" {}", mesh(&self.positions, &faces));
        probe(&pictured(&camera, self.cells as u32 + 1, 1, "path", &world))
    }

    /// Sends a ray at a place, in cells; everything must hit.
    fn ask(&self, probe: &Probe, tally: &mut Tally, x: f64, y: f64) {
        let film = DVec2::new(x + 0.5, self.cells as f64 - y + 0.5);
        let ray: Ray = probe.camera_ray(film, DVec2::splat(0.5));
        tally.answer(probe.nearest(&ray).is_some());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_of_the_camera_go_exactly_through_vertices() {
        let grid = Grid::new(10, 1.0);
        let probe = grid.probe();
        let ray = probe.camera_ray(DVec2::new(3.5, 10.0 - 7.0 + 0.5), DVec2::splat(0.5));
        assert_eq!((probe.origin() + ray.o, ray.d), (DVec3::new(3.0, 7.0, -10.0), DVec3::Z));
        let hit = probe.nearest(&ray).unwrap();
        assert!((hit.t - 10.0 - grid.positions[7 * 11 + 3].z).abs() < 1e-14);
    }
}
