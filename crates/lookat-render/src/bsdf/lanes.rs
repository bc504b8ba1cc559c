//! Scattering side by side: by a diffuse lobe, a glossy one, or both; and one by one by others.

use std::f32::consts::FRAC_1_PI as FRAC_1_PI_F32;
use std::f64::consts::FRAC_1_PI;

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*};
use glam::{DVec2, Vec3};
use lookat_scene::MaterialKind;

use super::choice::ALIKE;
use super::fresnel::Fresnel;
use super::lobe::Lobe;
use super::microfacet::lanes::Facets;
use super::{Bsdf, BsdfSample, Domain, LobeList, Part, lambert, material};
use crate::frame::flipped;
use crate::frame::lanes::Frames;
use crate::lanes::{Colors, LANES, Vec3x8, bits, splat_f32, to_f32};
use crate::texture::TexturePoint;
use crate::warp::lanes::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};

/// The lobes at a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coat {
    /// Black where there is no such lobe.
    diffuse: Vec3,
    /// The terms of Oren and Nayar's model.
    rough: Option<[f64; 2]>,
    glossy: Option<Gloss>,
    /// Diffuse and nothing else, without a list of lobes.
    is_lambert: bool,
}

#[derive(Debug, Clone, Copy)]
struct Gloss {
    reflectance: Vec3,
    alpha: DVec2,
    eta: f64,
}

impl Coat {
    /// Without any lobe.
    pub const NONE: Coat = Coat { diffuse: Vec3::ZERO, rough: None, glossy: None, is_lambert: false };

    /// That of a material at a point; `None` where it has other lobes.
    pub fn at(material: &MaterialKind, at: &TexturePoint) -> Option<Coat> {
        let mut coat = Coat { diffuse: Vec3::ZERO, rough: None, glossy: None, is_lambert: false };
        if let Some(kd) = lambert(material) {
            return Some(Coat { diffuse: at.value(kd).max(Vec3::ZERO), is_lambert: true, ..coat });
        }
        let mut lobes = LobeList::new();
        material::add_lobes(material, at, &mut lobes);
        for (number, likely) in lobes.iter().enumerate() {
            match likely.lobe {
                Lobe::Lambert { reflectance } if number == 0 => coat.diffuse = reflectance,
                Lobe::OrenNayar { reflectance, a, b } if number == 0 => {
                    (coat.diffuse, coat.rough) = (reflectance, Some([a, b]));
                }
                Lobe::Microfacet { reflectance, facets, fresnel: Fresnel::Dielectric { eta } }
                    if coat.glossy.is_none() =>
                {
                    coat.glossy = Some(Gloss { reflectance, alpha: facets.alpha(), eta });
                }
                _ => return None,
            }
        }
        Some(coat)
    }
}

/// The lobes at points side by side.
#[derive(Clone, Copy)]
pub(crate) struct Coats<S: Simd> {
    diffuse: Colors<S>,
    has_diffuse: mask64x8<S>,
    is_rough: mask64x8<S>,
    rough: [f64x8<S>; 2],
    has_gloss: mask64x8<S>,
    gloss: Colors<S>,
    facets: Facets<S>,
    eta: f64x8<S>,
    is_lambert: mask64x8<S>,
}

impl<S: Simd> Coats<S> {
    /// The same one everywhere.
    #[inline(always)]
    pub fn splat(simd: S, coat: &Coat) -> Self {
        let gloss = coat.glossy.unwrap_or(Gloss { reflectance: Vec3::ZERO, alpha: DVec2::ONE, eta: 1.0 });
        let [a, b] = coat.rough.unwrap_or_default();
        Coats {
            diffuse: Colors::splat(simd, coat.diffuse),
            has_diffuse: mask64x8::splat(simd, coat.diffuse != Vec3::ZERO || coat.is_lambert),
            is_rough: mask64x8::splat(simd, coat.rough.is_some()),
            rough: [a.simd_into(simd), b.simd_into(simd)],
            has_gloss: mask64x8::splat(simd, coat.glossy.is_some()),
            gloss: Colors::splat(simd, gloss.reflectance),
            facets: Facets { x: gloss.alpha.x.simd_into(simd), y: gloss.alpha.y.simd_into(simd) },
            eta: gloss.eta.simd_into(simd),
            is_lambert: mask64x8::splat(simd, coat.is_lambert),
        }
    }

    /// These where `mask` says so, and the others elsewhere.
    #[inline(always)]
    pub fn or(self, mask: mask64x8<S>, others: Self) -> Self {
        Coats {
            diffuse: self.diffuse.or(mask, others.diffuse),
            has_diffuse: mask & self.has_diffuse | !mask & others.has_diffuse,
            is_rough: mask & self.is_rough | !mask & others.is_rough,
            rough: [mask.select(self.rough[0], others.rough[0]), mask.select(self.rough[1], others.rough[1])],
            has_gloss: mask & self.has_gloss | !mask & others.has_gloss,
            gloss: self.gloss.or(mask, others.gloss),
            facets: Facets {
                x: mask.select(self.facets.x, others.facets.x),
                y: mask.select(self.facets.y, others.facets.y),
            },
            eta: mask.select(self.eta, others.eta),
            is_lambert: mask & self.is_lambert | !mask & others.is_lambert,
        }
    }
}

/// The scattering at points where there are other lobes than [`Coats`] has.
#[derive(Default)]
pub(crate) struct Others<'l>([Option<Bsdf<'l>>; LANES]);

impl<'l> Others<'l> {
    pub fn put(&mut self, lane: usize, bsdf: Bsdf<'l>) {
        self.0[lane] = Some(bsdf);
    }

    fn each(&self) -> impl Iterator<Item = (usize, &Bsdf<'l>)> {
        self.0.iter().enumerate().filter_map(|(lane, bsdf)| Some((lane, bsdf.as_ref()?)))
    }

    /// Where they have lobes of a part.
    fn has(&self, part: Part) -> u64 {
        self.each().fold(0, |found, (lane, bsdf)| found | u64::from(bsdf.has(part)) << lane)
    }
}

/// The scattering of light at points; as [`super::Bsdf`], to the bit. Where all are `LAMBERT`, nothing else is asked for.
#[derive(Clone, Copy)]
pub(crate) struct Bsdfs<'s, S: Simd, const LAMBERT: bool> {
    frame: &'s Frames<S>,
    /// Geometric normals on the side of the directions towards which light is scattered.
    n: Vec3x8<S>,
    /// These directions, in the shading frames.
    local_o: Vec3x8<S>,
    coats: &'s Coats<S>,
    others: &'s Others<'s>,
    /// The probabilities of the diffuse lobe and of the glossy one; of no use where all are Lambert.
    shares: [f64x8<S>; 2],
}

/// Directions that light may come from; as [`super::BsdfSample`], where there is one.
pub(crate) struct BsdfSamples<S: Simd> {
    pub is_there: mask64x8<S>,
    pub wi: Vec3x8<S>,
    /// Densities by solid angle.
    pub pdf: f64x8<S>,
    /// By what radiance is multiplied.
    pub weight: Colors<S>,
    pub is_specular: mask64x8<S>,
    pub compression: f32x8<S>,
}

impl<'s, S: Simd, const LAMBERT: bool> Bsdfs<'s, S, LAMBERT> {
    /// Those at points with geometric normals `n`, towards `wo`.
    #[inline(always)]
    pub fn new(
        n: Vec3x8<S>,
        frame: &'s Frames<S>,
        wo: Vec3x8<S>,
        coats: &'s Coats<S>,
        others: &'s Others<'s>,
    ) -> Self {
        let local_o = frame.to_local(wo);
        let n = (-n).or(n.dot(wo).simd_lt(0.0), n);
        let shares = if LAMBERT { [local_o.z; 2] } else { shares(coats, local_o.z) };
        Bsdfs { frame, n, local_o, coats, others, shares }
    }

    /// Where there are lobes of a part; as [`Bsdf::has`].
    #[inline(always)]
    pub fn has(&self, part: Part) -> mask64x8<S> {
        let own = match part {
            Part::Specular => bits(self.local_o.z.token(), 0),
            Part::All | Part::Smooth => self.coats.has_diffuse | self.coats.has_gloss,
        };
        if LAMBERT { own } else { own | bits(own.token(), self.others.has(part)) }
    }

    /// What [`super::Bsdf::domain`] is at one of the points.
    pub fn domain(&self, lane: usize) -> Domain {
        if let Some(bsdf) = &self.others.0[lane] {
            return bsdf.domain();
        }
        Domain {
            n: self.n.lane(lane),
            ns: flipped(self.frame.z.lane(lane), self.local_o.z[lane] < 0.0),
            is_two_sided: false,
            is_diffuse: self.coats.is_lambert.to_bitmask() >> lane & 1 == 1,
        }
    }

    /// As [`super::Bsdf::f_cos`] and [`super::Bsdf::pdf`].
    #[inline(always)]
    pub fn f_cos_pdf(&self, wi: Vec3x8<S>, part: Part) -> (Colors<S>, f64x8<S>) {
        let local_i = self.frame.to_local(wi);
        let (mut f_cos, mut pdf) = self.at(wi, local_i);
        if !LAMBERT {
            for (lane, bsdf) in self.others.each() {
                let wi = wi.lane(lane);
                f_cos.put(lane, bsdf.f_cos(wi));
                pdf[lane] = bsdf.pdf(wi, part);
            }
        }
        (f_cos, pdf)
    }

    /// The same of a direction of the world and of the frames.
    #[inline(always)]
    fn at(&self, wi: Vec3x8<S>, local_i: Vec3x8<S>) -> (Colors<S>, f64x8<S>) {
        let simd = wi.x.token();
        let zero: f64x8<S> = 0.0.simd_into(simd);
        let black = Colors::splat(simd, Vec3::ZERO);
        let is_above = self.local_o.z.simd_ne(0.0) & wi.dot(self.n).simd_gt(0.0);
        let same_side = (self.local_o.z * local_i.z).simd_gt(0.0);
        let Coats { diffuse, has_diffuse, is_rough, has_gloss, .. } = *self.coats;
        let mut f = diffuse * splat_f32(simd, FRAC_1_PI_F32);
        let mut pdf = same_side.select(square_to_cosine_hemisphere_pdf(local_i.z.abs()), zero);
        if !LAMBERT {
            pdf = has_diffuse.select(self.shares[0] * pdf, zero);
            if is_rough.any_true() {
                let [a, b] = self.coats.rough;
                let term = oren_nayar(self.local_o, local_i);
                let rough = diffuse * to_f32(FRAC_1_PI * (a + b * term));
                f = rough.or(is_rough, f);
            }
            if has_gloss.any_true() {
                let (value, density) = self.microfacet(local_i);
                // A sum with nothing before, as that of a list is.
                f = (f.or(has_diffuse, black) + self.coats.gloss * value).or(has_gloss, f);
                let density = same_side.select(density, zero);
                pdf = has_gloss.select(pdf + self.shares[1] * density, pdf);
            }
        }
        ((f * to_f32(local_i.z.abs())).or(is_above, black), pdf)
    }

    /// As in [`Lobe::f`], but for the reflectance, and in [`Lobe::pdf`].
    #[inline(always)]
    fn microfacet(&self, wi: Vec3x8<S>) -> (f32x8<S>, f64x8<S>) {
        let (wo, facets) = (self.local_o, self.coats.facets);
        let simd = wi.x.token();
        let (wh, is_there) = half(wo, wi);
        let (density, [lambda_o, lambda_i]) = (facets.density(wh), [facets.lambda(wo), facets.lambda(wi)]);
        let shape = density * (1.0 / (1.0 + lambda_o + lambda_i)) / (4.0 * wi.z * wo.z).abs();
        let upward = (-wh).or(wh.z.simd_lt(0.0), wh);
        let value = to_f32(dielectric(wi.dot(upward), self.coats.eta)) * to_f32(shape);
        let cos = wo.dot(wh).abs();
        let pdf = density * cos / ((1.0 + lambda_o) * wo.z.abs()) / (4.0 * cos);
        let narrow = mask32x8::from_bitmask(simd, is_there.to_bitmask());
        (narrow.select(value, splat_f32(simd, 0.0)), is_there.select(pdf, 0.0.simd_into(simd)))
    }

    /// As [`super::Bsdf::sample`].
    #[inline(never)]
    pub fn sample(&self, [u, v]: [f64x8<S>; 2], part: Part) -> BsdfSamples<S> {
        self.local_o.x.token().vectorize(
            #[inline(always)]
            || {
                let Coats { has_diffuse, has_gloss, .. } = *self.coats;
                if LAMBERT {
                    return self.sample_of([u, v], has_gloss);
                }
                // As `pick` does.
                let is_gloss = has_gloss & (!has_diffuse | (u - self.shares[0]).simd_ge(0.0));
                let share = is_gloss.select(self.shares[1], self.shares[0]);
                let taken = (is_gloss & has_diffuse).select(u - self.shares[0], u);
                let rest = (taken / share).min(1.0 - f64::EPSILON);
                let mut samples = self.sample_of([self.coats.is_lambert.select(u, rest), v], is_gloss);
                for (lane, bsdf) in self.others.each() {
                    samples.put(lane, bsdf.sample(DVec2::new(u[lane], v[lane]), part).as_ref());
                }
                samples
            },
        )
    }

    /// Those of the diffuse lobes, or of the glossy ones.
    #[inline(always)]
    fn sample_of(&self, u: [f64x8<S>; 2], is_gloss: mask64x8<S>) -> BsdfSamples<S> {
        let mut is_there = self.local_o.z.simd_ne(0.0);
        let mut local = square_to_cosine_hemisphere(u);
        local.z = local.z.copysign(self.local_o.z);
        if !LAMBERT && is_gloss.any_true() {
            let wh = self.coats.facets.sample(self.local_o, u);
            let reflected = wh * (2.0 * self.local_o.dot(wh)) - self.local_o;
            local = reflected.or(is_gloss, local);
            is_there &= !is_gloss | (local.z * self.local_o.z).simd_gt(0.0);
        }
        let wi = self.frame.to_world(local);
        let (f_cos, pdf) = self.at(wi, local);
        is_there &= pdf.simd_gt(0.0) & f_cos.is_light();
        let simd = u[0].token();
        let (is_specular, compression) = (bits(simd, 0), splat_f32(simd, 1.0));
        BsdfSamples { is_there, wi, pdf, weight: f_cos / to_f32(pdf), is_specular, compression }
    }
}

impl<S: Simd> BsdfSamples<S> {
    /// Puts what one of them is in its place.
    #[inline(always)]
    fn put(&mut self, lane: usize, sample: Option<&BsdfSample>) {
        let own = bits(self.pdf.token(), 1 << lane);
        self.is_there &= !own;
        let Some(sample) = sample else { return };
        self.is_there |= own;
        self.wi.put(lane, sample.wi);
        self.pdf[lane] = sample.pdf;
        self.weight.put(lane, sample.weight());
        if sample.is_specular {
            self.is_specular |= own;
        }
        self.compression[lane] = sample.compression;
    }
}

/// As [`super::choice::weigh`]: the probabilities of the diffuse lobe and of the glossy one.
#[inline(always)]
fn shares<S: Simd>(coats: &Coats<S>, cos_o: f64x8<S>) -> [f64x8<S>; 2] {
    let Coats { has_diffuse, has_gloss, .. } = *coats;
    let simd = cos_o.token();
    let (zero, one): (f64x8<S>, f64x8<S>) = (0.0.simd_into(simd), 1.0.simd_into(simd));
    let alone = [has_diffuse.select(one, zero), has_gloss.select(one, zero)];
    let both = has_diffuse & has_gloss;
    if !both.any_true() {
        return alone;
    }
    let diffuse = coats.diffuse.amount();
    let gloss = (coats.gloss * to_f32(dielectric(cos_o, coats.eta))).amount();
    let sum = zero + diffuse + gloss;
    let usable = sum.simd_gt(0.0) & sum.is_finite();
    let alike: f64x8<S> = 0.5.simd_into(simd);
    let base = alike * ALIKE;
    let of_diffuse = usable.select(base + diffuse / sum * (1.0 - ALIKE), alike);
    let of_gloss = usable.select(base + gloss / sum * (1.0 - ALIKE), alike);
    [both.select(of_diffuse, alone[0]), both.select(of_gloss, alone[1])]
}

/// As in `lobe.rs`, and where there is one.
#[inline(always)]
fn half<S: Simd>(wo: Vec3x8<S>, wi: Vec3x8<S>) -> (Vec3x8<S>, mask64x8<S>) {
    let (wh, is_there) = (wo + wi).try_normalize();
    (wh, is_there & wo.z.simd_ne(0.0) & wi.z.simd_ne(0.0))
}

/// As [`super::fresnel::dielectric`].
#[inline(always)]
fn dielectric<S: Simd>(cos: f64x8<S>, eta: f64x8<S>) -> f64x8<S> {
    let ratio = cos.simd_gt(0.0).select(eta, 1.0 / eta);
    let cos = cos.abs();
    let squared = 1.0 - (1.0 - cos * cos) / (ratio * ratio);
    let cos_t = squared.sqrt();
    let parallel = (ratio * cos - cos_t) / (ratio * cos + cos_t);
    let perpendicular = (cos - ratio * cos_t) / (cos + ratio * cos_t);
    let one: f64x8<S> = 1.0.simd_into(cos.token());
    let share = (parallel * parallel + perpendicular * perpendicular) / 2.0;
    squared.simd_le(0.0).select(one, share)
}

/// As in `lobe.rs`.
#[inline(always)]
fn oren_nayar<S: Simd>(wo: Vec3x8<S>, wi: Vec3x8<S>) -> f64x8<S> {
    let zero: f64x8<S> = 0.0.simd_into(wo.x.token());
    let sin_i = (wi.x * wi.x + wi.y * wi.y).sqrt();
    let sin_o = (wo.x * wo.x + wo.y * wo.y).sqrt();
    let across = wi.x * wo.x + wi.y * wo.y;
    let product = sin_i * sin_o;
    let cos_phi = product.simd_gt(1e-8).select((across / product).max(0.0), zero);
    let is_steep = wi.z.abs().simd_gt(wo.z.abs());
    let sin_alpha = is_steep.select(sin_o, sin_i);
    let tan_beta = is_steep.select(sin_i / wi.z.abs(), sin_o / wo.z.abs());
    cos_phi * sin_alpha * tan_beta
}
