//! Words for `Sampler`.

use super::Table;

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "Sampler",
    types: &[
        (&["independent", "uniform"], "random", ""),
        (&["ldsampler", "hammersley", "bestcandidate", "adaptive"], "halton", ""),
        (&["zsobol", "paddedsobol", "pmj02bn", "pmj", "bluenoise", "orthogonal"], "sobol", ""),
        (&["multijitter", "jittered", "grid"], "stratified", ""),
    ],
    parameters: &[
        (&["stratified"], &["samples", "spp", "pixelsamples", "samplecount", "samplesperpixel", "count", "nsamples"], "", "\"integer xsamples\" times \"integer ysamples\" is the number of samples of each pixel"),
        (&[], &["samples", "spp", "samplecount", "samplesperpixel", "count", "nsamples", "aasamples"], "pixelsamples", ""),
        (&[], &["seed"], "", "the option --seed of lookat sets the seed"),
    ],
};
