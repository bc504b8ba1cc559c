//! The value of a texture at a point of a surface (PBR 10).

mod imagemap;
mod mapping;

use glam::{DVec2, DVec3};
use lookat_scene::{Texture, Value, Varying};

/// Where a texture is asked.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TexturePoint {
    /// Position, relative to `eye`.
    pub p: DVec3,
    /// World position of the eye, which positions are relative to.
    pub eye: DVec3,
    /// Coordinates of the surface.
    pub uv: DVec2,
    /// How position and coordinates change from one camera ray to its neighbours; 0 where there are none.
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
            Texture::Varying(varying) => self.varying(varying),
        }
    }

    fn varying<T: Value>(&self, texture: &Varying<T>) -> T {
        match texture {
            Varying::Scale([a, b]) => self.value(a) * self.value(b),
            Varying::Mix { textures: [a, b], amount } => {
                T::mix(self.value(a), self.value(b), self.value(amount))
            }
            Varying::ImageMap(image) => imagemap::value(image, self),
        }
    }
}
