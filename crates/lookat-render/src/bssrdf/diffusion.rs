//! Photon beam diffusion: the light that leaves a half space around a beam that enters it at a right angle (PBR 15.5). Lengths are in mean
//! free paths.

use std::f64::consts::PI;

/// The indices of refraction that the fits of Fresnel moments are for.
const FITTED: [f64; 2] = [0.4, 2.5];
/// Beyond, phase functions are as good as delta distributions.
const MOST_FORWARD: f64 = 0.999;
/// The depths along the beam that light scatters at, by equal shares of it.
const DEPTHS: usize = 100;

/// A medium of a mean cosine and an index of refraction. The index is the same on both sides of the fit.
pub(super) struct Beam {
    g: f64,
    eta: f64,
    moments: [f64; 2],
    depths: [f64; DEPTHS],
}

/// The share of diffuse light from outside that a boundary lets through.
pub(crate) fn diffuse_transmittance(eta: f64) -> f64 {
    1.0 - 2.0 * fresnel_moment_1(1.0 / eta.clamp(FITTED[0], FITTED[1]))
}

impl Beam {
    pub fn new(g: f64, eta: f64) -> Self {
        let eta = eta.clamp(FITTED[0], FITTED[1]);
        let depth = |index: usize| -libm::log(1.0 - (index as f64 + 0.5) / DEPTHS as f64);
        Beam {
            g: g.clamp(-MOST_FORWARD, MOST_FORWARD),
            eta,
            moments: [fresnel_moment_1(eta), fresnel_moment_2(eta)],
            depths: std::array::from_fn(depth),
        }
    }

    /// The light per area at a distance `r` from the beam, in a medium of a single-scattering albedo.
    pub fn exitance(&self, albedo: f64, r: f64) -> f64 {
        self.single(albedo, r) + self.multiple(albedo, r)
    }

    /// Light that scatters once (BeamDiffusionSS).
    fn single(&self, albedo: f64, r: f64) -> f64 {
        let Beam { g, eta, .. } = *self;
        // Before, all light is reflected at the surface. In a thinner medium none is.
        let critical = r * (eta * eta - 1.0).max(0.0).sqrt();
        let of = |depth: &f64| {
            let t = critical + depth;
            let distance = (r * r + t * t).sqrt();
            let cos = t / distance;
            let base = 1.0 + g * g + 2.0 * g * cos;
            let phase = (1.0 - g * g) / (4.0 * PI * base * base.sqrt());
            let leaves = 1.0 - fresnel_leaving(cos, eta);
            libm::exp(-(distance + critical)) / (distance * distance) * phase * leaves * cos
        };
        albedo * self.mean(of)
    }

    /// Light that scatters more often, as from a dipole (BeamDiffusionMS).
    fn multiple(&self, albedo: f64, r: f64) -> f64 {
        let Beam { g, moments: [first, second], .. } = *self;
        let (scattered, absorbed) = (albedo * (1.0 - g), 1.0 - albedo);
        let extinction = scattered + absorbed;
        let reduced = scattered / extinction;
        // Grosjean's diffusion.
        let diffusion = (2.0 * absorbed + scattered) / (3.0 * extinction * extinction);
        let transport = (absorbed / diffusion).sqrt();
        let extrapolation = -2.0 * diffusion * (1.0 + 3.0 * second) / (1.0 - 2.0 * first);
        let (of_fluence, of_flux) = (0.25 * (1.0 - 2.0 * first), 0.5 * (1.0 - 3.0 * second));
        let of = |depth: &f64| {
            let real = depth / extinction;
            let mirrored = 2.0 * extrapolation - real;
            let [near, far] = [real, mirrored].map(|z| (r * r + z * z).sqrt());
            let [at_near, at_far] = [near, far].map(|d| libm::exp(-transport * d) / d);
            let flux = |z: f64, d: f64, at: f64| z * (1.0 + transport * d) * at / (d * d);
            let fluence = (at_near - at_far) / diffusion;
            let out =
                fluence * of_fluence + (flux(real, near, at_near) - flux(mirrored, far, at_far)) * of_flux;
            (1.0 - libm::exp(-2.0 * extinction * (near + real))) * out
        };
        reduced * reduced / (4.0 * PI) * self.mean(of)
    }

    fn mean(&self, of: impl Fn(&f64) -> f64) -> f64 {
        self.depths.iter().map(of).sum::<f64>() / DEPTHS as f64
    }
}

/// The Fresnel reflectance for light that leaves a dielectric of index `eta` at an angle of cosine `cos`.
fn fresnel_leaving(cos: f64, eta: f64) -> f64 {
    let squared = eta * eta * (1.0 - cos * cos);
    if squared >= 1.0 {
        return 1.0;
    }
    let outside = (1.0 - squared).sqrt();
    let parallel = (cos - eta * outside) / (cos + eta * outside);
    let perpendicular = (eta * cos - outside) / (eta * cos + outside);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// The first moment of the Fresnel reflectance (d'Eon and Irving, "A Quantized-Diffusion Model for Rendering Translucent Materials",
/// SIGGRAPH 2011).
fn fresnel_moment_1(eta: f64) -> f64 {
    let coefficients = if eta < 1.0 {
        [-0.68441, 2.49277, -3.904945, 3.37668, -1.73965, 0.45966]
    } else {
        [0.12746, -1.27198, 5.11455, -10.4646, 11.1136, -4.61686]
    };
    polynomial(coefficients, eta)
}

/// The second moment of the same.
fn fresnel_moment_2(eta: f64) -> f64 {
    if eta < 1.0 {
        return polynomial([0.0486, 0.07883, -0.65095, 1.12077, -0.8735, 0.27614], eta);
    }
    polynomial([0.63942, -9.00603, 54.9327, -189.519, 404.557, 0.0], eta)
        + polynomial([45.3087, -218.725, 458.843, -547.033], 1.0 / eta)
}

/// The coefficient of the highest power first.
fn polynomial<const N: usize>(coefficients: [f64; N], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}
