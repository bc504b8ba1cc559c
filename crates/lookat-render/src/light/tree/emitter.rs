//! What a leaf of the tree of lights emits.

use std::f64::consts::PI;

use glam::DVec3;

/// The emission of a light, a triangle or a group of these, as far as choosing one needs it.
#[derive(Debug, Clone, Copy)]
pub(in crate::light) struct Emitter {
    pub center: DVec3,
    /// All of it is at most this far from `center`.
    pub radius: f64,
    /// What is added to the square of the distance in estimates of the irradiance. It keeps these finite nearby.
    pub spread: f64,
    /// The irradiance at distance 1, at right angles.
    pub intensity: f64,
    /// The share of `intensity` that leaves in all directions.
    pub base: f64,
    /// The share that leaves by the cosine to `axis`.
    pub along: f64,
    /// True if it also leaves by the cosine to the opposite direction.
    pub is_two_sided: bool,
    /// A unit vector.
    pub axis: DVec3,
    /// Light leaves only in directions whose cosine to `axis` is at least this. [`EVERYWHERE`]: in all directions.
    pub least_cosine: f64,
    /// True if all of it lies in one plane across `axis`.
    pub is_flat: bool,
}

/// The [`Emitter::least_cosine`] of lights that shine in all directions.
pub(in crate::light) const EVERYWHERE: f64 = -2.0;

/// A closed convex shape shows a quarter of its area.
const CONVEX: f64 = 0.25;

impl Emitter {
    /// A point that shines alike in all directions.
    pub fn point(position: DVec3, intensity: f64) -> Self {
        Emitter {
            center: position,
            radius: 0.0,
            spread: 0.0,
            intensity,
            base: 1.0,
            along: 0.0,
            is_two_sided: false,
            axis: DVec3::Z,
            least_cosine: EVERYWHERE,
            is_flat: false,
        }
    }

    /// A point that shines around an axis, up to an angle with this cosine.
    pub fn cone(position: DVec3, intensity: f64, axis: DVec3, least_cosine: f64) -> Self {
        let base = (1.0 - least_cosine) * 0.5;
        Emitter { base, along: 1.0 - base, axis, least_cosine, ..Emitter::point(position, intensity) }
    }

    /// A surface within `radius` of `center`, with the mean of its unit normals on the side that emits.
    pub fn surface(
        (center, radius): (DVec3, f64),
        (radiance, area): (f64, f64),
        mean_normal: DVec3,
        (is_flat, is_two_sided): (bool, bool),
    ) -> Self {
        let length = mean_normal.length();
        let is_one_sided = is_flat && !is_two_sided;
        Emitter {
            radius,
            // The irradiance from a disk, at any distance; from a ball, from outside of it about that.
            spread: area / if is_flat { PI } else { 4.0 * PI },
            base: if is_flat { 0.0 } else { CONVEX * (1.0 - length * length).max(0.0) },
            along: length.min(1.0),
            is_two_sided,
            axis: mean_normal.normalize_or(DVec3::Z),
            least_cosine: if is_one_sided { 0.0 } else { EVERYWHERE },
            is_flat,
            ..Emitter::point(center, radiance * area)
        }
    }

    /// A group.
    pub fn group<'e>(all: impl Iterator<Item = &'e Emitter> + Clone) -> Self {
        let intensity: f64 = all.clone().map(|emitter| emitter.intensity).sum();
        let weighted = || all.clone().map(|emitter| (emitter, emitter.intensity / intensity));
        let center = weighted().fold(DVec3::ZERO, |sum, (emitter, share)| sum + emitter.center * share);
        // Of lights spread evenly in a ball, seen from its middle, the mean of 1 / r^2 is about 1 over half the mean of r^2.
        let square = |(emitter, share): (&Emitter, f64)| {
            share * (0.5 * emitter.center.distance_squared(center) + emitter.spread)
        };
        let reach = |emitter: &Emitter| emitter.center.distance(center) + emitter.radius;
        let (mut base, mut along, mut moment) = (0.0, 0.0, DVec3::ZERO);
        for (emitter, share) in weighted() {
            match emitter.is_two_sided {
                true => base += share * (emitter.base + 0.5 * emitter.along),
                false => {
                    base += share * emitter.base;
                    along += share * emitter.along;
                    moment += emitter.axis * (share * emitter.along);
                }
            }
        }
        let length = moment.length();
        if along > 0.0 {
            base += CONVEX * (along - length * length / along).max(0.0);
        }
        let axis = moment.normalize_or(DVec3::Z);
        Emitter {
            radius: all.clone().map(reach).fold(0.0, f64::max),
            spread: weighted().map(square).sum(),
            base,
            along: length,
            axis,
            least_cosine: all.clone().map(|emitter| emitter.least_cosine_to(axis)).fold(1.0, f64::min),
            ..Emitter::point(center, intensity)
        }
    }

    /// The cosine of the angle to `axis` up to which it shines.
    fn least_cosine_to(&self, axis: DVec3) -> f64 {
        if self.least_cosine <= -1.0 {
            return EVERYWHERE;
        }
        let (a, b) = (self.least_cosine, self.axis.dot(axis).clamp(-1.0, 1.0));
        let [sin_a, sin_b] = [a, b].map(|cos| ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt());
        // From a sum of half a turn on, it is everywhere.
        if sin_a * b + a * sin_b <= 0.0 && b < 1.0 - 1e-12 { EVERYWHERE } else { a * b - sin_a * sin_b }
    }

    /// How far a cone around the axis of `group`, with its angle, begins behind `center` if it is to hold all light of this emitter.
    pub fn shift_in(&self, group: &Emitter) -> f64 {
        let cos = group.least_cosine;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        if cos <= -1.0 {
            return 0.0;
        }
        let offset = self.center - group.center;
        let height = offset.dot(group.axis);
        let beside = (offset - group.axis * height).length();
        let slope = cos.abs() / sin;
        let of_ball = slope * beside - height + self.radius / sin;
        if !self.is_flat {
            return of_ball;
        }
        // Of a disk across its own axis.
        let tilt = self.axis.cross(group.axis).length();
        of_ball.min(slope * (beside + self.radius) - height + self.radius * tilt)
    }
}
