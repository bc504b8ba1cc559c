//! Measures the time of the stages of a rendering.

use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use lookat_scene::Scene;

use super::{Settings, on_threads, run};
use crate::integrator::{StageProfile, stage_profiles};
use crate::prepare::Prepared;

/// Renders a scene on one thread, and measures the stages of that. The clock is read at the beginning of each stage of each group of
/// samples, so the rendering takes a little longer than otherwise. Packets of rays are kept, about 800 bytes each, and
/// traced again. Rays behind surfaces without a material belong to no stage of their own.
pub fn profile(scene: &Scene) -> Vec<StageProfile> {
    let settings = Settings { threads: 1, ..Settings::default() };
    on_threads(&settings, || {
        let (prepared, profilers) = (Prepared::new(scene), Mutex::default());
        let progress = |_: super::Progress| ControlFlow::Continue(());
        run(&prepared, &scene.view, &settings, None, &progress, Some(&profilers), None)
            .expect("an empty film is of any rendering");
        let profilers = profilers.into_inner().unwrap_or_else(PoisonError::into_inner);
        stage_profiles(&profilers, &prepared.traceable, &prepared.lights)
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::render::render;
    use crate::testing::scene;

    #[test]
    fn each_ray_belongs_to_a_stage() {
        let scene = scene(
            r#"Film "image" "integer xresolution" 20 "integer yresolution" 20 Camera "perspective"
            Sampler "sobol" "integer pixelsamples" 64 Integrator "path" "integer maxdepth" 2 WorldBegin
            LightSource "infinite" AttributeBegin AreaLightSource "diffuse" Translate 0 3 4
            Shape "sphere" "float radius" .5 AttributeEnd Translate 0 0 4 Shape "sphere" Shape "disk" WorldEnd"#,
        );
        let stages = profile(&scene);
        let traced: Vec<_> = stages.iter().filter(|stage| stage.name.ends_with("rays")).collect();
        let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
        assert_eq!(traced.iter().map(|stage| stage.lanes).sum::<u64>(), rendered.statistics.rays);
        assert_eq!((traced.len(), traced[0].lanes), (4, rendered.statistics.samples));
        for stage in &stages {
            let is_counted = stage.name == "shading" || stage.name.ends_with("rays");
            assert!(stage.time > Duration::ZERO && is_counted == (stage.lanes > 0), "{stage:?}");
            // A group may have no shadow ray at all.
            assert!(stage.lanes <= 8 * stage.batches, "{stage:?}");
            assert_eq!(stage.alone > Duration::ZERO, stage.name.ends_with("rays"), "{stage:?}");
        }
    }
}
