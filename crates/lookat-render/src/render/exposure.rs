//! How bright the samples of a view are, for the scale of the film's sums.

use lookat_scene::{Sampler, SamplerKind};

use super::control::Meter;
use super::sample::{Context, Job, Pattern};
use super::waves::Worker;
use crate::film::Scale;
use crate::prepare::Brightest;

/// Pixels of the full picture across which brightness is looked for, in each direction.
const PROBES: u32 = 16;

/// A sample may be eight times as bright as the brightest light that a camera ray can hit: [`Scale`] has room for 2^31.
const SHARE_OF_BRIGHTEST: f64 = 1.0 / (1 << 28) as f64;

impl Context<'_> {
    /// Sets the scale of sums: by the root mean square of a few samples that depend on no seed and no crop window, and by the
    /// brightest light, which these samples may miss.
    pub fn expose(&mut self) {
        let sampler = Sampler { kind: SamplerKind::SOBOL, samples_per_pixel: 1 };
        let pattern = Pattern { sampler, seed: 0, is_watched: true };
        let [width, height] = self.film.of.resolution.map(u64::from);
        let place = |at: u64| {
            let [x, y] = [at % u64::from(PROBES), at / u64::from(PROBES)];
            [x * width, y * height].map(|at| (at / u64::from(PROBES)) as i32)
        };
        let jobs = (0..u64::from(PROBES).pow(2)).map(|at| Job::new(pattern, place(at), 0..1));
        let mut jobs: Vec<Job> = jobs.collect();
        self.sample_all(&mut Worker::new(self), &mut Meter::silent(self.control), &mut jobs);
        let squares: f64 = jobs.iter().map(|job| job.samples.squares).sum();
        let seen = (squares / f64::from(PROBES.pow(2))).sqrt();
        let Brightest { emitted, intensity } = self.prepared.brightest;
        let brightness = seen.max(emitted * SHARE_OF_BRIGHTEST);
        // Where the samples see nothing, the light of points and directions is all that is known.
        let brightness = if brightness > 0.0 { brightness } else { intensity };
        if brightness > 0.0 && brightness.is_finite() {
            self.scale = Scale::new(brightness);
        }
        self.film.set_scale(self.scale);
    }
}
