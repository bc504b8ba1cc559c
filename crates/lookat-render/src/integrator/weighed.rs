//! How many samples of lights and how many directions from the BSDF there are at a surface (PBR 14.3.1).

use lookat_scene::{DirectStrategy, LightChoice};

use crate::light::LightTable;

/// How many samples of lights and how many directions from the BSDF there are at a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples {
    pub lights: LightSamples,
    pub directions: u32,
}

/// Which lights are sampled.
#[derive(Debug, Clone, Copy)]
pub(super) enum LightSamples {
    /// One, chosen at random.
    One(LightChoice),
    /// All of them, as often as the strategy says.
    Each(DirectStrategy),
}

impl Samples {
    /// For one light: one direction, or two where no light is sampled. For all lights: as many directions as the light with the most
    /// samples has, and the samples of each light that is not sampled.
    pub fn new(table: &LightTable, lights: LightSamples, has_lune: bool) -> Self {
        let directions = match lights {
            LightSamples::One(_) if table.leaves_all_to_directions(has_lune) => 2,
            LightSamples::One(_) => 1,
            LightSamples::Each(strategy) => {
                let others =
                    (table.eligible(has_lune)..table.len()).map(|light| table.samples(light, strategy));
                others.fold(most_samples(table, strategy), u32::saturating_add)
            }
        };
        Samples { lights, directions }
    }
}

/// The most samples that any of the lights asks for, if any is more than a point or a direction.
pub(super) fn most_samples(table: &LightTable, strategy: DirectStrategy) -> u32 {
    let samples = (0..table.len()).map(|light| table.samples(light, strategy));
    samples.max().filter(|_| table.has_extended()).unwrap_or(0)
}
