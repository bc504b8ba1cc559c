//! The lights that a tree holds, and the triangles of meshes among them.

use std::iter::{empty, once};

use super::SceneLight;
use super::tree::{Emitter, LightTree};

/// The leaves of the tree of lights.
pub(super) struct Leaves {
    pub tree: LightTree,
    /// The number of the first leaf of each light, and at last how many leaves there are.
    first: Vec<u32>,
}

/// A light, or a triangle of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leaf {
    pub light: usize,
    /// The number of the triangle, or 0 of lights that are one leaf.
    pub triangle: usize,
}

impl Leaves {
    /// Those of the lights that `is_held` says.
    pub fn new(lights: &[SceneLight], is_held: impl Fn(usize) -> bool) -> Self {
        let mut first = vec![0];
        let mut count = 0;
        for (number, light) in lights.iter().enumerate() {
            count += if is_held(number) { light.leaves() as u32 } else { 0 };
            first.push(count);
        }
        let held = lights.iter().enumerate().filter(|(number, _)| is_held(*number));
        Leaves { tree: LightTree::new(count as usize, held.flat_map(|(_, light)| light.emitters())), first }
    }

    /// What a leaf is.
    pub fn of(&self, leaf: usize) -> Leaf {
        let light = self.first.partition_point(|first| *first as usize <= leaf) - 1;
        Leaf { light, triangle: leaf - self.first[light] as usize }
    }

    /// The leaf that a light or one of its triangles is, if it is in the tree.
    pub fn find(&self, light: usize, triangle: usize) -> Option<usize> {
        let [first, end] = [self.first[light] as usize, self.first[light + 1] as usize];
        (first < end).then(|| (first + triangle).min(end - 1))
    }
}

impl SceneLight {
    /// How many leaves it has in the tree of lights. None if it has no place.
    pub(super) fn leaves(&self) -> usize {
        match self {
            SceneLight::Point(_) => 1,
            SceneLight::Surface(surface) => surface.leaves(),
            SceneLight::Distant { .. } | SceneLight::Infinite { .. } | SceneLight::Environment(_) => 0,
        }
    }

    /// The emission of each leaf.
    fn emitters(&self) -> Box<dyn Iterator<Item = Option<Emitter>> + '_> {
        match self {
            SceneLight::Point(light) => Box::new(once(Some(light.emitter()))),
            SceneLight::Surface(surface) => surface.emitters(),
            SceneLight::Distant { .. } | SceneLight::Infinite { .. } | SceneLight::Environment(_) => {
                Box::new(empty())
            }
        }
    }
}
