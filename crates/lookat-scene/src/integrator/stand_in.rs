//! `bdpt`, `mlt` and `sppm`: `path` stands in for them. The picture is the same, except for caustics of lights that no ray can
//! hit.

use super::{LIGHT_STRATEGY, MAX_DEPTH, PIXEL_BOUNDS};
use crate::schema::{DefaultValue, Effect, Key, Keys, Kind};

const fn unread<T: DefaultValue>(key: Key<T>) -> Key<T> {
    key.effect(Effect::NotRendered)
}

const LIGHT_PATH: Key<&[&str]> = unread(Key {
    default: &["power", "spatial", "uniform"],
    meaning: "how a path chooses its light",
    ..LIGHT_STRATEGY
});
const STRATEGIES: Key<bool> =
    unread(Key::bool("visualizestrategies", false, "true also writes a picture of each strategy"));
const WEIGHTS: Key<bool> = unread(Key::bool(
    "visualizeweights",
    false,
    "true also writes a picture of the weights of each strategy",
));
const BDPT_KEYS: Keys = &[&MAX_DEPTH, &LIGHT_PATH, &STRATEGIES, &WEIGHTS, &PIXEL_BOUNDS];

const BOOTSTRAP: Key<i32> =
    unread(Key::integer("bootstrapsamples", 100_000, "the paths among which the chains choose their starts"));
const CHAINS: Key<i32> = unread(Key::integer("chains", 1000, "the number of Markov chains"));
const MUTATIONS: Key<i32> =
    unread(Key::integer("mutationsperpixel", 100, "the mutations of paths in each pixel, on average"));
const LARGE_STEP: Key<f64> =
    unread(Key::float("largestepprobability", 0.3, "the probability that a mutation is a new path"));
const SIGMA: Key<f64> = unread(Key::float(
    "sigma",
    0.01,
    "the standard deviation of a small mutation, as a fraction of a dimension",
));
const MLT_KEYS: Keys = &[&MAX_DEPTH, &BOOTSTRAP, &CHAINS, &MUTATIONS, &LARGE_STEP, &SIGMA];

const ITERATIONS: Key<i32> = unread(Key::integer("numiterations", 64, "the number of photon passes"));
const SAME_ITERATIONS: Key<i32> =
    Key { name: "iterations", meaning: "another name of numiterations, which it replaces", ..ITERATIONS }
        .default_words("numiterations");
const PHOTONS: Key<i32> = unread(Key::integer(
    "photonsperiteration",
    -1,
    "the photons of a pass; at most 0 counts as one per pixel",
));
const WRITE_FREQUENCY: Key<i32> =
    unread(Key::integer("imagewritefrequency", i32::MAX, "the passes after which the picture is written"))
        .default_words("only at the end");
const RADIUS: Key<f64> = unread(Key::float("radius", 1.0, "the first radius of the search for photons"));
const SPPM_KEYS: Keys = &[&MAX_DEPTH, &ITERATIONS, &SAME_ITERATIONS, &PHOTONS, &WRITE_FREQUENCY, &RADIUS];

pub(super) const BDPT: Kind =
    Kind::new("Integrator", "bdpt", "bidirectional path tracing", &[BDPT_KEYS]).instead("path");
pub(super) const MLT: Kind =
    Kind::new("Integrator", "mlt", "Metropolis light transport", &[MLT_KEYS]).instead("path");
pub(super) const SPPM: Kind = Kind::new("Integrator", "sppm", "photon mapping", &[SPPM_KEYS]).instead("path");
