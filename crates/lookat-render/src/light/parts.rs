//! The parts of each light if all lights are sampled: triangles of meshes, as in pbrt-v3.

use lookat_scene::DirectStrategy;

use super::{LightTable, SceneLight};
use crate::light::tree::Leaves;

/// If a mesh light has more triangles, some are chosen.
pub(super) const MOST_EACH: usize = 16;
/// The number of triangles chosen among all such lights, if there are no more lights than this. It costs as much as sampling
/// [`MOST_EACH`].
const CHOSEN: u32 = 8;

impl LightTable {
    /// The number of parts of a light that are sampled: its triangles, or 1 for the whole light. 0 if its triangles are
    /// chosen at random.
    pub fn parts(&self, light: usize) -> u32 {
        match self.lights[light].leaves() {
            triangles if triangles > MOST_EACH => 0,
            triangles => triangles.max(1) as u32,
        }
    }

    /// The number of triangles chosen among all lights that have too many to sample each.
    pub fn chosen_triangles(&self, strategy: DirectStrategy) -> u32 {
        let samples = || self.finely_split.iter().map(|light| self.samples(*light, strategy));
        let sum = samples().fold(0, u32::saturating_add);
        samples().max().map_or(0, |most| most.saturating_mul(CHOSEN).max(sum))
    }

    /// True if some light has too many triangles to sample each.
    pub(super) fn chooses_triangles(&self) -> bool {
        !self.finely_split.is_empty()
    }

    /// Builds the tree of triangles, if any are chosen. See [`LightTable::prepare`].
    pub fn prepare_triangles(&self) {
        if self.chooses_triangles() {
            self.triangles();
        }
    }

    /// The triangles to choose from.
    pub(super) fn triangles(&self) -> &Leaves {
        self.triangles.get_or_init(|| Leaves::new(&self.lights, |light| self.parts(light) == 0))
    }
}

/// The lights that have too many triangles to sample each.
pub(super) fn finely_split(lights: &[SceneLight]) -> Vec<usize> {
    (0..lights.len()).filter(|light| lights[*light].leaves() > MOST_EACH).collect()
}
