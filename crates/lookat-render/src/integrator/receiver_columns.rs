//! Columns of surfaces that have scattered rays: what weighs the emission that these see.

use fearless_simd::{Simd, mask32x8, prelude::*};
use glam::DVec3;

use crate::bsdf::Domain;
use crate::columns::{Column, ROOM, Stored, columns};
use crate::light::{Lunes, Receivers};
use crate::number::{LANES, Vec3x8, bits};
use crate::surface::Surfaces;

columns! {
    /// What [`ReceiverColumns`] store, except lunes.
    struct PlaceColumns of Receivers {
        p_x: f64 = surfaces.p.x,
        p_y: f64 = surfaces.p.y,
        p_z: f64 = surfaces.p.z,
        n_x: f32 = domain.n.x,
        n_y: f32 = domain.n.y,
        n_z: f32 = domain.n.z,
        ns_x: f32 = domain.ns.x,
        ns_y: f32 = domain.ns.y,
        ns_z: f32 = domain.ns.z,
        magnitude: f64 = surfaces.magnitude,
        element: f64 = surfaces.element,
        instance: u32 = surfaces.instance,
        is_two_sided: f32 = domain.is_two_sided,
        is_diffuse: f32 = domain.is_diffuse,
    }
}

/// Surfaces that have scattered rays, as far as the light that these find depends on them.
#[derive(Clone)]
pub(in crate::integrator) struct ReceiverColumns {
    places: PlaceColumns,
    /// 1 for surfaces with a lune.
    has_lune: [f32; ROOM],
}

impl ReceiverColumns {
    pub fn new() -> Self {
        ReceiverColumns { places: PlaceColumns::new(), has_lune: [0.0; ROOM] }
    }

    /// Stores some receivers one after the other, from a place on.
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, at: usize, stored: &Stored<S>, receivers: &Receivers<S>) {
        self.places.store(at, stored, receivers);
        let none = bits(receivers.surfaces.element.token(), 0);
        let has_lune = receivers.lunes.as_ref().map_or(none, |lunes| lunes.is_valid);
        has_lune.store(stored, &mut self.has_lune[at..at + LANES]);
    }

    /// The eight receivers from one on. Their normals are on the side of the ray that was scattered. `has_lunes`: some may have lunes.
    #[inline(always)]
    pub fn eight<S: Simd>(&self, simd: S, from: usize, has_lunes: bool) -> Receivers<S> {
        let (zero, none) = (Vec3x8::splat(simd, DVec3::ZERO), mask32x8::splat(simd, false));
        let (number, instance, n) = (0.0.simd_into(simd), 0.simd_into(simd), zero.narrow());
        // Lights do not move.
        let time = 0.0.simd_into(simd);
        let surfaces = Surfaces { p: zero, n, ns: zero, magnitude: number, element: number, instance, time };
        let domain = Domain { n, ns: n, is_two_sided: none, is_diffuse: none };
        let mut receivers = Receivers { surfaces, domain, lunes: None };
        self.places.load(simd, from, &mut receivers);
        receivers.surfaces.n = receivers.domain.n;
        if has_lunes {
            let has_lune = Column::load(simd, &self.has_lune[from..from + LANES]);
            receivers.lunes = Lunes::new(&receivers.domain, has_lune);
        }
        receivers
    }
}
