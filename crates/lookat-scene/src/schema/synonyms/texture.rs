//! Words for `Texture`.

use super::{PLACE, Table};

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "Texture",
    types: &[
        (&["bitmap", "image", "imagetexture", "picture"], "imagemap", ""),
        (&["checker", "checkers", "chess"], "checkerboard", ""),
        (&["noise", "perlin", "turbulence"], "fbm", ""),
        (&["polkadots"], "dots", ""),
        (&["multiply", "product"], "scale", ""),
        (&["blend", "lerp"], "mix", ""),
        (&["solid", "color", "value"], "constant", ""),
    ],
    parameters: &[
        (&["imagemap"], &["file", "image", "map", "mapname", "bitmap", "path", "texture"], "filename", ""),
        (&["imagemap"], &["encoding", "srgb", "colorspace"], "", "\"bool gamma\" says whether the values are on the sRGB curve"),
        (&["imagemap"], &["filter", "filtertype"], "", "\"bool trilinear\" \"true\" replaces the anisotropic filter"),
        (&["imagemap"], &["wrapmode", "extension", "swrap", "repeat"], "wrap", ""),
        (&["constant"], &["color", "rgb", "tex1"], "value", ""),
        (&["checkerboard", "mix"], &["color0", "a", "even", "color1value"], "tex1", ""),
        (&["checkerboard", "mix"], &["color1"], "tex1", ""),
        (&["checkerboard", "mix"], &["color1", "b", "odd", "color2"], "tex2", ""),
        (&["mix"], &["factor", "fac", "weight", "alpha"], "amount", "amount is the fraction of tex2"),
        (&["scale"], &["tex", "texture"], "tex1", ""),
        (&["scale"], &["scale", "factor"], "tex2", ""),
        (&[], &["uoffset", "offsetu"], "udelta", ""),
        (&[], &["voffset", "offsetv"], "vdelta", ""),
        (&[], &["scale", "uvscale", "tiling"], "", "\"float uscale\" and \"float vscale\" repeat it"),
        (&[], &["toworld", "touv", "transform"], "", PLACE),
    ],
};
