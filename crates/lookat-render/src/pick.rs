//! What a view shows at a place.

use glam::{DVec2, DVec3};
use lookat_scene::{Primitive, View};

use crate::prepare::Prepared;
use crate::surface::Surface;

/// A shape at a place of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Picked<'p> {
    /// The shape, with the place of its directive. An instance gives a shape of its object.
    pub primitive: &'p Primitive,
    /// The point that is seen, in the world.
    pub p: DVec3,
    /// The unit normal there, on the side of the eye.
    pub n: DVec3,
    /// Its z in camera space: the focal distance at which it is sharp. Negative for what an environment camera sees behind it.
    pub depth: f64,
}

impl Prepared {
    /// The shape that a view shows at `film`, in pixels from the top left corner of the full picture, through the middle of
    /// the lens. Surfaces without a material are seen, holes are not. `None` where there is nothing.
    pub fn pick(&self, view: &View, film: DVec2) -> Option<Picked<'_>> {
        let camera = self.camera(view);
        let ray = camera.ray(film, DVec2::splat(0.5));
        let hit = self.traceable.nearest(&ray)?;
        let Surface { p, n, primitive, .. } = Surface::new(&self.traceable, &ray, &hit);
        Some(Picked {
            primitive,
            p: p + self.traceable.origin,
            n: if n.dot(ray.d) > 0.0 { -n } else { n },
            depth: depth(view, p - camera.eye),
        })
    }
}

/// The z in camera space of a point, given relative to the eye.
pub(crate) fn depth(view: &View, from_eye: DVec3) -> f64 {
    view.camera.world_from_camera.inverse().vector(from_eye).z
}

#[cfg(test)]
mod tests {
    use lookat_scene::load_str;

    use super::*;

    #[test]
    fn shapes_are_picked_with_their_lines() {
        let loaded = load_str(
            "LookAt 0 0 -10 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 60 \"float lensradius\" 1
            Film \"image\" \"integer xresolution\" 60 \"integer yresolution\" 60 Sampler \"sobol\" Integrator \"path\" WorldBegin
            LightSource \"infinite\"
            ObjectBegin \"o\"
              Shape \"disk\"
            ObjectEnd Translate -2 0 0
            Shape \"sphere\"
            Translate 4 0 1 ObjectInstance \"o\" WorldEnd",
        );
        let scene = loaded.scene.unwrap();
        let prepared = Prepared::new(&scene);
        let pixels = 30.0 / 30_f64.to_radians().tan();
        let pick = |x: f64, z: f64| {
            let film = DVec2::new(30.0 + pixels * x / (10.0 + z), 30.0);
            let Picked { primitive, p, n, depth } = prepared.pick(&scene.view, film)?;
            assert!((n.z + 1.0).abs() < 0.1 && (p.x - x).abs() < 0.2, "{p} {n}");
            Some((loaded.sources.location(primitive.span.unwrap()).line, depth))
        };
        let (line, depth) = pick(-1.8, -1.0).unwrap();
        assert!(line == 7 && (depth - 9.0).abs() < 0.05, "{line} {depth}");
        let (line, depth) = pick(2.0, 1.0).unwrap();
        assert!(line == 5 && (depth - 11.0).abs() < 1e-9, "{line} {depth}");
        assert_eq!(pick(0.0, 0.0), None);
    }
}
