//! The value of a texture at a point of a surface (PBR 10).

mod checkerboard;
mod dots;
mod imagemap;
pub(crate) mod mapping;
mod marble;
mod noise;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{Bilerp, Mapping, Texture, Transform, Value, Varying};

use self::noise::PointInSpace;

/// Where a texture is asked.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TexturePoint {
    /// Position, relative to `origin`.
    pub p: DVec3,
    /// World position that positions are relative to.
    pub origin: DVec3,
    /// Coordinates of the surface.
    pub uv: DVec2,
    /// How position and coordinates change from one camera ray to its neighbors; 0 where there are none.
    pub footprint: Footprint,
}

/// How a point changes with the place on the film: x to the right and y down, by the distance of samples.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Footprint {
    pub dp: [DVec3; 2],
    pub duv: [DVec2; 2],
}

impl TexturePoint {
    /// The value of a texture here.
    #[inline]
    pub fn value<T: Value>(&self, texture: &Texture<T>) -> T {
        match texture {
            Texture::Constant(value) => *value,
            Texture::Varying(node) => self.varying(node.texture()),
        }
    }

    fn varying<T: Value>(&self, texture: &Varying<T>) -> T {
        match texture {
            Varying::Scale([a, b]) => self.value(a) * self.value(b),
            Varying::Mix { textures: [a, b], amount } => {
                T::mix(self.value(a), self.value(b), self.value(amount))
            }
            Varying::ImageMap(image) => imagemap::value(image, self),
            Varying::Bilerp(bilerp) => self.bilerp(bilerp),
            Varying::Uv(mapping) => T::from_rgb(self.fractions(mapping)),
            Varying::Checkerboard(board) => checkerboard::checkerboard(self, board),
            Varying::Dots(dots) => dots::dots(self, dots),
            Varying::Fbm(octaves) => T::gray(noise::fbm_octaves(self, octaves)),
            Varying::Wrinkled(octaves) => T::gray(noise::turbulence_octaves(self, octaves)),
            Varying::Windy { texture_from_world } => {
                T::gray(noise::windy(&PointInSpace::new(self, texture_from_world)))
            }
            Varying::Marble(marble) => T::from_rgb(marble::marble(self, marble)),
        }
    }

    /// The point in another space. The origin is taken there apart, so that neighboring points keep their distance.
    fn within(&self, space_from_world: &Transform) -> DVec3 {
        space_from_world.vector(self.p) + space_from_world.point(self.origin)
    }

    fn bilerp<T: Value>(&self, bilerp: &Bilerp<T>) -> T {
        let [low, high] = bilerp.corners;
        // Far outside of the square, the values stay finite.
        let st = mapping::coordinates(&bilerp.mapping, self).clamp(DVec2::splat(-1e9), DVec2::splat(1e9));
        T::mix(T::mix(low[0], low[1], st.y), T::mix(high[0], high[1], st.y), st.x)
    }

    /// The fractions of s and t as red and green.
    fn fractions(&self, mapping: &Mapping) -> Vec3 {
        let st = mapping::coordinates(mapping, self);
        (st - st.floor()).as_vec2().extend(0.0)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use lookat_scene::{LoadOptions, MaterialKind, load};

    use super::*;

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
            let at = TexturePoint { uv: uv.into(), ..TexturePoint::default() };
            assert_eq!(at.value(&texture), expected);
        }
    }

    #[test]
    fn positions_in_space_take_the_transformation_and_not_its_inverse() {
        let texture = kd("\"checkerboard\" \"integer dimension\" [3]");
        for (x, even) in [(0.1, true), (0.6, false), (1.1, true), (-0.1, false)] {
            let at = TexturePoint { p: DVec3::new(x, 0.1, 0.1), ..TexturePoint::default() };
            assert_eq!(at.value(&texture) == Vec3::ONE, even, "{x}");
        }
    }

    #[test]
    fn fractions_of_coordinates_are_red_and_green() {
        let texture = kd("\"uv\" \"float uscale\" [3] \"float vdelta\" [-0.75]");
        let at = TexturePoint { uv: DVec2::new(0.5, 0.25), ..TexturePoint::default() };
        assert_eq!(at.value(&texture), Vec3::new(0.5, 0.5, 0.0));
    }
}
