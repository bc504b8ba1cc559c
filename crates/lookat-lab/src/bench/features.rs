//! What each feature costs: one scene, with one thing more at a time.

use lookat_render::{Settings, Stop};
use lookat_scene::Scene;

use super::bench_table::{BenchTable, Column};
use super::rendering::{load, render};
use crate::timed;

/// Two spheres on a floor under four lamps, without anything that can be left out.
const BASE: &str = include_str!("base.pbrt");

/// One feature in each line, the base first: its name, then pairs of texts to replace in the base.
const FEATURES: &str = include_str!("features.tsv");

/// The feature that is no part of the scene.
const ERROR_LAYERS: &str = "error layers";

fn features() -> Vec<(&'static str, Scene)> {
    let lines = FEATURES.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| scene(&line.split('\t').collect::<Vec<_>>())).collect()
}

/// Each feature by its ratio to the base, in the same round.
pub(super) fn table(rounds: usize) -> BenchTable {
    let features = features();
    // Seconds and rays.
    let columns: [Column<(f64, f64)>; 4] = [
        ("s", |own, _| own.0),
        ("time", |own, base| own.0 / base.0),
        ("rays", |own, base| own.1 / base.1),
        ("time of a ray", |own, base| own.0 / own.1 / (base.0 / base.1)),
    ];
    let title = "the base scene with one more feature, on one thread; ratios to the base".into();
    let names = features.iter().map(|(name, _)| (*name).into()).collect();
    BenchTable::measured(("features", title), &columns, names, rounds, |feature| {
        let (name, scene) = &features[feature];
        let stop = Stop::Samples { error_layers: *name == ERROR_LAYERS };
        let (seconds, rendered) =
            timed(|| render(scene, &Settings { threads: 1, stop, ..Settings::default() }));
        (seconds, rendered.statistics.rays as f64)
    })
}

/// The name of a feature, and the base as it changes it.
///
/// # Panics
///
/// If that gives no scene, or changes nothing.
fn scene(line: &[&'static str]) -> (&'static str, Scene) {
    let mut text = BASE.to_owned();
    for [from, to] in line[1..].as_chunks().0 {
        assert!(text.contains(from), "{}: {from}", line[0]);
        text = text.replacen(from, to, 1);
    }
    (line[0], load(line[0], &text, false))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_feature_makes_another_scene() {
        let inspected: Vec<_> = features()
            .into_iter()
            .map(|(name, scene)| {
                (name, lookat_render::inspect(&lookat_render::Prepared::new(&scene), &scene.view))
            })
            .collect();
        let base = &inspected[0].1;
        assert!(!base.has_lens && !base.shares_samples && !base.has_cutouts && base.world.instances == 0);
        assert_eq!(
            base.surfaces.as_ref().map(|surfaces| (surfaces.most_lobes, surfaces.coordinates)),
            Some((1, 0))
        );
        // Neither the sampler, nor error layers, nor the parameters of a material are a part of the inspection.
        let same = ["halton sampler", ERROR_LAYERS, "rough diffuse surfaces"];
        for (name, inspection) in &inspected[1..] {
            assert!(same.contains(name) || inspection != base, "{name}");
        }
    }
}
