//! The methods that can be charted.

use lookat_render::{Stop, TargetError};
use lookat_scene::LightChoice::{self, Power, Spatial, Uniform};
use lookat_scene::SamplerKind::{self, Random, Stratified};
use lookat_scene::{DirectStrategy, Integrator, View};

use Change::{Direct, Path, Sampler};

/// A way to render, to be held against others.
#[derive(Debug)]
pub struct Method {
    /// As users type it.
    pub name: &'static str,
    /// In a few words.
    pub about: &'static str,
    /// The samples per pixel that it begins with, in place of 1; they double from there.
    pub first: u32,
    change: Change,
    /// When a picture of so many samples per pixel is done.
    pub(super) stop: fn(u32) -> Stop,
}

/// What is not as the scene says.
#[derive(Debug)]
enum Change {
    Sampler(SamplerKind),
    /// Direct lighting, as deep as the scene's integrator.
    Direct(DirectStrategy),
    /// Path tracing, as deep as the scene's integrator, with its choice of lights if no other is given.
    Path(Option<LightChoice>),
}

/// All of them. Another one is another line here.
pub const METHODS: &[Method] = &[
    method("random", "independent samples", Sampler(Random)),
    method(
        "stratified",
        "one sample in each cell of a grid",
        Sampler(Stratified { cells: [1, 1], jitter: true }),
    ),
    method("sobol", "Sobol sequence", Sampler(SamplerKind::SOBOL)),
    method("direct-one", "direct lighting, one random light at each surface", Direct(DirectStrategy::One)),
    method("direct-all", "direct lighting, all lights at each surface", Direct(DirectStrategy::All)),
    method("path", "path tracing", Path(None)),
    method("path-uniform", "path tracing, lights chosen with equal probabilities", Path(Some(Uniform))),
    method("path-power", "path tracing, lights chosen by power", Path(Some(Power))),
    method(
        "path-spatial",
        "path tracing, lights chosen by the light they send to the shaded point",
        Path(Some(Spatial)),
    ),
    Method {
        // Every pixel takes as many before it is judged.
        first: 64,
        stop: to_target,
        ..method(
            "target-error",
            "Sobol sequence, with as many samples in each pixel as the target error needs",
            Sampler(SamplerKind::SOBOL),
        )
    },
    Method {
        // With fewer, all pixels have alike many.
        first: 8,
        stop: |_| Stop::Adaptive,
        ..method("adaptive", "Sobol sequence, with more samples in noisy pixels", Sampler(SamplerKind::SOBOL))
    },
];

/// Makes the reference.
pub(super) const REFERENCE: Method = Method {
    stop: |_| Stop::Samples { error_layers: true },
    ..method("reference", "Sobol sequence", Sampler(SamplerKind::SOBOL))
};

const fn method(name: &'static str, about: &'static str, change: Change) -> Method {
    Method { name, about, first: 1, change, stop: |_| Stop::Samples { error_layers: false } }
}

/// The methods that are charted where none is named: the samplers.
pub const DEFAULT: &str = "random,stratified,sobol";

/// Depth where the scene's integrator has none, and pbrt-v3's default.
const DEPTH: u32 = 5;

/// The method of this name.
pub fn named(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}

/// The target error on the rung of so many samples: what as many independent samples of a pixel give whose deviation is
/// about its value. The samples that are really taken are counted.
fn to_target(samples: u32) -> Stop {
    let target = TargetError { relative: f64::from(samples).sqrt().recip(), confidence: 0.95 };
    Stop::TargetError { target, max_samples: samples.saturating_mul(4), limit: None, error_layers: false }
}

impl Method {
    /// Changes how a scene is rendered.
    pub(super) fn apply(&self, view: &mut View) {
        let max_depth = depth(view.integrator);
        match self.change {
            Sampler(kind) => view.sampler.kind = kind,
            Direct(strategy) => view.integrator = Integrator::DirectLighting { strategy, max_depth },
            Path(choice) => {
                let (roulette_threshold, own) = match view.integrator {
                    Integrator::Path { roulette_threshold, light_choice, .. } => {
                        (roulette_threshold, light_choice)
                    }
                    _ => (1.0, Spatial),
                };
                let light_choice = choice.unwrap_or(own);
                view.integrator = Integrator::Path { max_depth, roulette_threshold, light_choice };
            }
        }
    }
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
    use crate::text_scene::{around_eye, scene};

    #[test]
    fn methods_change_what_they_name() {
        let integrator =
            |light_choice| Integrator::Path { max_depth: 7, roulette_threshold: 0.5, light_choice };
        let mut view = scene(&around_eye("")).view;
        view.integrator = integrator(Power);
        let own = view.sampler.kind;
        let chosen = |name: &str| {
            let (method, mut view) = (named(name).unwrap(), view.clone());
            method.apply(&mut view);
            (view.sampler.kind, view.integrator, (method.stop)(4))
        };
        let stop = Stop::Samples { error_layers: false };
        assert_eq!(chosen("sobol"), (SamplerKind::SOBOL, integrator(Power), stop));
        assert_eq!(chosen("path"), (own, integrator(Power), stop));
        let direct = Integrator::DirectLighting { strategy: DirectStrategy::All, max_depth: 7 };
        assert_eq!(chosen("direct-all"), (own, direct, stop));
        assert_eq!(chosen("path-uniform"), (own, integrator(Uniform), stop));
        assert_eq!(chosen("adaptive"), (SamplerKind::SOBOL, integrator(Power), Stop::Adaptive));
        assert!(DEFAULT.split(',').all(|name| named(name).is_some()));
    }
}
