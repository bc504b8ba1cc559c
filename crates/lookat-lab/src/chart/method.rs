//! The methods that can be charted.

use lookat_render::{Settings, Stop, TargetError};
use lookat_scene::{DirectStrategy, Integrator, LightChoice, SamplerKind, Scene};

/// What methods may change: all else is the scene's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// How samples are placed.
    pub sampler: SamplerKind,
    /// How light is computed.
    pub integrator: Integrator,
    /// The rest; the seed and error layers are set elsewhere.
    pub settings: Settings,
}

/// A way to render, to be held against others.
#[derive(Debug)]
pub struct Method {
    /// As users type it.
    pub name: &'static str,
    /// In a few words.
    pub about: &'static str,
    /// The samples per pixel that it begins with, in place of 1; they double from there.
    pub first: u32,
    /// Changes how the scene is rendered with so many samples per pixel.
    pub choose: fn(&mut Way, u32),
}

/// All of them. Another one is another line here.
pub const METHODS: &[Method] = &[
    method("random", "independent samples", 1, |way, _| way.sampler = SamplerKind::Random),
    method("stratified", "one sample in each cell of a grid", 1, |way, _| {
        way.sampler = SamplerKind::Stratified { cells: [1, 1], jitter: true }
    }),
    method("halton", "Halton sequence", 1, |way, _| {
        way.sampler = SamplerKind::Halton { pixel_center: false }
    }),
    method("sobol", "Sobol sequence", 1, |way, _| way.sampler = SamplerKind::Sobol),
    method("direct-one", "direct lighting, one random light at each surface", 1, |way, _| {
        way.integrator = direct(way.integrator, DirectStrategy::One)
    }),
    method("direct-all", "direct lighting, all lights at each surface", 1, |way, _| {
        way.integrator = direct(way.integrator, DirectStrategy::All)
    }),
    method("path", "path tracing", 1, |way, _| way.integrator = path(way.integrator, None)),
    method("path-uniform", "path tracing, lights chosen with equal probabilities", 1, |way, _| {
        way.integrator = path(way.integrator, Some(LightChoice::Uniform))
    }),
    method("path-power", "path tracing, lights chosen by power", 1, |way, _| {
        way.integrator = path(way.integrator, Some(LightChoice::Power))
    }),
    method(
        "path-spatial",
        "path tracing, lights chosen by the light they send to the shaded point",
        1,
        |way, _| way.integrator = path(way.integrator, Some(LightChoice::Spatial)),
    ),
    method(
        "target-error",
        "Sobol sequence, with as many samples in each pixel as the target error needs",
        FIRST_OF_TARGET,
        |way, samples| {
            way.sampler = SamplerKind::Sobol;
            let (target, max_samples) = (target(samples), samples.saturating_mul(4));
            way.settings.stop = Stop::TargetError { target, max_samples, limit: None, error_layers: false };
        },
    ),
    method("adaptive", "Sobol sequence, with more samples in noisy pixels", FIRST_OF_ADAPTIVE, |way, _| {
        way.sampler = SamplerKind::Sobol;
        way.settings.stop = Stop::Adaptive;
    }),
];

const fn method(name: &'static str, about: &'static str, first: u32, choose: fn(&mut Way, u32)) -> Method {
    Method { name, about, first, choose }
}

/// Every pixel takes as many before it is judged.
const FIRST_OF_TARGET: u32 = 64;

/// With fewer, all pixels have alike many.
const FIRST_OF_ADAPTIVE: u32 = 8;

/// The methods that are charted where none is named: the samplers.
pub const DEFAULT: &str = "random,stratified,halton,sobol";

/// Depth where the scene's integrator has none, and pbrt-v3's default.
const DEPTH: u32 = 5;

impl Way {
    /// How the scene says that it is rendered, on so many threads; 0 is one for each processor.
    pub fn of(scene: &Scene, threads: usize) -> Way {
        let settings = Settings { threads, ..Settings::default() };
        Way { sampler: scene.view.sampler.kind, integrator: scene.view.integrator, settings }
    }
}

/// The method of this name.
pub fn named(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}

/// The target error on the rung of so many samples: what as many independent samples of a pixel give whose deviation is
/// about its value. The samples that are really taken are counted.
fn target(samples: u32) -> TargetError {
    TargetError { relative: f64::from(samples).sqrt().recip(), confidence: 0.95 }
}

/// Direct lighting, as deep as the scene's integrator.
fn direct(integrator: Integrator, strategy: DirectStrategy) -> Integrator {
    Integrator::DirectLighting { strategy, max_depth: depth(integrator) }
}

/// Path tracing, as deep as the scene's integrator, with its choice of lights if no other is given.
fn path(integrator: Integrator, choice: Option<LightChoice>) -> Integrator {
    let (roulette_threshold, own) = match integrator {
        Integrator::Path { roulette_threshold, light_choice, .. } => (roulette_threshold, light_choice),
        _ => (1.0, LightChoice::Spatial),
    };
    Integrator::Path { max_depth: depth(integrator), roulette_threshold, light_choice: choice.unwrap_or(own) }
}

fn depth(integrator: Integrator) -> u32 {
    match integrator {
        Integrator::DirectLighting { max_depth, .. } | Integrator::Path { max_depth, .. } => max_depth,
        Integrator::AmbientOcclusion { .. } => DEPTH,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_change_what_they_name() {
        let integrator =
            Integrator::Path { max_depth: 7, roulette_threshold: 0.5, light_choice: LightChoice::Power };
        let way = Way {
            sampler: SamplerKind::Halton { pixel_center: true },
            integrator,
            settings: Settings::default(),
        };
        let chosen = |name: &str| {
            let mut way = way;
            (named(name).unwrap().choose)(&mut way, 4);
            way
        };
        assert_eq!(chosen("sobol"), Way { sampler: SamplerKind::Sobol, ..way });
        assert_eq!(chosen("path"), way);
        let direct = Integrator::DirectLighting { strategy: DirectStrategy::All, max_depth: 7 };
        assert_eq!(chosen("direct-all"), Way { integrator: direct, ..way });
        let uniform =
            Integrator::Path { max_depth: 7, roulette_threshold: 0.5, light_choice: LightChoice::Uniform };
        assert_eq!(chosen("path-uniform"), Way { integrator: uniform, ..way });
        assert!(DEFAULT.split(',').all(|name| named(name).is_some()));
    }
}
