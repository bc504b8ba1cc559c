use glam::DVec3;

use super::*;
use crate::columns::Stored;
use crate::number::{Vec3x8, side_by_side};
use crate::prepare::Prepared;
use crate::testing::{cases, levels};
use crate::testing::{noise, scene};
use crate::trace::tests::Batch;

/// Where meshes have holes, others of them for shadow rays, rays meet what they meet in a tree.
#[test]
fn rays_pass_the_holes_of_small_worlds() {
    let mesh =
        "Shape \"trianglemesh\" \"point P\" [-2 -2 0 2 -2 0 2 2 0 -2 2 0] \"integer indices\" [0 1 2 0 2 3]
        \"float uv\" [0 0 1 0 1 1 0 1]";
    let traceable = Prepared::new(&scene(&format!(
        "Film \"image\" Camera \"perspective\" WorldBegin
         Texture \"h\" \"float\" \"checkerboard\" \"float uscale\" 4 \"float vscale\" 4 Translate 0 0 3
         {mesh} \"texture alpha\" \"h\" Translate 0 0 1 {mesh} \"texture shadowalpha\" \"h\" Translate 1 0 1 {mesh} WorldEnd"
    )))
    .traceable;
    let list = List::new(&traceable).unwrap();
    let mut passed = 0;
    side_by_side!(traceable.level, simd => for case in 0..2000 {
        let ray = Ray::new(DVec3::ZERO, DVec3::new(noise(case, 1.1), noise(case, 2.3), 2.0).normalize());
        let rays = Rays::new(Vec3x8::splat(simd, ray.o), Vec3x8::splat(simd, ray.d));
        let mut columns = RayColumns::new();
        columns.store(0, &Stored::new(bits(simd, 0xff)), &rays);
        let mut hits = HitColumns::new();
        list.nearest(simd, &columns, 0xff, &mut hits);
        let hits = hits.eight(simd, 0);
        let name = |hit: Hit| (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits));
        let own = hits.is_hit().all_true().then(|| name(list.hit(&hits, 5)));
        assert_eq!(own, traceable.nearest(&ray).map(name), "{ray:?}");
        assert_eq!(list.occluded(simd, &columns, 0xff, false) == 0xff, own.is_some());
        let is_blocked = traceable.occluded(&ray);
        assert_eq!(list.occluded(simd, &columns, 0xff, true) == 0xff, is_blocked, "{ray:?}");
        passed += u32::from(own.is_some() && !is_blocked);
    });
    assert!((100..1900).contains(&passed), "{passed} of 2000 pass as shadow rays alone");
}

/// What rays hit in small worlds has the same bits as what each hits among all elements, one by one.
#[test]
fn rays_hit_in_small_worlds_what_they_hit_alone() {
    let square = "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0]";
    let squares = &format!(
        "{square} \"integer indices\" [0 1 2 0 2 3] Translate .2 .1 .05 Rotate 30 1 2 3 {square} \"integer indices\" [0 1 2 0 2 3]"
    );
    let twice = &format!(
        "{squares} {square} \"integer indices\" [1 2 0 2 3 0] Translate 0 0 1e-8 {square} \"integer indices\" [1 2 0]"
    );
    let spheres = &format!(
        "{squares} AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .2 Translate .6 .6 0
         Shape \"sphere\" \"float radius\" .1 AttributeEnd Shape \"sphere\" \"float radius\" .3 \"float zmax\" .1
         Translate .3 .4 .5 Scale .2 .5 .1 Shape \"sphere\" Shape \"sphere\" Scale 1e-5 1e-5 1e-5 Shape \"sphere\""
    );
    let quadrics = &format!(
        "{squares} Shape \"cylinder\" \"float radius\" .3 Translate .1 .2 .3 Shape \"disk\" Shape \"disk\" AreaLightSource \"diffuse\" Rotate 50 1 2 0
         Shape \"disk\" \"float radius\" .4 \"float phimax\" 200 Shape \"cone\" Shape \"paraboloid\" Scale 1 .2 2
         Shape \"hyperboloid\" \"point p1\" [.2 0 0] \"point p2\" [.1 .3 .5] Shape \"cylinder\" \"float radius\" .2 \"float phimax\" 100"
    );
    let holes = &format!("Texture \"holes\" \"float\" \"checkerboard\" \"float tex1\" 0 \"float tex2\" 1 \"float uscale\" 7
        \"float vscale\" 7 {squares} Translate 0 0 .1 {square} \"integer indices\" [0 1 2 0 2 3] \"float uv\" [0 0 1 0 1 1 0 1]
        \"texture alpha\" \"holes\" Translate 0 0 .01 {square} \"integer indices\" [0 1 2 0 2 3] \"float shadowalpha\" 0");
    // Thin ones, which single precision cannot tell from lines, and those that are small beside others.
    let thin = &format!(
        "{squares} Shape \"trianglemesh\" \"integer indices\" [0 1 2 1 3 2 3 4 5] \"point P\" [-.3 0 .4 1 .5 .4 1 .500001 .40000001 2 1 .4
         0 0 1e-9 1e-8 1e-8 0] Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [.1 .1 .2 .1001 .1 .2 .1 .1001 .2]"
    );
    let wide = &format!(
        "{squares} Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-1e5 -1e5 -1 1e5 -1e5 -1 0 1e5 -1]"
    );
    // Triangles of a trillionth of the world.
    let tiny = &format!(
        "{wide} Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [.4 .3 .2 .400001 .3 .2 .400001 .300001 .2 .4 .300001 .2]
         Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [.5 .5 .1 .50000001 .5 .1 .5 .50000001 .1]"
    );
    let far = &format!("Translate 3e5 2e4 -1e6 {squares} Shape \"sphere\" \"float radius\" .3");
    // As many elements as lists may have, with the lamp.
    let most = &format!(
        "{} {}",
        "Translate .02 .03 .01 Shape \"sphere\" \"float radius\" .1 ".repeat(24),
        format!("Translate -.05 .01 .02 Rotate 9 1 2 3 {square} \"integer indices\" [0 1 2 0 2 3] ")
            .repeat(11)
    );
    let lamp = "AttributeBegin AreaLightSource \"diffuse\" Translate 0 0 1.5 Shape \"trianglemesh\"
        \"integer indices\" [0 1 2 0 2 3] \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] AttributeEnd";
    let cases = cases(100);
    for shapes in [squares, twice, spheres, quadrics, holes, thin, wide, tiny, far, most] {
        let text = format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin {lamp} {shapes} WorldEnd"
        );
        let mut traceable = Prepared::new(&scene(&text)).traceable;
        let (mut met, mut left, mut all) = (0, 0, 0);
        for level in levels() {
            traceable.level = level;
            let Some(list) = List::new(&traceable) else {
                assert!(shapes == most && super::most(level) == MOST_WITHOUT_COMPRESS);
                continue;
            };
            let place = |place| list.number(traceable.world.triangle(place).element(ElementId::WORLD));
            let leaving = |ray: &Ray| match ray.leaving_place {
                Hit::NO_PLACE => list.number(ray.leaving),
                at => place(at),
            };
            for case in 0..cases {
                let mut batch = Batch::new(&traceable, case, leaving);
                // Only what emits is ever a target.
                for (ray, target) in batch.all.iter_mut().zip(&mut batch.rays.target) {
                    let emits = |id: ElementId| traceable.primitive(id.primitive).emission.is_some();
                    if *target >= 0.0 && !emits(ray.target) {
                        (ray.target, *target) = (ElementId::NONE, NONE);
                    }
                }
                let mut hits = HitColumns::new();
                hits.clear();
                let mut may = [batch.active; ROOM];
                side_by_side!(level, simd => {
                    list.filter.test::<_, false>(simd, &batch.rays, batch.active, &mut may);
                    list.nearest(simd, &batch.rays, batch.active, &mut hits);
                    let occluded = list.occluded(simd, &batch.rays, batch.active, true);
                    met += batch.check(simd, &traceable, &hits, occluded, |hits, lane| list.hit(hits, lane));
                });
                let may = may[..list.elements.len()].iter().map(|may| may.count_ones()).sum::<u32>();
                left += may;
                all += batch.active.count_ones() * list.elements.len() as u32;
            }
        }
        assert!(met > 10 * cases, "{met} {shapes}");
        assert!(3 * left < 2 * all, "the filter leaves {left} of {all} pairs {shapes}");
    }
}

/// Worlds without a list: empty ones, those of a point, and those with too many elements.
#[test]
fn other_worlds_have_no_list() {
    let point = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [1 1 1 1 1 1 1 1 1]";
    for shapes in ["", point, &"Translate 1 0 0 Shape \"sphere\" ".repeat(MOST + 1)] {
        let text = format!("Film \"image\" Camera \"perspective\" WorldBegin {shapes} WorldEnd");
        assert!(List::new(&Prepared::new(&scene(&text)).traceable).is_none(), "{shapes}");
    }
}
