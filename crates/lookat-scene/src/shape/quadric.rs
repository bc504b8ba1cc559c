//! Quadrics: surfaces of revolution around the z axis of object space.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};

use crate::Transform;
use crate::params::Params;
use crate::schema::{Key, Kind, Range, Unit};
use crate::transform::LARGEST;

/// A quadric around the z axis of object space, or a part of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadric {
    /// The form.
    pub form: QuadricForm,
    /// The sweep angle about z from +x toward +y, in radians, above 0 and at most 2 pi (`phimax`, default 360
    /// degrees). A hyperboloid starts at its segment instead of +x.
    pub phi_max: f64,
    /// Its placement.
    pub world_from_object: Transform,
}

/// The form of a [`Quadric`], in object space.
#[derive(Debug, Clone, PartialEq)]
pub enum QuadricForm {
    /// A sphere around the origin.
    Sphere(Sphere),
    /// A disk or ring.
    Disk(Disk),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A cone.
    Cone(Cone),
    /// A paraboloid.
    Paraboloid(Paraboloid),
    /// A hyperboloid.
    Hyperboloid(Box<Hyperboloid>),
}

impl QuadricForm {
    /// The type name in scene files.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            QuadricForm::Sphere(_) => "sphere",
            QuadricForm::Disk(_) => "disk",
            QuadricForm::Cylinder(_) => "cylinder",
            QuadricForm::Cone(_) => "cone",
            QuadricForm::Paraboloid(_) => "paraboloid",
            QuadricForm::Hyperboloid(_) => "hyperboloid",
        }
    }
}

impl Quadric {
    /// A whole sphere around the origin of object space.
    pub fn sphere(radius: f64, world_from_object: Transform) -> Quadric {
        let form = QuadricForm::Sphere(Sphere { radius, z_min: -radius, z_max: radius });
        Quadric { form, phi_max: TAU, world_from_object }
    }

    /// The lowest and highest z, and the largest distance from the axis, in object space, for a full sweep.
    pub fn extent(&self) -> (f64, f64, f64) {
        match self.form {
            QuadricForm::Sphere(Sphere { radius, .. }) => (-radius, radius, radius),
            QuadricForm::Disk(Disk { height, radius, .. }) => (height, height, radius),
            QuadricForm::Cylinder(Cylinder { radius, z_min, z_max }) => (z_min, z_max, radius),
            QuadricForm::Cone(Cone { radius, height }) => (0.0, height, radius),
            QuadricForm::Paraboloid(Paraboloid { radius, z_min, z_max }) => (z_min.max(0.0), z_max, radius),
            QuadricForm::Hyperboloid(ref form) => {
                let Hyperboloid { p1, p2 } = **form;
                (p1.z.min(p2.z), p1.z.max(p2.z), p1.truncate().length().max(p2.truncate().length()))
            }
        }
    }

    /// Two opposite corners of the bounding box in object space.
    pub fn corners(&self) -> (DVec3, DVec3) {
        let (low, high, radius) = self.extent();
        (DVec3::new(-radius, -radius, low), DVec3::new(radius, radius, high))
    }
}

pub(super) fn quadric(params: &mut Params, world_from_object: Transform) -> Option<Quadric> {
    let limits = Limits::new(&world_from_object);
    let form = match params.kind() {
        "sphere" => QuadricForm::Sphere(sphere(params, &limits)),
        "disk" => QuadricForm::Disk(disk(params, &limits)),
        "cylinder" => QuadricForm::Cylinder(cylinder(params, &limits)),
        "cone" => QuadricForm::Cone(cone(params, &limits)),
        "paraboloid" => QuadricForm::Paraboloid(paraboloid(params, &limits)),
        "hyperboloid" => QuadricForm::Hyperboloid(Box::new(hyperboloid(params, &limits))),
        other => unreachable!("shape::shape has no arm for {other}"),
    };
    let phi_max = sweep(params).min(TAU);
    params.usable().then_some(Quadric { form, phi_max, world_from_object })
}

pub(super) const fn radius(meaning: &'static str) -> Key<f64> {
    Key::float("radius", 1.0, meaning).within(Range::above(0.0)).unit(Unit::ObjectSpace)
}

pub(super) const fn z_min(default: f64) -> Key<f64> {
    Key::float("zmin", default, "the lowest z; zmin and zmax may be swapped").unit(Unit::ObjectSpace)
}

pub(super) const fn z_max(default: f64) -> Key<f64> {
    Key::float("zmax", default, "the highest z, different from zmin").unit(Unit::ObjectSpace)
}

const PHI_MAX: Key<f64> =
    Key::float("phimax", 360.0, "the angle of the sweep around the z axis; over 360 counts as 360")
        .within(Range::above(0.0))
        .unit(Unit::Degrees);

/// The valid lengths of a shape under its transformation.
pub(crate) struct Limits {
    largest: f64,
}

impl Limits {
    pub fn new(world_from_object: &Transform) -> Self {
        let linear = world_from_object.linear().to_cols_array();
        Limits { largest: LARGEST / linear.iter().fold(1.0_f64, |max, x| max.max(x.abs())) }
    }

    /// The valid lengths.
    pub fn lengths(&self) -> RangeInclusive<f64> {
        LARGEST.recip()..=self.largest
    }

    /// True if no coordinate is too large.
    pub fn contain(&self, coordinates: &[f64]) -> bool {
        coordinates.iter().all(|x| x.abs() <= self.largest)
    }

    /// A length above 0.
    pub fn length(&self, params: &mut Params, key: &Key<f64>) -> f64 {
        let length = params.take(key);
        let (least, largest) = self.lengths().into_inner();
        if !self.lengths().contains(&length) {
            let range = format!("from {least:.1e} to {largest:.1e} under this transformation");
            params.reject(key.name, format!("{} must be {range}", key.name), None);
        }
        length
    }

    /// Rejects a parameter with a coordinate that is too large under this transformation.
    pub fn check(&self, params: &mut Params, name: &str, coordinates: &[f64]) {
        if !self.contain(coordinates) {
            params.reject(
                name,
                format!("{name} must be at most {:.1e} under this transformation", self.largest),
                None,
            );
        }
    }

    /// `zmin` and `zmax` in ascending order, as in pbrt-v3. Equal values are an error.
    pub fn heights(&self, params: &mut Params, keys: [Key<f64>; 2]) -> [f64; 2] {
        let [z0, z1] = keys.map(|key| params.take(&key));
        self.check(params, "zmin", &[z0]);
        self.check(params, "zmax", &[z1]);
        if z0 == z1 {
            params.reject(
                given(params),
                format!("the shape is empty: zmin {z0} is not below zmax {z1}"),
                None,
            );
        }
        [z0.min(z1), z0.max(z1)]
    }
}

/// The parameter to underline: `zmin` or `zmax`, preferably one that is given.
pub(super) fn given(params: &Params) -> &'static str {
    if params.was_taken("zmin") { "zmin" } else { "zmax" }
}

/// `phimax`, in radians.
fn sweep(params: &mut Params) -> f64 {
    let phi_max = params.take(&PHI_MAX);
    if phi_max > 360.0 {
        params.note("phimax", "phimax above 360 degrees is used as 360, as in pbrt-v3", "360 is a full turn");
    }
    phi_max.min(360.0).to_radians()
}

/// A sphere around the origin, clipped in z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// The radius, above 0 (`radius`, default 1).
    pub radius: f64,
    /// The lowest z, at least -radius (`zmin`, default -radius).
    pub z_min: f64,
    /// The highest z, at most radius, above `z_min` (`zmax`, default radius).
    pub z_max: f64,
}

const SPHERE_RADIUS: Key<f64> = radius("the radius of the sphere");
const SPHERE_Z_MIN: Key<f64> = z_min(-1.0).default_words("-radius");
const SPHERE_Z_MAX: Key<f64> = z_max(1.0).default_words("radius");

pub(super) const SPHERE_KIND: Kind = Kind::new(
    "sphere",
    "a sphere around the origin, clipped in z",
    &[&[&SPHERE_RADIUS, &SPHERE_Z_MIN, &SPHERE_Z_MAX, &PHI_MAX]],
);

pub(super) fn sphere(params: &mut Params, limits: &Limits) -> Sphere {
    let radius = limits.length(params, &SPHERE_RADIUS);
    if !params.usable() {
        // The heights depend on the radius. Take them, so that they are not reported as unknown.
        let (z_min, z_max) = (params.take(&SPHERE_Z_MIN), params.take(&SPHERE_Z_MAX));
        return Sphere { radius, z_min, z_max };
    }
    let [z_min, z_max] = limits
        .heights(params, [Key { default: -radius, ..SPHERE_Z_MIN }, Key { default: radius, ..SPHERE_Z_MAX }]);
    if z_min < z_max && (z_min >= radius || z_max <= -radius) {
        params.reject(given(params), "the sphere is empty between zmin and zmax", None);
    }
    Sphere { radius, z_min: z_min.max(-radius), z_max: z_max.min(radius) }
}

/// A disk or ring perpendicular to the z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// Its z (`height`, default 0).
    pub height: f64,
    /// The outer radius, above `inner_radius` (`radius`, default 1).
    pub radius: f64,
    /// The radius of the hole, at least 0 (`innerradius`, default 0).
    pub inner_radius: f64,
}

const DISK_HEIGHT: Key<f64> = Key::float("height", 0.0, "the z of the disk").unit(Unit::ObjectSpace);
const DISK_RADIUS: Key<f64> = radius("the outer radius");
const INNER_RADIUS: Key<f64> = Key::float("innerradius", 0.0, "the radius of the hole, less than radius")
    .within(Range::at_least(0.0))
    .unit(Unit::ObjectSpace);

pub(super) const DISK_KIND: Kind = Kind::new(
    "disk",
    "a disk or ring perpendicular to the z axis",
    &[&[&DISK_HEIGHT, &DISK_RADIUS, &INNER_RADIUS, &PHI_MAX]],
);

pub(super) fn disk(params: &mut Params, limits: &Limits) -> Disk {
    let height = params.take(&DISK_HEIGHT);
    limits.check(params, "height", &[height]);
    let radius = limits.length(params, &DISK_RADIUS);
    let inner_radius = params.take(&INNER_RADIUS);
    if params.usable() && inner_radius >= radius {
        let message = format!("the disk is empty: innerradius {inner_radius} is not below radius {radius}");
        params.reject("innerradius", message, None);
    }
    Disk { height, radius, inner_radius }
}

/// A cylinder around the z axis, open at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// The radius, above 0 (`radius`, default 1).
    pub radius: f64,
    /// Lowest z (`zmin`, default -1).
    pub z_min: f64,
    /// Highest z, above `z_min` (`zmax`, default 1).
    pub z_max: f64,
}

const CYLINDER_RADIUS: Key<f64> = radius("the radius of the cylinder");
const CYLINDER_Z_MIN: Key<f64> = z_min(-1.0);
const CYLINDER_Z_MAX: Key<f64> = z_max(1.0);

pub(super) const CYLINDER_KIND: Kind = Kind::new(
    "cylinder",
    "a cylinder around the z axis, open at both ends",
    &[&[&CYLINDER_RADIUS, &CYLINDER_Z_MIN, &CYLINDER_Z_MAX, &PHI_MAX]],
);

pub(super) fn cylinder(params: &mut Params, limits: &Limits) -> Cylinder {
    let radius = limits.length(params, &CYLINDER_RADIUS);
    let [z_min, z_max] = limits.heights(params, [CYLINDER_Z_MIN, CYLINDER_Z_MAX]);
    Cylinder { radius, z_min, z_max }
}

/// A cone around the z axis, open at its base in the plane z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// The radius of the base, above 0 (`radius`, default 1).
    pub radius: f64,
    /// The z of the apex, above 0 (`height`, default 1).
    pub height: f64,
}

const CONE_RADIUS: Key<f64> = radius("the radius of the open base at z = 0");
const CONE_HEIGHT: Key<f64> =
    Key::float("height", 1.0, "the z of the tip").within(Range::above(0.0)).unit(Unit::ObjectSpace);

pub(super) const CONE_KIND: Kind = Kind::new(
    "cone",
    "a cone around the z axis, open at its base",
    &[&[&CONE_RADIUS, &CONE_HEIGHT, &PHI_MAX]],
);

pub(super) fn cone(params: &mut Params, limits: &Limits) -> Cone {
    Cone { radius: limits.length(params, &CONE_RADIUS), height: limits.length(params, &CONE_HEIGHT) }
}

/// A paraboloid around the z axis with its vertex at the origin, open at the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paraboloid {
    /// The radius at `z_max`, above 0 (`radius`, default 1).
    pub radius: f64,
    /// The lowest z, with texture coordinate v = 0, at least 0 (`zmin`, default 0).
    pub z_min: f64,
    /// The highest z, above 0 and above `z_min` (`zmax`, default 1).
    pub z_max: f64,
}

impl Paraboloid {
    /// True if it is neither too flat nor too narrow.
    pub(crate) fn is_curved(&self) -> bool {
        (1e-100..=1e100).contains(&(self.z_max / self.radius / self.radius))
    }
}

const PARABOLOID_RADIUS: Key<f64> = radius("the radius at zmax");
const PARABOLOID_Z_MIN: Key<f64> = z_min(0.0);
const PARABOLOID_Z_MAX: Key<f64> = z_max(1.0);

pub(super) const PARABOLOID_KIND: Kind = Kind::new(
    "paraboloid",
    "a paraboloid around the z axis with its vertex at the origin, open at the top",
    &[&[&PARABOLOID_RADIUS, &PARABOLOID_Z_MIN, &PARABOLOID_Z_MAX, &PHI_MAX]],
);

pub(super) fn paraboloid(params: &mut Params, limits: &Limits) -> Paraboloid {
    let radius = limits.length(params, &PARABOLOID_RADIUS);
    let [z_min, z_max] = limits.heights(params, [PARABOLOID_Z_MIN, PARABOLOID_Z_MAX]);
    if z_min < z_max && z_max <= 0.0 {
        let help = "its vertex is at z = 0 and it opens upward: to turn it over, use Scale 1 1 -1";
        params.reject(given(params), "the paraboloid is empty between zmin and zmax", Some(help));
    }
    let paraboloid = Paraboloid { radius, z_min, z_max };
    if z_max > 0.0 && !paraboloid.is_curved() {
        params.reject(given(params), "the paraboloid is too flat or too narrow", None);
    }
    paraboloid
}

/// A line segment rotated about the z axis. If both ends have the same angle about the axis, it is a cone or a part
/// of one. If it is parallel to the axis, it is a cylinder.
///
/// pbrt-v3 renders another surface unless the waist, the point of the line closest to the axis, is at z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hyperboloid {
    /// The end with texture coordinate v = 0 (`p1`, default 0 0 0).
    pub p1: DVec3,
    /// The end with v = 1. Its z is not 0 and differs from the z of `p1` (`p2`, default 1 1 1).
    pub p2: DVec3,
}

const P1: Key<[f64; 3]> =
    Key::point("p1", [0.0; 3], "one end of the segment, with v = 0").unit(Unit::ObjectSpace);
const P2: Key<[f64; 3]> =
    Key::point("p2", [1.0; 3], "the other end, with v = 1, at another z").unit(Unit::ObjectSpace);

pub(super) const HYPERBOLOID_KIND: Kind =
    Kind::new("hyperboloid", "a line segment rotated about the z axis", &[&[&P1, &P2, &PHI_MAX]]);

pub(super) fn hyperboloid(params: &mut Params, limits: &Limits) -> Hyperboloid {
    let (p1, p2) = (params.take(&P1), params.take(&P2));
    limits.check(params, "p1", &p1.to_array());
    limits.check(params, "p2", &p2.to_array());
    let given = if params.was_taken("p2") { "p2" } else { "p1" };
    if p1.z == p2.z {
        let help = "for a flat ring, use Shape \"disk\" with \"float innerradius\"";
        params.reject(given, "p1 and p2 of a hyperboloid must have different z", Some(help));
    } else if p1.truncate() == DVec2::ZERO && p2.truncate() == DVec2::ZERO {
        params.reject(given, "p1 and p2 of a hyperboloid must not both lie on its axis", None);
    }
    if params.usable() && !has_waist_at_zero(p1, p2) {
        let message = "pbrt-v3 renders this hyperboloid as another surface that misses p1 (a known defect)";
        let help =
            "lookat rotates the segment from p1 to p2; the two programs agree if the waist is at z = 0";
        params.warn(given, message, help);
    }
    // The order determines the outer side and the direction of v.
    if p2.z == 0.0 { Hyperboloid { p1: p2, p2: p1 } } else { Hyperboloid { p1, p2 } }
}

/// True if the point of the line closest to the axis is at z = 0.
fn has_waist_at_zero(p1: DVec3, p2: DVec3) -> bool {
    let along = p2 - p1;
    let at_zero = p1 - along * (p1.z / along.z);
    let [p, d] = [at_zero, along].map(DVec3::truncate);
    p.dot(d).abs() <= 1e-6 * p.length() * d.length()
}
