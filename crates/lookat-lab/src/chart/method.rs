//! The methods that can be charted.

use lookat_render::{Stop, TargetError};
use lookat_scene::LightChoice::{self, Power, Spatial, Uniform};
use lookat_scene::SamplerKind::{self, Random, Stratified};
use lookat_scene::{DirectStrategy, Integrator, View};

use Change::{Direct, Path, Sampler};

/// A way to render a scene.
#[derive(Debug)]
pub struct Method {
    /// The name on the command line.
    pub name: &'static str,
    /// What it does, in a few words for the help.
    pub about: &'static str,
    /// The samples per pixel of its first point, a power of two. They double from point to point.
    pub first: u32,
    change: Change,
    /// The stopping rule of a picture by its samples per pixel.
    pub(super) stop: fn(u32) -> Stop,
}

/// How a method departs from the scene.
#[derive(Debug)]
enum Change {
    Sampler(SamplerKind),
    /// Direct lighting with the scene's depth.
    Direct(DirectStrategy),
    /// Path tracing with the scene's depth, and with its choice of lights for `None`.
    Path(Option<LightChoice>),
}

/// All methods. A further one is a further line here.
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
        // Each pixel takes at least 64 samples.
        first: 64,
        stop: to_target,
        ..method(
            "target-error",
            "Sobol sequence, with as many samples in each pixel as the target error needs",
            Sampler(SamplerKind::SOBOL),
        )
    },
    Method {
        // With fewer samples all pixels have equally many.
        first: 8,
        stop: |_| Stop::Adaptive,
        ..method("adaptive", "Sobol sequence, with more samples in noisy pixels", Sampler(SamplerKind::SOBOL))
    },
];

/// Renders the reference.
pub(super) const REFERENCE: Method = Method {
    stop: |_| Stop::Samples { error_layers: true },
    ..method("reference", "Sobol sequence", Sampler(SamplerKind::SOBOL))
};

const fn method(name: &'static str, about: &'static str, change: Change) -> Method {
    Method { name, about, first: 1, change, stop: |_| Stop::Samples { error_layers: false } }
}

/// The default methods: the samplers.
pub const DEFAULT: &str = "random,stratified,sobol";

/// Depth for a scene whose integrator has none: pbrt-v3's default.
const DEPTH: u32 = 5;

/// The method with this name.
pub fn named(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}

/// The target error of independent samples whose standard deviation is the value of the pixel. A picture may take up to four
/// times the samples.
fn to_target(samples: u32) -> Stop {
    let target = TargetError { relative: f64::from(samples).sqrt().recip(), confidence: 0.95 };
    Stop::TargetError { target, max_samples: samples.saturating_mul(4), limit: None, error_layers: false }
}

impl Method {
    /// Changes the view of a scene to this method.
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
    fn methods_change_the_view() {
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
