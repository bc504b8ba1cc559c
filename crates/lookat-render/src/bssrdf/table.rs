//! Tables of what leaves a half space around a beam, over albedos and radii (ComputeBeamDiffusionBSSRDF).

use std::sync::OnceLock;

use lookat_scene::{MaterialKind, Subsurface, World};

use super::diffusion::Beam;
use super::spline::{self, Spline};

const ALBEDOS: usize = 100;
const RADII: usize = 64;

/// The light that leaves in rings around a beam.
pub(crate) struct Table {
    albedos: [f64; ALBEDOS],
    /// In mean free paths.
    radii: [f64; RADII],
    /// The light of a ring over its width, for each albedo and radius.
    profiles: Vec<[f64; RADII]>,
    /// The share of the light that leaves in all, over the albedos.
    effective: Spline,
}

impl Table {
    /// The table of a medium of mean cosine `g` and index of refraction `eta`.
    pub fn new(g: f64, eta: f64) -> Self {
        const DENSITY: f64 = 8.0;
        let spread = |share: f64| 1.0 - libm::exp(-DENSITY * share);
        let albedos = std::array::from_fn(|index| spread(index as f64 / (ALBEDOS - 1) as f64) / spread(1.0));
        let (mut radii, mut next) = ([0.0; RADII], 2.5e-3);
        for radius in &mut radii[1..] {
            (*radius, next) = (next, next * 1.2);
        }
        let beam = Beam::new(g, eta);
        let profile = |albedo: f64| radii.map(|r| 2.0 * std::f64::consts::PI * r * beam.exitance(albedo, r));
        // One by one: whoever waits for threads here may be given work that waits for this table.
        let profiles: Vec<_> = albedos.into_iter().map(profile).collect();
        let effective: Vec<f64> =
            profiles.iter().map(|profile| Spline::new(&radii, profile).integral()).collect();
        let effective = Spline::new(&albedos, &effective);
        Table { albedos, radii, profiles, effective }
    }

    /// The light of rings over their width, by their radius in mean free paths, in a medium of an albedo.
    pub(super) fn profile(&self, albedo: f64) -> Spline {
        let (at, weights) = spline::weights(&self.albedos, albedo);
        let mut profile = [0.0; RADII];
        for (of, weight) in weights.into_iter().enumerate() {
            if let Some(own) = (at + of).checked_sub(1).and_then(|row| self.profiles.get(row)) {
                for (sum, value) in profile.iter_mut().zip(own) {
                    *sum += weight * value;
                }
            }
        }
        Spline::new(&self.radii, &profile)
    }

    /// The albedo of a medium that so much light leaves in all (SubsurfaceFromDiffuse).
    pub fn albedo(&self, effective: f64) -> f64 {
        self.effective.invert(effective)
    }
}

/// The tables of a world, each made when it is first used.
#[derive(Default)]
pub(crate) struct Tables {
    /// By mean cosine and index of refraction.
    all: Vec<([f64; 2], OnceLock<Table>)>,
}

impl Tables {
    /// Takes over another world. Keeps the tables that it uses too.
    pub fn renew(&mut self, world: &World) {
        let mut before = std::mem::take(&mut self.all);
        for of in world.shapes().filter_map(|primitive| primitive.material.inside()) {
            let MaterialKind::Subsurface(of) = of else { continue };
            let key = [of.g, of.eta];
            if self.all.iter().all(|(own, _)| *own != key) {
                let known = before.iter().position(|(own, _)| *own == key);
                self.all.push(known.map_or((key, OnceLock::new()), |known| before.swap_remove(known)));
            }
        }
    }

    /// The table of a material of the world.
    pub fn of(&self, of: &Subsurface) -> &Table {
        let own = self.all.iter().find(|(key, _)| *key == [of.g, of.eta]);
        let (_, table) = own.expect("there is one for each material of the world");
        table.get_or_init(|| Table::new(of.g, of.eta))
    }
}
