//! The sums of a whole film as plain data, which programs add, write and read.

use std::sync::PoisonError;

use lookat_image::{Image, IntegerChannel, PixelError};
use lookat_scene::Filter;
use serde::{Deserialize, Serialize};

use super::area::Area;
use super::spread::Spreads;
use super::sum::{PixelSums, Scale, Sum};
use super::tile::Tile;
use super::{Film, Keeps, REPLICATES, develop, lock, noise_area, value};
use crate::filter::PixelFilter;

/// All that the samples of a picture have brought: per pixel the sums of weighted radiance and of weights, in integers, and how many
/// samples there are. So partial sums give the same bits in any order, and the sum of all is the picture of one rendering.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmSums {
    /// The film of the picture.
    pub film: lookat_scene::Film,
    /// The filter of the picture.
    pub filter: Filter,
    /// The samples taken in each pixel of the crop window and as far beyond it as the filter reaches, row by row.
    pub counts: Vec<u32>,
    /// The light paths whose splats are in the sums.
    pub light_paths: u64,
    scale: Scale,
    /// The sums of samples: one for each pixel of the crop window, row by row.
    sums: Vec<Sum>,
    /// The sums of splats in the same order. Empty without splats.
    splats: Vec<Sum>,
    /// The sums of the samples of each replicate, if the picture has error layers: empty for replicates without samples.
    replicates: Vec<PixelSums>,
    /// What a policy needs to go on, if the numbers of samples do not tell it. Such sums do not add up with others.
    state: Option<PolicyState>,
}

/// The state of a rendering that has been broken off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PolicyState {
    /// See [`Film::plan`].
    plan: Vec<u8>,
    tiles: Vec<Tile>,
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
    /// render, have more samples, or are damaged.
    pub fn restore(&self, so_far: FilmSums, most: u32) -> Result<(), FilmSumsError> {
        // What is kept of passes or spreads alone does not tell where they end.
        let has_policy = matches!(self.keeps, Keeps::Passes | Keeps::Spreads);
        let is_own = (&so_far.film, so_far.filter) == (self.settings, self.view_filter)
            && so_far.splats.is_empty()
            && so_far.replicates.is_empty() == (self.keeps != Keeps::Replicates)
            && so_far.state.is_some() == self.plan.is_some()
            && self.plan.is_some() == has_policy;
        if !is_own {
            return Err(FilmSumsError::OtherPicture);
        }
        if so_far.counts.iter().any(|count| *count > most) {
            return Err(FilmSumsError::TooManySamples);
        }
        self.set_scale(so_far.scale);
        if let (Some(PolicyState { plan, tiles }), Some(own_plan)) = (so_far.state, &self.plan) {
            let continues = |(tile, own): (&Tile, _)| tile.continues(&lock(own));
            if tiles.len() != self.tiles.len() || !tiles.iter().zip(&self.tiles).all(continues) {
                return Err(FilmSumsError::Unreadable);
            }
            *lock(own_plan) = plan;
            self.tiles.iter().zip(tiles).for_each(|(own, tile)| *lock(own) = tile);
            return Ok(());
        }
        let (crop, sources) = (self.crop(), self.sources());
        for tile in &self.tiles {
            let Tile { bounds, sources: own_sources, counts, sums, replicates, .. } = &mut *lock(tile);
            let take = |from: &[Sum]| -> Vec<Sum> {
                if from.is_empty() {
                    Vec::new()
                } else {
                    bounds.pixels().map(|pixel| from[crop.index(pixel)]).collect()
                }
            };
            *counts = own_sources.pixels().map(|pixel| so_far.counts[sources.index(pixel)]).collect();
            if replicates.is_empty() {
                *sums = take(&so_far.sums);
            }
            for (own, PixelSums { filtered, unfiltered }) in replicates.iter_mut().zip(&so_far.replicates) {
                *own = PixelSums { filtered: take(filtered), unfiltered: take(unfiltered) };
            }
        }
        Ok(())
    }

    /// The sums so far: each sample is in all of the pixels that it counts for, or in none.
    pub fn sums(&self) -> FilmSums {
        let (crop, sources) = (self.crop(), self.sources());
        let replicates = if self.keeps == Keeps::Replicates { REPLICATES as usize } else { 0 };
        let mut all = FilmSums {
            film: self.settings.clone(),
            filter: self.view_filter,
            counts: vec![0; sources.size()],
            light_paths: self.light_paths(),
            scale: self.scale(),
            sums: vec![Sum::default(); crop.size()],
            splats: Vec::new(),
            replicates: vec![PixelSums::default(); replicates],
            state: None,
        };
        // Only now: other threads wait.
        let _whole = self.adding.write().unwrap_or_else(PoisonError::into_inner);
        for tile in &self.tiles {
            let tile = lock(tile);
            let put = |into: &mut Vec<Sum>, own: &[Sum]| {
                if !own.is_empty() {
                    into.resize(crop.size(), Sum::default());
                }
                own.iter().zip(tile.bounds.pixels()).for_each(|(sum, pixel)| into[crop.index(pixel)] = *sum);
            };
            for (pixel, count) in tile.sources.pixels().zip(&tile.counts) {
                all.counts[sources.index(pixel)] = *count;
            }
            for (own, pixel) in tile.bounds.pixels().enumerate() {
                all.sums[crop.index(pixel)] = tile.so_far(own);
            }
            put(&mut all.splats, &tile.splats);
            for (into, own) in all.replicates.iter_mut().zip(&tile.replicates) {
                into.kinds_mut().into_iter().zip(own.kinds()).for_each(|(into, own)| put(into, own));
            }
        }
        if let Some(plan) = &self.plan {
            let tiles = self.tiles.iter().map(|tile| lock(tile).clone()).collect();
            all.state = Some(PolicyState { plan: lock(plan).clone(), tiles });
        }
        all
    }
}

/// Changes whenever the bytes of a header do.
const FORMAT: u32 = 3;

/// The pixels in which samples are taken: see [`FilmSums::counts`].
fn sources(film: &lookat_scene::Film, filter: &Filter) -> Area {
    Area::of(film.crop).grown(filter.reach())
}

/// What [`FilmSums`] are made of beside their integers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SumsHeader {
    /// See [`FilmSums::film`].
    pub film: lookat_scene::Film,
    /// See [`FilmSums::filter`].
    pub filter: Filter,
    /// See [`FilmSums::light_paths`].
    pub light_paths: u64,
    scale: Scale,
    /// [`FilmSums::counts`], as runs of equal ones: how many, and the samples of each. Empty if a state has them.
    runs: Vec<(u32, u32)>,
    /// Channels of the sums.
    channels: u64,
    /// The number of replicates: 0 or [`REPLICATES`].
    replicates: u32,
    /// Bytes of the state in memory, about; 0 without one.
    state: u64,
}

impl SumsHeader {
    /// The number of samples, if all pixels have as many. `None` with a state.
    pub fn samples(&self) -> Option<u32> {
        let samples = self.runs.first()?.1;
        self.runs.iter().all(|run| run.1 == samples).then_some(samples)
    }

    /// The most samples of a pixel. 0 with a state.
    pub fn most_samples(&self) -> u32 {
        self.runs.iter().map(|run| run.1).max().unwrap_or(0)
    }

    /// As bytes, without loss.
    pub fn to_bytes(&self) -> Vec<u8> {
        postcard::to_allocvec(&(FORMAT, self)).expect("plain data in memory can be written")
    }

    /// What [`SumsHeader::to_bytes`] has written.
    pub fn from_bytes(bytes: &[u8]) -> Result<SumsHeader, FilmSumsError> {
        let read: Result<(u32, SumsHeader), _> = postcard::from_bytes(bytes);
        let read = read.ok().filter(|(format, header)| *format == FORMAT && header.is_sound());
        read.map(|(_, header)| header).ok_or(FilmSumsError::Unreadable)
    }

    /// True if it can be the header of a film. Checked before memory is taken.
    fn is_sound(&self) -> bool {
        self.film.is_valid()
            && self.filter.is_valid()
            && self.scale.is_valid()
            && [0, REPLICATES].contains(&self.replicates)
            && self.runs.iter().map(|(length, _)| u64::from(*length)).sum::<u64>()
                == if self.state == 0 { sources(&self.film, &self.filter).size() as u64 } else { 0 }
    }

    /// Bytes of the sums that it belongs to, about.
    pub fn bytes(&self) -> u64 {
        let counts = sources(&self.film, &self.filter).size() * size_of::<u32>();
        let words = self.channels.saturating_mul(size_of::<u32>() as u64);
        let pixel = words.saturating_add(size_of::<Sum>() as u64);
        let kept = self.film.crop.area().saturating_mul(pixel).saturating_add(counts as u64);
        // The bytes of a state, and what they become.
        kept.saturating_add(self.state.saturating_mul(2))
    }
}

/// What the names of all channels begin with.
const PREFIX: &str = "sums";

/// The name of a channel with the words of 32 bits of a color, or of the weight.
fn name(kind: &str, color: usize, word: usize) -> String {
    format!("{PREFIX}{kind}.{}.{word}", ["R", "G", "B", "weight"][color])
}

/// The kinds of sums of a replicate.
fn kinds_of(replicate: usize) -> [String; 2] {
    ["replicate", "unfiltered"].map(|kind| format!(".{kind}{replicate}"))
}

/// The name of a channel with the bytes of a state.
fn state_name(number: usize) -> String {
    format!("{PREFIX}.state{number}")
}

/// The colors, or the weight, and the words of 32 bits of their sums.
fn words() -> impl Iterator<Item = (usize, usize)> {
    (0..4).flat_map(|color| (0..Sum::WORDS).map(move |word| (color, word)))
}

impl FilmSums {
    /// Bytes of a pixel.
    pub(crate) const PIXEL_BYTES: usize = size_of::<Sum>() + size_of::<u32>();

    /// Leaves out what only the rendering itself can go on from.
    pub fn without_state(self) -> FilmSums {
        FilmSums { state: None, ..self }
    }

    /// True for the names of channels that [`FilmSums::to_channels`] writes.
    pub fn is_channel(name: &str) -> bool {
        name.split('.').next() == Some(PREFIX)
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
        let counts: Option<_> = self.counts.iter().zip(&other.counts).map(count).collect();
        let light_paths = self.light_paths.checked_add(other.light_paths);
        self.counts = counts.filter(|_| light_paths.is_some()).ok_or(FilmSumsError::TooManySamples)?;
        self.light_paths = light_paths.unwrap_or_default();
        self.splats.resize(self.splats.len().max(other.splats.len()), Sum::default());
        for (own, more) in [(&mut self.sums, &other.sums), (&mut self.splats, &other.splats)] {
            for (own, more) in own.iter_mut().zip(more) {
                *own += *more;
            }
        }
        self.replicates.iter_mut().zip(&other.replicates).for_each(|(own, more)| own.add(more));
        Ok(())
    }

    /// True if both are of one picture, as far as sums tell.
    fn is_like(&self, other: &FilmSums) -> bool {
        let of = |sums: &FilmSums| (sums.filter, sums.scale, sums.replicates.len());
        self.film == other.film && of(self) == of(other)
    }

    /// The picture: linear RGB, with the crop window as data window, and with error layers if there are replicates. Pixels without
    /// samples are black.
    pub fn image(&self) -> Image {
        let value = |(at, sum): (usize, &Sum)| value(sum, self.splats.get(at), self.light_paths, self.scale);
        let mut image = develop(&self.film, self.sums.iter().enumerate().map(value).enumerate());
        let noise_area = noise_area(&self.filter, &PixelFilter::new(&self.filter));
        let crop = Area::of(self.film.crop);
        let mut errors = Vec::new();
        if !self.replicates.is_empty() {
            let spreads = |(at, samples)| Spreads::of(&self.replicates, at, samples, self.scale);
            let all = self.samples().enumerate().map(spreads);
            errors.extend(all.map(|spreads| spreads.error(&self.film, noise_area)));
        }
        for tile in self.state.iter().flat_map(|state| &state.tiles) {
            for (own, pixel) in tile.bounds.pixels().enumerate() {
                if let Some(spreads) = tile.spreads(own, self.scale) {
                    errors.resize(crop.size(), PixelError::default());
                    errors[crop.index(pixel)] = spreads.error(&self.film, noise_area);
                }
            }
        }
        if !errors.is_empty() {
            image.add_errors(&errors);
        }
        image
    }

    /// The samples of each pixel of the picture, row by row.
    pub fn samples(&self) -> impl Iterator<Item = u32> {
        let sources = sources(&self.film, &self.filter);
        Area::of(self.film.crop).pixels().map(move |pixel| self.counts[sources.index(pixel)])
    }

    /// The mean number of samples of the pixels of the picture.
    pub fn mean_samples(&self) -> f64 {
        self.samples().map(f64::from).sum::<f64>() / self.film.crop.area() as f64
    }

    /// The sums as channels of integers, without loss, and what else they need.
    pub fn to_channels(&self) -> (SumsHeader, Vec<IntegerChannel>) {
        // A state has the sums and the numbers of samples of its tiles, and replicates have the sums of all.
        let (none, has_state) = (Vec::new(), self.state.is_some());
        let runs = self.counts.chunk_by(|a, b| a == b).map(|run| (run.len() as u32, run[0]));
        let runs = runs.filter(|_| !has_state).collect();
        let is_double = has_state || !self.replicates.is_empty();
        let own =
            [(String::new(), if is_double { &none } else { &self.sums }), (".splats".into(), &self.splats)];
        let replicates = self.replicates.iter().enumerate();
        let replicates = replicates.flat_map(|(at, sums)| kinds_of(at).into_iter().zip(sums.kinds()));
        let mut channels = Vec::new();
        for (kind, sums) in own.into_iter().chain(replicates).filter(|(_, sums)| !sums.is_empty()) {
            channels.extend(words().map(|(color, word)| IntegerChannel {
                name: name(&kind, color, word),
                samples: sums.iter().map(|sum| sum.word(color, word)).collect(),
            }));
        }
        channels.extend(self.state.iter().flat_map(|state| state.to_channels(self.sums.len())));
        let header = SumsHeader {
            film: self.film.clone(),
            filter: self.filter,
            light_paths: self.light_paths,
            scale: self.scale,
            runs,
            channels: channels.len() as u64,
            replicates: self.replicates.len() as u32,
            state: self.state.iter().map(PolicyState::bytes).sum(),
        };
        (header, channels)
    }

    /// The sums that [`FilmSums::to_channels`] has written.
    pub fn from_channels(header: SumsHeader, channels: &[IntegerChannel]) -> Result<FilmSums, FilmSumsError> {
        let SumsHeader { film, filter, light_paths, scale, runs, channels: count, replicates, state: bytes } =
            header;
        let (crop, sources) = (Area::of(film.crop), sources(&film, &filter));
        // Before memory is taken for as many.
        let is_sized = |channel: &IntegerChannel| channel.samples.len() == crop.size();
        if channels.len() as u64 != count || !channels.iter().all(is_sized) {
            return Err(FilmSumsError::Unreadable);
        }
        let find = |name: &str| channels.iter().find(|channel| channel.name == name);
        let read = |kind: &str| -> Option<Vec<Sum>> {
            let mut sums = vec![Sum::default(); crop.size()];
            for (color, word) in words() {
                for (sum, bits) in sums.iter_mut().zip(&find(&name(kind, color, word))?.samples) {
                    sum.set_word(color, word, *bits);
                }
            }
            sums.iter().all(Sum::is_carried).then_some(sums)
        };
        let replicate = |at| {
            let [filtered, unfiltered] = kinds_of(at).map(|kind| read(&kind).unwrap_or_default());
            PixelSums { filtered, unfiltered }
        };
        let mut all = FilmSums {
            replicates: (0..replicates as usize).map(replicate).collect(),
            splats: read(".splats").unwrap_or_default(),
            sums: vec![Sum::default(); crop.size()],
            counts: vec![0; sources.size()],
            state: None,
            film,
            filter,
            light_paths,
            scale,
        };
        let is_shared = |replicate: &PixelSums| {
            replicate.unfiltered.is_empty() != (filter.shares_samples() && !replicate.filtered.is_empty())
        };
        if !all.replicates.iter().all(is_shared) {
            return Err(FilmSumsError::Unreadable);
        }
        if bytes > 0 {
            let channels: Vec<_> = (0..).map_while(|number| find(&state_name(number))).collect();
            let state = PolicyState::from_channels(&channels).filter(|state| state.is_sound(crop, sources));
            let state = state.ok_or(FilmSumsError::Unreadable)?;
            for tile in &state.tiles {
                for (pixel, count) in tile.sources.pixels().zip(&tile.counts) {
                    all.counts[sources.index(pixel)] = *count;
                }
                for (own, pixel) in tile.bounds.pixels().enumerate() {
                    all.sums[crop.index(pixel)] = tile.so_far(own);
                }
            }
            all.state = Some(state);
            return Ok(all);
        }
        let runs = runs.into_iter().flat_map(|(length, count)| std::iter::repeat_n(count, length as usize));
        all.counts.iter_mut().zip(runs).for_each(|(own, count)| *own = count);
        if all.replicates.is_empty() {
            all.sums = read("").ok_or(FilmSumsError::Unreadable)?;
        }
        for replicate in &all.replicates {
            all.sums.iter_mut().zip(&replicate.filtered).for_each(|(sum, more)| *sum += *more);
        }
        Ok(all)
    }
}

impl PolicyState {
    /// The state as channels of so many integers: its bytes, behind their number.
    fn to_channels(&self, size: usize) -> Vec<IntegerChannel> {
        let state = postcard::to_allocvec(self).expect("plain data in memory can be written");
        let mut bytes = (state.len() as u64).to_le_bytes().to_vec();
        bytes.extend(state);
        bytes.resize(bytes.len().next_multiple_of(size_of::<u32>() * size), 0);
        let words: Vec<u32> = bytes.as_chunks().0.iter().copied().map(u32::from_le_bytes).collect();
        let channel = |(number, words): (usize, &[u32])| IntegerChannel {
            name: state_name(number),
            samples: words.into(),
        };
        words.chunks(size).enumerate().map(channel).collect()
    }

    /// Bytes of its memory, about: at least 1.
    fn bytes(&self) -> u64 {
        1 + (self.plan.len() + self.tiles.iter().map(Tile::bytes).sum::<usize>()) as u64
    }

    /// True if it can be of a film with this crop window, whose samples are taken in these pixels.
    fn is_sound(&self, crop: Area, sources: Area) -> bool {
        self.tiles.iter().all(|tile| {
            tile.sources.intersection(sources) == tile.sources
                && tile.counts.len() == tile.sources.size()
                && tile.is_sound(crop)
        })
    }

    fn from_channels(channels: &[&IntegerChannel]) -> Option<PolicyState> {
        let words = channels.iter().flat_map(|channel| &channel.samples);
        let bytes: Vec<u8> = words.flat_map(|word| word.to_le_bytes()).collect();
        let (length, bytes) = bytes.split_first_chunk()?;
        let bytes = bytes.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
        postcard::from_bytes(bytes).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Part, Settings, render};
    use crate::testing::scene;
    use std::ops::ControlFlow;

    /// The sums of a picture at its end, and the picture.
    fn sums(seed: u64, width: u32, lamp: &str) -> (FilmSums, Image) {
        filtered(seed, width, lamp, "gaussian")
    }

    /// The sums and the picture of one rendering with this filter.
    fn filtered(seed: u64, width: u32, lamp: &str, filter: &str) -> (FilmSums, Image) {
        let scene = scene(&format!(
            "LookAt 0 0 -4 0 0 0 0 1 0 Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" 16
            \"float cropwindow\" [.2 .9 0 1] \"float scale\" 3 Camera \"perspective\" PixelFilter \"{filter}\"
            Sampler \"sobol\" \"integer pixelsamples\" 5 Integrator \"path\" WorldBegin
            LightSource \"infinite\" \"rgb L\" [.5 1 {lamp}] Shape \"sphere\" WorldEnd"
        ));
        let settings = Settings { seed, keep_sums: true, ..Settings::default() };
        let rendered = render(&scene, &settings, &|_| ControlFlow::Continue(()));
        (rendered.sums.unwrap(), rendered.image)
    }

    #[test]
    fn sums_give_the_picture_and_add_up_in_any_order() {
        let parts = [1, 2, 3].map(|seed| sums(seed, 24, "2"));
        for (sums, image) in &parts {
            assert_eq!(sums.image(), *image);
            assert!(sums.counts.iter().all(|count| *count == 5));
        }
        let sum = |order: [usize; 3]| {
            let mut sum = parts[order[0]].0.clone();
            order[1..].iter().for_each(|part| sum.add(&parts[*part].0).unwrap());
            sum
        };
        let all = sum([0, 1, 2]);
        assert_eq!(all, sum([2, 0, 1]));
        assert!(all.counts.iter().all(|count| *count == 15));
        let means = |image: &Image| -> f64 {
            image.channels.iter().flat_map(|channel| &channel.samples).map(|value| f64::from(*value)).sum()
        };
        let mean = parts.iter().map(|(_, image)| means(image)).sum::<f64>() / 3.0;
        assert!((means(&all.image()) / mean - 1.0).abs() < 1e-3);
    }

    /// The sums of all parts add up to those of the whole, in every bit, however many parts there are.
    #[test]
    fn parts_add_up_to_the_sums_of_the_whole() {
        for filter in ["box", "triangle", "gaussian", "mitchell", "sinc"] {
            let scene = scene(&format!(
                "LookAt 0 0 -4 0 0 0 0 1 0 Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 30
                Camera \"perspective\" PixelFilter \"{filter}\" Sampler \"halton\" \"integer pixelsamples\" 53
                Integrator \"path\" WorldBegin LightSource \"infinite\" \"rgb L\" [.5 1 1e-3]
                LightSource \"point\" \"point from\" [0 2 -2] \"rgb I\" [1e3 1e3 1e3] Shape \"sphere\" WorldEnd"
            ));
            let sums = |part: Option<Part>| {
                let settings = Settings { part, keep_sums: true, ..Settings::default() };
                render(&scene, &settings, &|_| ControlFlow::Continue(())).sums.unwrap()
            };
            let whole = sums(None);
            for of in [2, 7, 53] {
                let mut added = sums(Some(Part { index: 0, of }));
                (1..of).for_each(|index| added.add(&sums(Some(Part { index, of }))).unwrap());
                assert!(added == whole, "{filter}: {of} parts");
            }
        }
    }

    #[test]
    fn sums_are_written_and_read_without_loss() {
        let (mut sums, _) = sums(1, 24, "2");
        sums.counts[7] += 3;
        let (header, channels) = sums.to_channels();
        assert_eq!(header.samples(), None);
        let bytes = header.to_bytes();
        let read = |bytes: &[u8]| FilmSums::from_channels(SumsHeader::from_bytes(bytes)?, &channels);
        assert_eq!(read(&bytes), Ok(sums));
        for bad in [&bytes[..bytes.len() / 2], &bytes[1..], b"", b"PF\n8 8\n"] {
            assert_eq!(read(bad), Err(FilmSumsError::Unreadable));
        }
        // Damaged bytes never panic.
        for (at, bit) in (0..bytes.len()).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
            let mut bad = bytes.clone();
            bad[at] ^= 1 << bit;
            if let Ok(sums) = read(&bad) {
                sums.image();
            }
        }
    }

    #[test]
    fn sums_of_other_pictures_do_not_add_up() {
        let (mut own, _) = sums(1, 24, "2");
        let before = own.clone();
        // Another width, another brightness.
        for (width, lamp) in [(25, "2"), (24, "2000")] {
            assert_eq!(own.add(&sums(1, width, lamp).0), Err(FilmSumsError::OtherPicture));
        }
        // Another filter of the same radius.
        assert_eq!(own.add(&filtered(1, 24, "2", "mitchell").0), Err(FilmSumsError::OtherPicture));
        let mut full = own.clone();
        full.counts[7] = u32::MAX;
        assert_eq!(own.add(&full), Err(FilmSumsError::TooManySamples));
        assert_eq!(own, before);
    }
}
