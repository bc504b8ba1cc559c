//! The sums of a film as channels of integers, which files hold without loss.

use std::array::from_fn;
use std::collections::HashMap;

use lookat_image::IntegerChannel;
use lookat_scene::Filter;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

use super::REPLICATES;
use super::area::Area;
use super::film_sums::{FilmSums, FilmSumsError, PolicyState, sources};
use super::spread::Spread;
use super::sum::{PixelSums, Scale, Sum};
use super::tile::Tile;

/// Changes whenever the bytes of a header or of channels do.
const FORMAT: u32 = 5;

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
    /// The samples taken in each source, as runs of equal numbers: how many, and the samples of each. Empty with a state, which has them.
    runs: Vec<(u32, u32)>,
    /// The number of all channels.
    channels: u64,
    /// The number of replicates: 0 or [`REPLICATES`].
    replicates: u32,
    /// The bytes of the state in its channels; 0 without one.
    state_bytes: u64,
    /// How many of these are the states of tiles.
    tile_bytes: u64,
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
            && self.state_channels() <= self.channels
            && self.tile_bytes <= self.state_bytes
            && self.runs.iter().map(|(length, _)| u64::from(*length)).sum::<u64>()
                == if self.state_bytes == 0 { sources(&self.film, &self.filter).size() as u64 } else { 0 }
    }

    /// The number of channels with bytes of the state.
    fn state_channels(&self) -> u64 {
        self.state_bytes.div_ceil((size_of::<u32>() as u64).saturating_mul(self.film.crop.area()).max(1))
    }

    /// Bytes of the sums that it belongs to, about.
    pub fn bytes(&self) -> u64 {
        let counts = sources(&self.film, &self.filter).size() * size_of::<u32>();
        // Each kind of sums has a channel for each color at least.
        let words = self.channels.saturating_sub(self.state_channels());
        let kinds = (words / COLORS as u64).min(kinds(self.replicates as usize).count() as u64);
        let pixel =
            words.saturating_mul(size_of::<u32>() as u64).saturating_add(kinds * size_of::<Sum>() as u64);
        let sums = self.film.crop.area().saturating_mul(pixel);
        // The channels of a state, its bytes, and what they become.
        sums.saturating_add(counts as u64).saturating_add(self.state_bytes.saturating_mul(4))
    }
}

/// What the names of all channels begin with.
const PREFIX: &str = "sums";

/// The colors of a sum, and its weight.
const COLORS: usize = 4;

/// The words of 32 bits of each, the lowest first: see [`Sum::zigzags`].
const WORDS: usize = 4;

/// The name of a channel with the words of a color, or of the weight.
fn name(kind: &str, color: usize, word: usize) -> String {
    format!("{PREFIX}{kind}.{}.{word}", ["R", "G", "B", "weight"][color])
}

/// The names of all sums, in the order of [`Tile::all_sums`].
fn kinds(replicates: usize) -> impl Iterator<Item = String> {
    let replicates =
        (0..replicates).flat_map(|at| ["", "-unfiltered"].map(|kind| format!(".replicate{at}{kind}")));
    ["", ".splats", ".pass", ".pass-unfiltered"].into_iter().map(String::from).chain(replicates)
}

/// The name of a channel with the bytes of a state.
fn state_name(number: usize) -> String {
    format!("{PREFIX}.state{number}")
}

/// What the channels of a state hold behind the states of tiles, which are not copied.
#[derive(Serialize, Deserialize)]
struct Stored {
    plan: ByteBuf,
    counts: Vec<u32>,
    spreads: Vec<Spread>,
    unfiltered: Vec<Spread>,
}

impl FilmSums {
    /// Bytes of a pixel.
    pub(crate) const PIXEL_BYTES: usize = size_of::<Sum>() + size_of::<u32>();

    /// True for the names of channels that [`FilmSums::into_channels`] gives.
    pub fn is_channel(name: &str) -> bool {
        name.split('.').next() == Some(PREFIX)
    }

    /// The sums as channels of integers, without loss, and what else they need.
    pub fn into_channels(self) -> (SumsHeader, Vec<IntegerChannel>) {
        let FilmSums { film, filter, light_paths, scale, mut all, state } = self;
        let (size, replicates) = (all.bounds.size(), all.replicates.len());
        let counts = std::mem::take(&mut all.counts);
        let (mut runs, mut bytes, mut tile_bytes) = (Vec::new(), Vec::new(), 0);
        match state {
            None => runs.extend(counts.chunk_by(|a, b| a == b).map(|run| (run.len() as u32, run[0]))),
            Some(policy) => {
                let [spreads, unfiltered] = [&mut all.spreads, &mut all.unfiltered].map(std::mem::take);
                let PolicyState { plan, tiles } = policy;
                tile_bytes = tiles.len() as u64;
                let stored = Stored { plan, counts, spreads, unfiltered };
                bytes = postcard::to_extend(&stored, tiles).expect("plain data in memory can be written");
            }
        }
        let mut channels = Vec::new();
        for (kind, sums) in kinds(replicates).zip(all.all_sums_mut()) {
            channels.extend(to_channels(&kind, &std::mem::take(sums)));
        }
        let state_bytes = bytes.len() as u64;
        bytes.resize(bytes.len().next_multiple_of(size_of::<u32>() * size), 0);
        let bytes = bytes.as_chunks().0.chunks(size).enumerate();
        channels.extend(bytes.map(|(number, bytes)| IntegerChannel {
            name: state_name(number),
            samples: bytes.iter().copied().map(u32::from_le_bytes).collect(),
        }));
        let header = SumsHeader {
            film,
            filter,
            light_paths,
            scale,
            runs,
            channels: channels.len() as u64,
            replicates: replicates as u32,
            state_bytes,
            tile_bytes,
        };
        (header, channels)
    }

    /// The sums that [`FilmSums::into_channels`] has given.
    pub fn from_channels(header: SumsHeader, channels: &[IntegerChannel]) -> Result<FilmSums, FilmSumsError> {
        // Before memory is taken for as many.
        let is_sized = |channel: &IntegerChannel| channel.samples.len() as u64 == header.film.crop.area();
        if channels.len() as u64 != header.channels || !channels.iter().all(is_sized) {
            return Err(FilmSumsError::Unreadable);
        }
        let state_channels = header.state_channels();
        let SumsHeader {
            film, filter, light_paths, scale, runs, replicates, state_bytes, tile_bytes, ..
        } = header;
        let (bounds, sources) = (Area::of(film.crop), sources(&film, &filter));
        let mut all = Tile {
            bounds,
            sources,
            replicates: vec![PixelSums::default(); replicates as usize],
            ..Tile::default()
        };
        let by_name: HashMap<_, _> = channels.iter().map(|channel| (&*channel.name, channel)).collect();
        let find = |name: &str| by_name.get(name).copied();
        for (kind, sums) in kinds(all.replicates.len()).zip(all.all_sums_mut()) {
            *sums = from_channels(&kind, find).ok_or(FilmSumsError::Unreadable)?;
        }
        let mut state = None;
        if state_bytes > 0 {
            let mut bytes = Vec::with_capacity(state_channels as usize * size_of::<u32>() * bounds.size());
            for number in 0..state_channels as usize {
                let channel = find(&state_name(number)).ok_or(FilmSumsError::Unreadable)?;
                bytes.extend(channel.samples.iter().flat_map(|word| word.to_le_bytes()));
            }
            bytes.truncate(state_bytes as usize);
            let stored = postcard::from_bytes(&bytes[tile_bytes as usize..]);
            let stored: Stored = stored.map_err(|_| FilmSumsError::Unreadable)?;
            bytes.truncate(tile_bytes as usize);
            let Stored { plan, counts, spreads, unfiltered } = stored;
            state = Some(PolicyState { plan, tiles: bytes });
            all = Tile { counts, spreads, unfiltered, ..all };
        } else {
            let run = |(length, count)| std::iter::repeat_n(count, length as usize);
            all.counts.extend(runs.into_iter().flat_map(run));
        }
        let is_shared = |replicate: &PixelSums| {
            replicate.unfiltered.is_empty() != (filter.shares_samples() && !replicate.filtered.is_empty())
        };
        if !all.is_sound() || !all.replicates.iter().all(is_shared) {
            return Err(FilmSumsError::Unreadable);
        }
        Ok(FilmSums { film, filter, light_paths, scale, all, state })
    }
}

/// The sums of one kind as channels, without the words that are 0 everywhere; but all of them have the lowest words.
fn to_channels(kind: &str, sums: &[Sum]) -> Vec<IntegerChannel> {
    let word_of = |zigzag: u128, word: usize| (zigzag >> (32 * word)) as u32;
    let mut used = [0; COLORS];
    for sum in sums {
        used.iter_mut().zip(sum.zigzags()).for_each(|(used, zigzag)| *used |= zigzag);
    }
    let words = (0..COLORS).flat_map(|color| (0..WORDS).map(move |word| (color, word)));
    let is_used = |(color, word): &(usize, usize)| *word == 0 || word_of(used[*color], *word) > 0;
    let words: Vec<_> = words.filter(|at| !sums.is_empty() && is_used(at)).collect();
    let channel = |(color, word): &(usize, usize)| IntegerChannel {
        name: name(kind, *color, *word),
        samples: Vec::with_capacity(sums.len()),
    };
    let mut channels: Vec<_> = words.iter().map(channel).collect();
    let mut zigzags = Vec::new();
    // So many at a time stay in the cache.
    for sums in sums.chunks(512) {
        zigzags.clear();
        zigzags.extend(sums.iter().map(Sum::zigzags));
        for (IntegerChannel { samples, .. }, (color, word)) in channels.iter_mut().zip(&words) {
            samples.extend(zigzags.iter().map(|zigzags| word_of(zigzags[*color], *word)));
        }
    }
    channels
}

/// The sums of one kind: none without channels. `None` if these are none of [`to_channels`].
fn from_channels<'c>(kind: &str, find: impl Fn(&str) -> Option<&'c IntegerChannel>) -> Option<Vec<Sum>> {
    let words: [[Option<&IntegerChannel>; WORDS]; COLORS] =
        from_fn(|color| from_fn(|word| find(&name(kind, color, word))));
    if words.iter().flatten().all(Option::is_none) {
        return Some(Vec::new());
    }
    let [Some(first), Some(_), Some(_), Some(_)] = words.map(|words| words[0]) else { return None };
    let sum = |at: usize| {
        let word = |channel: Option<&IntegerChannel>| channel.map_or(0, |channel| channel.samples[at]);
        let joined = |all: u128, channel| all << 32 | u128::from(word(channel));
        Sum::from_zigzags(words.map(|words| words.into_iter().rev().fold(0, joined)))
    };
    (0..first.samples.len()).map(sum).collect()
}
