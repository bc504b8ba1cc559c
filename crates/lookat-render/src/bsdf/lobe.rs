//! The lobes of BSDFs (PBR 8). Directions are in the shading frame, where z is the shading normal, and
//! point away from the surface. Perfectly specular directions are computed in the world in `f64`, so that reflections are exact.

use std::f32::consts::{FRAC_1_PI, PI};

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*};
use glam::{DVec3, Vec3};

use super::fourier::{self, Table};
use super::fresnel::{conductor, dielectric, schlick};
use super::microfacet::{TrowbridgeReitz, half, ratio, reflected, refracted, upward};
use crate::number::{V3, Vec3fx8, Vec3x8, bits, narrow, splat_f32, to_f32, to_f64};
use crate::warp::{square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf};

/// The kind of a lobe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LobeKind<'m> {
    /// PBR 8.3.
    Lambert,
    /// PBR 8.3: to the other side.
    LambertTransmission,
    /// PBR 8.4.1.
    OrenNayar,
    /// Torrance and Sparrow's model (PBR 8.4.4).
    Microfacet(Fresnel),
    /// Torrance and Sparrow's model and Walter et al.'s model of rough refraction in one (PBR 8.4.4), chosen at each facet as Fresnel's
    /// equations say.
    RoughGlass,
    /// Ashikhmin and Shirley's model (PBR 8.5).
    Substrate,
    /// The lobes of Disney's material, except the facets that reflect: see [`disney`](super::disney).
    Disney(DisneyLobe),
    /// A fiber: see [`hair`](super::hair).
    Hair,
    /// A table.
    Fourier(Table<'m>),
    /// Diffuse light from inside of a body, that its boundary lets through (SeparableBSSRDFAdapter).
    Exit,
    /// PBR 8.2.2.
    Mirror(Fresnel),
    /// PBR 8.2.3.
    Refraction,
    /// Reflection and refraction in one, chosen as Fresnel's equations say (PBR 8.2.3, FresnelSpecular).
    Glass,
}

/// A lobe of Disney's material. What solids with a clear part have `outside` only scatters no light from within: pbrt-v3 makes light
/// there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DisneyLobe {
    /// Diffuse reflection, retro-reflection, sheen, and what looks like subsurface scattering: all by cosine. `colors`: the
    /// color and that of the sheen; `roughness`: the roughness and the flatness; `eta`: the share of the diffuse light that
    /// is reflected.
    Diffuse { outside: bool },
    /// The second gloss: Schlick's approximation, and facets with longer tails than Trowbridge and Reitz's (Burley's GTR1).
    /// `roughness`: the width.
    Clearcoat { outside: bool },
    /// Rough refraction.
    Transmission,
    /// Rough transmission that bends no light: it comes from where facets would reflect it on the other side.
    ThinTransmission,
}

impl LobeKind<'_> {
    /// True for delta lobes.
    #[inline]
    pub fn is_delta(self) -> bool {
        matches!(self, LobeKind::Mirror(_) | LobeKind::Refraction | LobeKind::Glass)
    }

    /// True for non-delta lobes that scatter to the other side. Rough glass, hair and tables scatter to both sides.
    #[inline]
    pub fn transmits(self) -> bool {
        use DisneyLobe::{ThinTransmission, Transmission};
        matches!(
            self,
            LobeKind::LambertTransmission
                | LobeKind::RoughGlass
                | LobeKind::Hair
                | LobeKind::Fourier(_)
                | LobeKind::Disney(Transmission | ThinTransmission)
        )
    }
}

/// A way of scattering light: at one point, of a color and a number, or at eight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lobe<'m, C, N> {
    pub kind: LobeKind<'m>,
    /// The factor of the lobe, at least 0: mostly a reflectance or a transmittance.
    pub color: C,
    /// For conductors: index of refraction and absorption coefficient. For substrates: the colors of the base and of the
    /// coat. For glass: reflectance and transmittance. For Disney's material and hair: see there.
    pub colors: [C; 2],
    /// The widths of the distribution of microfacets; of rough matte surfaces the terms A and B of Oren and Nayar's model.
    pub roughness: [N; 2],
    /// The index of refraction behind the surface by that before it. For Disney's material: see [`DisneyLobe`].
    pub eta: N,
}

/// The lobe of one point.
pub(super) type PointLobe<'m> = Lobe<'m, Vec3, f32>;
/// The lobes of eight points.
pub(super) type Lobes<'m, S> = Lobe<'m, Vec3fx8<S>, f32x8<S>>;

impl<'m, S: Simd> Lobes<'m, S> {
    /// Lobes whose only parameter is a color.
    #[inline(always)]
    pub fn new(kind: LobeKind<'m>, color: Vec3fx8<S>) -> Self {
        let simd = color.x.token();
        let (black, one) = (Vec3fx8::splat(simd, Vec3::ZERO), splat_f32(simd, 1.0));
        Lobe { kind, color, colors: [black; 2], roughness: [one; 2], eta: one }
    }

    /// The lobe of the first point.
    pub fn first(&self) -> PointLobe<'m> {
        Lobe {
            kind: self.kind,
            color: self.color.lane(0),
            colors: self.colors.map(|color| color.lane(0)),
            roughness: self.roughness.map(|width| width[0]),
            eta: self.eta[0],
        }
    }

    /// The same lobe in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, lobe: &PointLobe<'m>) -> Self {
        Lobe {
            kind: lobe.kind,
            color: Vec3fx8::splat(simd, lobe.color),
            colors: lobe.colors.map(
                #[inline(always)]
                |color| Vec3fx8::splat(simd, color),
            ),
            roughness: [splat_f32(simd, lobe.roughness[0]), splat_f32(simd, lobe.roughness[1])],
            eta: splat_f32(simd, lobe.eta),
        }
    }

    /// Keeps the lanes in `mask` and takes the other lanes from `others`, which has the same kind.
    #[inline(always)]
    pub fn keep_where(self, mask: mask32x8<S>, others: Self) -> Self {
        let ([a, b], [x, y]) = (self.colors, self.roughness);
        Lobe {
            kind: self.kind,
            color: self.color.keep_where(mask, others.color),
            colors: [a.keep_where(mask, others.colors[0]), b.keep_where(mask, others.colors[1])],
            roughness: [mask.select(x, others.roughness[0]), mask.select(y, others.roughness[1])],
            eta: mask.select(self.eta, others.eta),
        }
    }

    #[inline(always)]
    pub fn facets(&self) -> TrowbridgeReitz<S> {
        let is_separable = matches!(
            self.kind,
            LobeKind::Microfacet(Fresnel::Disney { .. }) | LobeKind::Disney(DisneyLobe::Transmission)
        );
        TrowbridgeReitz { alpha: self.roughness, is_separable }
    }

    /// The reflectance at an angle of cosine `cos`.
    #[inline(always)]
    pub fn fresnel(&self, fresnel: Fresnel, cos: f32x8<S>) -> Vec3fx8<S> {
        match fresnel {
            Fresnel::Perfect => self.color,
            Fresnel::Dielectric => self.color * dielectric(cos, self.eta),
            Fresnel::Conductor => self.color * conductor(cos, self.colors),
            Fresnel::Disney { is_thin } => self.disney_fresnel(if is_thin { cos.abs() } else { cos }),
        }
    }

    /// About what it scatters, in all, of light that comes along `wo`: exact where it does not depend on roughness.
    #[inline(always)]
    pub fn albedo(&self, cos_o: f32x8<S>) -> Vec3fx8<S> {
        match self.kind {
            LobeKind::Lambert | LobeKind::OrenNayar | LobeKind::LambertTransmission | LobeKind::Exit => {
                self.color
            }
            LobeKind::Microfacet(fresnel) | LobeKind::Mirror(fresnel) => self.fresnel(fresnel, cos_o),
            LobeKind::Refraction => self.color - self.color * dielectric(cos_o, self.eta),
            LobeKind::Substrate => {
                let [base, coat] = self.colors;
                self.color * (base - base * coat + schlick(coat, cos_o.abs()))
            }
            LobeKind::Disney(lobe) => self.disney_albedo(lobe, cos_o),
            LobeKind::Hair => self.hair_albedo(),
            LobeKind::Fourier(Table(table)) => self.color * fourier::albedo(table, cos_o),
            LobeKind::Glass | LobeKind::RoughGlass => {
                let [reflectance, transmittance] = self.colors;
                transmittance + (reflectance - transmittance) * dielectric(cos_o, self.eta)
            }
        }
    }

    /// The value of the BSDF, and the density by solid angle of [`Lobes::sample`] where `wi` is on its side; neither of single
    /// directions. `above`: where light is reflected, as geometric normals say; elsewhere it passes. `own`:
    /// the points that have the lobe.
    #[inline(always)]
    pub fn f_pdf(
        &self,
        wo: Vec3fx8<S>,
        wi: Vec3fx8<S>,
        above: mask32x8<S>,
        own: mask32x8<S>,
    ) -> (Vec3fx8<S>, f32x8<S>) {
        let simd = wi.z.token();
        let none = splat_f32(simd, 0.0);
        match self.kind {
            LobeKind::Lambert | LobeKind::LambertTransmission => {
                (self.color * splat_f32(simd, FRAC_1_PI), cosine(wi))
            }
            LobeKind::Exit => {
                let through = 1.0 - dielectric(wi.z.abs(), self.eta);
                (self.color * (FRAC_1_PI * through), cosine(wi))
            }
            LobeKind::OrenNayar => {
                let [a, b] = self.roughness;
                (self.color * (FRAC_1_PI * (a + b * oren_nayar(wo, wi))), cosine(wi))
            }
            LobeKind::Microfacet(fresnel) => {
                let (wh, is_valid) = half(wo, wi);
                let (value, pdf) = self.facets().reflection(wo, wi, wh);
                let value = is_valid.select(value, none);
                (self.fresnel(fresnel, wi.dot(upward(wh))) * value, is_valid.select(pdf, none))
            }
            LobeKind::RoughGlass => {
                let [reflectance, transmittance] = self.colors;
                let (wh, is_valid) = half(wo, wi);
                let wh = upward(wh);
                let (value, pdf) = self.facets().reflection(wo, wi, wh);
                let share = self.reflected_share(dielectric(wo.dot(wh).copysign(wo.z), self.eta));
                let reflected =
                    reflectance * (dielectric(wi.dot(wh), self.eta) * is_valid.select(value, none));
                let reflected_pdf = is_valid.select(pdf * share, none);
                let (value, pdf, cos, is_valid) = self.facets().transmission(self.eta, wo, wi);
                let share = self.reflected_share(dielectric(cos, self.eta));
                let transmitted = transmittance * is_valid.select(value, none);
                let transmitted_pdf = is_valid.select(pdf * (1.0 - share), none);
                let same_side = (wo.z * wi.z).simd_gt(0.0);
                (reflected.keep_where(above, transmitted), same_side.select(reflected_pdf, transmitted_pdf))
            }
            LobeKind::Substrate => {
                let [base, coat] = self.colors;
                let (wh, is_valid) = half(wo, wi);
                let (_, pdf) = self.facets().reflection(wo, wi, wh);
                let base = (base - base * coat) * (28.0 / (23.0 * PI) * flat(wi.z) * flat(wo.z));
                let cos = wi.dot(wh);
                let value = self.facets().density(wh) / (4.0 * cos.abs() * wi.z.abs().max(wo.z.abs()));
                let sum = base + schlick(coat, cos) * value;
                let sum = sum.keep_where(is_valid, Vec3fx8::splat(simd, Vec3::ZERO));
                (self.color * sum, 0.5 * (cosine(wi) + is_valid.select(pdf, none)))
            }
            LobeKind::Disney(lobe) => self.disney_f_pdf(lobe, wo, wi),
            LobeKind::Hair => self.hair_f_pdf(wo, wi),
            LobeKind::Fourier(Table(table)) => {
                let (f, pdf) = fourier::f_pdf(table, wo, wi, own);
                (self.color * f, pdf)
            }
            LobeKind::Mirror(_) | LobeKind::Refraction | LobeKind::Glass => {
                (Vec3fx8::splat(simd, Vec3::ZERO), none)
            }
        }
    }

    /// A direction, and where there is one; none of single directions. `fine`: a number from 0 to 1 that chooses at a facet.
    #[inline(always)]
    pub fn sample(
        &self,
        wo: Vec3fx8<S>,
        [u, v]: [f32x8<S>; 2],
        fine: f32x8<S>,
        own: mask32x8<S>,
    ) -> (Vec3fx8<S>, mask32x8<S>) {
        let all = mask32x8::splat(u.token(), true);
        match self.kind {
            LobeKind::Lambert | LobeKind::OrenNayar | LobeKind::Exit => (cosine_direction(wo.z, [u, v]), all),
            LobeKind::LambertTransmission => (cosine_direction(-wo.z, [u, v]), all),
            LobeKind::Microfacet(_) => self.facets().reflected(wo, [u, v]),
            LobeKind::RoughGlass => {
                let wh = self.facets().visible_normal(wo, [u, v]);
                let share = self.reflected_share(dielectric(wo.dot(wh).copysign(wo.z), self.eta));
                let is_reflected = fine.simd_lt(share);
                let ((above, has_above), (through, has_through)) =
                    (reflected(wo, wh), refracted(self.eta, wo, wh));
                let is_valid = is_reflected & has_above | !is_reflected & has_through;
                (above.keep_where(is_reflected, through), is_valid)
            }
            LobeKind::Substrate => {
                let is_coat = u.simd_ge(0.5);
                let u = [is_coat.select(2.0 * u - 1.0, 2.0 * u), v];
                let (reflected, is_valid) = self.facets().reflected(wo, u);
                (reflected.keep_where(is_coat, cosine_direction(wo.z, u)), is_valid | !is_coat)
            }
            LobeKind::Disney(lobe) => self.disney_sample(lobe, wo, [u, v]),
            LobeKind::Hair => self.hair_sample(wo, [u, v], fine),
            LobeKind::Fourier(Table(table)) => fourier::sample(table, wo, [u, v], own),
            LobeKind::Mirror(_) | LobeKind::Refraction | LobeKind::Glass => (wo, !all),
        }
    }

    /// The share of samples that is reflected by facets which reflect a share `fresnel` of light.
    #[inline(always)]
    fn reflected_share(&self, fresnel: f32x8<S>) -> f32x8<S> {
        let [reflectance, transmittance] = self.colors;
        let (r, t) = (reflectance.amount() * fresnel, transmittance.amount() * (1.0 - fresnel));
        let share = r / (r + t);
        // Textures may give more than can be added up.
        share.is_finite().select(share, splat_f32(fresnel.token(), 0.5))
    }

    /// The factor by which refraction scales radiance from `wi` to `wo` (Mitsuba's eta scale). For smooth glass: the factor
    /// if it refracts.
    #[inline(always)]
    pub fn radiance_scale(&self, cos_o: f32x8<S>, cos_i: f32x8<S>) -> f32x8<S> {
        let one = splat_f32(cos_o.token(), 1.0);
        let ratio = match self.kind {
            LobeKind::RoughGlass => (cos_o * cos_i).simd_lt(0.0).select(ratio(cos_o, self.eta), one),
            LobeKind::Refraction | LobeKind::Glass | LobeKind::Disney(DisneyLobe::Transmission) => {
                ratio(cos_o, self.eta)
            }
            _ => one,
        };
        1.0 / (ratio * ratio)
    }
}

#[inline(always)]
pub(super) fn cosine<S: Simd>(w: Vec3fx8<S>) -> f32x8<S> {
    square_to_cosine_hemisphere_pdf(w.z.abs())
}

#[inline(always)]
pub(super) fn cosine_direction<S: Simd>(side: f32x8<S>, u: [f32x8<S>; 2]) -> Vec3fx8<S> {
    let w = square_to_cosine_hemisphere(u);
    V3 { z: w.z.copysign(side), ..w }
}

/// The term of Oren and Nayar's model that depends on the directions.
#[inline(always)]
fn oren_nayar<S: Simd>(wo: Vec3fx8<S>, wi: Vec3fx8<S>) -> f32x8<S> {
    let sin_i = (wi.x * wi.x + wi.y * wi.y).sqrt();
    let sin_o = (wo.x * wo.x + wo.y * wo.y).sqrt();
    let (across, product) = (wi.x * wo.x + wi.y * wo.y, sin_i * sin_o);
    let none = splat_f32(product.token(), 0.0);
    let cos_phi = product.simd_gt(1e-8).select((across / product).max(0.0), none);
    // The larger angle to the normal is alpha, the smaller one beta.
    let is_steep = wi.z.abs().simd_gt(wo.z.abs());
    let sin_alpha = is_steep.select(sin_o, sin_i);
    let tan_beta = is_steep.select(sin_i / wi.z.abs(), sin_o / wo.z.abs());
    cos_phi * sin_alpha * tan_beta
}

/// The share of the base of a substrate that is visible at an angle.
#[inline(always)]
fn flat<S: Simd>(cos: f32x8<S>) -> f32x8<S> {
    let x = 1.0 - 0.5 * cos.abs();
    1.0 - x * x * x * x * x
}

/// The Fresnel term of a specular or glossy lobe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fresnel {
    /// Everything is reflected.
    Perfect,
    /// A boundary between dielectrics.
    Dielectric,
    /// A conductor in air.
    Conductor,
    /// Disney's: between a dielectric and Schlick's approximation of a metal.
    Disney { is_thin: bool },
}

/// Sampled directions of incident light.
#[derive(Clone, Copy)]
pub(crate) struct BsdfSample<S: Simd> {
    /// The lanes with a valid sample.
    pub is_valid: mask64x8<S>,
    /// In `f64`, as mirrors and glass show what is far away or seen in a narrow view: rounding to `f32` would turn their rays by more than a
    /// pixel. Other lobes have directions of `f32`.
    pub wi: Vec3x8<S>,
    /// The densities of `wi` by solid angle, more than 0. For delta samples: the probabilities of their directions.
    pub pdf: f32x8<S>,
    /// The factor for radiance from `wi`: the BSDF times the cosine over the density. Of [`Lobe::delta_sample`] and
    /// [`Bsdf::delta_samples`](super::Bsdf::delta_samples), not divided by the density.
    pub weight: Vec3fx8<S>,
    /// The lanes with delta samples.
    pub is_delta: mask64x8<S>,
    /// The factor by which refraction scales radiance: the ratio of the squared indices of refraction. 1 for reflection.
    /// Leaving the medium undoes it.
    pub radiance_scale: f32x8<S>,
}

impl<S: Simd> BsdfSample<S> {
    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(self, mask: mask64x8<S>, others: Self) -> Self {
        BsdfSample {
            is_valid: mask & self.is_valid | !mask & others.is_valid,
            wi: self.wi.keep_where(mask, others.wi),
            pdf: narrow(mask).select(self.pdf, others.pdf),
            weight: self.weight.keep_where_wide(mask, others.weight),
            is_delta: mask & self.is_delta | !mask & others.is_delta,
            radiance_scale: narrow(mask).select(self.radiance_scale, others.radiance_scale),
        }
    }
}

impl<S: Simd> Lobes<'_, S> {
    /// One of the directions of a delta lobe at points with shading normals `n`. The weight is not divided by the
    /// probability of the direction.
    #[inline(always)]
    pub fn delta_sample(&self, n: Vec3x8<S>, wo: Vec3x8<S>, u: f64x8<S>) -> BsdfSample<S> {
        let cos = n.dot(wo);
        match self.kind {
            LobeKind::Mirror(fresnel) => mirrored(n, wo, self.fresnel(fresnel, to_f32(cos))),
            LobeKind::Glass => {
                let share = dielectric(to_f32(cos), self.eta);
                let [reflectance, transmittance] = self.colors;
                let reflected = BsdfSample { pdf: share, ..mirrored(n, wo, reflectance * share) };
                let transmitted = self.refracted(n, wo, transmittance * (1.0 - share));
                let refracted = BsdfSample { pdf: 1.0 - share, ..transmitted };
                reflected.keep_where(u.simd_lt(to_f64(share)), refracted)
            }
            _ => self.refracted(n, wo, self.color - self.fresnel(Fresnel::Dielectric, to_f32(cos))),
        }
    }

    /// Light that a smooth boundary refracts.
    #[inline(always)]
    fn refracted(&self, n: Vec3x8<S>, wo: Vec3x8<S>, factor: Vec3fx8<S>) -> BsdfSample<S> {
        let (eta, cos) = (to_f64(self.eta), n.dot(wo));
        let (n, cos) = ((-n).keep_where(cos.simd_lt(0.0), n), (cos, cos.abs()));
        let ratio = cos.0.simd_gt(0.0).select(eta, 1.0 / eta);
        let along = (n * cos.1 - wo) * (1.0 / ratio);
        let squared = 1.0 - along.length_squared();
        let radiance_scale = self.radiance_scale(to_f32(cos.0), to_f32(cos.0));
        BsdfSample {
            is_valid: squared.simd_gt(0.0),
            wi: (along - n * squared.max(0.0).sqrt()).normalize(),
            radiance_scale,
            ..delta(factor * radiance_scale)
        }
    }
}

#[inline(always)]
fn mirrored<S: Simd>(n: Vec3x8<S>, wo: Vec3x8<S>, factor: Vec3fx8<S>) -> BsdfSample<S> {
    BsdfSample { wi: (n * (2.0 * n.dot(wo)) - wo).normalize(), ..delta(factor) }
}

/// A delta sample of probability 1, without a direction.
#[inline(always)]
fn delta<S: Simd>(weight: Vec3fx8<S>) -> BsdfSample<S> {
    let simd = weight.x.token();
    let all = bits(simd, 0xff);
    BsdfSample {
        is_valid: all,
        wi: Vec3x8::splat(simd, DVec3::ZERO),
        pdf: splat_f32(simd, 1.0),
        weight,
        is_delta: all,
        radiance_scale: splat_f32(simd, 1.0),
    }
}
