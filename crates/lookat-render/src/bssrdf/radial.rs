//! How far from where it enters light leaves a medium, in one channel.

use std::f64::consts::PI;

use super::spline::Spline;
use super::table::Table;

/// The share of light that probes look for: what leaves still farther away is left out, as in pbrt-v3.
const REACHED: f64 = 0.999;

/// Light that leaves a medium around where it enters.
#[derive(Clone)]
pub(crate) struct Radial {
    /// The share of the light that leaves in all.
    pub albedo: f64,
    /// The distance within which probes look for light.
    pub reach: f64,
    /// One over the unit of length of the profile.
    extinction: f64,
    profile: Profile,
}

#[derive(Clone)]
enum Profile {
    /// Photon beam diffusion: the light of rings over their width.
    Rings(Spline),
    /// Disney's normalized diffusion: two exponential functions, one of which falls off three times as slowly.
    Exponentials,
}

impl Radial {
    /// Light in a medium of an extinction coefficient and an albedo of single scattering. `None` if no light leaves it.
    pub fn new(table: &Table, extinction: f64, albedo: f64) -> Option<Self> {
        if !(0.0..=1.0).contains(&albedo) {
            return None;
        }
        let rings = table.profile(albedo);
        Radial::of(rings.integral(), extinction, Profile::Rings(rings))
    }

    /// Light of which a share comes back, around a distance that Disney's material has.
    pub fn exponentials(albedo: f64, distance: f64) -> Option<Self> {
        // As in pbrt-v3.
        const UNIT: f64 = 0.2;
        Radial::of(albedo, 1.0 / (UNIT * distance), Profile::Exponentials)
    }

    fn of(albedo: f64, extinction: f64, profile: Profile) -> Option<Self> {
        if !(extinction > 0.0 && extinction.is_finite() && albedo > 0.0 && albedo.is_finite()) {
            return None;
        }
        let mut radial = Radial { albedo, reach: 0.0, extinction, profile };
        radial.reach = radial.sample(REACHED);
        (radial.reach > 0.0).then_some(radial)
    }

    /// A distance from where light enters.
    pub fn sample(&self, u: f64) -> f64 {
        let r = match &self.profile {
            Profile::Rings(rings) => rings.invert_integral(u * self.albedo),
            Profile::Exponentials if u < 0.25 => -libm::log1p(-4.0 * u),
            Profile::Exponentials => -3.0 * libm::log1p((0.25 - u) / 0.75),
        };
        r / self.extinction
    }

    /// The density by area with which [`Radial::sample`] gives a distance.
    pub fn pdf(&self, distance: f64) -> f64 {
        // Nearer, the light of rings is proportional to their radius.
        let r = (distance * self.extinction).max(1e-9);
        let ring = match &self.profile {
            Profile::Rings(rings) if r > rings.end() => 0.0,
            Profile::Rings(rings) => rings.value(r).max(0.0) / self.albedo,
            Profile::Exponentials => 0.25 * (libm::exp(-r) + libm::exp(r / -3.0)),
        };
        ring / (2.0 * PI * r) * (self.extinction * self.extinction)
    }

    /// The share of the light that leaves at a distance, per area.
    pub fn value(&self, distance: f64) -> f64 {
        self.pdf(distance) * self.albedo
    }
}
