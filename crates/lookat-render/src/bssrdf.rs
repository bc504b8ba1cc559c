//! Subsurface scattering: light that enters a body and leaves it at another point (separable BSSRDFs, PBR 11.4).
//!
//! Diffusion of photon beams: Habel, Christensen, Jarosz, "Photon Beam Diffusion: A Hybrid Monte Carlo Method for Subsurface Scattering",
//! EGSR 2013 (PBR 15.5). Normalized diffusion: Burley, "Extending the Disney BRDF to a BSDF with integrated subsurface scattering",
//! SIGGRAPH 2015 course notes.

mod diffusion;
mod radial;
mod spline;
mod table;

use std::array;
use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use lookat_scene::{Interior, Material, MaterialKind};

pub(crate) use diffusion::diffuse_transmittance;
use radial::Radial;
use table::Table;
pub(crate) use table::Tables;

/// What is inside of surfaces of a material.
pub(crate) struct Body<'s> {
    medium: Medium<'s>,
    /// The channels of a medium that is everywhere the same.
    pub constant: Option<Channels>,
}

/// How two colors describe a medium.
#[derive(Clone, Copy)]
enum Medium<'s> {
    /// The absorption and the scattering coefficients.
    Coefficients(&'s Table),
    /// The share of light that comes back, and the mean free path.
    Color(&'s Table),
    /// Normalized diffusion: the share of light that comes back, and Disney's distance.
    Distance,
}

/// Red, green and blue; `None` for those that no light comes back in.
pub(crate) type Channels = [Option<Radial>; 3];

impl<'s> Body<'s> {
    /// `None` for materials without a medium inside.
    pub fn new(material: &Material, tables: &'s Tables) -> Option<Self> {
        let MaterialKind::Subsurface(of) = material.inside()? else {
            return Some(Body { medium: Medium::Distance, constant: None });
        };
        let medium = match &of.interior {
            Interior::Coefficients(_) => Medium::Coefficients(tables.of(of)),
            Interior::Color(_) => Medium::Color(tables.of(of)),
        };
        let [a, b] = of.interior.colors();
        let constant = a.constant().zip(b.constant()).map(|(a, b)| medium.channels([a, b]));
        Some(Body { medium, constant })
    }

    /// The channels of a medium of these colors.
    pub fn channels(&self, colors: [Vec3; 2]) -> Channels {
        self.medium.channels(colors)
    }
}

impl Medium<'_> {
    fn channels(self, colors: [Vec3; 2]) -> Channels {
        array::from_fn(|channel| {
            // Negative values and NaN count as 0.
            let [a, b] = colors.map(|color| f64::from(color[channel]).max(0.0));
            match self {
                Medium::Coefficients(table) => Radial::new(table, a + b, b / (a + b)),
                Medium::Color(table) => Radial::new(table, 1.0 / b, table.albedo(a)),
                Medium::Distance => Radial::exponentials(a, b),
            }
        })
    }
}

/// The probabilities that probes run along the axes of a frame whose z axis is the normal.
const AXES: [f64; 3] = [0.25, 0.25, 0.5];

/// A line segment on which light may leave a body. Points where it crosses the surface are equally likely.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Probe {
    pub o: DVec3,
    pub d: DVec3,
    pub length: f64,
    /// What is left of the random number, 0 to 1.
    pub rest: f64,
}

/// A point where light comes out of a body, with the axes of its frame; the last is the normal.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub p: DVec3,
    pub axes: [DVec3; 3],
}

impl Place {
    /// Samples a probe for a path that enters with a throughput: an axis, a channel, and a point around the place in the plane across the
    /// axis.
    pub fn probe(
        &self,
        channels: &Channels,
        throughput: Vec3,
        choice: f64,
        [u, v]: [f64; 2],
    ) -> Option<Probe> {
        let [x, y, z] = self.axes;
        let (axis, rest) = match choice {
            _ if choice < 0.5 => ([x, y, z], choice * 2.0),
            _ if choice < 0.75 => ([y, z, x], choice * 4.0 - 2.0),
            _ => ([z, x, y], choice * 4.0 - 3.0),
        };
        let shares = shares(channels, throughput)?;
        let [red, green, _] = shares;
        let (chosen, before) = match rest {
            _ if rest < red => (0, 0.0),
            _ if rest < red + green => (1, red),
            _ => (2, red + green),
        };
        let radial = channels[chosen].as_ref()?;
        let r = radial.sample(u);
        let half = (radial.reach * radial.reach - r * r).max(0.0).sqrt();
        let ([x, y, d], (sin, cos)) = (axis, libm::sincos(2.0 * PI * v));
        let o = self.p + r * (x * cos + y * sin) - d * half;
        let rest = (rest - before) / shares[chosen];
        // Where a channel has no share, rounding has chosen it.
        let is_valid = r < radial.reach && o.is_finite() && rest < 1.0;
        is_valid.then_some(Probe { o, d, length: 2.0 * half, rest })
    }

    /// What leaves at the point `p`, where the normal is `n`, over the density by area with which [`Place::probe`] finds it. Only probes of
    /// channels that reach so far find it; pbrt-v3 counts the others as well, so that there it is too dark behind thin walls.
    pub fn weight(&self, channels: &Channels, throughput: Vec3, p: DVec3, n: DVec3) -> Vec3 {
        let Some(shares) = shares(channels, throughput) else { return Vec3::ZERO };
        let [d, n] = [p - self.p, n].map(|v| DVec3::from(self.axes.map(|axis| axis.dot(v))));
        let distance = d.length();
        let around = |a: f64, b: f64| (a * a + b * b).sqrt();
        let radii = [around(d.y, d.z), around(d.z, d.x), around(d.x, d.y)];
        let mut pdf = 0.0;
        for (radial, share) in channels.iter().zip(shares) {
            let Some(radial) = radial.as_ref().filter(|radial| distance < radial.reach) else { continue };
            for axis in 0..3 {
                pdf += share * AXES[axis] * n[axis].abs() * radial.pdf(radii[axis]);
            }
        }
        let of = |channel: &Option<Radial>| match channel {
            Some(radial) if pdf > 0.0 => (radial.value(distance) / pdf) as f32,
            _ => 0.0,
        };
        Vec3::from_array(channels.each_ref().map(of))
    }
}

/// The probabilities of the channels: in proportion to the square root of the light that they bring out. `None` without any light.
///
/// Measured against even probabilities: the bright channel of ketchup has 0.4 of the variance, and dark channels of a color as strong twice
/// as much. In proportion to the light itself, it would be 0.3 and six times.
fn shares(channels: &Channels, throughput: Vec3) -> Option<[f64; 3]> {
    let light = |channel: usize| {
        channels[channel]
            .as_ref()
            .map_or(0.0, |radial| (radial.albedo * f64::from(throughput[channel])).sqrt())
    };
    let light: [f64; 3] = array::from_fn(light);
    let sum: f64 = light.iter().sum();
    (sum > 0.0 && sum.is_finite()).then(|| light.map(|of| of / sum))
}

#[cfg(test)]
mod tests;
