//! Bodies in which light scatters, and where paths enter them (PBR 15.4).

use fearless_simd::{Simd, f32x8, mask64x8, prelude::*};
use glam::Vec3;

use super::path_record::{PathColumns, PathRecord};
use crate::bsdf::Inside;
use crate::bssrdf::{Body, Channels, Place};
use crate::frame::Frames;
use crate::number::{LANES, Vec3fx8, Vec3x8, set_lanes, vectorized, widen};
use crate::shading::{Materials, Shaded};
use crate::trace::rays::{HitColumns, RayColumns};
use crate::traceable::Traceable;

/// The sample dimensions of a probe.
pub(super) const PROBE_NUMBERS: u32 = 3;

/// The bodies of a world.
pub(in crate::integrator) struct Bodies<'s> {
    /// Of each material.
    of_material: Vec<Option<Body<'s>>>,
}

impl<'s> Bodies<'s> {
    /// `None` for a world without any.
    pub fn new(materials: &Materials<'s>, traceable: &'s Traceable) -> Option<Self> {
        let of_material: Vec<_> =
            materials.all.iter().map(|material| Body::new(material, &traceable.tables)).collect();
        of_material.iter().any(Option::is_some).then_some(Bodies { of_material })
    }

    pub fn of(&self, entry: &Entry) -> Option<&Body<'s>> {
        self.of_material[entry.material as usize].as_ref()
    }

    /// The channels of a body where a path has entered it.
    pub fn channels<'a>(&'a self, entry: &'a Entry) -> Option<&'a Channels> {
        self.of(entry)?.constant.as_ref().or(entry.channels.as_ref())
    }
}

/// Where rays meet bodies. Their shading normals are on the side of the rays, which counts as outside: what a boundary lets through leaves it
/// by subsurface scattering alone.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Entrances<S: Simd> {
    mask: mask64x8<S>,
    colors: [Vec3fx8<S>; 2],
    /// The indices of refraction.
    eta: f32x8<S>,
    /// The shading normals.
    ns: Vec3x8<S>,
    /// Where the geometric normals point inside.
    is_reversed: mask64x8<S>,
    materials: [u32; LANES],
}

impl<S: Simd> Entrances<S> {
    /// Finds the bodies that rays meet, and turns their shading normals to the side of the rays.
    #[inline(never)]
    pub fn new(
        simd: S,
        materials: &Materials,
        paths: &PathRecord<S>,
        shaded: &mut Shaded<S>,
        inside: Option<Inside<S>>,
    ) -> Option<Self> {
        vectorized!(simd, {
            let Inside { mask, colors, eta } = inside?;
            let mask = widen(mask) & paths.active;
            let Shaded { found, frames, .. } = shaded;
            let surfaces = &mut found.surfaces;
            let is_behind = mask & surfaces.ns.dot(paths.rays.d).simd_gt(0.0);
            surfaces.ns = (-surfaces.ns).keep_where(is_behind, surfaces.ns);
            let turned = Frames { x: frames.x, y: -frames.y, z: -frames.z };
            *frames = turned.keep_where(is_behind, *frames);
            let mut numbers = [0; LANES];
            for lane in set_lanes(mask) {
                numbers[lane] = materials.number(found.elements[lane].primitive);
            }
            let is_reversed = surfaces.n.widen().dot(paths.rays.d).simd_gt(0.0);
            Some(Entrances { mask, colors, eta, ns: surfaces.ns, is_reversed, materials: numbers })
        })
    }

    /// Where rays in directions `d` enter bodies.
    #[inline(always)]
    pub fn enters(&self, d: Vec3x8<S>) -> mask64x8<S> {
        self.mask & self.ns.dot(d).simd_lt(0.0)
    }
}

/// Where a path has entered a body.
pub(in crate::integrator) struct Entry {
    pub place: Place,
    /// True if the geometric normal points inside.
    pub is_reversed: bool,
    /// The number of the material.
    pub material: u32,
    pub colors: [Vec3; 2],
    pub eta: f32,
    /// The channels of these colors, if the body has others elsewhere.
    pub channels: Option<Channels>,
    /// A random number that chooses among the points that a probe finds.
    pub rest: f64,
    /// The number of these so far.
    pub found: u32,
}

/// The paths of a batch that have entered bodies, and their probes.
pub(in crate::integrator) struct BodyBatch {
    pub paths: PathColumns,
    pub entries: Vec<Entry>,
    /// What is left of the probes, and the next points on them.
    pub probes: RayColumns,
    pub hits: HitColumns,
    /// The probes to the chosen points, and these.
    pub exit_rays: RayColumns,
    pub exit_hits: HitColumns,
}

impl BodyBatch {
    pub fn new() -> Box<Self> {
        Box::new(BodyBatch {
            paths: PathColumns::new(),
            entries: Vec::new(),
            probes: RayColumns::new(),
            hits: HitColumns::new(),
            exit_rays: RayColumns::new(),
            exit_hits: HitColumns::new(),
        })
    }

    /// Adds paths that enter bodies at the points `p`.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, paths: &PathRecord<S>, entrances: &Entrances<S>, p: Vec3x8<S>) {
        self.paths.push(paths);
        for lane in set_lanes(paths.active) {
            let n = entrances.ns.lane(lane);
            let (x, y) = n.any_orthonormal_pair();
            self.entries.push(Entry {
                place: Place { p: p.lane(lane), axes: [x, y, n] },
                is_reversed: entrances.is_reversed.to_bitmask() >> lane & 1 == 1,
                material: entrances.materials[lane],
                colors: entrances.colors.map(|color| color.lane(lane)),
                eta: entrances.eta[lane],
                channels: None,
                rest: 0.0,
                found: 0,
            });
        }
    }

    /// Removes all paths.
    pub fn clear(&mut self) {
        self.paths.count = 0;
        self.entries.clear();
    }
}
