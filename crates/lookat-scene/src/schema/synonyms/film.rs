//! Words for `Film`.

use super::{SAMPLES, Table};

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "Film",
    types: &[
        (&["rgb", "hdrfilm", "ldrfilm", "exr", "png", "file"], "image", ""),
    ],
    parameters: &[
        (&[], &["width", "xres", "imagewidth", "resolutionx"], "xresolution", ""),
        (&[], &["height", "yres", "imageheight", "resolutiony"], "yresolution", ""),
        (&[], &["resolution", "size", "res"], "", "write \"integer xresolution\" and \"integer yresolution\""),
        (&[], &["output", "file", "outputfile", "image", "name"], "filename", ""),
        (&[], &["crop", "croprect", "cropbounds", "region"], "cropwindow", "cropwindow is xmin xmax ymin ymax, from 0 to 1"),
        (&[], &["exposure", "iso", "gain", "sensor", "imagingratio"], "", "\"float scale\" multiplies the picture: write 2 to the power of the exposure in stops"),
        (&[], &["gamma", "tonemap", "colorspace"], "", "exr and pfm pictures are linear, png and tga pictures sRGB: leave it out"),
        (&[], &["filter", "rfilter"], "", "PixelFilter sets the filter"),
        (&[], &["samples", "spp", "pixelsamples"], "", SAMPLES),
        (&[], &["maxluminance", "clamp", "maxcomponentvalue"], "maxsampleluminance", "maxsampleluminance is the largest luminance of a sample"),
    ],
};
