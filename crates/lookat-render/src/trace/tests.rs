use glam::DVec3;

use crate::Precision;
use crate::prepare::Traceable;
use crate::ray::Ray;
use crate::surface::Surface;
use crate::testing::scene;

/// Triangles with the same place, in the world and in instances, and of the same number in two objects: what a ray leaves is
/// told from all of them.
#[test]
fn a_ray_leaves_one_triangle_of_many_with_its_place() {
    let triangle = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-1 -1 0 1 -1 0 0 1 0]";
    let scene = scene(&format!(
        "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
        ObjectBegin \"a\" {triangle} ObjectEnd ObjectBegin \"b\" {triangle} ObjectEnd {triangle}
        Translate 0 0 1 ObjectInstance \"a\" Translate 0 0 1 ObjectInstance \"a\"
        Translate 0 0 1 ObjectInstance \"b\" Translate 0 0 1 {triangle} WorldEnd"
    ));
    for precision in [Precision::Mixed, Precision::Double] {
        let traceable = Traceable::new(&scene, precision);
        for (start, d) in [(-1.0, DVec3::Z), (5.0, DVec3::NEG_Z)] {
            let mut ray = Ray::new(DVec3::new(0.1, 0.1, start), d);
            let mut met = Vec::new();
            while let Some(hit) = traceable.nearest(&ray) {
                assert!(traceable.meets(&ray) && traceable.nearest_by_all(&ray).is_some());
                let surface = Surface::new(&traceable, &ray, &hit);
                assert!((surface.p.z - start - d.z * (met.len() as f64 + 1.0)).abs() < 1e-9);
                met.push(hit.element);
                ray = surface.leave(d);
            }
            assert!(!traceable.meets(&ray));
            assert_eq!(met.len(), 5, "{met:?}");
        }
    }
}
