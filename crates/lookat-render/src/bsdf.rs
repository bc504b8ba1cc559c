//! How surfaces scatter light.

mod fresnel;
mod lobe;
mod material;
mod microfacet;
#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::Material;
use smallvec::SmallVec;

use crate::texture::TexturePoint;
use crate::warp::Frame;
use lobe::Lobe;

/// The scattering of light at a point of a surface. Directions are in the world and point away from the surface.
#[derive(Debug, Clone)]
pub(crate) struct Bsdf {
    /// The shading frame: z is the shading normal.
    frame: Frame,
    /// The geometric normal: it decides which directions are on the same side.
    n: DVec3,
    lobes: Lobes,
}

/// Most materials have one or two.
type Lobes = SmallVec<[Lobe; 2]>;

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

impl Bsdf {
    /// The scattering at a point of a material: `frame` holds the shading normal, `n` is the geometric normal. `None` for
    /// a material that is not there: light passes.
    pub fn new(material: &Material, at: &TexturePoint, frame: Frame, n: DVec3) -> Option<Self> {
        Some(Bsdf { frame, n, lobes: material::lobes(&material.kind, at)? })
    }

    /// Whether any of its lobes are of a kind.
    pub fn has(&self, part: Part) -> bool {
        self.lobes.iter().any(|lobe| part.holds(lobe))
    }

    fn count(&self, part: Part) -> usize {
        self.lobes.iter().filter(|lobe| part.holds(lobe)).count()
    }

    /// The BSDF times the cosine between `wi` and the shading normal; specular lobes count for nothing.
    pub fn f_cos(&self, wo: DVec3, wi: DVec3) -> Vec3 {
        let (local_o, local_i) = (self.frame.to_local(wo), self.frame.to_local(wi));
        self.f_cos_between(wo, wi, local_o, local_i)
    }

    fn f_cos_between(&self, wo: DVec3, wi: DVec3, local_o: DVec3, local_i: DVec3) -> Vec3 {
        let sides = wi.dot(self.n) * wo.dot(self.n);
        if local_o.z == 0.0 || sides == 0.0 {
            return Vec3::ZERO;
        }
        // The geometric normal tells the sides, so that bent normals let no light through.
        let counts = |lobe: &&Lobe| lobe.transmits() == (sides < 0.0);
        let f: Vec3 = self.lobes.iter().filter(counts).map(|lobe| lobe.f(local_o, local_i)).sum();
        f * local_i.z.abs() as f32
    }

    /// Density by solid angle with which [`Bsdf::sample`] gives `wi`, specular directions aside.
    pub fn pdf(&self, wo: DVec3, wi: DVec3, part: Part) -> f64 {
        self.pdf_between(self.frame.to_local(wo), self.frame.to_local(wi), part)
    }

    fn pdf_between(&self, local_o: DVec3, local_i: DVec3, part: Part) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for lobe in self.lobes.iter().filter(|lobe| part.holds(lobe)) {
            sum += lobe.pdf(local_o, local_i);
            count += 1;
        }
        if count > 1 { sum / f64::from(count) } else { sum }
    }

    /// A direction of one of the lobes, all of them alike likely. `None` where no light is scattered.
    pub fn sample(&self, wo: DVec3, u: DVec2, part: Part) -> Option<BsdfSample> {
        let local = self.frame.to_local(wo);
        let count = self.count(part);
        if local.z == 0.0 || count == 0 {
            return None;
        }
        let scaled = u.x * count as f64;
        let index = (scaled as usize).min(count - 1);
        let u = DVec2::new(scaled - index as f64, u.y);
        let lobe = self.lobes.iter().filter(|lobe| part.holds(lobe)).nth(index)?;
        if lobe.is_specular() {
            return self.single(lobe, local, u.x, count);
        }
        let local_i = lobe.sample(local, u)?;
        let wi = self.frame.to_world(local_i);
        let pdf = self.pdf_between(local, local_i, part);
        let f_cos = self.f_cos_between(wo, wi, local, local_i);
        let compression = lobe.compression(local, local_i);
        let sample = BsdfSample { wi, f_cos, pdf, is_specular: false, compression };
        (pdf > 0.0 && f_cos != Vec3::ZERO).then_some(sample)
    }

    fn single(&self, lobe: &Lobe, local: DVec3, u: f64, count: usize) -> Option<BsdfSample> {
        let single = lobe.single(local, u)?;
        let sample = BsdfSample {
            wi: self.frame.to_world(single.wi).normalize(),
            f_cos: single.factor,
            pdf: single.probability / count as f64,
            is_specular: true,
            compression: single.compression,
        };
        (single.factor != Vec3::ZERO && sample.pdf > 0.0).then_some(sample)
    }
}
