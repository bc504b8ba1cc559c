//! The methods that can be charted.

use lookat_render::{Stop, TargetError};
use lookat_scene::LightChoice::{self, Power, Spatial, Uniform};
use lookat_scene::SamplerKind::{self, Random, Stratified};
use lookat_scene::{DirectStrategy, Integrator, View};

/// A way to render a scene.
#[derive(Debug)]
pub struct Method {
    /// The name on the command line.
    pub name: &'static str,
    /// What it does, in a few words for the help.
    pub about: &'static str,
    /// The samples per pixel of its first point, a power of two. They double from point to point.
    pub first: u32,
    /// Changes the view of a scene to this method.
    pub(super) change: fn(&mut View),
    /// The stopping rule of a picture by its samples per pixel.
    pub(super) stop: fn(u32) -> Stop,
}

/// All methods. A further one is a further line here.
pub const METHODS: &[Method] = &[
    method("random", "independent samples", |view| view.sampler.kind = Random),
    method("stratified", "one sample in each cell of a grid", |view| {
        view.sampler.kind = Stratified { cells: [1, 1], jitter: true };
    }),
    method("sobol", "Sobol sequence", sobol),
    method("direct-one", "direct lighting, one random light at each surface", |view| {
        direct(view, DirectStrategy::One)
    }),
    method("direct-all", "direct lighting, all lights at each surface", |view| {
        direct(view, DirectStrategy::All)
    }),
    method("path", "path tracing", |view| path(view, None)),
    method("path-uniform", "path tracing, lights chosen with equal probabilities", |view| {
        path(view, Some(Uniform));
    }),
    method("path-power", "path tracing, lights chosen by power", |view| path(view, Some(Power))),
    method(
        "path-spatial",
        "path tracing, lights chosen by the light they send to the shaded point",
        |view| {
            path(view, Some(Spatial));
        },
    ),
    Method {
        // Each pixel takes at least 64 samples.
        first: 64,
        stop: to_target,
        ..method(
            "target-error",
            "Sobol sequence, with as many samples in each pixel as the target error needs",
            sobol,
        )
    },
    Method {
        // With fewer samples all pixels have equally many.
        first: 8,
        stop: |_| Stop::Adaptive,
        ..method("adaptive", "Sobol sequence, with more samples in noisy pixels", sobol)
    },
];

/// Renders the reference.
pub(super) const REFERENCE: Method =
    Method { stop: |_| Stop::Samples { error_layers: true }, ..method("reference", "Sobol sequence", sobol) };

const fn method(name: &'static str, about: &'static str, change: fn(&mut View)) -> Method {
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

fn sobol(view: &mut View) {
    view.sampler.kind = SamplerKind::SOBOL;
}

/// Direct lighting with the scene's depth.
fn direct(view: &mut View, strategy: DirectStrategy) {
    view.integrator = Integrator::DirectLighting { strategy, max_depth: depth(view.integrator) };
}

/// Path tracing with the scene's depth, and with its choice of lights for `None`.
fn path(view: &mut View, choice: Option<LightChoice>) {
    let (roulette_threshold, own) = match view.integrator {
        Integrator::Path { roulette_threshold, light_choice, .. } => (roulette_threshold, light_choice),
        _ => (1.0, Spatial),
    };
    let (max_depth, light_choice) = (depth(view.integrator), choice.unwrap_or(own));
    view.integrator = Integrator::Path { max_depth, roulette_threshold, light_choice };
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
            (method.change)(&mut view);
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
