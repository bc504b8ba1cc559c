//! Shapes: where they are, and what is seen of them.

use glam::{DVec3, Vec3};
use lookat_scene::MaterialKind;
use lookat_scene::syntax::Span;

use super::{PROBES, Seen, sorted, spread};
use crate::prepare::corners_of_shape;
use crate::ray::ElementId;
use crate::traceable::Traceable;

/// The most shapes that are measured unless they are seen.
const MOST: usize = 4096;

/// A shape of the world, or an instance of an object.
#[derive(Debug, Clone)]
pub struct ShapeFacts {
    /// The place of its directive. An instance has the place of the first shape of its object. `None` for a shape made in code.
    pub span: Option<Span>,
    /// Two opposite corners of its box.
    pub bounds: [DVec3; 2],
    /// Whether it emits light.
    pub is_emitter: bool,
    /// Whether no light passes its surface.
    pub is_opaque: bool,
    /// The share of the picture that shows it.
    pub share: f64,
    /// Whether light that it emits is seen. It is not where only the back of a light is in view.
    pub glows: bool,
    /// The least, the median and the largest depth of what is seen of it.
    pub depths: Option<[f64; 3]>,
    /// The plane that holds all that is seen of it.
    pub flat: Option<Flat>,
    /// The numbers of its instance and of its first primitive.
    pub(super) key: (u32, u32),
}

/// A plane: a point of it, and its unit normal on the side of the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flat {
    /// A point.
    pub p: DVec3,
    /// The normal.
    pub n: DVec3,
}

/// What tells shapes apart: instances as a whole, other shapes by their primitives.
pub(super) fn key(element: ElementId) -> (u32, u32) {
    (element.instance, if element.instance == ElementId::WORLD { element.primitive } else { 0 })
}

/// The shapes of a world, or as many of them as are measured at most.
pub(super) fn measured(traceable: &Traceable) -> Vec<ShapeFacts> {
    let (primitives, instances) = (traceable.source.primitives.len(), traceable.instances.len());
    let every = (primitives + instances).div_ceil(MOST).max(1);
    let of_world = (0..primitives as u32).map(|primitive| (ElementId::WORLD, primitive));
    let all = of_world.chain((0..instances as u32).map(|instance| (instance, 0)));
    all.step_by(every).filter_map(|key| ShapeFacts::new(traceable, key)).collect()
}

impl ShapeFacts {
    /// `None` for a mesh without area, which cannot be seen.
    pub(super) fn new(traceable: &Traceable, key: (u32, u32)) -> Option<ShapeFacts> {
        let (instance, primitive) = key;
        let (number, bounds) = match traceable.instance(instance) {
            Some(placed) => {
                let group = &traceable.objects[placed.object];
                let (low, high) = placed.bounds(group.bvh.bounds).corners();
                (
                    traceable.first_of_objects[placed.object],
                    [low, high].map(|corner| corner + traceable.origin),
                )
            }
            None => (primitive, corners_of_shape(traceable.primitive(primitive))?),
        };
        let own = traceable.primitive(number);
        Some(ShapeFacts {
            span: own.span,
            bounds,
            is_emitter: own.emission.is_some(),
            is_opaque: own.cutout.is_none() && is_opaque(own.material.kind()),
            share: 0.0,
            glows: false,
            depths: None,
            flat: None,
            key,
        })
    }

    /// The largest side of its box.
    pub fn size(&self) -> f64 {
        (self.bounds[1] - self.bounds[0]).max_element()
    }

    /// Whether its box is next to flat.
    pub fn is_thin(&self) -> bool {
        (self.bounds[1] - self.bounds[0]).min_element() < 0.01 * self.size()
    }

    /// Adds what probe rays have seen of it.
    pub(super) fn see(&mut self, seen: &[&Seen], origin: DVec3) {
        self.share = seen.len() as f64 / f64::from(PROBES);
        self.glows = seen.iter().any(|seen| seen.surface.le(-seen.ray.d) != Vec3::ZERO);
        self.depths = spread(&sorted(seen.iter().map(|seen| seen.depth).collect()));
        let Some(first) = seen.first() else { return };
        let n = first.surface.n * -first.surface.n.dot(first.ray.d).signum();
        let is_in_plane = |seen: &&&Seen| {
            let off = (seen.surface.p - first.surface.p).dot(n).abs();
            seen.surface.n.dot(n).abs() > 1.0 - 1e-9 && off <= 1e-6 * self.size()
        };
        let is_flat = seen.iter().all(|seen| is_in_plane(&seen));
        self.flat = is_flat.then(|| Flat { p: first.surface.p + origin, n });
    }
}

/// Whether no light passes a surface of this material.
fn is_opaque(material: &MaterialKind) -> bool {
    match material {
        MaterialKind::Matte(_)
        | MaterialKind::Metal(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Plastic(_)
        | MaterialKind::Substrate(_) => true,
        MaterialKind::Mix(mix) => mix.materials.iter().all(|material| is_opaque(material.kind())),
        _ => false,
    }
}
