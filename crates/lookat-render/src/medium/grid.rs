//! Tracking in media whose density is a grid: where a ray scatters, and how much light gets along it (PBR 15.2.2; PBR, fourth edition, 11.4.3).

use arrayvec::ArrayVec;
use glam::{DVec3, Vec3};
use lookat_scene::DensityGrid;

use super::PreparedMedium;
use super::majorants::Majorants;
use crate::sampler::{mix, unit};

/// A grid of densities. Rays are relative to the origin.
pub(super) struct PreparedGrid<'s> {
    pub grid: &'s DensityGrid,
    pub majorants: &'s Majorants,
    pub origin: DVec3,
}

/// What a ray meets in a medium.
pub(super) struct GridSample {
    /// The distance at which it scatters. `None` if it gets to its end.
    pub t: Option<f64>,
    /// The throughput up to there, over its probability.
    pub weight: Vec3,
}

/// A ray up to a distance, which may be infinite.
pub(super) struct RayPart {
    pub o: DVec3,
    pub d: DVec3,
    pub t_max: f64,
}

impl PreparedGrid<'_> {
    /// The part of a ray that is in the box, and the ray in its space.
    fn within(&self, part: &RayPart) -> Option<(DVec3, DVec3, [f64; 2])> {
        let grid_from_world = &self.grid.grid_from_world;
        let (o, d) = (grid_from_world.point(part.o + self.origin), grid_from_world.vector(part.d));
        let (mut near, mut far) = (0.0_f64, part.t_max);
        for axis in 0..3 {
            let ends = [-o[axis] / d[axis], (1.0 - o[axis]) / d[axis]];
            if d[axis] == 0.0 {
                if !(0.0..=1.0).contains(&o[axis]) {
                    return None;
                }
                continue;
            }
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        (near < far).then_some((o, d, [near, far]))
    }

    /// The density at a point of the unit cube.
    fn density(&self, p: DVec3) -> f32 {
        let DensityGrid { resolution, values, .. } = self.grid;
        let count = DVec3::from(resolution.map(|cells| cells as f64));
        let at = p * count - 0.5;
        let (first, rest) = (at.floor(), (at - at.floor()).as_vec3());
        let first = first.to_array().map(|first| first as i64);
        let value = |x: i64, y: i64, z: i64| {
            let cell = [first[0] + x, first[1] + y, first[2] + z];
            let is_in = (0..3).all(|axis| (0..resolution[axis] as i64).contains(&cell[axis]));
            let [x, y, z] = cell.map(|cell| cell as usize);
            if is_in { values[(z * resolution[1] + y) * resolution[0] + x] } else { 0.0 }
        };
        let lerp = |share: f32, a: f32, b: f32| a * (1.0 - share) + b * share;
        let along_x = |y, z| lerp(rest.x, value(0, y, z), value(1, y, z));
        let along_y = |z| lerp(rest.y, along_x(0, z), along_x(1, z));
        lerp(rest.z, along_y(0), along_y(1))
    }

    /// Delta tracking for a path. Where the channels differ, a collision is real with the mean probability of what is left of its throughput,
    /// and weights make up for the difference (Kutz et al., "Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes", SIGGRAPH 2017).
    pub fn sample(
        &self,
        medium: &PreparedMedium,
        part: &RayPart,
        throughput: Vec3,
        random: &mut Random,
    ) -> GridSample {
        let (mut weight, collisions) = (Vec3::ONE, self.collisions(medium, part));
        let Some(mut collisions) = collisions else { return GridSample { t: None, weight } };
        while let Some((t, real)) = collisions.next(random)
            && throughput * weight != Vec3::ZERO
        {
            let left = throughput * weight;
            let probability = (left * real).element_sum() / left.element_sum();
            if random.next() < f64::from(probability) {
                let albedo = medium.scattering / medium.extinction.max(Vec3::splat(f32::MIN_POSITIVE));
                return GridSample { t: Some(t), weight: weight * real * albedo / probability };
            }
            weight *= (Vec3::ONE - real) / (1.0 - probability);
        }
        GridSample { t: None, weight }
    }

    /// Ratio tracking, with roulette once little gets through.
    pub fn transmittance(&self, medium: &PreparedMedium, part: &RayPart, random: &mut Random) -> Vec3 {
        let (mut share, collisions) = (Vec3::ONE, self.collisions(medium, part));
        let Some(mut collisions) = collisions else { return share };
        while let Some((_, real)) = collisions.next(random) {
            share *= Vec3::ONE - real;
            let most = share.max_element();
            if most < 0.1 {
                if random.next() >= f64::from(most) {
                    return Vec3::ZERO;
                }
                share /= most;
            }
        }
        share
    }

    /// The collisions of a ray with a medium that is as dense in each coarse cell as anywhere in it. `None` for a ray that misses the box.
    fn collisions(&self, medium: &PreparedMedium, part: &RayPart) -> Option<Collisions<'_>> {
        let (o, d, [near, end]) = self.within(part)?;
        let cells = DVec3::from(self.majorants.cells.map(|cells| cells as f64));
        let start = (o + d * near) * cells;
        let last = self.majorants.cells.map(|cells| cells as i64 - 1);
        let cell = [0, 1, 2].map(|axis| (start[axis].floor() as i64).clamp(0, last[axis]));
        let speed = d * cells;
        let crossing = |axis: usize| {
            let side = cell[axis] + i64::from(speed[axis] > 0.0);
            if speed[axis] == 0.0 {
                f64::INFINITY
            } else {
                (side as f64 - o[axis] * cells[axis]) / speed[axis]
            }
        };
        Some(Collisions {
            grid: self,
            extinction: medium.extinction,
            o,
            d,
            t: near,
            end,
            cell,
            crossings: [0, 1, 2].map(crossing),
            steps: (1.0 / speed.abs()).to_array(),
            count: 0,
        })
    }
}

/// Collisions along a ray. In the space of the grid, but distances are those of the world.
struct Collisions<'g> {
    grid: &'g PreparedGrid<'g>,
    extinction: Vec3,
    o: DVec3,
    d: DVec3,
    /// The distance of the last collision, or where the ray has entered the cell that it is in.
    t: f64,
    /// The distance at which the ray ends or leaves the box.
    end: f64,
    /// The coarse cell that the ray is in.
    cell: [i64; 3],
    /// The distances at which it crosses the next side of a cell, across each axis, and from one to the next.
    crossings: [f64; 3],
    steps: [f64; 3],
    /// The number of collisions so far.
    count: u32,
}

/// After so many collisions that were not real, about half a millisecond, the next one is: in a grid where that happens, one density is far
/// beyond all others, and rays would never come to their ends.
const MOST_COLLISIONS: u32 = 10_000;

impl Collisions<'_> {
    /// The distance of the next collision, and the share of each channel that really collides there.
    fn next(&mut self, random: &mut Random) -> Option<(f64, Vec3)> {
        let mut depth = -libm::log(1.0 - random.next());
        let Majorants { cells, values } = self.grid.majorants;
        let [across, down, _] = cells.map(|cells| cells as i64);
        while self.t < self.end {
            let [x, y, z] = self.cell;
            let majorant = values[((z * down + y) * across + x) as usize];
            let most = self.extinction * majorant;
            let rate = f64::from(most.max_element());
            let axis = usize::from(self.crossings[1] < self.crossings[0]);
            let axis = if self.crossings[2] < self.crossings[axis] { 2 } else { axis };
            let leaves = self.crossings[axis].min(self.end);
            let through = (leaves - self.t) * rate;
            if depth < through {
                self.t += depth / rate;
                self.count += 1;
                let real = match self.count {
                    ..MOST_COLLISIONS => {
                        self.extinction * (self.grid.density(self.o + self.d * self.t) / most.max_element())
                    }
                    _ => Vec3::ONE,
                };
                return Some((self.t, real.min(Vec3::ONE)));
            }
            depth -= through.max(0.0);
            self.t = self.t.max(leaves);
            self.crossings[axis] += self.steps[axis];
            self.cell[axis] += if self.d[axis] > 0.0 { 1 } else { -1 };
            if !(0..cells[axis] as i64).contains(&self.cell[axis]) {
                self.t = self.end;
            }
        }
        None
    }
}

/// Random numbers for tracking in media, as many as it takes.
pub(super) struct Random {
    /// The first ones, if a sampler gives any; the last number comes first.
    given: ArrayVec<f64, 2>,
    state: u64,
}

impl Random {
    /// Numbers that depend on a ray and on the sample that it belongs to, after those of a sampler. `seed`: other samples have others.
    pub fn new(part: &RayPart, seed: u64, given: Option<[f64; 2]>) -> Self {
        let numbers = part.o.to_array().into_iter().chain(part.d.to_array());
        let state = numbers.fold(seed, |hash, number| mix(hash ^ number.to_bits()));
        Random { given: given.into_iter().flatten().rev().collect(), state }
    }

    /// A number from 0 to 1, below 1.
    pub fn next(&mut self) -> f64 {
        self.given.pop().unwrap_or_else(|| {
            self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            unit(mix(self.state))
        })
    }
}

#[cfg(test)]
mod tests {
    use lookat_scene::{Density, Medium, Transform};

    use super::*;
    use crate::testing::noise;

    /// A grid with gaps and a peak.
    fn grid() -> DensityGrid {
        let resolution = [9, 5, 17];
        let density = |at: usize| {
            let own = noise(at, 1.3) as f32;
            if at == 333 { 20.0 } else { own.max(0.0) }
        };
        DensityGrid {
            resolution,
            values: (0..resolution.iter().product()).map(density).collect(),
            grid_from_world: Transform::scale(DVec3::new(0.5, 1.0, 0.25)).unwrap(),
        }
    }

    #[test]
    fn no_density_exceeds_the_majorant_of_its_cell() {
        let (grid, mut largest) = (grid(), 0.0_f32);
        let majorants = &Majorants::new(&grid);
        let prepared = PreparedGrid { grid: &grid, majorants, origin: DVec3::ZERO };
        assert_eq!(majorants.cells, [3, 2, 5]);
        for at in 0..20_000 {
            let p = DVec3::new(noise(at, 1.1), noise(at, 2.1), noise(at, 3.1)).abs();
            let [x, y, z] = [0, 1, 2].map(|axis| (p[axis] * majorants.cells[axis] as f64) as usize);
            let majorant = majorants.values[(z * 2 + y) * 3 + x];
            let density = prepared.density(p);
            assert!(density <= majorant * (1.0 + 1e-5), "{p} {density} {majorant}");
            largest = largest.max(density / majorant);
        }
        assert!(largest > 0.9);
        // The peak makes no cell denser but its own and those beside it.
        assert!(majorants.values.iter().filter(|majorant| **majorant > 1.0).count() <= 8);
    }

    /// Both kinds of tracking let as much light through as the integral of the density along the ray says, also along an axis and beside the
    /// grid.
    #[test]
    fn light_gets_through_as_the_integral_says() {
        let grid = grid();
        let density = Density::Grid(Box::new(grid.clone()));
        let (absorption, scattering) = (Vec3::new(0.4, 0.1, 0.0), Vec3::new(0.4, 0.7, 0.2));
        let medium = Medium { name: None, absorption, scattering, asymmetry: 0.0, density };
        let majorants = Majorants::of(&medium);
        let medium = PreparedMedium::new(&medium, majorants.as_ref(), DVec3::ZERO);
        let prepared = medium.grid.as_ref().unwrap();
        for (o, d, t_max) in [
            (DVec3::new(-1.0, 0.4, 1.0), DVec3::new(1.0, 0.1, 0.5), f64::INFINITY),
            (DVec3::new(1.9, 0.7, 3.9), DVec3::new(-0.5, -0.1, -1.0), 3.0),
            (DVec3::new(0.9, 0.5, -1.0), DVec3::Z, f64::INFINITY),
            (DVec3::new(0.9, 0.5, -1.0), DVec3::Y, f64::INFINITY),
        ] {
            let steps = 20_000;
            let step = 6.0 / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|at| (f64::from(at) + 0.5) * step)
                .filter(|t| *t < t_max)
                .map(|t| grid.grid_from_world.point(o + d * t))
                .filter(|p| p.cmpge(DVec3::ZERO).all() && p.cmple(DVec3::ONE).all())
                .map(|p| f64::from(prepared.density(p)) * step)
                .sum();
            let expected = (-(absorption + scattering) * sum as f32).exp();
            let (mut ratio, mut delta, count) = (Vec3::ZERO, Vec3::ZERO, 40_000);
            let throughput = Vec3::new(1.0, 2.0, 0.5);
            for number in 0..count {
                let mut random = Random { given: ArrayVec::new(), state: number };
                ratio += prepared.transmittance(&medium, &RayPart { o, d, t_max }, &mut random);
                let sample = prepared.sample(&medium, &RayPart { o, d, t_max }, throughput, &mut random);
                delta += if sample.t.is_none() { sample.weight } else { Vec3::ZERO };
            }
            for found in [ratio, delta].map(|sum| sum / count as f32) {
                assert!((found - expected).abs().max_element() < 0.01, "{o} {d}: {found}, not {expected}");
            }
        }
    }
}
