//! The layers that a picture can have beside its colors, and sets of them.

/// A layer of the picture beside its color. It describes the first surface with a material in each pixel. All layers but the
/// depth are 0 without such a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// z in camera space; 1e10 where there is no surface, as in Blender's files. Depth, position, texture coordinates, shape and
    /// material belong to the point behind the middle of the pixel, through the middle of the lens. A mean over an edge would
    /// belong to no surface.
    Depth,
    /// The point in the world.
    Position,
    /// The geometric normal in the world, on the side of the eye. Normals and albedo are means over the camera samples of the pixel,
    /// with its filter: a denoiser needs them.
    Normal,
    /// The shading normal, with bumps, on the same side.
    ShadingNormal,
    /// Texture coordinates, from 0 to 1 on most shapes.
    Uv,
    /// The reflectance and transmittance for light along the normal, at most 1. This color does not depend on light and
    /// view.
    Albedo,
    /// The number of the shape in [`Prepared::shapes`](crate::Prepared::shapes), counted from 1. An instance gives a shape of its object.
    Shape,
    /// The number of the material in [`Prepared::materials`](crate::Prepared::materials), counted from 1.
    Material,
    /// Camera samples of the picture.
    Samples,
}

/// All layers, in the order of their definition: names, and channels of an EXR file. `P`, `N` and `Ns` are pbrt-v4's names, `Z` is
/// OpenEXR's own, and the channels `U`, `V` and `I` are Mitsuba's.
pub(super) const TABLE: [(Layer, &str, &[&str]); 9] = [
    (Layer::Depth, "depth", &["Z"]),
    (Layer::Position, "position", &["P.X", "P.Y", "P.Z"]),
    (Layer::Normal, "normal", &["N.X", "N.Y", "N.Z"]),
    (Layer::ShadingNormal, "shading-normal", &["Ns.X", "Ns.Y", "Ns.Z"]),
    (Layer::Uv, "uv", &["uv.U", "uv.V"]),
    (Layer::Albedo, "albedo", &["albedo.R", "albedo.G", "albedo.B"]),
    (Layer::Shape, "shape", &["shape.I"]),
    (Layer::Material, "material", &["material.I"]),
    // As in the layers of errors.
    (Layer::Samples, "samples", &["count.samples"]),
];

impl Layer {
    /// The layer of a name in [`Layers::names`]; none for a set.
    pub fn named(name: &str) -> Option<Layer> {
        TABLE.iter().find(|(_, known, _)| *known == name).map(|(layer, ..)| *layer)
    }

    /// The channels of an EXR file.
    pub fn channels(self) -> &'static [&'static str] {
        TABLE[self as usize].2
    }

    /// The name of the layer in an EXR file: the name of its only channel, or the part before the dot that its channels share.
    pub fn name_in_file(self) -> &'static str {
        match self.channels() {
            [only] => only,
            several => several[0].split('.').next().unwrap_or_default(),
        }
    }
}

/// A set of layers. The default is empty.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Layers(u16);

impl Layers {
    /// The auxiliary images of Open Image Denoise.
    pub const DENOISE: Layers = Layers(1 << Layer::Albedo as u16 | 1 << Layer::ShadingNormal as u16);
    /// Layers with the values of one point.
    pub(in crate::render) const OF_POINTS: Layers = Layers(
        1 << Layer::Depth as u16
            | 1 << Layer::Position as u16
            | 1 << Layer::Uv as u16
            | 1 << Layer::Shape as u16
            | 1 << Layer::Material as u16,
    );
    /// Layers with means over samples.
    pub(in crate::render) const OF_SAMPLES: Layers = Layers(Layers::DENOISE.0 | 1 << Layer::Normal as u16);

    /// All names, of layers and of the set for denoising.
    pub fn names() -> impl Iterator<Item = &'static str> {
        TABLE.iter().map(|(_, name, _)| *name).chain(["denoise"])
    }

    /// The layer, or the set, of a name.
    pub fn named(name: &str) -> Option<Layers> {
        let number = Layers::names().position(|known| known == name)?;
        Some(if number < TABLE.len() { Layers(1 << number) } else { Layers::DENOISE })
    }

    /// The layers of both sets.
    pub fn union(self, others: Layers) -> Layers {
        Layers(self.0 | others.0)
    }

    /// True if there are no layers.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(super) fn has_any(self, of: Layers) -> bool {
        self.0 & of.0 != 0
    }

    /// For each channel its layer, which coordinate of it, and its name.
    pub(super) fn channels(self) -> impl Iterator<Item = (Layer, usize, &'static str)> {
        let own = TABLE.iter().filter(move |(layer, ..)| self.0 >> *layer as u16 & 1 == 1);
        own.flat_map(|(layer, _, names)| names.iter().enumerate().map(|(axis, name)| (*layer, axis, *name)))
    }

    /// Bytes of a pixel, with the copy that is written.
    pub(in crate::render) fn pixel_bytes(self) -> usize {
        2 * size_of::<f32>() * self.channels().count()
    }
}
