//! Paths and shadow rays in participating media: where paths scatter or meet a surface with a material next, and how much light shadow rays
//! let through. Both cross the boundaries of media (PBR 15.3.1).

use arrayvec::ArrayVec;
use fearless_simd::{Simd, prelude::*};
use glam::DVec3;

use super::lighting::Lighting;
use super::path_batch::{LightColumns, MediaBatch, MediaRoom, PathBatch, Radiance, ScatteredPaths};
use super::path_record::{PathColumns, PathRecord};
use super::profiler::Stage;
use super::world::{MAX_PASSED, Tracer, World};
use crate::columns::Column;
use crate::medium::{Media, MediumNumber, MediumSamples};
use crate::number::{LANES, bits, eights, narrow, set_bits, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, Ray};
use crate::trace::rays::{HitColumns, OneRay, RayColumns};

/// Surfaces no farther apart, relative to their largest coordinate, are in one place: 2^-48.
const SAME_PLACE: f64 = 1.0 / (1_u64 << 48) as f64;

impl Lighting<'_> {
    /// Leads the traced paths of a batch to where they scatter next, in a medium or at a surface with a material, and adds the emission
    /// that they see on their way.
    pub fn advance<S: Simd>(&self, simd: S, tracer: &mut Tracer, media: &Media, batch: &mut PathBatch) {
        let mut own = batch.in_media.take().unwrap_or_else(MediaBatch::new);
        let MediaBatch { events, room } = &mut *own;
        events.count = 0;
        let (scattered, radiance) = batch.branch(0);
        self.lead(simd, tracer, media, (scattered, radiance), Some(events), room);
        batch.in_media = Some(own);
    }

    /// Does what [`Lighting::advance`] does. Without `events`, paths that scatter in media end.
    #[inline(never)]
    pub fn lead<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        media: &Media,
        (scattered, radiance): (&mut ScatteredPaths, &mut Radiance),
        mut events: Option<&mut PathColumns>,
        MediaRoom { ahead, arrived }: &mut MediaRoom,
    ) {
        arrived.paths.count = 0;
        for _ in 0..MAX_PASSED {
            if scattered.paths.count == 0 {
                break;
            }
            self.sample_media(simd, media, scattered, ahead);
            self.add_emission(simd, tracer, ahead, ahead.paths.all(), radiance);
            scattered.paths.count = 0;
            self.cross(simd, tracer, media, ahead, (&mut *scattered, &mut *arrived), events.as_deref_mut());
            let (all, paths) = (scattered.paths.all(), &mut scattered.paths);
            if all != 0 {
                self.world.nearest(simd, tracer, &paths.rays, all, &mut paths.hits);
            }
        }
        std::mem::swap(scattered, arrived);
    }

    /// Samples where paths scatter before they get to the ends of their rays.
    #[inline(never)]
    fn sample_media<S: Simd>(
        &self,
        simd: S,
        media: &Media,
        ScatteredPaths { paths, receivers }: &ScatteredPaths,
        ahead: &mut ScatteredPaths,
    ) {
        vectorized!(simd, {
            let own = &mut PathRecord::none(simd);
            ahead.paths.count = 0;
            for first in (0..paths.count).step_by(LANES) {
                paths.load(simd, first, paths.count, own);
                let infinite = f64::INFINITY.simd_into(simd);
                let end = own.hits.is_hit().select(own.hits.t, infinite);
                let MediumSamples { scatters, t, weight } =
                    media.sample((&own.rays, own.medium), own.throughput, end, own.active);
                own.throughput = own.throughput * weight;
                own.active &= own.throughput.is_light();
                own.scatters = scatters;
                own.hits.t = t;
                // It is a hit, of nothing that emits.
                let element = own.hits.element;
                own.hits.element = scatters.select(element.max(0.0), element);
                own.hits.emits &= !scatters;
                let receivers = receivers.eight(simd, first, self.has_lunes);
                ahead.push_with_hits(own, &receivers);
            }
        });
    }

    /// Moves paths that have met surfaces without a material to behind these, and the others that go on to their vertices.
    #[inline(never)]
    fn cross<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        media: &Media,
        ScatteredPaths { paths, receivers }: &ScatteredPaths,
        (crossing, arrived): (&mut ScatteredPaths, &mut ScatteredPaths),
        mut events: Option<&mut PathColumns>,
    ) {
        vectorized!(simd, {
            let own = &mut PathRecord::none(simd);
            for first in (0..paths.count).step_by(LANES) {
                paths.load(simd, first, paths.count, own);
                let receivers = receivers.eight(simd, first, self.has_lunes);
                let going_on = own.active & own.hits.is_hit();
                let mut crosses = 0;
                for lane in set_lanes(going_on & !own.scatters) {
                    let (ray, Some(hit)) = self.world.one(&own.rays, &own.hits, lane) else { continue };
                    if tracer.scene.is_passed(&hit) {
                        crosses |= 1 << lane;
                        let Beyond { o, medium } =
                            self.world.beyond(tracer, media, (&ray, &hit), own.medium[lane]);
                        own.medium[lane] = medium;
                        own.rays.o.set_lane(lane, o);
                    }
                }
                let crosses = bits(simd, crosses);
                let before = own.rays;
                own.rays.leaving = crosses.select(own.hits.element, before.leaving);
                own.rays.leaving_instance =
                    narrow(crosses).select(own.hits.instance, before.leaving_instance);
                own.has_passed |= crosses;
                own.active = crosses;
                crossing.push(own, &receivers);
                own.active = going_on & !crosses & !own.scatters;
                arrived.push_with_hits(own, &receivers);
                if let Some(events) = &mut events {
                    own.active = going_on & own.scatters;
                    events.push_with_hits(own);
                }
            }
        });
    }
}

/// Where a path or a shadow ray that crosses a surface without a material starts again, and the medium that it is in there.
struct Beyond {
    o: DVec3,
    medium: MediumNumber,
}

impl World<'_> {
    /// Leads a ray, which is in `medium` at its start, across a surface without a material that it hits.
    ///
    /// It starts again behind the surface, beyond all that touches it there; so whatever does is looked for first. A surface with a material
    /// is yet to be hit. Of two boundaries in one place the ray leaves a medium first and then enters one: media that touch have no gap.
    #[inline(never)]
    fn beyond(
        &self,
        tracer: &Tracer,
        media: &Media,
        (ray, hit): (&Ray, &Hit),
        medium: MediumNumber,
    ) -> Beyond {
        let (surface, d) = (tracer.surface(ray, hit), ray.d);
        let (before, behind) = (surface.spawn_ray(-d).o, surface.spawn_ray(d));
        let o = behind.o;
        let beyond = media.beyond(hit.element.primitive, surface.n, d, medium);
        // Across the surface: at a grazing angle, a way along the ray ends before it.
        let across = o - before;
        let between = Ray { o: before, d: across.normalize(), t_max: across.length(), ..behind };
        let Some(touching) = tracer.scene.nearest(&between) else { return Beyond { o, medium: beyond } };
        if !tracer.scene.is_passed(&touching) {
            return Beyond { o: before, medium };
        }
        let other = tracer.surface(&between, &touching);
        let gap = (other.p - surface.p).dot(surface.n).abs();
        let enters = |n: DVec3| n.dot(d) < 0.0;
        let is_first = gap <= surface.magnitude * SAME_PLACE && enters(surface.n) && !enters(other.n);
        let medium =
            if is_first { beyond } else { media.beyond(touching.element.primitive, other.n, d, beyond) };
        Beyond { o, medium }
    }

    /// Multiplies the light of shadow rays by what the media on their way let through. Returns the rays that no surface with a material
    /// blocks.
    #[inline(never)]
    pub(in crate::integrator) fn transmit<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        media: &Media,
        rays: &mut RayColumns,
        light: &mut LightColumns,
        all: u64,
    ) -> u64 {
        vectorized!(simd, {
            for t_max in rays.t_max.iter_mut().filter(|t_max| **t_max == f64::INFINITY) {
                *t_max = media.reach;
            }
            let (mut rest, mut free, mut hits) = (all, 0, HitColumns::new());
            for _ in 0..MAX_PASSED {
                if rest == 0 {
                    break;
                }
                self.nearest_as(simd, tracer, Stage::ShadowRays, rays, rest, &mut hits);
                for (first, own) in eights(rest) {
                    let (eight, found) = (rays.eight(simd, first), hits.eight(simd, first));
                    let (mut blocked, mut crossed) = (0, ArrayVec::<_, LANES>::new());
                    let mut end = eight.t_max.max(0.0);
                    for lane in set_bits(own) {
                        let (ray, hit) = self.one(&eight, &found, lane);
                        // The light itself is no obstacle.
                        let hit = hit.filter(|hit| {
                            hit.element.instance != ElementId::WORLD
                                || tracer.scene.labels.of(hit.element) != eight.target[lane]
                        });
                        match hit {
                            Some(hit) if tracer.scene.is_passed(&hit) => {
                                end[lane] = hit.t;
                                crossed.push((lane, ray, hit));
                            }
                            Some(_) => blocked |= 1 << lane,
                            None => {}
                        }
                    }
                    let medium = Column::load(simd, &light.medium[first..first + LANES]);
                    let going_on = bits(simd, own & !blocked);
                    let shares = media.transmittance((&eight, medium), end, going_on);
                    let is_dark = !shares.is_light().to_bitmask();
                    for lane in set_lanes(going_on) {
                        let (at, share) = (first + lane, shares.lane(lane));
                        light.red[at] *= share.x;
                        light.green[at] *= share.y;
                        light.blue[at] *= share.z;
                    }
                    let mut open = 0;
                    for (lane, ray, hit) in crossed.into_iter().filter(|(lane, ..)| is_dark >> lane & 1 == 0)
                    {
                        let at = first + lane;
                        let Beyond { o, medium } = self.beyond(tracer, media, (&ray, &hit), light.medium[at]);
                        light.medium[at] = medium;
                        let t_max = eight.t_max[lane] - (o - ray.o).dot(ray.d);
                        let (leaving, leaving_instance) = (found.element[lane], found.instance[lane]);
                        rays.set(at, &OneRay { o, t_max, leaving, leaving_instance, ..rays.one(at) });
                        open |= 1 << lane;
                    }
                    rest = rest & !(own << first) | open << first;
                    free |= (own & !blocked & !is_dark & !open) << first;
                }
            }
            free
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use glam::Vec3;

    use crate::render::{Settings, render};
    use crate::testing::scene;

    /// The mean color of what a camera at z = -5 sees, in a narrow view, so that all rays have the same way.
    fn seen(before: &str, world: &str, samples: u32) -> Vec3 {
        let scene = scene(&format!(
            "{before} LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 1
             Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
             Sampler \"sobol\" \"integer pixelsamples\" {samples}
             Integrator \"volpath\" \"integer maxdepth\" 1000 \"float rrthreshold\" 0 WorldBegin {world} WorldEnd"
        ));
        let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
        let mean = |channel: usize| {
            let samples = &rendered.image.channels[channel].samples;
            samples.iter().sum::<f32>() / samples.len() as f32
        };
        Vec3::new(mean(0), mean(1), mean(2))
    }

    fn medium(rest: &str) -> String {
        format!("MakeNamedMedium \"m\" {rest} ")
    }

    const BOX: &str = "MediumInterface \"m\" \"\" Material \"\" Shape \"sphere\" \"float radius\" 1.7 ";
    const GRID: &str = "\"string type\" \"heterogeneous\" \"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2
        \"float density\" [1 .2 .4 0 2 .1 1 .6] \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]";

    /// Media that absorb nothing are invisible under an even sky.
    #[test]
    fn media_that_absorb_nothing_lose_no_light() {
        let kinds = ["\"string type\" \"homogeneous\"", GRID];
        // In the colored ones most paths see one channel alone.
        let scattering = ["[1 1 1]", "[9 3 1]"];
        for (kind, sigma_s) in kinds.into_iter().flat_map(|kind| scattering.map(|sigma_s| (kind, sigma_s))) {
            for g in [-0.7, 0.0, 0.9] {
                let medium = medium(&format!(
                    "{kind} \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" {sigma_s} \"float g\" {g}"
                ));
                let found = seen("", &format!("{medium} LightSource \"infinite\" {BOX}"), 1024);
                assert!((found - 1.0).abs().max_element() < 0.01, "{kind} {sigma_s} {g}: {found}");
            }
        }
    }

    const LAMP: &str = "AttributeBegin Material \"matte\" \"rgb Kd\" [0 0 0] AreaLightSource \"diffuse\" \"bool twosided\" \"true\"
        MediumInterface \"\" \"\" Translate 0 0 4 Shape \"disk\" \"float radius\" 9 AttributeEnd ";

    /// Closed forms: light through two boundaries, around an eye in the medium, and through a grid of even density.
    #[test]
    fn light_is_absorbed_as_it_should_be() {
        let coefficients = "\"rgb sigma_a\" [.1 .5 1] \"rgb sigma_s\" [0 0 0]";
        let even = medium(&format!("\"string type\" \"homogeneous\" {coefficients}"));
        let slab = "MediumInterface \"m\" \"\" Material \"\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6]
            \"point P\" [-9 -9 1 9 -9 1 9 9 1 -9 9 1 -9 -9 -1 9 -9 -1 9 9 -1 -9 9 -1] ";
        let grid = medium(&format!(
            "\"string type\" \"heterogeneous\" {coefficients} \"float density\" 1 \"point p0\" [-1e4 -1e4 -1e4] \"point p1\" [1e4 1e4 1e4]"
        ));
        for (before, world, way) in [
            ("", format!("{even}{LAMP}{slab}"), 2.0),
            ("", format!("{grid}{LAMP}{slab}"), 2.0),
            (
                &*format!("{even} MediumInterface \"\" \"m\""),
                LAMP.replace("MediumInterface \"\" \"\"", ""),
                9.0,
            ),
        ] {
            let expected = (Vec3::new(-0.1, -0.5, -1.0) * way).exp();
            let found = seen(before, &world, 4096);
            let error = (found - expected).abs() / expected;
            assert!(error.max_element() < 0.02, "{before} {world}: {found}, not {expected}");
        }
    }

    /// Thin slabs, in each other and in an instance, and an eye on a boundary.
    #[test]
    fn boundaries_are_met_once() {
        let thin = |thickness: f64| {
            let sigma = 1.0 / thickness;
            medium(&format!(
                "\"string type\" \"homogeneous\" \"rgb sigma_a\" [{sigma} {sigma} {sigma}] \"rgb sigma_s\" [0 0 0]"
            ))
        };
        let slab = |from: f64, to: f64| {
            let face = |z: f64| format!("-9 -9 {z} 9 -9 {z} 9 9 {z} -9 9 {z} ");
            format!(
                "MediumInterface \"m\" \"\" Material \"\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6] \"point P\" [{}{}] ",
                face(to),
                face(from)
            )
        };
        for (thickness, world, way) in [
            (1e-6, slab(1.0, 1.0 + 1e-6), 1.0),
            (1e-6, format!("{}{}", slab(1.0, 1.0 + 1e-6), slab(1.0 + 2e-6, 1.0 + 3e-6)), 2.0),
            (
                1e-6,
                format!(
                    "ObjectBegin \"o\" {} ObjectEnd Scale 1 1 1e-3 ObjectInstance \"o\"",
                    slab(1.0, 1.001)
                ),
                1.0,
            ),
            // Empty space within it.
            (
                1e-6,
                slab(1.0, 1.0 + 3e-6) + &slab(1.0 + 1e-6, 1.0 + 2e-6).replace("\"m\" \"\"", "\"\" \"m\""),
                2.0,
            ),
        ] {
            let expected = (-way as f32).exp();
            let found =
                seen("", &format!("{}{LAMP}AttributeBegin {world} AttributeEnd", thin(thickness)), 16_384);
            assert!((found / expected - 1.0).abs().max_element() < 0.01, "{world}: {found}, not {expected}");
        }
        let on_boundary = seen(
            &format!("{} MediumInterface \"\" \"m\"", thin(1.0)),
            &format!("AttributeBegin {} AttributeEnd {LAMP}", slab(-5.0, -3.0)),
            16_384,
        );
        assert!((on_boundary / (-2.0_f32).exp() - 1.0).abs().max_element() < 0.01, "{on_boundary}");
    }

    /// Slabs that touch, in either order, and one that lies on the floor that it shades, named before or after it.
    #[test]
    fn boundaries_in_one_place_are_all_crossed() {
        let face = |z: f64| format!("-9 -9 {z} 9 -9 {z} 9 9 {z} -9 9 {z} ");
        let slab = |name: &str, from: f64, to: f64| {
            format!(
                "MediumInterface \"{name}\" \"\" Material \"\" Shape \"trianglemesh\"
                 \"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6] \"point P\" [{}{}] ",
                face(to),
                face(from)
            )
        };
        let media = ["a", "b"]
            .map(|name| {
                medium("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.5 .5 .5] \"rgb sigma_s\" [0 0 0]")
                    .replace("\"m\"", &format!("\"{name}\""))
            })
            .concat();
        // The floor is at z = 0.7, and the light in front of it.
        let floor = format!(
            "MediumInterface \"\" \"\" Material \"matte\" \"rgb Kd\" [1 1 1] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
             \"point P\" [{}] ",
            face(0.7)
        );
        let [near, far] = [slab("a", -1.3, -0.3), slab("b", -0.3, 0.7)];
        let orders =
            [[&near, &far, &floor], [&far, &near, &floor], [&floor, &near, &far], [&floor, &far, &near]];
        // From above, and at an angle whose cosine is 0.4.
        for (shapes, (x, cosine)) in
            orders.into_iter().flat_map(|order| [(order, (0.0, 1.0)), (order, (2.291_288, 0.4_f32))])
        {
            let light = format!(
                "LightSource \"distant\" \"point from\" [{x} 0 -1] \"point to\" [0 0 0] \"rgb L\" [100 100 100] "
            );
            let without = seen("", &format!("{light}{floor}"), 4096);
            // There and back again.
            let expected = without * (-1.0 - 1.0 / cosine).exp();
            let found = seen("", &format!("{media}{light}{}{}{}", shapes[0], shapes[1], shapes[2]), 16_384);
            assert!(
                ((found - expected).abs() / expected).max_element() < 0.01,
                "{shapes:?}: {found}, not {expected}"
            );
        }
    }

    /// A dark floor sees a lamp, or a point light, through a medium: what light samples and directions find has one mean.
    #[test]
    fn shadow_rays_cross_media() {
        let medium =
            medium("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.5 .5 .5] \"rgb sigma_s\" [0 0 0]");
        let floor = "Material \"matte\" \"rgb Kd\" [1 1 1] AttributeBegin Translate 0 0 1 Shape \"disk\" \"float radius\" 9 AttributeEnd ";
        let shell = "AttributeBegin MediumInterface \"m\" \"\" Material \"\" Translate 0 0 -9 Shape \"sphere\" \"float radius\" 2 \
            MediumInterface \"\" \"m\" Shape \"sphere\" AttributeEnd ";
        let light = "LightSource \"point\" \"point from\" [0 0 -9] \"rgb I\" [100 100 100] ";
        let found = seen("", &format!("{medium}{floor}{shell}{light}"), 64);
        let without = seen("", &format!("{medium}{floor}{light}"), 64);
        let expected = without * (-0.5_f32).exp();
        assert!(((found - expected).abs() / expected).max_element() < 0.01, "{found}, not {expected}");
    }
}
