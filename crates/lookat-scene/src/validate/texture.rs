//! Whether textures keep the promises of a scene.

use crate::{Cells, Checkerboard, Dots, ImageFilter, Mapping, Octaves, Texture, Value, Varying};

/// True if all numbers of a texture, and of the textures below it, are in range, and if those are not too many.
pub(super) fn is_texture<T: Value>(texture: &Texture<T>) -> bool {
    let node = match texture {
        Texture::Constant(value) => return value.is_finite(),
        // Not even visited: it can be deeper than the stack.
        Texture::Varying(_) if texture.is_too_long() => return false,
        Texture::Varying(node) => node,
    };
    let (parts, weight) = node.texture().parts();
    is_varying(node.texture()) && parts.into_iter().all(is_texture) && weight.is_none_or(is_texture)
}

/// True if the numbers of a texture itself are in range.
fn is_varying<T: Value>(varying: &Varying<T>) -> bool {
    match varying {
        Varying::Scale(_) | Varying::Mix { .. } => true,
        Varying::ImageMap(image) => {
            let is_filter = match image.filter {
                ImageFilter::Trilinear => true,
                ImageFilter::Ellipse { max_anisotropy } => {
                    ImageFilter::ANISOTROPY_RANGE.contains(max_anisotropy)
                }
            };
            is_filter && is_mapping(&image.mapping) && T::from_texel(image.map.mean()).is_finite()
        }
        Varying::Bilerp(bilerp) => {
            is_mapping(&bilerp.mapping)
                && bilerp.corners.as_flattened().iter().all(|corner| corner.is_finite())
        }
        Varying::Uv(mapping) | Varying::Dots(Dots { mapping, .. }) => is_mapping(mapping),
        Varying::Checkerboard(Checkerboard { cells: Cells::Plane { mapping, .. }, .. }) => {
            is_mapping(mapping)
        }
        Varying::Checkerboard(Checkerboard { cells: Cells::Space { texture_from_world }, .. })
        | Varying::Windy { texture_from_world } => texture_from_world.in_range(),
        Varying::Fbm(octaves) | Varying::Wrinkled(octaves) => is_octaves(octaves),
        Varying::Marble(marble) => {
            is_octaves(&marble.octaves) && marble.scale.is_finite() && marble.variation.is_finite()
        }
    }
}

fn is_octaves(octaves: &Octaves) -> bool {
    let Octaves { texture_from_world, count, roughness } = octaves;
    texture_from_world.in_range() && *count <= Octaves::MOST && Octaves::ROUGHNESS_RANGE.contains(*roughness)
}

fn is_mapping(mapping: &Mapping) -> bool {
    match mapping {
        Mapping::Uv { scale, offset } => scale.is_finite() && offset.is_finite(),
        Mapping::Spherical { texture_from_world } | Mapping::Cylindrical { texture_from_world } => {
            texture_from_world.in_range()
        }
        Mapping::Planar { axes, offset } => axes.iter().all(|axis| axis.is_finite()) && offset.is_finite(),
    }
}
