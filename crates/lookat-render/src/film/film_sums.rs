//! The sums of a whole film as plain data, which add up, and which a rendering goes on from.

#[cfg(test)]
mod tests;

use std::fmt::Debug;
use std::ops::Deref;
use std::sync::{Mutex, PoisonError};

use lookat_image::Image;
use lookat_scene::Filter;
use serde_bytes::ByteBuf;

use super::area::Area;
use super::develop::Developer;
use super::sum::{PixelSums, Scale, Sum};
use super::tile::Tile;
use super::{Film, Keeps, lock};
use crate::filter::PixelFilter;

/// All that the samples of a picture have brought: per pixel the sums of weighted radiance and of weights, in integers, and how many
/// samples there are. So partial sums give the same bits in any order, and the sum of all is the picture of one rendering.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmSums {
    /// The film of the picture.
    pub film: lookat_scene::Film,
    /// The filter of the picture.
    pub filter: Filter,
    /// The light paths whose splats are in the sums.
    pub light_paths: u64,
    pub(super) scale: Scale,
    /// All pixels, as one tile.
    pub(super) all: Tile,
    /// What a policy needs to go on, if the numbers of samples do not tell it. Such sums do not add up with others.
    pub(super) state: Option<PolicyState>,
}

/// What a policy knows about a rendering that has been broken off, in a form of its own.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PolicyState {
    /// What is planned for the round. Empty before the first.
    pub plan: ByteBuf,
    /// What it knows about all tiles, one after the other.
    pub tiles: Vec<u8>,
}

/// What a policy knows while it renders.
pub(crate) trait PolicyStates: Debug + Send + Sync {
    /// The states now. While tiles are rendered, the caller keeps threads from adding samples.
    fn encoded(&self) -> PolicyState;
}

/// Why sums do not add up, or cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FilmSumsError {
    /// The film, the filter or the brightness of the scene differs.
    #[error("the film sums are of different pictures: scene, film and filter must be the same")]
    OtherPicture,
    /// A pixel would have more samples than a film, or this rendering, has room for.
    #[error("a pixel would have more samples than there is room for")]
    TooManySamples,
    /// The sums are of a rendering that is not in parts, and have its state.
    #[error("the state of a rendering does not add up with others: only its parts do")]
    HasState,
    /// The bytes are no film sums, are damaged, or of another version of lookat.
    #[error("these are no film sums, or they are damaged, or of another version of lookat")]
    Unreadable,
}

impl Film<'_> {
    /// Starts with sums, and takes their scale over. `most`: the samples that a pixel may have. Fails if they are of another picture or way to
    /// render, have more samples, or are damaged. Returns what the policy knew.
    pub fn restore(&self, so_far: FilmSums, most: u32) -> Result<Option<PolicyState>, FilmSumsError> {
        let FilmSums { film, filter, scale, all, state, .. } = so_far;
        // What is kept of passes or spreads alone does not tell where they end.
        let has_policy = matches!(self.keeps, Keeps::Passes | Keeps::Spreads);
        let is_own = (&film, filter) == (self.settings, self.view_filter)
            && all.splats.is_empty()
            && self.tiles.iter().all(|tile| lock(tile).is_like(&all))
            && state.is_some() == self.keeps_policy
            && self.keeps_policy == has_policy;
        if !is_own {
            return Err(FilmSumsError::OtherPicture);
        }
        if all.counts.iter().any(|count| *count > most) {
            return Err(FilmSumsError::TooManySamples);
        }
        self.set_scale(scale);
        self.tiles.iter().for_each(|tile| lock(tile).copy_from(&all));
        Ok(state)
    }

    /// The sums so far: each sample is in all of the pixels that it counts for, or in none.
    pub fn sums(&self) -> FilmSums {
        self.gathered(lock)
    }

    /// As [`Film::sums`]. Each tile is given back once it is copied.
    pub fn into_sums(self) -> FilmSums {
        self.gathered(|tile| Box::new(std::mem::take(&mut *lock(tile))))
    }

    /// The sums of all tiles, each as this function gives it.
    fn gathered<'f, T: Deref<Target = Tile>>(&'f self, of_tile: impl Fn(&'f Mutex<Tile>) -> T) -> FilmSums {
        let mut all = Tile::new(self.crop(), self.sources(), self.keeps, self.has_unfiltered());
        // Only now: other threads wait.
        let whole = self.adding.write().unwrap_or_else(PoisonError::into_inner);
        self.tiles.iter().for_each(|tile| all.copy_from(&of_tile(tile)));
        let state = || self.policy_states.get().map(|states| states.encoded()).unwrap_or_default();
        let state = self.keeps_policy.then(state);
        drop(whole);
        let (film, filter) = (self.settings.clone(), self.view_filter);
        let sums =
            FilmSums { film, filter, light_paths: self.light_paths(), scale: self.scale(), all, state };
        if sums.state.is_some() { sums } else { sums.without_state() }
    }
}

/// The pixels in which samples are taken.
pub(super) fn sources(film: &lookat_scene::Film, filter: &Filter) -> Area {
    Area::of(film.crop).grown(filter.reach())
}

impl FilmSums {
    /// Leaves out what only the rendering itself can go on from.
    pub fn without_state(mut self) -> FilmSums {
        self.all.merge_replicate(None, self.scale);
        let all =
            Tile { pass: PixelSums::default(), spreads: Vec::new(), unfiltered: Vec::new(), ..self.all };
        FilmSums { all, state: None, ..self }
    }

    /// Adds the sums of other samples. If it fails, nothing has changed. The caller sees to it that both are of one scene, and have other
    /// samples: other seeds or numbers.
    pub fn add(&mut self, other: &FilmSums) -> Result<(), FilmSumsError> {
        if !self.is_like(other) {
            return Err(FilmSumsError::OtherPicture);
        }
        if self.state.is_some() || other.state.is_some() {
            return Err(FilmSumsError::HasState);
        }
        let count = |(own, more): (&u32, &u32)| own.checked_add(*more);
        let counts: Option<_> = self.all.counts.iter().zip(&other.all.counts).map(count).collect();
        let light_paths = self.light_paths.checked_add(other.light_paths);
        self.all.counts = counts.filter(|_| light_paths.is_some()).ok_or(FilmSumsError::TooManySamples)?;
        self.light_paths = light_paths.unwrap_or_default();
        for (own, more) in self.all.all_sums_mut().zip(other.all.all_sums()) {
            own.resize(own.len().max(more.len()), Sum::default());
            own.iter_mut().zip(more).for_each(|(own, more)| *own += *more);
        }
        Ok(())
    }

    /// True if both are of one picture, as far as sums tell.
    fn is_like(&self, other: &FilmSums) -> bool {
        let of = |sums: &FilmSums| (sums.filter, sums.scale, sums.all.replicates.len());
        self.film == other.film && of(self) == of(other)
    }

    /// The picture: linear RGB, with the crop window as data window. Pixels without samples are black. `with_errors` adds the error layers
    /// if there are replicates.
    pub fn image(&self, with_errors: bool) -> Image {
        let FilmSums { film, light_paths, scale, .. } = self;
        let noise_area = super::noise_area(&self.filter, &PixelFilter::new(&self.filter));
        let developer = Developer { film, noise_area, light_paths: *light_paths, scale: *scale };
        developer.image(std::iter::once(&self.all), with_errors)
    }

    /// The samples of each pixel of the picture, row by row.
    pub fn samples(&self) -> impl Iterator<Item = u32> {
        (0..self.all.bounds.size()).map(|at| self.all.count(at))
    }

    /// The mean number of samples of the pixels of the picture.
    pub fn mean_samples(&self) -> f64 {
        self.samples().map(f64::from).sum::<f64>() / self.film.crop.area() as f64
    }
}
