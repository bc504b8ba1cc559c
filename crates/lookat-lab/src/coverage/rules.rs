//! Rules of others for when a pixel is done, tried with independent samples.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use lookat_render::DARK;

use super::known::Known;
use super::{Judged, Target, brightness, luminance};

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// What it is called.
    pub name: &'static str,
    /// Samples before it is asked for the first time; from then on after every 16.
    first: u32,
    /// Whether to stop.
    stops: fn(&Sums, allowed: f64) -> bool,
}

/// Rules that are used.
pub const RULES: [Rule; 4] = [
    Rule { name: "interval of the samples' deviation, from 4 samples", first: 4, stops: by_deviation },
    Rule { name: "interval of the samples' deviation, from 64 samples", first: 64, stops: by_deviation },
    // Dammertz et al., "A Hierarchical Automatic Stopping Condition for Monte Carlo Global Illumination", 2010, of a pixel.
    Rule { name: "half of the samples against all, from 16 samples", first: 16, stops: by_half },
    Rule { name: "half of the samples against all, from 64 samples", first: 64, stops: by_half },
];

/// Of samples that are 0 or 1.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: f64,
    bright: f64,
    /// Of every second sample.
    half: f64,
}

fn by_deviation(sums: &Sums, allowed: f64) -> bool {
    let mean = sums.bright / sums.count;
    let variance = mean * (1.0 - mean) / (sums.count - 1.0);
    1.96 * variance.sqrt() <= allowed
}

fn by_half(sums: &Sums, allowed: f64) -> bool {
    (sums.bright / sums.count - 2.0 * sums.half / sums.count).abs() <= allowed
}

/// The pixels of white on black under a rule; none of other pictures.
pub fn rule_pixels(rule: &Rule, known: &Known, target: &Target) -> Vec<Judged> {
    let dark = DARK * brightness(&known.values);
    let Some(is_bright) = known.is_bright else { return Vec::new() };
    let pixels = known.values.iter().enumerate().map(|(at, value)| {
        let mut random = Pcg64Mcg::seed_from_u64(1100 << 32 | at as u64);
        let mut sums = Sums::default();
        loop {
            let bright = f64::from(u8::from(is_bright(known.place(at), &mut random)));
            if sums.count % 2.0 == 0.0 {
                sums.half += bright;
            }
            sums.bright += bright;
            sums.count += 1.0;
            let count = sums.count as u32;
            let allowed = target.relative * (sums.bright / sums.count).max(dark);
            let is_asked = count == rule.first || count > rule.first && count.is_multiple_of(16);
            if count >= target.max_samples || is_asked && (rule.stops)(&sums, allowed) {
                break;
            }
        }
        let allowed = target.relative * luminance(value).max(dark);
        let error = (sums.bright / sums.count - value[1]) / allowed;
        Judged { value: value[1], error, samples: sums.count as u32, independent: 0.0 }
    });
    pixels.collect()
}
