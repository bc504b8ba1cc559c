//! Words for `Integrator`.

use super::{SAMPLES, Table};

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "Integrator",
    types: &[
        (&["pathtracer", "pathtracing", "simplepath", "gi"], "path", ""),
        (&["direct"], "directlighting", ""),
        (&["ao", "ambient", "occlusion"], "ambientocclusion", ""),
        (&["volpathmis", "volpathsimple", "simplevolpath", "volumetricpath"], "volpath", ""),
        (&["bidirectional", "ptracer"], "bdpt", ""),
        (&["pssmlt", "metropolis"], "mlt", ""),
        (&["photonmap", "photonmapper", "ppm"], "sppm", ""),
    ],
    parameters: &[
        (&[], &["depth", "bounces", "maxbounces", "raydepth", "recursion", "maxraydepth"], "maxdepth", ""),
        (&[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
        (&[], &["rrdepth", "russianroulettedepth"], "", "roulette starts at the fifth surface; \"float rrthreshold\" 0 turns it off"),
        (&[], &["lightsampler"], "lightsamplestrategy", "lightsamplestrategy is \"uniform\", \"power\" or \"spatial\""),
    ],
};
