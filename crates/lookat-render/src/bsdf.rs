//! How surfaces scatter light.

mod choice;
mod fresnel;
pub(crate) mod lanes;
mod lobe;
mod material;
mod microfacet;
#[cfg(test)]
mod tests;

use std::f32::consts::FRAC_1_PI;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{Material, MaterialKind, Matte, Texture};
use smallvec::SmallVec;

use crate::frame::{Frame, flipped};
use crate::texture::TexturePoint;
use crate::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};
use choice::LikelyLobe;
use lobe::Lobe;
pub(crate) use material::most_lobes;

/// The scattering of light at a point of a surface towards one direction, `wo`. Directions are in the world and point away
/// from the surface.
#[derive(Debug, Clone)]
pub(crate) struct Bsdf<'l> {
    /// The shading frame: z is the shading normal.
    frame: Frame,
    /// The geometric normal on the side of `wo`: it decides which directions are on the same side.
    n: DVec3,
    /// `wo` in the shading frame.
    local_o: DVec3,
    scattering: Scattering<'l>,
}

/// Most surfaces are diffuse and nothing else: they go without a list.
#[derive(Debug, Clone, Copy)]
enum Scattering<'l> {
    /// One [`Lobe::Lambert`] of this reflectance.
    Lambert(Vec3),
    /// Any lobes, and how many of them are specular.
    Lobes { lobes: &'l [LikelyLobe], specular: usize },
}

/// A place for lobes that serves one surface after the other. Few materials have more than these.
#[derive(Debug, Default)]
pub(crate) struct Lobes(LobeList);

type LobeList = SmallVec<[LikelyLobe; 8]>;

/// Which lobes are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    All,
    /// Those that scatter into all directions.
    Smooth,
    /// Those that scatter into single directions, which lights cannot be sampled for.
    Specular,
}

impl Part {
    fn holds(self, lobe: &Lobe) -> bool {
        match self {
            Part::All => true,
            Part::Smooth => !lobe.is_specular(),
            Part::Specular => lobe.is_specular(),
        }
    }
}

/// Where the light comes from that a surface scatters into all directions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Domain {
    /// The geometric normal on the side of `wo`.
    pub n: DVec3,
    /// The shading normal on the side of `wo`: the BSDF samples directions on the same side of it.
    pub ns: DVec3,
    /// Light comes through from behind, too.
    pub is_two_sided: bool,
    /// All directions count by their cosine: it is evenly diffuse.
    pub is_diffuse: bool,
}

/// A direction that light may come from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BsdfSample {
    pub wi: DVec3,
    /// The BSDF times the cosine to the shading normal.
    pub f_cos: Vec3,
    /// Density of `wi` by solid angle, more than 0. Of a specular sample the probability of its direction.
    pub pdf: f64,
    /// No other direction could have been sampled nearby.
    pub is_specular: bool,
    /// What refraction alone does to radiance, and the way out undoes: the ratio of the squared indices of refraction, or 1.
    pub compression: f32,
}

impl BsdfSample {
    /// By what radiance from `wi` is multiplied.
    pub fn weight(&self) -> Vec3 {
        self.f_cos / self.pdf as f32
    }
}

/// The reflectance of a material that goes without a list of lobes.
#[inline(always)]
pub(crate) fn lambert(material: &MaterialKind) -> Option<&Texture<Vec3>> {
    match material {
        MaterialKind::Matte(Matte { kd, sigma: Texture::Constant(0.0) }) => Some(kd),
        _ => None,
    }
}

impl<'l> Bsdf<'l> {
    /// The scattering at a point of a material towards `wo`: `frame` holds the shading normal, `n` is the geometric normal.
    /// A material that is not there scatters nothing.
    #[inline(always)]
    pub fn new(
        material: &Material,
        at: &TexturePoint,
        (frame, n): (Frame, DVec3),
        wo: DVec3,
        lobes: &'l mut Lobes,
    ) -> Self {
        let local_o = frame.to_local(wo);
        let n = flipped(n, n.dot(wo) < 0.0);
        // Twice, so that it is built where it is to be.
        match lambert(material.kind()) {
            Some(kd) => {
                let scattering = Scattering::Lambert(at.value(kd).max(Vec3::ZERO));
                Bsdf { frame, n, local_o, scattering }
            }
            None => {
                let scattering = Scattering::of(material.kind(), at, local_o, &mut lobes.0);
                Bsdf { frame, n, local_o, scattering }
            }
        }
    }

    /// Whether any of its lobes are of a kind.
    pub fn has(&self, part: Part) -> bool {
        match (self.scattering, part) {
            (Scattering::Lambert(_), part) => part != Part::Specular,
            (Scattering::Lobes { lobes, .. }, Part::All) => !lobes.is_empty(),
            (Scattering::Lobes { lobes, specular }, Part::Smooth) => specular < lobes.len(),
            (Scattering::Lobes { specular, .. }, Part::Specular) => specular > 0,
        }
    }

    /// Where its light comes from, single directions aside.
    pub fn domain(&self) -> Domain {
        let (is_diffuse, is_two_sided) = match self.scattering {
            Scattering::Lambert(_) => (true, false),
            Scattering::Lobes { lobes, .. } => (false, lobes.iter().any(|likely| likely.lobe.transmits())),
        };
        let ns = flipped(self.frame.z, self.local_o.z < 0.0);
        Domain { n: self.n, ns, is_two_sided, is_diffuse }
    }

    /// The BSDF times the cosine between `wi` and the shading normal; specular lobes count for nothing.
    #[inline(always)]
    pub fn f_cos(&self, wi: DVec3) -> Vec3 {
        let Some(through) = self.through(wi) else { return Vec3::ZERO };
        match self.scattering {
            Scattering::Lambert(_) if through => Vec3::ZERO,
            Scattering::Lambert(reflectance) => reflectance * FRAC_1_PI * self.frame.z.dot(wi).abs() as f32,
            Scattering::Lobes { lobes, .. } => self.f_cos_of(lobes, through, self.frame.to_local(wi)),
        }
    }

    /// Whether light from `wi` comes through the surface; `None` where it comes along it.
    #[inline(always)]
    fn through(&self, wi: DVec3) -> Option<bool> {
        let side = wi.dot(self.n);
        (self.local_o.z != 0.0 && side != 0.0).then_some(side < 0.0)
    }

    /// The geometric normal tells the sides, so that bent normals let no light through.
    #[inline(never)]
    fn f_cos_of(&self, lobes: &[LikelyLobe], through: bool, local_i: DVec3) -> Vec3 {
        let mut f = Vec3::ZERO;
        for LikelyLobe { lobe, .. } in lobes.iter().filter(|likely| likely.lobe.transmits() == through) {
            f += lobe.f(self.local_o, local_i);
        }
        f * local_i.z.abs() as f32
    }

    /// Density by solid angle with which [`Bsdf::sample`] gives `wi`, specular directions aside.
    #[inline]
    pub fn pdf(&self, wi: DVec3, part: Part) -> f64 {
        match self.scattering {
            Scattering::Lambert(_) => lambert_pdf(self.local_o.z, self.frame.z.dot(wi)),
            Scattering::Lobes { lobes, .. } => self.pdf_of(lobes, self.frame.to_local(wi), part),
        }
    }

    fn pdf_of(&self, lobes: &[LikelyLobe], local_i: DVec3, part: Part) -> f64 {
        if !self.has(part) {
            return 0.0;
        }
        let density = |likely: &LikelyLobe| likely.probability * likely.lobe.pdf(self.local_o, local_i);
        // Specular lobes add nothing, but are chosen too.
        lobes.iter().map(density).sum::<f64>() / choice::probability(lobes, part)
    }

    /// A direction of one of the lobes, the likelier the more it scatters. `None` where no light is scattered.
    #[inline]
    pub fn sample(&self, u: DVec2, part: Part) -> Option<BsdfSample> {
        if self.local_o.z == 0.0 {
            return None;
        }
        match self.scattering {
            Scattering::Lambert(_) if part == Part::Specular => None,
            Scattering::Lambert(reflectance) => {
                let local = square_to_cosine_hemisphere(u);
                let wi = self.frame.to_world(local.with_z(local.z.copysign(self.local_o.z)));
                let is_above = self.through(wi) == Some(false);
                let f_cos = if is_above { reflectance * FRAC_1_PI * local.z as f32 } else { Vec3::ZERO };
                smooth_sample(wi, f_cos, square_to_cosine_hemisphere_pdf(local.z), 1.0)
            }
            Scattering::Lobes { lobes, .. } => self.sample_of(lobes, u, part),
        }
    }

    fn sample_of(&self, lobes: &[LikelyLobe], u: DVec2, part: Part) -> Option<BsdfSample> {
        let (lobe, probability, rest) = choice::choose(lobes, part, u.x)?;
        if lobe.is_specular() {
            return self.single(lobe, rest, probability);
        }
        let local_i = lobe.sample(self.local_o, DVec2::new(rest, u.y))?;
        let wi = self.frame.to_world(local_i);
        let pdf = self.pdf_of(lobes, local_i, part);
        let f_cos = self.f_cos_of(lobes, self.through(wi)?, local_i);
        smooth_sample(wi, f_cos, pdf, lobe.compression(self.local_o, local_i))
    }

    fn single(&self, lobe: &Lobe, u: f64, probability: f64) -> Option<BsdfSample> {
        let single = lobe.single(self.local_o, u)?;
        let sample = BsdfSample {
            wi: self.frame.to_world(single.wi).normalize(),
            f_cos: single.factor,
            pdf: single.probability * probability,
            is_specular: true,
            compression: single.compression,
        };
        (single.factor != Vec3::ZERO && sample.pdf > 0.0).then_some(sample)
    }
}

impl<'l> Scattering<'l> {
    fn of(material: &MaterialKind, at: &TexturePoint, local_o: DVec3, lobes: &'l mut LobeList) -> Self {
        lobes.clear();
        material::add_lobes(material, at, lobes);
        choice::weigh(lobes, local_o);
        let specular = lobes.iter().filter(|likely| likely.lobe.is_specular()).count();
        Scattering::Lobes { lobes: lobes.as_slice(), specular }
    }
}

/// Density of directions in proportion to the cosine, on the same side.
fn lambert_pdf(cos_o: f64, cos_i: f64) -> f64 {
    if cos_o * cos_i > 0.0 { square_to_cosine_hemisphere_pdf(cos_i.abs()) } else { 0.0 }
}

/// A sample, if light comes that way.
#[inline]
fn smooth_sample(wi: DVec3, f_cos: Vec3, pdf: f64, compression: f32) -> Option<BsdfSample> {
    let sample = BsdfSample { wi, f_cos, pdf, is_specular: false, compression };
    (pdf > 0.0 && f_cos != Vec3::ZERO).then_some(sample)
}
