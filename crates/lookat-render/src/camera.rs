//! Camera rays in closed form and `f64`: from a position on the film and the lens to a ray. Also the depth of field of a lens
//! (PBR 6.2.3), and the texture footprints of camera rays.

mod realistic;

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::{DMat3, DVec2, DVec3};
use lookat_scene::{AnimatedTransform, Camera, Film, Lens, MILLIMETER, Projection, Transform};

pub use crate::camera::realistic::LensRays;
use crate::camera::realistic::RealisticLens;
use crate::number::{LANES, Vec2x8, Vec3x8, baseline};
use crate::ray::Ray;
use crate::trace::rays::Rays;
use crate::warp::at_turn;
use crate::warp::square_to_disk;

/// A camera, prepared to make rays, which are relative to an origin.
#[derive(Debug)]
pub struct CameraRays {
    world_from_camera: DMat3,
    camera_from_world: Transform,
    /// The eye, relative to [`Prepared::origin`](crate::Prepared::origin): the position of a perspective camera, the middle of
    /// the window of an orthographic one, the middle of the film behind a lens system.
    pub eye: DVec3,
    /// The middle of the film in pixels; its place in camera space, on the plane z = 1 of a perspective camera and
    /// relative to the eye of others; and the steps to the next pixel. Counted from the middle, no digits
    /// cancel where rays run along the axis.
    film_middle: DVec2,
    start: DVec2,
    step: DVec2,
    /// The eye in camera space.
    middle: DVec2,
    optics: Optics,
    lens: Option<Lens>,
    /// The way of a camera that moves. The places above are those of the middle of the time when the shutter is open.
    motion: Option<AnimatedTransform>,
    /// See [`Shutter::shares`](lookat_scene::Shutter::shares).
    shutter: [f64; 2],
    /// The position in the world that others are relative to.
    origin: DVec3,
}

/// How rays leave the camera.
#[derive(Debug)]
enum Optics {
    Perspective,
    Orthographic { telecentric: bool },
    Environment,
    Realistic(Box<RealisticLens>),
}

impl CameraRays {
    /// The eye in the world: the position of a perspective camera, the middle of the window
    /// of an orthographic one.
    pub(crate) fn eye(camera: &Camera) -> DVec3 {
        camera.world_from_camera.point(eye_in_camera(camera).extend(0.0))
    }

    pub(crate) fn new(camera: &Camera, film: &Film, origin: DVec3) -> Self {
        let (shutter, placed) = (camera.shutter.shares(), camera.clone().placed(camera.middle()));
        let motion = camera.motion.filter(|_| shutter[0] < shutter[1]);
        let camera = &placed;
        let screen = &camera.screen;
        let middle = eye_in_camera(camera);
        let corner = 0.5 * film.diagonal * MILLIMETER;
        let scale = match camera.projection {
            Projection::Perspective { fov } => tan_half(fov),
            Projection::Orthographic { .. } | Projection::Environment => 1.0,
            Projection::Realistic(_) => camera.screen_unit(film),
        };
        let optics = match &camera.projection {
            Projection::Perspective { .. } => Optics::Perspective,
            Projection::Orthographic { telecentric } => Optics::Orthographic { telecentric: *telecentric },
            Projection::Environment => Optics::Environment,
            Projection::Realistic(lenses) => {
                let focus = camera.lens.map_or(Lens::UNFOCUSED, |lens| lens.focal_distance);
                Optics::Realistic(Box::new(RealisticLens::new(lenses, focus, corner)))
            }
        };
        let start = ((screen.min + screen.max) * 0.5 - middle) * scale;
        // Raster space has y down.
        let extent = DVec2::new(screen.max.x - screen.min.x, screen.min.y - screen.max.y) * scale;
        let resolution = DVec2::new(f64::from(film.resolution[0]), f64::from(film.resolution[1]));
        CameraRays {
            world_from_camera: DMat3::from_mat4(camera.world_from_camera.matrix()),
            camera_from_world: camera.world_from_camera.inverse(),
            eye: CameraRays::eye(camera) - origin,
            film_middle: resolution * 0.5,
            start,
            step: extent / resolution,
            middle,
            optics,
            lens: camera.lens,
            motion,
            shutter,
            origin,
        }
    }

    /// True if the camera moves.
    pub(crate) fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// The instants that numbers from 0 to 1 choose while the shutter is open: see [`Ray::time`].
    #[inline(always)]
    pub(crate) fn times<S: Simd>(&self, u: f64x8<S>) -> f64x8<S> {
        let [open, close] = self.shutter;
        (u * (close - open) + open).max(0.0).min(1.0)
    }

    /// True if rays need a point on the lens.
    pub(crate) fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// The z of a point in camera space: the focal distance at which it is sharp. Negative behind an environment camera.
    pub fn depth(&self, p: DVec3) -> f64 {
        self.camera_from_world.vector(p - self.eye).z
    }

    /// The ray through a place of the film, in pixels from the top left corner of the full picture, and the point of the lens
    /// that `u`, in 0..1, chooses. `u` of 0.5 is the middle of the lens.
    ///
    /// The ray is that of the middle of the time when the shutter is open.
    pub fn ray(&self, film: DVec2, u: DVec2) -> Ray {
        baseline!(simd => {
            let [film, u] = [film, u].map(|at| [at.x.simd_into(simd), at.y.simd_into(simd)]);
            let time = self.times(0.5.simd_into(simd));
            let (o, d) = self.lines(simd, film, Some(u), time);
            Ray { time: time[0], ..Ray::new(o.lane(0), d.normalize().lane(0)) }
        })
    }

    /// The rays through places of the film, in pixels from the top left corner; `u` chooses the points on the lens (PBR 6.2.3).
    #[inline(always)]
    pub(crate) fn rays<S: Simd>(
        &self,
        simd: S,
        film: Vec2x8<S>,
        u: Option<Vec2x8<S>>,
        time: f64x8<S>,
    ) -> Rays<S> {
        let (o, d) = self.lines(simd, film, u, time);
        Rays { time, ..Rays::new(o, d.normalize()) }
    }

    /// Camera rays whose directions have any length.
    #[inline(always)]
    fn lines<S: Simd>(
        &self,
        simd: S,
        film: Vec2x8<S>,
        u: Option<Vec2x8<S>>,
        time: f64x8<S>,
    ) -> (Vec3x8<S>, Vec3x8<S>) {
        let [x, y] = film;
        let p = self.on_screen(film);
        let (zero, one): (f64x8<S>, f64x8<S>) = (0.0.simd_into(simd), 1.0.simd_into(simd));
        let (o, d) = match (&self.optics, self.lens.zip(u)) {
            (Optics::Realistic(lens), on_lens) => {
                let u = on_lens.map_or([0.5.simd_into(simd); 2], |(_, u)| u);
                let rays = lens.rays(simd, on_film(p), u);
                (rays.o, rays.d)
            }
            (Optics::Environment, _) => {
                let film = self.film_middle * 2.0;
                (Vec3x8::splat(simd, DVec3::ZERO), around([x / film.x, y / film.y]))
            }
            (Optics::Perspective, None) => {
                (Vec3x8::splat(simd, DVec3::ZERO), Vec3x8 { x: p[0], y: p[1], z: one })
            }
            (Optics::Perspective, Some((lens, u))) => through_lens([zero; 2], p, lens, u),
            (Optics::Orthographic { .. }, None) => {
                (Vec3x8 { x: p[0], y: p[1], z: zero }, Vec3x8::splat(simd, DVec3::Z))
            }
            (Optics::Orthographic { telecentric: true }, Some((lens, u))) => {
                through_lens(p, [zero; 2], lens, u)
            }
            // pbrt-v3: the ray starts on the lens around the origin of camera space, not around its pixel.
            (Optics::Orthographic { telecentric: false }, Some((lens, u))) => {
                let (x, y) = (p[0] + self.middle.x, p[1] + self.middle.y);
                let center = [(-self.middle.x).simd_into(simd), (-self.middle.y).simd_into(simd)];
                let focal = lens.focal_distance;
                through_lens(center, [x / focal, y / focal], lens, u)
            }
        };
        self.in_world(time, o, d)
    }

    /// Rays through a system of lenses, as [`CameraRays::rays`], and their weights: 0 for those that it blocks.
    #[inline(always)]
    pub(crate) fn weighted_rays<S: Simd>(
        &self,
        simd: S,
        film: Vec2x8<S>,
        u: Option<Vec2x8<S>>,
        time: f64x8<S>,
    ) -> (Rays<S>, Option<f64x8<S>>) {
        let (Optics::Realistic(lens), Some(u)) = (&self.optics, u) else {
            return (self.rays(simd, film, u, time), None);
        };
        let rays = lens.rays(simd, on_film(self.on_screen(film)), u);
        let (o, d) = self.in_world(time, rays.o, rays.d);
        (Rays { time, ..Rays::new(o, d.normalize()) }, Some(rays.weights))
    }

    /// True if rays have weights.
    pub(crate) fn has_weights(&self) -> bool {
        matches!(self.optics, Optics::Realistic(_))
    }

    /// Places of the film in camera space: see `start`.
    #[inline(always)]
    fn on_screen<S: Simd>(&self, [x, y]: Vec2x8<S>) -> Vec2x8<S> {
        let (start, step, middle) = (self.start, self.step, self.film_middle);
        [start.x + step.x * (x - middle.x), start.y + step.y * (y - middle.y)]
    }

    /// Origins relative to the origin of the prepared world, and directions, of rays in camera space. `o`: relative to the eye.
    #[inline(always)]
    fn in_world<S: Simd>(&self, time: f64x8<S>, o: Vec3x8<S>, d: Vec3x8<S>) -> (Vec3x8<S>, Vec3x8<S>) {
        match &self.motion {
            None => {
                let m = &self.world_from_camera;
                (Vec3x8::splat(o.x.token(), self.eye) + o.by(m), d.by(m))
            }
            Some(motion) => self.moved(motion, time, o, d),
        }
    }

    /// Lines of a camera that moves, in the world. `o`: relative to the eye.
    #[inline(never)]
    fn moved<S: Simd>(
        &self,
        motion: &AnimatedTransform,
        time: f64x8<S>,
        mut o: Vec3x8<S>,
        mut d: Vec3x8<S>,
    ) -> (Vec3x8<S>, Vec3x8<S>) {
        let eye = self.middle.extend(0.0);
        for lane in 0..LANES {
            let placed = motion.at(time[lane]);
            o.set_lane(lane, placed.point(eye) - self.origin + placed.vector(o.lane(lane)));
            d.set_lane(lane, placed.vector(d.lane(lane)));
        }
        (o, d)
    }
}

/// The place on the film of a lens system that shows a place of the picture: its image is upside down.
#[inline(always)]
fn on_film<S: Simd>([x, y]: Vec2x8<S>) -> Vec2x8<S> {
    [-x, -y]
}

/// The tangent of half an angle in degrees. Near 180 degrees it is that of what is missing, which is exact.
fn tan_half(degrees: f64) -> f64 {
    if degrees > 90.0 {
        1.0 / libm::tan(((180.0 - degrees) * 0.5).to_radians())
    } else {
        libm::tan((degrees * 0.5).to_radians())
    }
}

fn eye_in_camera(camera: &Camera) -> DVec2 {
    match camera.projection {
        Projection::Perspective { .. } | Projection::Environment | Projection::Realistic(_) => DVec2::ZERO,
        Projection::Orthographic { .. } => (camera.screen.min + camera.screen.max) * 0.5,
    }
}

/// The directions at places of a picture of all directions, from 0 to 1 from left to right and from top to bottom
/// (PBR 6.3), and beyond its edges.
#[inline(always)]
fn around<S: Simd>([x, y]: Vec2x8<S>) -> Vec3x8<S> {
    let at = |turn: f64x8<S>| at_turn(turn - turn.floor());
    let ([cos_theta, sin_theta], [cos_phi, sin_phi]) = (at(y * 0.5), at(x));
    Vec3x8 { x: sin_theta * cos_phi, y: cos_theta, z: sin_theta * sin_phi }
}

/// Rays that start on the lens around `center` and pass where the lines from `center` along `(slope, 1)` meet the plane of focus.
#[inline(always)]
fn through_lens<S: Simd>(
    center: Vec2x8<S>,
    slope: Vec2x8<S>,
    lens: Lens,
    u: Vec2x8<S>,
) -> (Vec3x8<S>, Vec3x8<S>) {
    let [x, y] = square_to_disk(u);
    let (x, y) = (x * lens.radius, y * lens.radius);
    let simd = x.token();
    let o = Vec3x8 { x: center[0] + x, y: center[1] + y, z: 0.0.simd_into(simd) };
    let focal = lens.focal_distance;
    // Scaled by the smaller of the two lengths, so that neither overflows: any focal distance is exact.
    if focal >= lens.radius {
        (o, Vec3x8 { x: slope[0] - x / focal, y: slope[1] - y / focal, z: 1.0.simd_into(simd) })
    } else {
        (o, Vec3x8 { x: slope[0] * focal - x, y: slope[1] * focal - y, z: focal.simd_into(simd) })
    }
}

/// The depth of field of a lens. Distances are along z in camera space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Focus {
    field: DepthOfField,
    /// The distance in focus, from the lens.
    focal_distance: f64,
    /// The diameter of the lens in pixels, seen at distance 1.
    aperture: f64,
    /// The depth of the lens: of the entrance pupil of a lens system.
    depth: f64,
    hyperfocal: Option<f64>,
}

/// How blur grows with the distance from the plane of focus.
#[derive(Debug, Clone, Copy, PartialEq)]
enum DepthOfField {
    Perspective,
    Telecentric,
    /// Rays of all pixels start at one lens, as in pbrt-v3's orthographic camera.
    OneLens,
}

impl Focus {
    /// The focus of a camera with a lens. `None` without a lens.
    pub fn new(camera: &Camera, film: &Film) -> Option<Focus> {
        let Lens { radius, focal_distance } = camera.lens?;
        let resolution = DVec2::new(f64::from(film.resolution[0]), f64::from(film.resolution[1]));
        let window = (camera.screen.max - camera.screen.min).abs() / resolution;
        let pixel = (window.x * window.y).sqrt();
        let focus = |field, pixel: f64| {
            let aperture = 2.0 * radius / pixel;
            let hyperfocal = (field == DepthOfField::Perspective).then_some(aperture);
            Focus { field, focal_distance, aperture, depth: 0.0, hyperfocal }
        };
        Some(match &camera.projection {
            Projection::Perspective { fov } => focus(DepthOfField::Perspective, pixel * tan_half(*fov)),
            Projection::Orthographic { telecentric: true } => focus(DepthOfField::Telecentric, pixel),
            Projection::Orthographic { telecentric: false } => focus(DepthOfField::OneLens, pixel),
            Projection::Environment => return None,
            Projection::Realistic(lenses) => {
                let pixel = pixel * camera.screen_unit(film);
                let view = lenses.equivalent_view(focal_distance)?;
                let thick = lenses.thick_lens()?;
                let f = thick.focal_length;
                // The distance from the front principal plane where blur at infinity is a pixel, and from there to the film.
                let object = f + 2.0 * radius * f / pixel;
                let hyperfocal = object + f * object / (object - f) + thick.front_plane - thick.rear_plane;
                Focus {
                    focal_distance: focal_distance - view.depth,
                    depth: view.depth,
                    hyperfocal: Some(hyperfocal),
                    ..focus(DepthOfField::Perspective, pixel * view.scale)
                }
            }
        })
    }

    /// The diameter of the circle of confusion of a point at a depth, in pixels. 0 at the focal distance.
    pub fn blur(&self, depth: f64) -> f64 {
        let (focal, depth) = (self.focal_distance, (depth - self.depth).max(f64::MIN_POSITIVE));
        self.aperture
            * match self.field {
                DepthOfField::Perspective => (1.0 / focal - 1.0 / depth).abs(),
                DepthOfField::Telecentric => (1.0 - depth / focal).abs(),
                DepthOfField::OneLens => (focal / depth - 1.0).abs(),
            }
    }

    /// The depths between which points are blurred by one pixel at most; the last may be infinite.
    pub fn sharp(&self) -> [f64; 2] {
        let (focal, share) = (self.focal_distance, 1.0 / self.aperture);
        let sharp = match self.field {
            DepthOfField::Perspective => {
                let far = 1.0 / focal - share;
                [1.0 / (1.0 / focal + share), if far > 0.0 { 1.0 / far } else { f64::INFINITY }]
            }
            DepthOfField::Telecentric => [(focal * (1.0 - share)).max(0.0), focal * (1.0 + share)],
            DepthOfField::OneLens => {
                [focal / (1.0 + share), if share < 1.0 { focal / (1.0 - share) } else { f64::INFINITY }]
            }
        };
        sharp.map(|depth| depth + self.depth)
    }

    /// The hyperfocal distance: focused there, a perspective camera blurs nothing behind by more than a pixel. `None` of others.
    pub fn hyperfocal(&self) -> Option<f64> {
        self.hyperfocal
    }
}

/// A camera and the spacing of its samples.
#[derive(Clone, Copy)]
pub(crate) struct Viewer<'v> {
    pub camera: &'v CameraRays,
    /// From one sample to the next, in pixels.
    pub spacing: f64,
}

/// The position of a camera sample on the film, in pixels, the random numbers for its point on the lens, and its instant (PBR 6.1).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CameraSample {
    pub film: DVec2,
    pub lens: DVec2,
    /// See [`Ray::time`].
    pub time: f64,
}

/// The camera samples of a packet of rays.
#[derive(Clone, Copy)]
pub(crate) struct Views<'v> {
    pub of: Viewer<'v>,
    /// All samples of the batch.
    pub camera_samples: &'v [CameraSample],
    /// The samples in the lanes of the packet.
    pub samples: [u16; LANES],
    /// Bits of the samples whose rays have not passed anything.
    pub direct: u64,
}

impl Views<'_> {
    /// Origins and directions, of any length, of the neighbors of the rays to the right and below, through the same points of the lens.
    #[inline(always)]
    pub fn neighbors<S: Simd>(&self, simd: S) -> [(Vec3x8<S>, Vec3x8<S>); 2] {
        let (mut numbers, mut time): (_, f64x8<S>) = ([[0.0; LANES]; 4], 0.0.simd_into(simd));
        for (lane, sample) in self.samples.iter().enumerate() {
            let CameraSample { film, lens, time: own } = self.camera_samples[usize::from(*sample)];
            time[lane] = own;
            for (own, number) in numbers.iter_mut().zip([film.x, film.y, lens.x, lens.y]) {
                own[lane] = number;
            }
        }
        let [x, y, u, v]: [f64x8<S>; 4] = numbers.map(
            #[inline(always)]
            |numbers| numbers.simd_into(simd),
        );
        let Viewer { camera, spacing } = self.of;
        let lines = |film| camera.lines(simd, film, Some([u, v]), time);
        [lines([x + spacing, y]), lines([x, y + spacing])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat4;
    use glam::DVec2;
    use glam::DVec3;
    use glam::DVec4;
    use lookat_scene::Transform;
    use lookat_scene::{ScreenWindow, Shutter};

    fn film() -> Film {
        Film::new([200, 120])
    }

    fn camera(projection: Projection, lens: Option<Lens>) -> Camera {
        let eye = DVec3::new(-3.0, 1.5, -3.0);
        let look_at = Transform::look_at(eye, DVec3::ZERO, DVec3::new(0.2, 1.0, 0.0)).unwrap();
        let mirrored = Transform::scale(DVec3::new(-1.0, 1.0, 1.0)).unwrap() * look_at;
        let screen = ScreenWindow { min: DVec2::new(-0.5, -0.3), max: DVec2::new(1.25, 0.9) };
        Camera { screen, lens, ..Camera::new(mirrored, projection, &film()) }
    }

    /// The chain of PBR 6.1 and 6.2, matrix by matrix: camera, screen, NDC and raster space.
    fn book(camera: &Camera, film: DVec2, u: DVec2) -> (DVec3, DVec3) {
        let window = &camera.screen;
        let size = DVec2::new(200.0, 120.0);
        let raster_from_screen = DMat4::from_scale(DVec3::new(size.x, size.y, 1.0))
            * DMat4::from_scale(DVec3::new(
                1.0 / (window.max.x - window.min.x),
                1.0 / (window.min.y - window.max.y),
                1.0,
            ))
            * DMat4::from_translation(DVec3::new(-window.min.x, -window.max.y, 0.0));
        let screen_from_camera = match camera.projection {
            Projection::Perspective { fov } => {
                let (n, f) = (1e-2, 1000.0);
                let project = DMat4::from_cols(
                    DVec4::X,
                    DVec4::Y,
                    DVec4::new(0.0, 0.0, f / (f - n), 1.0),
                    DVec4::new(0.0, 0.0, -f * n / (f - n), 0.0),
                );
                DMat4::from_scale(DVec3::new(
                    1.0 / (fov / 2.0).to_radians().tan(),
                    1.0 / (fov / 2.0).to_radians().tan(),
                    1.0,
                )) * project
            }
            _ => DMat4::IDENTITY,
        };
        let camera_from_raster = screen_from_camera.inverse() * raster_from_screen.inverse();
        let p = camera_from_raster.project_point3(film.extend(0.0));
        let (mut o, mut d) = match camera.projection {
            Projection::Perspective { .. } => (DVec3::ZERO, p.normalize()),
            _ => (p, DVec3::Z),
        };
        if let Some(lens) = camera.lens {
            let [x, y] = baseline!(simd => square_to_disk::<f64x8<_>>([u.x, u.y].map(|u| u.simd_into(simd))).map(|x| x[0]));
            let on_lens = DVec3::new(x, y, 0.0) * lens.radius;
            let focus = o + d * (lens.focal_distance / d.z);
            o = match camera.projection {
                Projection::Orthographic { telecentric: true } => o + on_lens,
                _ => on_lens,
            };
            d = focus - o;
        }
        (camera.world_from_camera.point(o), camera.world_from_camera.vector(d).normalize())
    }

    /// The middle of the left and right edge is +x, the top +y, and a quarter to the right +z.
    #[test]
    fn environments_are_seen_all_around() {
        for (place, expected) in [
            (DVec2::new(0.0, 0.5), DVec3::X),
            (DVec2::new(1.0, 0.5), DVec3::X),
            (DVec2::new(0.25, 0.5), DVec3::Z),
            (DVec2::new(-0.75, 0.5), DVec3::Z),
            (DVec2::new(0.5, 0.5), -DVec3::X),
            (DVec2::new(0.3, 0.0), DVec3::Y),
        ] {
            let d = baseline!(simd => around(place.to_array().map(|x| x.simd_into(simd))).lane(0));
            assert!((d - expected).length() < 1e-15, "{place}");
        }
    }

    #[test]
    fn rays_are_those_of_the_matrices_of_the_book() {
        let lens = Some(Lens { radius: 0.3, focal_distance: 3.0 });
        let perspective = || Projection::Perspective { fov: 70.0 };
        let cases = [
            camera(perspective(), None),
            camera(perspective(), lens),
            camera(perspective(), Some(Lens { radius: 0.3, focal_distance: 0.1 })),
            camera(Projection::Orthographic { telecentric: false }, None),
            camera(Projection::Orthographic { telecentric: false }, lens),
            camera(Projection::Orthographic { telecentric: true }, lens),
        ];
        for camera in cases {
            let rays = CameraRays::new(&camera, &film(), DVec3::ZERO);
            for (x, y) in [(0.0, 0.0), (100.0, 60.0), (200.0, 0.0), (37.25, 111.5)] {
                let (film, u) = (DVec2::new(x, y), DVec2::new(0.2, 0.9));
                let ray = rays.ray(film, u);
                let (o, d) = book(&camera, film, u);
                assert!((ray.o - o).length() < 1e-13, "{camera:?} {film}");
                assert!((ray.d - d).length() < 1e-12, "{camera:?} {film}: {} {d}", ray.d);
            }
        }
    }

    #[test]
    fn a_camera_moves_while_its_shutter_is_open() {
        let still = camera(Projection::Orthographic { telecentric: false }, None);
        let end = Transform::translate(DVec3::new(1.0, 2.0, 3.0)) * still.world_from_camera;
        let motion = AnimatedTransform::new(still.world_from_camera, end).unwrap();
        let shutter = Shutter { open: 3.0, close: 7.0, transform_times: [0.0, 8.0] };
        let moving = Camera { motion: Some(motion), shutter, ..still.clone() };
        let origin = DVec3::new(-1.0, 0.5, 0.0);
        let rays = CameraRays::new(&moving, &film(), origin);
        let film = DVec2::new(20.0, 70.0);
        baseline!(simd => {
            let u = f64x8::from_fn(simd, |lane| lane as f64 / 7.0);
            let at = rays.rays(simd, [film.x.simd_into(simd), film.y.simd_into(simd)], None, rays.times(u));
            for lane in 0..LANES {
                let time = (3.0 + 4.0 * u[lane]) / 8.0;
                let own = still.clone().placed(motion.at(time));
                let expected = CameraRays::new(&own, &self::film(), origin).ray(film, DVec2::ZERO);
                assert!((at.time[lane] - time).abs() < 1e-15);
                assert!((at.o.lane(lane) - expected.o).length() < 1e-12, "{lane}");
                assert!((at.d.lane(lane) - expected.d).length() < 1e-12, "{lane}");
            }
        });
        let middle = rays.ray(film, DVec2::ZERO);
        assert_eq!(middle.time, 0.625);
        // A shutter that opens before all motion, and one that closes after it.
        let shutter = Shutter { open: -8.0, close: 16.0, ..shutter };
        let rays = CameraRays::new(&Camera { shutter, ..moving }, &self::film(), origin);
        let times = baseline!(simd => rays.times([0.0, 0.2, 0.5, 0.7, 1.0, 0.0, 0.0, 0.0].simd_into(simd)).to_array());
        assert_eq!(times[..5], [0.0, 0.0, 0.5, 1.0, 1.0]);
    }

    #[test]
    fn the_middle_of_a_very_wide_view_is_exact() {
        let screen = ScreenWindow { min: DVec2::splat(-1.0), max: DVec2::splat(1.0) };
        let projection = Projection::Perspective { fov: 179.9 };
        let camera = Camera { screen, ..Camera::new(Transform::IDENTITY, projection, &film()) };
        let ray = CameraRays::new(&camera, &film(), DVec3::ZERO).ray(DVec2::new(100.0625, 60.0), DVec2::ZERO);
        // From tan(89.95 degrees), computed with 60 digits.
        let expected = 1145.915299373488 * 0.0625 / 100.0;
        assert!((ray.d.x / ray.d.z / expected - 1.0).abs() < 1e-15, "{}", ray.d.x / ray.d.z);
    }

    #[test]
    fn any_focal_distance_gives_a_direction() {
        for focal_distance in [1e-300, 1e-30, 1.0, 1e30, 1e300] {
            let lens = Some(Lens { radius: 1.0, focal_distance });
            let camera = camera(Projection::Perspective { fov: 60.0 }, lens);
            let ray = CameraRays::new(&camera, &film(), DVec3::ZERO)
                .ray(DVec2::new(3.0, 4.0), DVec2::new(0.9, 0.3));
            assert!((ray.d.length() - 1.0).abs() < 1e-14, "{focal_distance}");
        }
    }

    /// Rays from the edges of the lens through the middle of the film, where they meet a plane, and how many pixels that is.
    #[test]
    fn blur_is_the_spread_of_camera_rays() {
        let film = Film::new([300, 200]);
        let screen = ScreenWindow { min: DVec2::new(-1.5, -1.0), max: DVec2::new(1.5, 1.0) };
        for projection in [
            Projection::Perspective { fov: 40.0 },
            Projection::Orthographic { telecentric: true },
            Projection::Orthographic { telecentric: false },
        ] {
            let lens = Lens { radius: 0.2, focal_distance: 3.0 };
            let camera =
                Camera { screen, lens: Some(lens), ..Camera::new(Transform::IDENTITY, projection, &film) };
            let projection = &camera.projection;
            let focus = Focus::new(&camera, &film).unwrap();
            let rays = CameraRays::new(&camera, &film, DVec3::ZERO);
            for depth in [0.5, 1.0, 2.5, 3.0, 3.5, 10.0, 1e3] {
                let at = |film: f64, u: f64| {
                    let ray = rays.ray(DVec2::new(film, 100.0), DVec2::new(u, 0.5));
                    ray.at((depth - ray.o.z) / ray.d.z).x
                };
                let spread = (at(150.0, 1.0 - 1e-12) - at(150.0, 0.0)).abs();
                let pixel = at(151.0, 0.5) - at(150.0, 0.5);
                let blur = focus.blur(depth);
                assert!((blur - spread / pixel).abs() < 1e-6 * (1.0 + blur), "{projection:?} {depth} {blur}");
            }
            for depth in focus.sharp().into_iter().filter(|depth| depth.is_finite()) {
                assert!((focus.blur(depth) - 1.0).abs() < 1e-9, "{projection:?} {depth}");
            }
            if let Some(hyperfocal) = focus.hyperfocal() {
                let lens = Lens { focal_distance: hyperfocal, ..lens };
                let focus = Focus::new(&Camera { lens: Some(lens), ..camera.clone() }, &film).unwrap();
                let [near, far] = focus.sharp();
                assert!((near / hyperfocal - 0.5).abs() < 1e-9 && far > 1e6 * hyperfocal, "{near} {far}");
            }
        }
    }
}
