//! The memory of a rendering.

use lookat_scene::View;

use super::settings::{Settings, Stop};
use super::{adaptive, rounds, target};
use crate::film::{FilmSums, Keeps, pixel_bytes};
use crate::threads::threads;

/// Bytes of a film while it is rendered, about: the sums of each pixel, and the picture that they become; with
/// [`Settings::keep_sums`], also the copy that [`Progress::sums`](super::Progress::sums) gives, and its channels.
pub fn film_bytes(view: &View, settings: &Settings) -> u64 {
    let threads = settings.threads.max(threads());
    let policy = match settings.stop {
        Stop::Samples { .. } | Stop::Time { adaptive: false, .. } => 0,
        Stop::Adaptive | Stop::Time { adaptive: true, .. } => adaptive::pixel_bytes(threads),
        Stop::TargetError { .. } => target::PIXEL_BYTES,
    };
    let keeps = settings.keeps();
    let replicates = match keeps {
        Keeps::Replicates => rounds::replicates_of(settings.stop.sampler(view), settings),
        _ => 0,
    };
    let film = pixel_bytes(keeps, replicates, view.filter.shares_samples());
    // A copy of the film for a checkpoint, and the channels that it becomes.
    let sums = match (settings.keep_sums, keeps) {
        (false, _) => 0,
        (true, Keeps::Sums) => 2 * FilmSums::PIXEL_BYTES,
        // The states of a policy are encoded, and joined with spreads in a vector that grows.
        (true, _) => 2 * film + 4 * policy,
    };
    let pixel = film + policy + settings.layers.pixel_bytes() + sums;
    view.film.crop.area() * pixel as u64
}
