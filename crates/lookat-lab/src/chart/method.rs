//! The methods that can be charted.

use lookat_render::{Stop, TargetError};
use lookat_scene::{DirectStrategy, Integrator, LightChoice, SamplerKind};

/// A way to render, to be held against others.
#[derive(Debug)]
pub struct Method {
    /// As users type it.
    pub name: &'static str,
    /// In a few words.
    pub about: &'static str,
    /// The samples per pixel that it begins with, in place of 1; they double from there.
    pub first: u32,
    /// How samples are placed; `None` leaves that to the scene.
    pub(super) sampler: Option<SamplerKind>,
    /// How light is computed, instead of how the scene does it.
    pub(super) integrator: fn(Integrator) -> Integrator,
    /// When a picture of so many samples per pixel is done.
    pub(super) stop: fn(u32) -> Stop,
}

/// All of them. Another one is another line here.
pub const METHODS: &[Method] = &[
    sampler("random", "independent samples", SamplerKind::Random),
    sampler(
        "stratified",
        "one sample in each cell of a grid",
        SamplerKind::Stratified { cells: [1, 1], jitter: true },
    ),
    sampler("halton", "Halton sequence", SamplerKind::Halton { pixel_center: false }),
    sampler("sobol", "Sobol sequence", SamplerKind::Sobol),
    integrator("direct-one", "direct lighting, one random light at each surface", |scene| {
        direct(scene, DirectStrategy::One)
    }),
    integrator("direct-all", "direct lighting, all lights at each surface", |scene| {
        direct(scene, DirectStrategy::All)
    }),
    integrator("path", "path tracing", |scene| path(scene, None)),
    integrator("path-uniform", "path tracing, lights chosen with equal probabilities", |scene| {
        path(scene, Some(LightChoice::Uniform))
    }),
    integrator("path-power", "path tracing, lights chosen by power", |scene| {
        path(scene, Some(LightChoice::Power))
    }),
    integrator(
        "path-spatial",
        "path tracing, lights chosen by the light they send to the shaded point",
        |scene| path(scene, Some(LightChoice::Spatial)),
    ),
    Method {
        // Every pixel takes as many before it is judged.
        first: 64,
        stop: |samples| Stop::TargetError {
            target: target(samples),
            max_samples: samples.saturating_mul(4),
            limit: None,
            error_layers: false,
        },
        ..sampler(
            "target-error",
            "Sobol sequence, with as many samples in each pixel as the target error needs",
            SamplerKind::Sobol,
        )
    },
    Method {
        // With fewer, all pixels have alike many.
        first: 8,
        stop: |_| Stop::Adaptive,
        ..sampler("adaptive", "Sobol sequence, with more samples in noisy pixels", SamplerKind::Sobol)
    },
];

/// Makes the reference.
pub(super) const REFERENCE: Method = Method {
    stop: |_| Stop::Samples { error_layers: true },
    ..sampler("reference", "Sobol sequence", SamplerKind::Sobol)
};

const fn sampler(name: &'static str, about: &'static str, kind: SamplerKind) -> Method {
    Method { sampler: Some(kind), ..integrator(name, about, |scene| scene) }
}

const fn integrator(
    name: &'static str,
    about: &'static str,
    integrator: fn(Integrator) -> Integrator,
) -> Method {
    let stop = |_| Stop::Samples { error_layers: false };
    Method { name, about, first: 1, sampler: None, integrator, stop }
}

/// The methods that are charted where none is named: the samplers.
pub const DEFAULT: &str = "random,stratified,halton,sobol";

/// Depth where the scene's integrator has none, and pbrt-v3's default.
const DEPTH: u32 = 5;

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
        let chosen = |name: &str| {
            let method = named(name).unwrap();
            (method.sampler, (method.integrator)(integrator), (method.stop)(4))
        };
        let stop = Stop::Samples { error_layers: false };
        assert_eq!(chosen("sobol"), (Some(SamplerKind::Sobol), integrator, stop));
        assert_eq!(chosen("path"), (None, integrator, stop));
        let direct = Integrator::DirectLighting { strategy: DirectStrategy::All, max_depth: 7 };
        assert_eq!(chosen("direct-all"), (None, direct, stop));
        let uniform =
            Integrator::Path { max_depth: 7, roulette_threshold: 0.5, light_choice: LightChoice::Uniform };
        assert_eq!(chosen("path-uniform"), (None, uniform, stop));
        assert_eq!(chosen("adaptive"), (Some(SamplerKind::Sobol), integrator, Stop::Adaptive));
        assert!(DEFAULT.split(',').all(|name| named(name).is_some()));
    }
}
