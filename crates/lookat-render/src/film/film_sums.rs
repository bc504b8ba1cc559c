//! The sums of a film as plain data. Sums of different samples of one picture add up; programs write and read them.

use std::fmt;

use lookat_image::Image;
use serde::{Deserialize, Serialize};

use super::sum::{Scale, Sum, value};
use super::{Area, Film, develop, lock};

/// All that the samples of a picture have brought: per pixel the sums of weighted radiance and of weights, in integers, and how many
/// samples there are. So partial sums give the same bits in any order, and the sum of all is the picture of one rendering.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FilmSums {
    /// The film of the picture.
    pub film: lookat_scene::Film,
    /// The weights of the filter for the unit squares around a pixel, across and down: from so many pixels before its own on to so many
    /// after it as the filter reaches.
    pub weights: [Vec<f64>; 2],
    /// The samples taken in each pixel of the crop window and as far beyond it as the filter reaches, row by row.
    pub counts: Vec<u32>,
    /// The light paths whose splats are in the sums.
    pub light_paths: u64,
    scale: Scale,
    /// Of the samples, one for each pixel of the crop window, row by row.
    sums: Vec<Sum>,
    /// Of the splats, likewise; empty without splats.
    splats: Vec<Sum>,
}

/// Why sums do not add up, or cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilmSumsError {
    /// They are of another film or filter, or of a scene of another brightness.
    OtherPicture,
    /// A pixel would have 2^32 samples or more.
    TooManySamples,
    /// The bytes are no film sums, are damaged, or of another version of lookat.
    Unreadable,
}

impl std::error::Error for FilmSumsError {}

impl fmt::Display for FilmSumsError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            FilmSumsError::OtherPicture => {
                "the film sums are of different pictures: scene, film and filter must be the same"
            }
            FilmSumsError::TooManySamples => "a pixel would have 2^32 samples or more",
            FilmSumsError::Unreadable => {
                "these are no film sums, or they are damaged, or of another version of lookat"
            }
        })
    }
}

impl Film<'_> {
    /// The sums so far.
    pub fn sums(&self) -> FilmSums {
        let (crop, sources) = (self.crop(), self.sources());
        let mut all = FilmSums {
            film: self.of.clone(),
            weights: self.filter.of_squares(),
            counts: vec![0; sources.size()],
            light_paths: self.light_paths(),
            scale: self.scale(),
            sums: vec![Sum::default(); crop.size()],
            splats: Vec::new(),
        };
        for tile in &self.tiles {
            let tile = lock(tile);
            for (place, count) in tile.sources.places().zip(&tile.counts) {
                all.counts[sources.index(place)] = *count;
            }
            for (own, place) in tile.bounds.places().enumerate() {
                all.sums[crop.index(place)] = tile.so_far(own);
            }
            if !tile.splats.is_empty() {
                all.splats.resize(crop.size(), Sum::default());
            }
            for (splats, place) in tile.splats.iter().zip(tile.bounds.places()) {
                all.splats[crop.index(place)] = *splats;
            }
        }
        all
    }
}

/// Changes whenever the bytes of sums do.
const FORMAT: u32 = 1;

impl FilmSums {
    /// Bytes of a pixel.
    pub(crate) const PIXEL_BYTES: usize = size_of::<Sum>() + size_of::<u32>();

    /// Adds the sums of other samples. If it fails, nothing has changed. The caller sees to it that both are of one scene, and have other
    /// samples: other seeds or numbers.
    pub fn add(&mut self, other: &FilmSums) -> Result<(), FilmSumsError> {
        if (&self.film, &self.weights, self.scale) != (&other.film, &other.weights, other.scale) {
            return Err(FilmSumsError::OtherPicture);
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
        Ok(())
    }

    /// The picture: linear RGB, with the crop window as data window. Pixels without samples are black.
    pub fn image(&self) -> Image {
        let value = |(at, sum): (usize, &Sum)| value(sum, self.splats.get(at), self.light_paths, self.scale);
        develop(&self.film, self.sums.iter().enumerate().map(value).enumerate())
    }

    /// The sums as bytes, without loss.
    pub fn to_bytes(&self) -> Vec<u8> {
        postcard::to_allocvec(&(FORMAT, self)).expect("plain data in memory can be written")
    }

    /// The sums that [`FilmSums::to_bytes`] has written.
    pub fn from_bytes(bytes: &[u8]) -> Result<FilmSums, FilmSumsError> {
        let read: Result<(u32, FilmSums), _> = postcard::from_bytes(bytes);
        let sums = read.ok().filter(|(format, _)| *format == FORMAT).map(|(_, sums)| sums);
        sums.filter(FilmSums::is_whole).ok_or(FilmSumsError::Unreadable)
    }

    /// Whether there is a sum for each pixel.
    fn is_whole(&self) -> bool {
        let lookat_scene::Film { resolution: [width, height], crop, .. } = self.film;
        let fits = |from, to, side| from < to && to <= side && side <= lookat_scene::MAX_SIDE;
        // A filter reaches 100 pixels at most.
        let reach = self.weights.each_ref().map(|weights| (weights.len() / 2).min(1000) as u32);
        fits(crop.x0, crop.x1, width)
            && fits(crop.y0, crop.y1, height)
            && self.counts.len() == Area::of(crop).grown(reach).size()
            && self.sums.len() == Area::of(crop).size()
            && (self.splats.is_empty() || self.splats.len() == self.sums.len())
            && self.scale.is_valid()
            && self.sums.iter().chain(&self.splats).all(Sum::is_carried)
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::render::{Settings, render};
    use crate::testing::scene;

    /// The sums of a picture at its end, and the picture.
    fn sums(seed: u64, width: u32, lamp: &str) -> (FilmSums, Image) {
        filtered(seed, width, lamp, "gaussian")
    }

    /// The same with another filter.
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

    #[test]
    fn sums_are_written_and_read_without_loss() {
        let (sums, _) = sums(1, 24, "2");
        let bytes = sums.to_bytes();
        assert_eq!(FilmSums::from_bytes(&bytes), Ok(sums));
        for bad in [&bytes[..bytes.len() / 2], &bytes[1..], b"", b"PF\n8 8\n"] {
            assert_eq!(FilmSums::from_bytes(bad), Err(FilmSumsError::Unreadable));
        }
        // Damaged bytes never panic.
        for at in 0..bytes.len().min(4000) {
            let mut bad = bytes.clone();
            bad[at] ^= 0x80;
            if let Ok(sums) = FilmSums::from_bytes(&bad) {
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
