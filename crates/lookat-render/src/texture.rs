//! The value of a texture at points of surfaces (PBR 10).

mod checkerboard;
mod dots;
pub(crate) mod imagemap;
pub(crate) mod mapping;
mod marble;
mod noise;
mod values;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DMat3, DVec3};
use lookat_scene::{Bilerp, Mapping, Texture, Transform, Varying};

use self::noise::{PointInSpace, Sum};
use self::values::Values;
use crate::number::{Colors, Vec2x8, Vec3x8, splat_f32, to_f32, vectorized};

/// Where a texture is asked.
#[derive(Clone, Copy)]
pub(crate) struct TexturePoint<S: Simd> {
    /// Positions, relative to `origin`.
    pub p: Vec3x8<S>,
    /// World position that positions are relative to.
    pub origin: DVec3,
    /// Coordinates of the surfaces.
    pub uv: Vec2x8<S>,
    /// How positions and coordinates change from one camera ray to its neighbors; 0 where there are none.
    pub footprint: Option<Footprint<S>>,
}

/// How points change with the place on the film: x to the right and y down, by the distance of samples.
#[derive(Clone, Copy)]
pub(crate) struct Footprint<S: Simd> {
    pub dp: [Vec3x8<S>; 2],
    pub duv: [Vec2x8<S>; 2],
}

impl<S: Simd> TexturePoint<S> {
    /// The same one everywhere, without neighbors.
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
                Varying::Dots(dots) => dots::dots(self, dots, active),
                Varying::Fbm(octaves) => T::gray(noise::octaves(self, Sum::Fbm, octaves, active)),
                Varying::Wrinkled(octaves) => T::gray(noise::octaves(self, Sum::Turbulence, octaves, active)),
                Varying::Windy { texture_from_world } => {
                    T::gray(PointInSpace::new(self, texture_from_world).windy(active))
                }
                Varying::Marble(marble) => T::from_rgb(marble::marble(self, marble, active)),
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
        T::or(self.value(a, active & mask), mask, self.value(b, active & !mask))
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
        let [s, t] = mapping::coordinates(&bilerp.mapping, self, active);
        let (s, t) = (s.max(-1e9).min(1e9), t.max(-1e9).min(1e9));
        T::blend(T::blend(low[0], low[1], t), T::blend(high[0], high[1], t), s)
    }

    /// The fractions of s and t as red and green.
    #[inline(always)]
    fn fractions(&self, mapping: &Mapping, active: mask64x8<S>) -> Colors<S> {
        let [s, t] = mapping::coordinates(mapping, self, active);
        Colors { x: to_f32(s - s.floor()), y: to_f32(t - t.floor()), z: splat_f32(active.token(), 0.0) }
    }
}

/// Vectors in another space.
#[inline(always)]
fn within<S: Simd>(space_from_world: &Transform, v: Vec3x8<S>) -> Vec3x8<S> {
    v.by(&DMat3::from_mat4(space_from_world.matrix()))
}

#[cfg(test)]
mod tests {
    use std::array;
    use std::path::Path;
    use std::sync::Arc;

    use glam::{DVec2, Vec3};
    use lookat_image::{MipMap, Wrap};
    use lookat_scene::{
        Cells, Checkerboard, Dots, ImageFilter, ImageMap, LoadOptions, Marble, MaterialKind, Octaves, load,
    };

    use super::*;
    use crate::number::{LANES, V3, bits};
    use crate::testing::{baseline, noise as random};

    /// Its value at a point.
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
                footprint: Some(footprint),
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
}
