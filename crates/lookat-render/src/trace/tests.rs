use glam::DVec3;

use crate::Precision;
use crate::prepare::Traceable;
use crate::ray::{Hit, Ray};
use crate::surface::Surface;
use crate::testing::{noise, scene};

/// Instances of one shape alone have no tree of their own: what is met is the same.
#[test]
fn single_shapes_are_met_in_instances() {
    let curve = "Shape \"curve\" \"point P\" [-1 0 0 -.3 .5 0 .3 -.5 0 1 0 0] \"float width\" .3 \"integer splitdepth\" 0";
    for (shape, placed) in [
        ("Shape \"disk\"", "Rotate 40 1 2 0"),
        ("Shape \"cylinder\"", "Scale 2 1 .5 Rotate 70 1 0 1"),
        (curve, ""),
    ] {
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
            ObjectBegin \"one\" {shape} ObjectEnd Translate .2 0 3 {placed} ObjectInstance \"one\"
            Translate 0 0 -1 ObjectInstance \"one\" WorldEnd"
        ));
        for precision in [Precision::Mixed, Precision::Double] {
            let traceable = Traceable::new(&scene, precision);
            let mut met = 0;
            for case in 0..2000 {
                let d = DVec3::new(noise(case, 1.1), noise(case, 2.3), 2.0).normalize();
                let t_max = if case % 3 == 0 { 3.0 } else { f64::INFINITY };
                let ray = Ray { t_max, ..Ray::new(DVec3::ZERO, d) };
                let name = |hit: Hit| (hit.element, hit.t.to_bits());
                let hit = traceable.nearest(&ray).map(name);
                assert_eq!(hit, traceable.nearest_by_all(&ray).map(name), "{shape} {ray:?}");
                assert_eq!([traceable.meets(&ray), traceable.occluded(&ray)], [hit.is_some(); 2]);
                met += u32::from(hit.is_some());
            }
            assert!(met > 20, "{shape} {met}");
        }
    }
}

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
