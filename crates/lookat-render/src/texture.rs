//! Evaluates textures at points of surfaces (PBR 10): values, mappings, and the footprints of camera rays on them (PBR 10.2).

mod checkerboard;
mod ellipse;
mod imagemap;
mod noise;
pub(crate) mod trilinear;

use std::f64::consts::{PI, TAU};
use std::ops::{Add, Mul};

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use glam::{DMat3, DVec3, Vec3};
use lookat_scene::{Bilerp, LUMINANCE, Mapping, Texture, Transform, Value, Varying};

use crate::number::{LANES, Vec2x8, Vec3fx8, Vec3x8, splat_f32, to_f32, to_f64, vectorized};
use crate::warp::{angle, longitude_latitude};
use noise::{OctaveSum, PointInSpace};

/// The points where a texture is evaluated.
#[derive(Clone, Copy)]
pub(crate) struct TexturePoint<'f, S: Simd> {
    /// Positions, relative to `origin`.
    pub p: Vec3x8<S>,
    /// World position that positions are relative to.
    pub origin: DVec3,
    /// Coordinates of the surfaces.
    pub uv: Vec2x8<S>,
    /// The change of positions and coordinates from a camera ray to its neighbors. 0 without neighbors.
    pub footprint: Option<&'f Footprint<S>>,
}

/// The change of points with the film position, x to the right and y down, per distance of samples.
#[derive(Clone, Copy)]
pub(crate) struct Footprint<S: Simd> {
    pub dp: [Vec3x8<S>; 2],
    pub duv: [Vec2x8<S>; 2],
}

impl<S: Simd> TexturePoint<'_, S> {
    /// The same point in all lanes, without a footprint.
    #[inline(always)]
    pub fn splat(simd: S, p: DVec3, uv: [f64; 2]) -> Self {
        let uv = [uv[0].simd_into(simd), uv[1].simd_into(simd)];
        TexturePoint { p: Vec3x8::splat(simd, p), origin: DVec3::ZERO, uv, footprint: None }
    }

    /// The values of a texture at those that are active; anything elsewhere.
    #[inline(always)]
    pub fn value<T: Values<S>>(&self, texture: &Texture<T>, active: mask64x8<S>) -> T::Wide {
        match texture {
            Texture::Constant(value) => T::splat(active.token(), *value),
            Texture::Varying(node) if active.any_true() => self.varying(node.texture(), active),
            // It is not asked.
            Texture::Varying(_) => T::gray(f64x8::splat(active.token(), 0.0)),
        }
    }

    #[inline(never)]
    fn varying<T: Values<S>>(&self, texture: &Varying<T>, active: mask64x8<S>) -> T::Wide {
        vectorized!(active.token(), {
            match texture {
                Varying::Scale([a, b]) => self.value(a, active) * self.value(b, active),
                Varying::Mix { textures: [a, b], amount } => {
                    T::blend(self.value(a, active), self.value(b, active), self.value(amount, active))
                }
                Varying::ImageMap(image) => imagemap::value(image, self, active),
                Varying::Bilerp(bilerp) => self.bilerp(bilerp, active),
                Varying::Uv(mapping) => T::from_rgb(self.fractions(mapping, active)),
                Varying::Checkerboard(board) => checkerboard::checkerboard(self, board, active),
                Varying::Dots(dots) => checkerboard::dots(self, dots, active),
                Varying::Fbm(octaves) => T::gray(noise::octaves(self, OctaveSum::Fbm, octaves, active)),
                Varying::Wrinkled(octaves) => {
                    T::gray(noise::octaves(self, OctaveSum::Turbulence, octaves, active))
                }
                Varying::Windy { texture_from_world } => {
                    T::gray(PointInSpace::new(self, texture_from_world).windy(active))
                }
                Varying::Marble(marble) => T::from_rgb(noise::marble(self, marble, active)),
            }
        })
    }

    /// The values of the first texture where `mask` says so, and of the second elsewhere.
    #[inline(always)]
    fn either<T: Values<S>>(
        &self,
        mask: mask64x8<S>,
        [a, b]: [&Texture<T>; 2],
        active: mask64x8<S>,
    ) -> T::Wide {
        T::keep_where(self.value(a, active & mask), mask, self.value(b, active & !mask))
    }

    /// The points in another space. The origin is taken there apart, so that neighboring points keep their distance.
    #[inline(always)]
    fn within(&self, space_from_world: &Transform) -> Vec3x8<S> {
        let origin = Vec3x8::splat(self.p.x.token(), space_from_world.point(self.origin));
        within(space_from_world, self.p) + origin
    }

    #[inline(always)]
    fn bilerp<T: Values<S>>(&self, bilerp: &Bilerp<T>, active: mask64x8<S>) -> T::Wide {
        let [low, high] = bilerp.corners.map(
            #[inline(always)]
            |[a, b]| [T::splat(active.token(), a), T::splat(active.token(), b)],
        );
        // Far outside of the square, the values stay finite.
        let [s, t] = coordinates(&bilerp.mapping, self, active);
        let (s, t) = (s.max(-1e9).min(1e9), t.max(-1e9).min(1e9));
        T::blend(T::blend(low[0], low[1], t), T::blend(high[0], high[1], t), s)
    }

    /// The fractions of s and t as red and green.
    #[inline(always)]
    fn fractions(&self, mapping: &Mapping, active: mask64x8<S>) -> Vec3fx8<S> {
        let [s, t] = coordinates(mapping, self, active);
        Vec3fx8 { x: to_f32(s - s.floor()), y: to_f32(t - t.floor()), z: splat_f32(active.token(), 0.0) }
    }
}

/// Vectors in another space.
#[inline(always)]
fn within<S: Simd>(space_from_world: &Transform, v: Vec3x8<S>) -> Vec3x8<S> {
    v.by(&DMat3::from_mat4(space_from_world.matrix()))
}

/// Values side by side.
pub(crate) trait Values<S: Simd>: Value {
    type Wide: Copy + Mul<Output = Self::Wide>;
    type Texels: Copy + Add<Output = Self::Texels> + Mul<f32x8<S>, Output = Self::Texels>;

    /// The same value in all lanes.
    fn splat(simd: S, value: Self) -> Self::Wide;

    /// Keeps the lanes of `first` in `mask` and takes the other lanes from `others`.
    fn keep_where(first: Self::Wide, mask: mask64x8<S>, others: Self::Wide) -> Self::Wide;

    /// Gray values.
    fn gray(values: f64x8<S>) -> Self::Wide;

    /// Numbers become luminances.
    fn from_rgb(rgb: Vec3fx8<S>) -> Self::Wide;

    /// `a` for an amount of 0, `b` for 1.
    fn blend(a: Self::Wide, b: Self::Wide, amount: f64x8<S>) -> Self::Wide;

    fn texels(simd: S, texels: &[Self::Texel; LANES]) -> Self::Texels;

    fn from_texels(texels: Self::Texels) -> Self::Wide;
}

impl<S: Simd> Values<S> for f64 {
    type Wide = f64x8<S>;
    type Texels = f32x8<S>;

    #[inline(always)]
    fn splat(simd: S, value: f64) -> f64x8<S> {
        value.simd_into(simd)
    }

    #[inline(always)]
    fn keep_where(first: f64x8<S>, mask: mask64x8<S>, others: f64x8<S>) -> f64x8<S> {
        mask.select(first, others)
    }

    #[inline(always)]
    fn gray(values: f64x8<S>) -> f64x8<S> {
        values
    }

    #[inline(always)]
    fn from_rgb(rgb: Vec3fx8<S>) -> f64x8<S> {
        to_f64(rgb.x) * LUMINANCE.x + to_f64(rgb.y) * LUMINANCE.y + to_f64(rgb.z) * LUMINANCE.z
    }

    #[inline(always)]
    fn blend(a: f64x8<S>, b: f64x8<S>, amount: f64x8<S>) -> f64x8<S> {
        a * (1.0 - amount) + b * amount
    }

    #[inline(always)]
    fn texels(simd: S, texels: &[f32; LANES]) -> f32x8<S> {
        (*texels).simd_into(simd)
    }

    #[inline(always)]
    fn from_texels(texels: f32x8<S>) -> f64x8<S> {
        to_f64(texels)
    }
}

impl<S: Simd> Values<S> for Vec3 {
    type Wide = Vec3fx8<S>;
    type Texels = Vec3fx8<S>;

    #[inline(always)]
    fn splat(simd: S, value: Vec3) -> Vec3fx8<S> {
        Vec3fx8::splat(simd, value)
    }

    #[inline(always)]
    fn keep_where(first: Vec3fx8<S>, mask: mask64x8<S>, others: Vec3fx8<S>) -> Vec3fx8<S> {
        first.keep_where_wide(mask, others)
    }

    #[inline(always)]
    fn gray(values: f64x8<S>) -> Vec3fx8<S> {
        let gray = to_f32(values);
        Vec3fx8 { x: gray, y: gray, z: gray }
    }

    #[inline(always)]
    fn from_rgb(rgb: Vec3fx8<S>) -> Vec3fx8<S> {
        rgb
    }

    #[inline(always)]
    fn blend(a: Vec3fx8<S>, b: Vec3fx8<S>, amount: f64x8<S>) -> Vec3fx8<S> {
        a * to_f32(1.0 - amount) + b * to_f32(amount)
    }

    #[inline(always)]
    fn texels(simd: S, texels: &[Vec3; LANES]) -> Vec3fx8<S> {
        let [r, g, b]: [[f32; LANES]; 3] = [
            std::array::from_fn(|lane| texels[lane].x),
            std::array::from_fn(|lane| texels[lane].y),
            std::array::from_fn(|lane| texels[lane].z),
        ];
        Vec3fx8 { x: r.simd_into(simd), y: g.simd_into(simd), z: b.simd_into(simd) }
    }

    #[inline(always)]
    fn from_texels(texels: Vec3fx8<S>) -> Vec3fx8<S> {
        texels
    }
}

/// The coordinates. They are finite.
#[inline(never)]
fn coordinates<S: Simd>(mapping: &Mapping, at: &TexturePoint<S>, active: mask64x8<S>) -> Vec2x8<S> {
    vectorized!(active.token(), {
        let [u, v] = at.uv;
        finite(match mapping {
            Mapping::Uv { scale, offset } => [u * scale.x + offset.x, v * scale.y + offset.y],
            Mapping::Spherical { texture_from_world } => spherical(at.within(texture_from_world)),
            Mapping::Cylindrical { texture_from_world } => cylindrical(at.within(texture_from_world)),
            // The origin apart, so that neighboring points keep their distance however far away it is.
            Mapping::Planar { axes, offset } => {
                let ([s, t], origin) = (along(axes, at.p), axes.map(|axis| at.origin.dot(axis)));
                [s + (origin[0] + offset.x), t + (origin[1] + offset.y)]
            }
        })
    })
}

/// The change of the coordinates to the neighbors at the right and below, as finite numbers.
///
/// pbrt-v3 takes differences on spheres and cylinders, which are wrong where the texture's edges meet; these are
/// derivatives.
#[inline(never)]
fn changes<S: Simd>(
    mapping: &Mapping,
    at: &TexturePoint<S>,
    footprint: &Footprint<S>,
    active: mask64x8<S>,
) -> [Vec2x8<S>; 2] {
    vectorized!(active.token(), {
        let ([dp0, dp1], [duv0, duv1]) = (footprint.dp, footprint.duv);
        let [x, y] = match mapping {
            Mapping::Uv { scale, .. } => {
                [[duv0[0] * scale.x, duv0[1] * scale.y], [duv1[0] * scale.x, duv1[1] * scale.y]]
            }
            Mapping::Spherical { texture_from_world: to }
            | Mapping::Cylindrical { texture_from_world: to } => {
                let (is_sphere, p) = (matches!(mapping, Mapping::Spherical { .. }), at.within(to));
                [within(to, dp0), within(to, dp1)].map(
                    #[inline(always)]
                    |dp| if is_sphere { spherical_derivative(p, dp) } else { cylindrical_derivative(p, dp) },
                )
            }
            Mapping::Planar { axes, .. } => [along(axes, dp0), along(axes, dp1)],
        };
        [finite(x), finite(y)]
    })
}

#[inline(always)]
fn along<S: Simd>(axes: &[DVec3; 2], v: Vec3x8<S>) -> Vec2x8<S> {
    let simd = v.x.token();
    [v.dot(Vec3x8::splat(simd, axes[0])), v.dot(Vec3x8::splat(simd, axes[1]))]
}

/// Coordinates of the file may overflow under a scale.
#[inline(always)]
fn finite<S: Simd>([s, t]: Vec2x8<S>) -> Vec2x8<S> {
    let (is_finite, zero) = (s.is_finite() & t.is_finite(), f64x8::splat(s.token(), 0.0));
    [is_finite.select(s, zero), is_finite.select(t, zero)]
}

/// Latitude and longitude, each from 0 to 1.
#[inline(always)]
fn spherical<S: Simd>(v: Vec3x8<S>) -> Vec2x8<S> {
    let [longitude, latitude] = longitude_latitude(v);
    [latitude, longitude]
}

#[inline(always)]
fn spherical_derivative<S: Simd>(v: Vec3x8<S>, dv: Vec3x8<S>) -> Vec2x8<S> {
    let radius = (v.x * v.x + v.y * v.y).sqrt();
    let outward = (v.x * dv.x + v.y * dv.y) / radius;
    let dtheta = (v.z * outward - radius * dv.z) / v.length_squared();
    [dtheta / PI, longitude_derivative(v, dv)]
}

/// Longitude from 0 to 1, and the height on the unit sphere, as pbrt-v3 has it.
#[inline(always)]
fn cylindrical<S: Simd>(v: Vec3x8<S>) -> Vec2x8<S> {
    [(PI + angle(v.y, v.x)) * (1.0 / TAU), v.normalize_or(DVec3::ZERO).z]
}

#[inline(always)]
fn cylindrical_derivative<S: Simd>(v: Vec3x8<S>, dv: Vec3x8<S>) -> Vec2x8<S> {
    let length = v.length_squared().sqrt();
    let height = (dv.z - v.z * v.dot(dv) / (length * length)) / length;
    [longitude_derivative(v, dv), height]
}

#[inline(always)]
fn longitude_derivative<S: Simd>(v: Vec3x8<S>, dv: Vec3x8<S>) -> f64x8<S> {
    (v.x * dv.y - v.y * dv.x) / (v.x * v.x + v.y * v.y) / TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::LANES;
    use crate::number::V3;
    use crate::number::bits;
    use crate::testing::baseline;
    use crate::testing::noise as random;
    use glam::DVec2;
    use glam::Vec3;
    use lookat_image::MipMap;
    use lookat_image::Wrap;
    use lookat_scene::Cells;
    use lookat_scene::Checkerboard;
    use lookat_scene::Dots;
    use lookat_scene::ImageFilter;
    use lookat_scene::ImageMap;
    use lookat_scene::LoadOptions;
    use lookat_scene::Marble;
    use lookat_scene::MaterialKind;
    use lookat_scene::Octaves;
    use lookat_scene::Transform;
    use lookat_scene::load;
    use std::array;
    use std::path::Path;
    use std::sync::Arc;

    /// The value of a texture at a point.
    fn value(texture: &Texture<Vec3>, p: DVec3, uv: DVec2) -> Vec3 {
        baseline!(simd => {
            TexturePoint::splat(simd, p, uv.into()).value(texture, bits(simd, 1 << 3)).lane(3)
        })
    }

    /// The Kd of a scene, with the texture "t" of the given type and parameters as Kd.
    fn kd(texture: &str) -> Texture<Vec3> {
        let scene = format!(
            "Film \"image\" Sampler \"sobol\" Camera \"perspective\" Integrator \"path\" WorldBegin
             LightSource \"infinite\" Translate 10 0 0 Scale 2 2 2 Texture \"t\" \"spectrum\" {texture}
             Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\" WorldEnd"
        );
        let loaded = load(Path::new("x.pbrt"), &|_| Ok(scene.clone().into()), &LoadOptions::default());
        let scene = loaded.scene.unwrap_or_else(|| panic!("{:?}", loaded.diagnostics));
        match &scene.world.primitives[0].material.kind() {
            MaterialKind::Matte(matte) => matte.kd.clone(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn corners_of_bilerp_are_where_their_names_say() {
        let texture =
            kd("\"bilerp\" \"rgb v00\" [0 0 0] \"rgb v10\" [1 0 0] \"rgb v01\" [0 1 0] \"rgb v11\" [1 1 1]");
        for (uv, expected) in [([1.0, 0.0], Vec3::X), ([0.0, 1.0], Vec3::Y), ([2.0, 0.0], Vec3::X * 2.0)] {
            assert_eq!(value(&texture, DVec3::ZERO, uv.into()), expected);
        }
    }

    #[test]
    fn positions_in_space_take_the_transformation_and_not_its_inverse() {
        let texture = kd("\"checkerboard\" \"integer dimension\" [3]");
        for (x, even) in [(0.1, true), (0.6, false), (1.1, true), (-0.1, false)] {
            let color = value(&texture, DVec3::new(x, 0.1, 0.1), DVec2::ZERO);
            assert_eq!(color == Vec3::ONE, even, "{x}");
        }
    }

    #[test]
    fn fractions_of_coordinates_are_red_and_green() {
        let texture = kd("\"uv\" \"float uscale\" [3] \"float vdelta\" [-0.75]");
        assert_eq!(value(&texture, DVec3::ZERO, DVec2::new(0.5, 0.25)), Vec3::new(0.5, 0.5, 0.0));
    }

    /// A texture with all kinds of parts.
    fn tree() -> Texture<Vec3> {
        let mapping = Mapping::Uv { scale: DVec2::splat(3.0), offset: DVec2::ZERO };
        let octaves = Octaves { texture_from_world: Transform::IDENTITY, count: 5, roughness: 0.6 };
        let texels = (0..16_i16).map(|i| Vec3::new(f32::from(i), f32::from(i * i % 7), 3.0)).collect();
        let map = Arc::new(MipMap::new(4, 4, texels, Wrap::Repeat));
        let image = |filter| {
            Texture::varying(Varying::ImageMap(Box::new(ImageMap { map: map.clone(), mapping, filter })))
        };
        let board = Texture::varying(Varying::Checkerboard(Checkerboard {
            textures: [
                image(ImageFilter::Trilinear),
                Texture::varying(Varying::Marble(Marble { octaves, scale: 2.0, variation: 0.3 })),
            ],
            cells: Cells::Plane { mapping, filtered: true },
        }));
        let mix = Texture::varying(Varying::Mix {
            textures: [
                image(ImageFilter::Ellipse { max_anisotropy: 8.0 }),
                Texture::varying(Varying::Wrinkled(octaves)),
            ],
            amount: Texture::varying(Varying::Fbm(octaves)),
        });
        Texture::varying(Varying::Dots(Dots { mapping, dots: board, around: mix }))
    }

    /// Nor on whether there is a footprint of 0 or none.
    #[test]
    fn values_do_not_depend_on_the_points_beside() {
        let texture = tree();
        baseline!(simd => for round in 0..50 {
            let number = |k: f64| -> f64x8<_> {
                let numbers: [f64; LANES] = array::from_fn(|lane| random(round * LANES + lane, k));
                numbers.simd_into(simd)
            };
            // Every other point has no neighbors.
            let step = |k: f64| bits(simd, 0x55).select(number(k) * 0.1, f64x8::splat(simd, 0.0));
            let steps = |k: f64| V3 { x: step(k), y: step(k + 0.1), z: step(k + 0.2) };
            let footprint = Footprint {
                dp: [steps(1.1), steps(2.1)],
                duv: [[step(3.1), step(3.2)], [step(3.3), step(3.4)]],
            };
            let at = TexturePoint {
                p: V3 { x: number(4.1), y: number(4.2), z: number(4.3) },
                origin: DVec3::ZERO,
                uv: [number(5.1), number(5.2)],
                footprint: Some(&footprint),
            };
            let together = at.value(&texture, bits(simd, 0xff));
            let still = TexturePoint { footprint: None, ..at }.value(&texture, bits(simd, 0xff));
            for lane in 0..LANES {
                let alone = at.value(&texture, bits(simd, 1 << lane));
                assert_eq!(together.lane(lane), alone.lane(lane), "{round} {lane}");
                if lane % 2 == 1 {
                    assert_eq!(still.lane(lane), alone.lane(lane), "{round} {lane}");
                }
            }
        });
    }

    const NEAR: [DVec3; 2] = [DVec3::new(1e-3, 2e-3, -1e-3), DVec3::new(0.0, -1e-3, 2e-3)];

    /// A point with its neighbors.
    struct Point {
        p: DVec3,
        origin: DVec3,
        uv: DVec2,
        dp: [DVec3; 2],
        duv: [DVec2; 2],
    }

    fn place(mapping: &Mapping, at: &Point) -> (DVec2, [DVec2; 2]) {
        baseline!(simd => {
            let vectors = |v: DVec3| Vec3x8::splat(simd, v);
            let points = |v: DVec2| v.to_array().map(|x| f64x8::splat(simd, x));
            let lane = |v: Vec2x8<_>| DVec2::new(v[0][5], v[1][5]);
            let footprint = Footprint { dp: at.dp.map(vectors), duv: at.duv.map(points) };
            let texture_point =
                TexturePoint { p: vectors(at.p), origin: at.origin, uv: points(at.uv), footprint: None };
            let active = bits(simd, 1 << 5);
            let changes = changes(mapping, &texture_point, &footprint, active).map(lane);
            (lane(coordinates(mapping, &texture_point, active)), changes)
        })
    }

    fn at(p: DVec3) -> Point {
        let duv = [DVec2::new(0.1, 0.2), DVec2::new(0.3, 0.4)];
        Point { p, origin: DVec3::ZERO, uv: DVec2::new(0.25, 0.5), dp: NEAR, duv }
    }

    fn mappings() -> [Mapping; 4] {
        let turned = Transform::rotate(40.0, DVec3::new(1.0, 2.0, 3.0)).unwrap()
            * Transform::translate(DVec3::new(0.3, 0.1, 0.2));
        [
            Mapping::Uv { scale: DVec2::new(2.0, 3.0), offset: DVec2::new(0.5, -0.5) },
            Mapping::Spherical { texture_from_world: turned },
            Mapping::Cylindrical { texture_from_world: turned },
            Mapping::Planar { axes: [DVec3::new(1.0, 2.0, 0.0), DVec3::Z], offset: DVec2::X },
        ]
    }

    #[test]
    fn known_places() {
        let [uv, _, _, planar] = mappings();
        let (st, [right, below]) = place(&uv, &at(DVec3::ZERO));
        assert_eq!(st, DVec2::ONE);
        assert!((right - DVec2::new(0.2, 0.6)).length() + (below - DVec2::new(0.6, 1.2)).length() < 1e-12);
        assert_eq!(place(&planar, &at(DVec3::new(1.0, 2.0, 3.0))).0, DVec2::new(6.0, 3.0));
        let texture_from_world = Transform::IDENTITY;
        let on_sphere = |p| place(&Mapping::Spherical { texture_from_world }, &at(p)).0;
        assert_eq!(on_sphere(DVec3::X), DVec2::new(0.5, 0.0));
        assert_eq!(on_sphere(-DVec3::Y * 7.0), DVec2::new(0.5, 0.75));
        assert_eq!(on_sphere(DVec3::NEG_Z), DVec2::new(1.0, 0.0));
        let on_cylinder =
            place(&Mapping::Cylindrical { texture_from_world }, &at(DVec3::new(0.0, 3.0, 4.0))).0;
        assert_eq!(on_cylinder, DVec2::new(0.75, 0.8));
    }

    /// Derivatives are what differences come to.
    #[test]
    fn derivatives_are_those_of_places() {
        for mapping in &mappings()[1..] {
            let p = DVec3::new(0.4, -0.7, 0.5);
            let (st, steps) = place(mapping, &at(p));
            for (step, dp) in steps.into_iter().zip(NEAR) {
                let beside = place(mapping, &at(p + dp * 1e-4)).0;
                assert!(((beside - st) / 1e-4 - step).length() < 1e-6, "{mapping:?}");
            }
        }
    }

    /// Far from the origin, with an origin of coordinates nearby, places are as near at hand.
    #[test]
    fn the_eye_is_apart() {
        let far = DVec3::new(1e8, -3e8, 2e8);
        for mapping in mappings() {
            let moved = match mapping {
                Mapping::Spherical { texture_from_world } => {
                    Mapping::Spherical { texture_from_world: texture_from_world * Transform::translate(-far) }
                }
                Mapping::Cylindrical { texture_from_world } => Mapping::Cylindrical {
                    texture_from_world: texture_from_world * Transform::translate(-far),
                },
                same => same,
            };
            let near = |p| place(&mapping, &at(p)).0;
            let there = |p| place(&moved, &Point { origin: far, ..at(p) }).0;
            let (a, b) = (DVec3::new(0.4, -0.7, 0.5), DVec3::new(0.4, -0.7, 0.5 + 1e-7));
            assert!(((near(a) - near(b)) - (there(a) - there(b))).length() < 1e-7);
        }
    }

    #[test]
    fn no_point_is_without_coordinates() {
        let texture_from_world = Transform::IDENTITY;
        let uv = Mapping::Uv { scale: DVec2::splat(1e50), offset: DVec2::ZERO };
        let all =
            [uv, Mapping::Spherical { texture_from_world }, Mapping::Cylindrical { texture_from_world }];
        for mapping in all {
            for p in [DVec3::ZERO, DVec3::splat(1e200), DVec3::new(1e-300, 0.0, 0.0)] {
                let uv = DVec2::splat(1e300);
                let dp = [DVec3::ZERO, DVec3::splat(1e300)];
                let (st, changes) =
                    place(&mapping, &Point { p, uv, dp, duv: [uv, -uv], origin: DVec3::ZERO });
                assert!(st.is_finite() && changes.iter().all(|change| change.is_finite()));
            }
        }
    }
}
