//! Samples side by side, of one pixel or several.

use std::array::from_fn;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, dispatch, mask64x8, prelude::*};
use glam::{DVec2, Vec3};

use super::control::Meter;
use super::sample::{Context, Job, center_of};
use crate::integrator::direct::lanes::Lanes;
use crate::integrator::{FirstHit, Tracer};
use crate::lanes::LANES;
use crate::sampler::SampleStream;
use crate::sampler::lanes::Streams;
use crate::trace::lanes::{NONE, Rays};

/// Samples of some pixels.
struct Eight {
    radiance: [Vec3; LANES],
    /// Whether the filter is negative.
    negative: [bool; LANES],
    /// How many rays they took.
    rays: u64,
}

/// A sample of a job: the job's number, and which of the pattern.
type Place = (usize, u32);

impl<F> Context<'_, F>
where
    F: Fn(&mut Tracer, &FirstHit, &mut SampleStream) -> Vec3,
{
    /// Does jobs as [`Context::sample_all`] does, eight samples at a time. Those of one pixel are added in their order.
    pub(super) fn sample_side_by_side(
        &self,
        lanes: &Lanes,
        tracer: &mut Tracer,
        meter: &mut Meter,
        jobs: &mut [Job],
    ) {
        let (mut number, mut index) = (0, jobs.first().map_or(0, |job| job.indices.start));
        let mut streams = None;
        loop {
            let mut places: ArrayVec<Place, LANES> = ArrayVec::new();
            while !places.is_full() && number < jobs.len() {
                if index < jobs[number].indices.end {
                    places.push((number, index));
                    index += 1;
                } else {
                    number += 1;
                    index = jobs.get(number).map_or(0, |job| job.indices.start);
                }
            }
            if places.is_empty() {
                return;
            }
            self.sample_places(lanes, tracer, jobs, &places, &mut streams);
            if !meter.add(places.len() as u32, tracer.rays) {
                return;
            }
        }
    }

    /// Takes up to eight samples.
    fn sample_places(
        &self,
        lanes: &Lanes,
        tracer: &mut Tracer,
        jobs: &mut [Job],
        places: &[Place],
        streams: &mut Option<Streams>,
    ) {
        // Where there are fewer, the first again, for nothing.
        let place_of = |lane: usize| places.get(lane).unwrap_or(&places[0]);
        let samples = from_fn(|lane| {
            let (number, index) = *place_of(lane);
            let Job { pattern, place, .. } = &jobs[number];
            (pattern.seed, *place, index)
        });
        let sampler = &jobs[places[0].0].pattern.sampler;
        debug_assert!(places.iter().all(|(number, _)| jobs[*number].pattern.sampler == *sampler));
        let streams = match streams {
            Some(streams) => {
                streams.restart(sampler, &samples);
                streams
            }
            None => streams.insert(Streams::new(sampler, &samples)),
        };
        let pixels = samples.map(|(_, place, _)| place);
        let count = places.len();
        let eight = match lanes.is_lambert {
            true => {
                dispatch!(lanes.level, simd => self.eight::<_, true>(simd, lanes, streams, &pixels, count))
            }
            false => {
                dispatch!(lanes.level, simd => self.eight::<_, false>(simd, lanes, streams, &pixels, count))
            }
        };
        tracer.rays += eight.rays;
        for (lane, (number, _)) in places.iter().enumerate() {
            let Job { pattern, samples, .. } = &mut jobs[*number];
            self.add(pattern, eight.radiance[lane], eight.negative[lane], samples);
        }
    }

    /// The first `count` of some samples.
    #[inline(always)]
    fn eight<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        lanes: &Lanes,
        streams: &mut Streams,
        pixels: &[[u32; 2]; LANES],
        count: usize,
    ) -> Eight {
        let mut film = streams.next_2d(simd);
        let mut negative = [false; LANES];
        for (lane, place) in pixels.iter().enumerate() {
            let (offset, is_negative) = self.filter.sample(DVec2::new(film[0][lane], film[1][lane]));
            (film[0][lane], film[1][lane]) = (center_of(*place) + offset).into();
            negative[lane] = is_negative;
        }
        let on_lens = self.camera.has_lens().then(|| streams.next_2d(simd));
        let (o, d) = self.camera.rays(simd, film, on_lens);
        let rays = Rays { o, d, t_max: f64::INFINITY.simd_into(simd), leaving: NONE.simd_into(simd) };
        let active = mask64x8::from_bitmask(simd, (1 << count) - 1);
        let brought = lanes.li::<_, LAMBERT>(simd, &rays, active, streams);
        Eight { radiance: from_fn(|lane| brought.radiance.lane(lane)), negative, rays: brought.rays }
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;
    use std::ops::ControlFlow;

    use fearless_simd::Level;
    use lookat_scene::{Integrator, Scene};

    use super::*;
    use crate::arithmetic::Precision;
    use crate::integrator::direct;
    use crate::lanes::level;
    use crate::light::LightTable;
    use crate::prepare::Traceable;
    use crate::render::control::Control;
    use crate::render::sample::{Pattern, Prepared, Samples};
    use crate::testing::{noise, scene};
    use crate::trace::lanes::MOST;

    /// What some pixels of a scene get, and the number of rays: one by one, or side by side on a processor of some level.
    fn pixels(scene: &Scene, level: Option<Level>) -> (Vec<String>, u64) {
        let traceable = Traceable::new(scene, Precision::Mixed);
        let lights = LightTable::new(scene, &traceable);
        let prepared = Prepared { scene, traceable, lights, preparation: Default::default() };
        let progress = |_| ControlFlow::Continue(());
        let control = Control::new(&progress, None);
        let Integrator::DirectLighting { strategy, max_depth } = scene.integrator else { panic!() };
        let li = |tracer: &mut Tracer, first: &FirstHit, stream: &mut SampleStream| {
            direct::li(tracer, first, stream, strategy, max_depth)
        };
        let mut context = Context::new(&prepared, 16, &control, li);
        match (&mut context.lanes, level) {
            (Some(lanes), Some(level)) => lanes.level = level,
            (lanes, _) => {
                assert!(lanes.take().is_some() || level.is_none(), "the scene is not for lanes");
            }
        }
        let (mut tracer, mut meter) = (context.tracer(), Meter::new(&control));
        let pattern = Pattern { sampler: scene.sampler, seed: 5, is_watched: true };
        let job = |at: u32| Job {
            pattern: Pattern { seed: u64::from(at % 2), ..pattern },
            place: [at % 8 * 4, at / 8 * 4],
            // All, none, or from the middle on.
            indices: at % 8 * 4..scene.sampler.samples_per_pixel,
            samples: Samples::after(Default::default()),
        };
        let mut jobs: Vec<Job> = (0..48).map(job).collect();
        context.sample_all(&mut tracer, &mut meter, &mut jobs);
        let sums = jobs.iter().map(|job| format!("{:?}", job.samples)).collect();
        (sums, tracer.rays)
    }

    fn text(case: usize) -> String {
        let number = |k: f64| noise(case, k);
        let pick = |k: f64, of: &[&str]| of[(number(k).abs() * of.len() as f64) as usize].to_owned();
        let camera = pick(
            1.1,
            &[
                "\"perspective\" \"float fov\" 60",
                "\"perspective\" \"float lensradius\" .1 \"float focaldistance\" 3",
                "\"perspective\" \"float lensradius\" .1 \"float focaldistance\" .05",
                "\"orthographic\" \"float screenwindow\" [-2 2 -2 2]",
                "\"orthographic\" \"float screenwindow\" [-2 2 -2 2] \"float lensradius\" .1 \"float focaldistance\" 3",
                "\"orthographic\" \"bool telecentric\" \"true\" \"float lensradius\" .1 \"float focaldistance\" 3",
            ],
        );
        let sampler = pick(
            1.2,
            &[
                "\"halton\"",
                "\"halton\" \"bool samplepixelcenter\" \"true\"",
                "\"sobol\"",
                "\"random\"",
                "\"stratified\" \"integer xsamples\" 5 \"integer ysamples\" 5",
            ],
        );
        let integrator = pick(1.6, &["directlighting", "whitted"]);
        let limit = pick(1.7, &["", "\"float maxsampleluminance\" .5"]);
        let filter = pick(1.3, &["box", "triangle", "gaussian", "mitchell", "sinc"]);
        let look_at = pick(1.4, &["LookAt 0 0 -4 0 0 0 0 1 0", "Scale -1 1 1 LookAt -3 1.5 -2 0 0 0 .1 1 0"]);
        let lights = pick(
            1.5,
            &[
                "LightSource \"distant\" LightSource \"infinite\" \"rgb L\" [.2 .3 .4]",
                "LightSource \"point\" \"point from\" [2 2 -3] \"rgb I\" [9 8 7] LightSource \"spot\"
                 \"point from\" [1 3 -2] \"point to\" [0 0 0] \"float coneangle\" 40 \"rgb I\" [20 20 20]",
                "LightSource \"infinite\" LightSource \"infinite\" \"rgb L\" [.1 0 0]",
                "LightSource \"spot\" \"float coneangle\" 50 \"float conedeltaangle\" 0 \"rgb I\" [20 20 20]
                 \"point from\" [1 3 -2] LightSource \"infinite\"",
                "LightSource \"distant\" \"point from\" [0 1 0] LightSource \"point\" \"point from\" [0 0 0]",
                "",
            ],
        );
        let mut text = format!(
            "{look_at} Camera {camera} Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 24 {limit}
             Sampler {sampler} \"integer pixelsamples\" 25 PixelFilter \"{filter}\" Integrator \"{integrator}\"
             WorldBegin {lights} Shape \"trianglemesh\" \"point P\" [-9 -2 5 9 -2 5 9 9 5 -9 9 5]
             \"integer indices\" [0 1 2 0 2 3] "
        );
        for shape in 0..1 + case % 12 {
            let number = |k: f64| noise(case * 16 + shape, k);
            let place = [number(2.1), number(2.2), number(2.3)].map(|x| x * 1.5);
            let size = [number(3.1), number(3.2), number(3.3)].map(|x| 0.4 + x.abs());
            let size = if case.is_multiple_of(2) { [size[0]; 3] } else { size };
            let color = [number(4.1), number(4.2), number(4.3)].map(|x| (x + 0.5).max(0.0));
            let material = match (number(8.1).abs() * 5.0) as u32 {
                0 | 1 => "",
                2 => "\"float sigma\" 30",
                3 => "\"float roughness\" .2 \"rgb Ks\" [.3 .4 .5]",
                _ => "\"float roughness\" .01 \"bool remaproughness\" \"false\" \"rgb Ks\" [1 1 1]",
            };
            // In half of the scenes all are diffuse.
            let material = if (case / 2).is_multiple_of(2) { "" } else { material };
            let kind = if material.contains("rough") { "plastic" } else { "matte" };
            let turn = 180.0 * number(5.1);
            let shape = match (number(6.1).abs() * 6.0) as u32 {
                0 | 1 => "\"sphere\"",
                2 => "\"sphere\" \"float zmin\" -.5 \"float phimax\" 200",
                // On pixels and edges of others.
                3 => {
                    "\"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"integer indices\" [0 1 2 0 2 3]"
                }
                4 => "\"trianglemesh\" \"point P\" [-1 0 0 1 0 0 0 1 .5] \"integer indices\" [0 1 2]",
                _ => {
                    "\"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0 0 0 1] \"integer indices\" [0 1 2 0 2 3 0 3 1]"
                }
            };
            let (orientation, turned) =
                (if number(7.1) > 0.0 { "ReverseOrientation" } else { "" }, number(7.2) > 0.0);
            let turn = if turned { format!("Rotate {turn} 1 .4 .2") } else { String::new() };
            let [x, y, z] = place;
            let _ = write!(
                text,
                "AttributeBegin Translate {x} {y} {z} {turn} Scale {} {} {} {orientation}
                 Material \"{kind}\" \"rgb Kd\" [{} {} {}] {material} Shape {shape} AttributeEnd ",
                size[0], size[1], size[2], color[0], color[1], color[2],
            );
        }
        text + "WorldEnd"
    }

    /// Of a scene with these in its world.
    fn is_served(before: &str, world: &str) -> bool {
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" Integrator \"directlighting\" {before} WorldBegin {world} WorldEnd"
        ));
        let traceable = Traceable::new(&scene, Precision::Mixed);
        let lights = LightTable::new(&scene, &traceable);
        Lanes::new(&scene, &traceable, &lights).is_some()
    }

    #[test]
    fn only_small_plain_worlds_are_served() {
        if level().is_none() {
            return;
        }
        let triangle = "Shape \"trianglemesh\" \"point P\" [-1 0 0 1 0 0 0 1 .5] \"integer indices\" [0 1 2]";
        for (before, world) in [
            ("", ""),
            ("Camera \"orthographic\" \"float lensradius\" 1", triangle),
            ("Integrator \"whitted\"", "LightSource \"infinite\" \"integer nsamples\" 2"),
            ("", "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd LightSource \"spot\" Shape \"sphere\""),
            ("", "Material \"matte\" \"float sigma\" 20 Shape \"sphere\""),
            ("", "Material \"plastic\" Shape \"sphere\""),
            ("", &triangle.repeat(MOST)),
        ] {
            assert!(is_served(before, world), "{before} {world}");
        }
        for (before, world) in [
            ("Camera \"environment\"", triangle),
            ("Integrator \"path\"", triangle),
            ("Integrator \"ambientocclusion\"", triangle),
            ("Integrator \"directlighting\" \"string strategy\" \"one\"", triangle),
            ("", "LightSource \"infinite\" \"integer nsamples\" 2"),
            ("", "LightSource \"projection\""),
            ("", "AreaLightSource \"diffuse\" Shape \"sphere\""),
            ("", "Shape \"disk\""),
            ("", "Shape \"curve\" \"point P\" [0 0 0 1 1 0 2 0 0 3 1 0]"),
            ("", "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd ObjectInstance \"o\""),
            ("", "Material \"none\" Shape \"sphere\""),
            ("", "Material \"mirror\" Shape \"sphere\""),
            ("", "Material \"metal\" Shape \"sphere\""),
            (
                "",
                "Texture \"t\" \"color\" \"checkerboard\" Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"",
            ),
            (
                "",
                "Texture \"t\" \"float\" \"fbm\" Material \"matte\" \"texture bumpmap\" \"t\" Shape \"sphere\"",
            ),
            ("", &format!("Texture \"t\" \"float\" \"checkerboard\" {triangle} \"texture alpha\" \"t\"")),
            ("", &format!("{triangle} \"normal N\" [0 0 1 0 1 1 0 0 1]")),
            ("", &triangle.repeat(MOST + 1)),
            ("", &"Shape \"sphere\" ".repeat(MOST / 2 + 1)),
        ] {
            assert!(!is_served(before, world), "{before} {world}");
        }
    }

    /// To the bit, in scenes of all kinds that it serves for, and with all that processors may have.
    #[test]
    fn samples_side_by_side_are_those_one_by_one() {
        let Some(level) = level() else { return };
        let mut levels = vec![level];
        #[cfg(target_arch = "x86_64")]
        levels.extend(level.as_avx2().map(Level::Avx2));
        let mut seen = 0;
        for case in 0..200 {
            let text = text(case);
            let scene = scene(&text);
            let (sums, rays) = pixels(&scene, None);
            // Of these, 110,000 are of the camera.
            seen += rays;
            for level in &levels {
                let (own, own_rays) = pixels(&scene, Some(*level));
                assert_eq!(sums, own, "{level:?} {text}");
                assert_eq!(rays, own_rays, "{level:?} {text}");
            }
        }
        assert!(seen > 180_000, "{seen}");
    }
}
