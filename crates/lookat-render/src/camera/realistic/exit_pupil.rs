//! Where rays from the film get through the lens: ellipses around the exit pupil, seen from places at all distances from the middle of the
//! film.
//!
//! pbrt-v3 has rectangles for 64 rings of the film, which step from one ring to the next. Between these ellipses everything is
//! interpolated, so noise has no rings.

use std::f64::consts::PI;

use fearless_simd::{Level, Simd, f64x8, prelude::*};
use rayon::prelude::*;

use super::Surfaces;
use crate::number::{LANES, V3, Vec2x8, side_by_side};

/// Ellipses, from the middle of the film to its corners.
const PLACES: usize = 65;

/// Rays are aimed at the plane of the rear vertex, so far from the axis, in radii of the rear opening.
const REACH: f64 = 1.5;

/// Ellipses around the exit pupil on the plane of the rear vertex, seen from the x axis of the film.
#[derive(Debug)]
pub(super) struct ExitPupil {
    /// From the middle of the film to its corners, in equal steps.
    ellipses: Vec<Ellipse>,
    /// Steps per distance on the film.
    steps: f64,
}

/// An ellipse whose axes are along x and y, and whose center is on the x axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ellipse {
    pub center: f64,
    pub half_x: f64,
    pub half_y: f64,
}

/// Ellipses seen from places on the film.
pub(super) struct Bounds<S: Simd> {
    center: f64x8<S>,
    half: Vec2x8<S>,
    /// The directions of the places.
    toward: Vec2x8<S>,
}

impl<S: Simd> Bounds<S> {
    /// The point of the rear plane at a point of the unit disk.
    #[inline(always)]
    pub fn place(&self, [x, y]: Vec2x8<S>) -> Vec2x8<S> {
        let (x, y, [cos, sin]) = (self.center + self.half[0] * x, self.half[1] * y, self.toward);
        [cos * x - sin * y, sin * x + cos * y]
    }

    #[inline(always)]
    pub fn area(&self) -> f64x8<S> {
        self.half[0] * self.half[1] * PI
    }
}

impl ExitPupil {
    /// The pupil seen from distances up to `corner` from the middle of a film.
    pub fn new(surfaces: &Surfaces, corner: f64) -> ExitPupil {
        let steps = (PLACES - 1) as f64 / corner;
        let places = (0..PLACES).into_par_iter();
        let found: Vec<_> = places.map(|place| find(surfaces, place as f64 / steps)).collect();
        ExitPupil { ellipses: joined(&found, REACH * surfaces.rear_radius), steps }
    }

    /// Ellipses for places on the film.
    #[inline(always)]
    pub fn at<S: Simd>(&self, simd: S, [x, y]: Vec2x8<S>) -> Bounds<S> {
        let r = (x * x + y * y).sqrt();
        let place = (r * self.steps).min((PLACES - 1) as f64);
        let first = place.floor().min((PLACES - 2) as f64);
        let share = place - first;
        let mut ends = [[0.0; LANES]; 6];
        for lane in 0..LANES {
            let at = first[lane] as usize;
            for (own, ellipse) in ends.chunks_exact_mut(3).zip([at, at + 1]) {
                let Ellipse { center, half_x, half_y } = self.ellipses[ellipse];
                (own[0][lane], own[1][lane], own[2][lane]) = (center, half_x, half_y);
            }
        }
        let between = |at: usize| -> f64x8<S> {
            let (a, b): (f64x8<S>, f64x8<S>) = (ends[at].simd_into(simd), ends[at + 3].simd_into(simd));
            a + (b - a) * share
        };
        let is_off = r.simd_gt(0.0);
        let (one, zero): (f64x8<S>, f64x8<S>) = (1.0.simd_into(simd), 0.0.simd_into(simd));
        let toward = [is_off.select(x / r, one), is_off.select(y / r, zero)];
        Bounds { center: between(0), half: [between(1), between(2)], toward }
    }

    /// The ellipse seen from a distance from the middle of the film.
    pub fn ellipse(&self, r: f64) -> Ellipse {
        let place = (r * self.steps).min((PLACES - 1) as f64);
        let at = (place as usize).min(PLACES - 2);
        let (a, b, share) = (self.ellipses[at], self.ellipses[at + 1], place - at as f64);
        let between = |of: fn(&Ellipse) -> f64| of(&a) + (of(&b) - of(&a)) * share;
        Ellipse {
            center: between(|it| it.center),
            half_x: between(|it| it.half_x),
            half_y: between(|it| it.half_y),
        }
    }
}

/// The most steps to a pupil. Each that sees nothing of it leaves an eighth of the one before.
const MOST_STEPS: usize = 20;

/// A part of the rear plane that is symmetric about the x axis.
#[derive(Debug, Clone, Copy)]
struct Part {
    center: f64,
    half_x: f64,
    half_y: f64,
}

/// A grid of points on the upper half of a part, from edge to edge.
#[derive(Clone, Copy)]
struct Grid {
    part: Part,
    columns: usize,
    rows: usize,
}

impl Grid {
    /// The distances between points.
    fn steps(&self) -> [f64; 2] {
        [2.0 * self.part.half_x / (self.columns - 1) as f64, self.part.half_y / (self.rows - 1) as f64]
    }

    /// Calls a function with each point, and with the clearance of the ray to it from a place on the x axis of the film.
    fn each(&self, surfaces: &Surfaces, film: f64, mut seen: impl FnMut([f64; 2], f64)) {
        let [dx, dy] = self.steps();
        let count = self.columns * self.rows;
        for first in (0..count).step_by(LANES) {
            let at = |lane: usize| {
                let at = (first + lane).min(count - 1);
                let (column, row) = (at % self.columns, at / self.columns);
                [self.part.center - self.part.half_x + dx * column as f64, dy * row as f64]
            };
            let points: [[f64; 2]; LANES] = std::array::from_fn(at);
            let clearance = clearance(surfaces, &[film; LANES], &points);
            for (point, clearance) in points.iter().zip(clearance).take(count - first) {
                seen(*point, clearance);
            }
        }
    }
}

/// The clearance of rays from places on the x axis of the film to points of the rear plane.
fn clearance(surfaces: &Surfaces, film: &[f64; LANES], points: &[[f64; 2]; LANES]) -> [f64; LANES] {
    let mut found = [0.0; LANES];
    side_by_side!(Level::new(), simd => {
        let axis = |axis: usize| -> [f64; LANES] { points.map(|point| point[axis]) };
        let [x, y, from] = [axis(0), axis(1), *film].map(|numbers| numbers.simd_into(simd));
        let zero: f64x8<_> = 0.0.simd_into(simd);
        let d = V3 { x: x - from, y, z: surfaces.rear.simd_into(simd) }.normalize();
        surfaces.trace(simd, V3 { x: from, y: zero, z: zero }, d).clearance.store_slice(&mut found);
    });
    found
}

/// Finds the pupil seen from a place on the x axis of the film. `None` if no ray gets through.
fn find(surfaces: &Surfaces, film: f64) -> Option<Ellipse> {
    let reach = REACH * surfaces.rear_radius;
    let mut part = Part { center: 0.0, half_x: reach, half_y: reach };
    // Zooms in on the pupil. Without any ray that gets through, on the one that comes closest.
    for _ in 0..MOST_STEPS {
        let grid = Grid { part, columns: 32, rows: 16 };
        let [dx, dy] = grid.steps();
        let (mut low, mut high, mut top) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        let mut best = (f64::NEG_INFINITY, [0.0; 2]);
        grid.each(surfaces, film, |[x, y], clearance| {
            if clearance >= 0.0 {
                (low, high, top) = (low.min(x), high.max(x), top.max(y));
            }
            if clearance > best.0 {
                best = (clearance, [x, y]);
            }
        });
        let next = if low <= high {
            Part { center: (low + high) / 2.0, half_x: (high - low) / 2.0 + dx, half_y: top + dy }
        } else {
            Part { center: best.1[0], half_x: 2.0 * dx, half_y: best.1[1] + 2.0 * dy }
        };
        let is_close = next.half_x > 0.8 * part.half_x && next.half_y > 0.8 * part.half_y;
        part = next;
        if is_close && low <= high {
            break;
        }
    }
    around(surfaces, film, Grid { part, columns: 64, rows: 32 })
}

/// The ellipse around the points of a grid where rays get through, with a step of the grid around each.
fn around(surfaces: &Surfaces, film: f64, grid: Grid) -> Option<Ellipse> {
    let [dx, dy] = grid.steps();
    let mut points = Vec::new();
    grid.each(surfaces, film, |point, clearance| {
        if clearance >= 0.0 {
            points.push(point);
        }
    });
    let low = points.iter().map(|[x, _]| *x).reduce(f64::min)?;
    let high = points.iter().map(|[x, _]| *x).reduce(f64::max)?;
    let top = points.iter().map(|[_, y]| *y).reduce(f64::max)?;
    let (center, half_x, half_y) = ((low + high) / 2.0, (high - low) / 2.0 + dx, top + dy);
    let square = |[x, y]: &[f64; 2]| {
        let [x, y] = [((x - center).abs() + dx) / half_x, (y + dy) / half_y];
        x * x + y * y
    };
    let factor = points.iter().map(square).fold(1.0, f64::max).sqrt();
    Some(Ellipse { center, half_x: factor * half_x, half_y: factor * half_y })
}

/// Ellipses between which the pupil stays inside of what is interpolated.
fn joined(found: &[Option<Ellipse>], reach: f64) -> Vec<Ellipse> {
    let nothing = Ellipse { center: 0.0, half_x: reach, half_y: reach };
    let mut ellipses: Vec<Ellipse> = Vec::new();
    for found in found {
        // Beyond the last place that light gets to, the pupil shrinks to nothing.
        let after = match ellipses[..] {
            [.., before, last] => Ellipse {
                center: 2.0 * last.center - before.center,
                half_x: 1.25 * last.half_x,
                half_y: 1.25 * last.half_y,
            },
            _ => nothing,
        };
        let after = Ellipse { half_x: after.half_x.min(reach), half_y: after.half_y.min(reach), ..after };
        ellipses.push(found.unwrap_or(after));
    }
    // The error of linear interpolation is less than the second difference, also where the slope jumps.
    let bend = |of: fn(&Ellipse) -> f64, sign: f64| -> Vec<f64> {
        let values: Vec<f64> = ellipses.iter().map(of).collect();
        let second = |at: usize| {
            let before = if at == 0 { sign * values[1] } else { values[at - 1] };
            values.get(at + 1).map_or(0.0, |after| (before - 2.0 * values[at] + after).abs())
        };
        let seconds: Vec<f64> = (0..values.len()).map(second).collect();
        let around = |at: usize| seconds[at.saturating_sub(1)..(at + 2).min(seconds.len())].iter().copied();
        (0..values.len()).map(|at| around(at).fold(0.0, f64::max)).collect()
    };
    // Seen from the other side of the middle, the pupil is on the other side of the axis.
    let center = bend(|it| it.center, -1.0);
    let (half_x, half_y) = (bend(|it| it.half_x, 1.0), bend(|it| it.half_y, 1.0));
    let wider = |(at, ellipse): (usize, &Ellipse)| Ellipse {
        half_x: ellipse.half_x + center[at] + half_x[at],
        half_y: ellipse.half_y + half_y[at],
        ..*ellipse
    };
    ellipses.iter().enumerate().map(wider).collect()
}

/// The number of rays by which pbrt-v3 bounds the exit pupil: see [`simple_area`].
const SAMPLES: u32 = 1 << 20;
/// The number of rings of the film in pbrt-v3.
const RINGS: f64 = 64.0;

/// The area that pbrt-v3 divides weights by under `simpleweighting`: of the rectangle around those of 2^20 rays from the innermost ring of
/// the film that get through, with a margin. It depends on these rays, so they are the same here.
pub(super) fn simple_area(surfaces: &Surfaces, pupil: &ExitPupil, corner: f64) -> f64 {
    let reach = REACH * surfaces.rear_radius;
    let ring = corner / RINGS;
    // All rays outside of these are blocked.
    let ellipses = [0.0, ring].map(|r| pupil.ellipse(r));
    let x_end = |sign: f64| ellipses.map(|it| sign * it.center + it.half_x).into_iter().fold(0.0, f64::max);
    let (left, right) = (-x_end(-1.0), x_end(1.0));
    let top = ellipses.map(|it| it.half_y).into_iter().fold(0.0, f64::max);
    let thirds = Thirds::new();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut waiting = Vec::with_capacity(LANES);
    for sample in 0..=SAMPLES {
        if sample < SAMPLES {
            let u = [f64::from(sample.reverse_bits()) * 0.5_f64.powi(32), thirds.inverse(sample)];
            let [x, y] = u.map(|u| (2.0 * u - 1.0) * reach);
            let is_near = (left..=right).contains(&x) && y.abs() <= top;
            let is_new = x < low[0] || x > high[0] || y < low[1] || y > high[1];
            if is_near && is_new {
                waiting.push(([x, y], (f64::from(sample) + 0.5) / f64::from(SAMPLES) * ring));
            }
        }
        if waiting.len() == LANES || (sample == SAMPLES && !waiting.is_empty()) {
            let ray = |lane: usize| waiting[lane.min(waiting.len() - 1)];
            let points = std::array::from_fn(|lane| ray(lane).0);
            let clearance = clearance(surfaces, &std::array::from_fn(|lane| ray(lane).1), &points);
            for (point, _) in points.iter().zip(clearance).filter(|(_, clearance)| *clearance >= 0.0) {
                low = [low[0].min(point[0]), low[1].min(point[1])];
                high = [high[0].max(point[0]), high[1].max(point[1])];
            }
            waiting.clear();
        }
    }
    if low[0] > high[0] {
        return (2.0 * reach).powi(2);
    }
    let margin = 2.0 * (2.0 * reach) * 2.0_f64.sqrt() / f64::from(SAMPLES).sqrt();
    (high[0] - low[0] + 2.0 * margin) * (high[1] - low[1] + 2.0 * margin)
}

/// Radical inverses in base 3 of numbers below 3^13, from those of their halves.
struct Thirds {
    low: Vec<u32>,
    high: Vec<u32>,
}

impl Thirds {
    const LOW: u32 = 729;
    const HIGH: u32 = 2187;

    fn new() -> Thirds {
        let reversed = |digits: u32| {
            move |number: u32| {
                (0..digits).fold((number, 0), |(rest, turned), _| (rest / 3, 3 * turned + rest % 3)).1
            }
        };
        Thirds {
            low: (0..Self::LOW).map(reversed(6)).collect(),
            high: (0..Self::HIGH).map(reversed(7)).collect(),
        }
    }

    fn inverse(&self, number: u32) -> f64 {
        let [low, high] = [number % Self::LOW, number / Self::LOW];
        let turned = self.low[low as usize] * Self::HIGH + self.high[high as usize];
        f64::from(turned) / f64::from(Self::LOW * Self::HIGH)
    }
}
