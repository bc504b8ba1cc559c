//! How many samples of lights and how many directions from the BSDF there are at a surface (PBR 14.3.1).

use lookat_scene::{DirectStrategy, LightChoice};

use crate::light::LightTable;

/// Which lights are sampled.
#[derive(Debug, Clone, Copy)]
pub(super) enum LightSamples {
    /// One, chosen at random.
    One(LightChoice),
    /// All of them, as often as the strategy says.
    Each(DirectStrategy),
}

/// How many directions from the BSDF there are at a surface. For one light: one, or two where no light is sampled. For all lights: as
/// many as the light with the most samples has, and the samples of each light that is not sampled.
pub(super) fn directions(table: &LightTable, lights: LightSamples, has_lune: bool) -> u32 {
    match lights {
        LightSamples::One(_) if table.leaves_all_to_directions(has_lune) => 2,
        LightSamples::One(_) => 1,
        LightSamples::Each(strategy) => {
            let others = (table.eligible(has_lune)..table.len()).map(|light| table.samples(light, strategy));
            others.fold(most_samples(table, strategy), u32::saturating_add)
        }
    }
}

/// The most samples that any of the lights asks for, if any is more than a point or a direction.
pub(super) fn most_samples(table: &LightTable, strategy: DirectStrategy) -> u32 {
    let samples = (0..table.len()).map(|light| table.samples(light, strategy));
    samples.max().filter(|_| table.has_extended()).unwrap_or(0)
}
