//! The pictures of lights and textures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use lookat_image::{
    ByteImage, Charge, Image, ImageError, ImageFault, MemoryBudget, MipMap, PictureFile, Pixels, Texel,
    Window, linear_from_srgb, luminance,
};
use lookat_syntax::{Diagnostic, Text};
use rayon::prelude::*;

use crate::cache::{PictureKey, PictureSettings};
use crate::color;
use crate::files::{Charged, Files, shown_path};
use crate::params::Params;

/// The pictures of a scene so far. Each file is decoded once for each type of texel and settings.
#[derive(Default)]
pub(crate) struct Pictures {
    /// True to check only that the files exist.
    pub fast: bool,
    /// The number of uses of pictures that were only checked, because `fast` is set.
    pub unread: usize,
    /// The file found for the first path tried.
    found: HashMap<PathBuf, PathBuf>,
    /// The names of pictures in the directives that come next, from last to first.
    next: Vec<Text>,
    /// Pictures that were read beside others and are not used yet.
    ahead: HashMap<PathBuf, ReadPixels>,
    colors: HashMap<PictureKey, Made<Vec3>>,
    numbers: HashMap<PictureKey, Made<f32>>,
}

impl Pictures {
    /// The picture in `file`, which the parameter `name` names. Reports an error and returns `None` without one: the directive is
    /// still valid, as in pbrt-v3. `instead`: what pbrt-v3 does with a picture that it does not read.
    pub fn get<T: FromColor>(
        &mut self,
        params: &mut Params,
        name: &'static str,
        file: &Text,
        settings: PictureSettings,
        instead: &str,
    ) -> Option<Arc<MipMap<T>>> {
        params.without_rejection(|params| {
            let (path, made) = if self.fast {
                self.unread += 1;
                let (path, _) = params.file(file, Files::open_named)?;
                let checked = PictureFile::check_name(&PathBuf::from(shown_path(&path)));
                let made = checked.map(|()| gray(&settings)).map_err(unreadable);
                (path, made)
            } else {
                self.decoded(params, name, file, settings)?
            };
            match made {
                Ok(map) => {
                    warn_of_format(params, name, &path, instead);
                    Some(map)
                }
                Err((message, help)) => {
                    params.error_surely(Diagnostic::error(file.span, message).help(help));
                    None
                }
            }
        })
    }

    /// Notes the names of pictures in the directives that come next: some are read beside the first ones.
    pub fn expect<'t>(&mut self, names: impl DoubleEndedIterator<Item = &'t Text>) {
        self.next = if self.fast { Vec::new() } else { names.rev().cloned().collect() };
    }

    /// The path found, and the picture.
    fn decoded<T: FromColor>(
        &mut self,
        params: &mut Params,
        name: &str,
        file: &Text,
        settings: PictureSettings,
    ) -> Option<(PathBuf, Made<T>)> {
        let first = params.files.beside(&file.value, file.span);
        let (path, bytes) = match self.found.get(&first) {
            Some(path) => {
                params.warn_of_path(file, path);
                (path.clone(), None)
            }
            None => {
                let reuse = params.files.reuse;
                let is_kept = |path: &Path| {
                    let key = (path.to_owned(), settings);
                    self.ahead.contains_key(path)
                        || reuse.is_some_and(|reuse| reuse.picture::<MipMap<T>>(&key).is_some())
                };
                let (path, bytes) =
                    params.file(file, |files, name, at| files.read_unless(name, at, is_kept))?;
                self.found.insert(first, path.clone());
                (path, bytes)
            }
        };
        let key = (path.clone(), settings);
        if let Some(made) = T::made(self).get(&key) {
            return Some((path, made.clone()));
        }
        let made = match kept(params, &key) {
            Some(map) => Ok(map),
            None => {
                let reported = params.reported();
                let read = match (self.ahead.remove(&path), bytes) {
                    (Some(read), _) => Ok(read),
                    (None, Some(bytes)) => self.read(params.files, &path, bytes),
                    (None, None) => self.read(params.files, &path, params.file(file, Files::read_named)?.1),
                };
                let made = read.and_then(|read| self.map(params, name, &path, read, &settings));
                // Warnings are given when the picture is decoded.
                if let (Some(reuse), Ok(map)) = (params.files.reuse, &made)
                    && reported.is_some_and(|reported| params.reported() == Some(reported))
                {
                    reuse.keep_picture(&key, map);
                }
                made
            }
        };
        T::made(self).insert(key, made.clone());
        Some((path, made))
    }

    /// Reads the pixels of a file, and beside it those of the pictures that come next, one for each other thread.
    fn read(&mut self, files: &Files, path: &Path, bytes: Charged) -> Fallible<ReadPixels> {
        let mut others: Vec<(PathBuf, Charged)> = Vec::new();
        while others.len() + 1 < rayon::current_num_threads()
            && let Some(name) = self.next.pop()
        {
            let is_known = |other: &Path| {
                let is_other = others.iter().any(|(known, _)| known == other);
                let is_kept = files.reuse.is_some_and(|reuse| reuse.has_picture(other));
                other == path || is_other || is_kept || self.ahead.contains_key(other)
            };
            // What is wrong with it is reported at its directive.
            if !self.found.contains_key(&files.beside(&name.value, name.span))
                && let Ok((other, Some(bytes))) = files.read_unless(&name.value, name.span, is_known)
            {
                others.push((other, bytes));
            }
        }
        let memory = &files.memory;
        let (own, others) = rayon::join(
            || pixels(path, &bytes, memory),
            || {
                let read =
                    |(path, bytes): (PathBuf, Charged)| Some((pixels(&path, &bytes, memory).ok()?, path));
                others.into_par_iter().filter_map(read).collect::<Vec<_>>()
            },
        );
        if own.is_err() && !(others.is_empty() && self.ahead.is_empty()) {
            // They may take the memory that this one needs.
            drop(others);
            self.ahead.clear();
            return pixels(path, &bytes, memory);
        }
        self.ahead.extend(others.into_iter().map(|(read, path)| (path, read)));
        own
    }

    /// The map of the pixels of a file. `name` is the parameter that names it, for warnings.
    fn map<T: FromColor>(
        &mut self,
        params: &mut Params,
        name: &str,
        path: &Path,
        (pixels, pixels_charge): ReadPixels,
        settings: &PictureSettings,
    ) -> Made<T> {
        let (window, of_bytes) = match &pixels {
            Pixels::Values(image) => (image.data_window, false),
            Pixels::Bytes(image) => (image.window, are_components::<T>(image.channels)),
        };
        let Window { width, height, .. } = window;
        let kept = MipMap::<T>::bytes_of(width, height, of_bytes);
        // While the map is made, there are two versions of the finest level.
        let reserve = || params.files.memory.reserve(kept.saturating_mul(2));
        let reserved = reserve().or_else(|_| {
            self.ahead.clear();
            reserve()
        });
        let mut charge = reserved.map_err(|shortage| {
            let message = format!("cannot use {}, {width} x {height} pixels: {shortage}", shown_path(path));
            (message, SMALLER.into())
        })?;
        let map = match pixels {
            Pixels::Bytes(image) => map_of_bytes(image, settings),
            Pixels::Values(image) => map_of_values(params, name, path, image, settings)?,
        };
        drop(pixels_charge);
        // Less than before, so it fits.
        let _ = charge.resize(kept);
        charge.keep();
        Ok(Arc::new(map))
    }
}

/// The pixels of a file.
fn pixels(path: &Path, bytes: &[u8], memory: &MemoryBudget) -> Fallible<ReadPixels> {
    // Escaped for messages.
    let shown = PathBuf::from(shown_path(path));
    PictureFile::of_bytes(&shown, bytes, memory).and_then(PictureFile::read_pixels).map_err(unreadable)
}

/// The map in place of a picture that cannot be read, as in pbrt-v3.
pub(crate) fn gray<T: FromColor>(settings: &PictureSettings) -> Arc<MipMap<T>> {
    Arc::new(MipMap::new(1, 1, vec![T::from_color(Vec3::splat(0.5), settings)], settings.wrap))
}

/// A picture that an earlier load has decoded. `None` also where memory is short, so that errors are the same as without it.
fn kept<T: FromColor>(params: &Params, key: &PictureKey) -> Option<Arc<MipMap<T>>> {
    let map: Arc<MipMap<T>> = params.files.reuse?.picture(key)?;
    let mut charge = params.files.memory.reserve(4 * map.bytes() as u64).ok()?;
    charge.resize(map.bytes() as u64).ok()?;
    charge.keep();
    Some(map)
}

/// Warns of a picture in a format that pbrt-v3 does not read (ReadImage in core/imageio.cpp).
fn warn_of_format(params: &mut Params, name: &str, path: &Path, instead: &str) {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    if ["exr", "tga", "png", "pfm"].contains(&ending.as_str()) {
        return;
    }
    let message = format!("pbrt-v3 does not read .{ending} pictures: it {instead}");
    params.warn(name, &message, "convert the picture to .exr, which both programs read");
}

/// The pixels of a file, and the charge for them.
type ReadPixels = (Pixels, Charge);

/// Something, or an error message and help.
type Fallible<T> = Result<T, (String, String)>;

type Made<T> = Fallible<Arc<MipMap<T>>>;

/// Converts a color to a texel.
pub(crate) trait FromColor: Texel + 'static {
    /// Converts a color of the file.
    fn from_color(color: Vec3, settings: &PictureSettings) -> Self;

    /// Converts the equal channels of a gray of the file to a component of a texel.
    fn component(gray: f32, settings: &PictureSettings) -> f32;

    /// The pictures of this type so far.
    fn made(pictures: &mut Pictures) -> &mut HashMap<PictureKey, Made<Self>>;
}

impl FromColor for Vec3 {
    fn from_color(color: Vec3, settings: &PictureSettings) -> Self {
        Vec3::from_array(color.to_array().map(|value| Self::component(value, settings)))
    }

    fn component(gray: f32, settings: &PictureSettings) -> f32 {
        texel_value(gray, settings)
    }

    fn made(pictures: &mut Pictures) -> &mut HashMap<PictureKey, Made<Vec3>> {
        &mut pictures.colors
    }
}

impl FromColor for f32 {
    /// The luminance, which pbrt-v3 computes before the sRGB conversion.
    fn from_color(color: Vec3, settings: &PictureSettings) -> Self {
        texel_value(luminance(color.to_array()), settings)
    }

    fn component(gray: f32, settings: &PictureSettings) -> f32 {
        Self::from_color(Vec3::splat(gray), settings)
    }

    fn made(pictures: &mut Pictures) -> &mut HashMap<PictureKey, Made<f32>> {
        &mut pictures.numbers
    }
}

const LARGEST: f32 = color::LARGEST as f32;

/// True for light above the limit of colors. An infinite value counts as 0.
fn is_too_bright(value: f32) -> bool {
    value.is_finite() && value > LARGEST
}

fn texel_value(value: f32, settings: &PictureSettings) -> f32 {
    let linear = if settings.gamma { linear_from_srgb(value) } else { value };
    let scaled = f32::from_bits(settings.scale) * linear;
    let least = if settings.not_negative { 0.0 } else { -LARGEST };
    if scaled.is_nan() { 0.0 } else { scaled.clamp(least, LARGEST) }
}

/// Warns of values that are not used as they are.
fn map_of_values<T: FromColor>(
    params: &mut Params,
    name: &str,
    path: &Path,
    image: Image,
    settings: &PictureSettings,
) -> Fallible<MipMap<T>> {
    let planes = image.rgb_planes().ok_or_else(|| {
        let message =
            format!("cannot use {}: it has neither the channels R, G and B nor Y", shown_path(path));
        (message, HELP.into())
    })?;
    if settings.not_negative && planes.iter().any(|plane| plane.iter().any(|value| *value < 0.0)) {
        let message = "values below 0 of this picture are used as 0; in pbrt-v3, they subtract light";
        params.warn(name, message, "set them to 0 in the picture: lookat and pbrt-v3 then agree");
    }
    if settings.not_negative && planes.iter().any(|plane| plane.iter().any(|value| is_too_bright(*value))) {
        let message = format!("{} is too bright; the limit is {:e}", shown_path(path), color::LARGEST);
        return Err((
            message,
            "divide the values of the picture, and multiply the scale of the light".into(),
        ));
    }
    let [width, height] = image.data_window.size().map(|side| side as usize);
    let (texels, is_finite) = texels(planes, width, settings);
    if !is_finite {
        let message = "the picture contains infinite or NaN values; they are used as 0";
        params.warn(name, message, "render the picture again, or replace these pixels");
    }
    // Frees the memory of a large picture early.
    drop(image);
    Ok(MipMap::new(width, height, texels, settings.wrap))
}

/// True if each component of a texel depends on one byte of a picture with so many channels.
fn are_components<T: Texel>(channels: usize) -> bool {
    channels <= T::COMPONENTS
}

fn map_of_bytes<T: FromColor>(image: ByteImage, settings: &PictureSettings) -> MipMap<T> {
    let ByteImage { window, channels, mut bytes, values } = image;
    let [width, height] = window.size().map(|side| side as usize);
    if settings.bottom_up {
        let row = width * channels;
        for y in 0..height / 2 {
            let (top, bottom) = bytes.split_at_mut((height - 1 - y) * row);
            top[y * row..][..row].swap_with_slice(&mut bottom[..row]);
        }
    }
    if are_components::<T>(channels) {
        if channels < T::COMPONENTS {
            bytes = bytes.into_iter().flat_map(|gray| [gray; 3]).collect();
        }
        let values = Box::new(values.map(|value| T::component(value, settings)));
        return MipMap::of_bytes(width, height, bytes, values, settings.wrap);
    }
    let texel = |rgb: &[u8; 3]| T::from_color(rgb.map(|byte| values[usize::from(byte)]).into(), settings);
    MipMap::new(width, height, bytes.as_chunks().0.par_iter().map(texel).collect(), settings.wrap)
}

fn unreadable(error: ImageError) -> (String, String) {
    (error.to_string(), help(&error))
}

/// The help for a picture that cannot be decoded.
fn help(error: &ImageError) -> String {
    match error.fault {
        ImageFault::WrongFormat(Some(ending)) => format!("rename it to end in .{ending}, or {HELP}"),
        ImageFault::TooLarge { .. } => SMALLER.into(),
        _ => HELP.into(),
    }
}

/// The help for a picture that is too large.
const SMALLER: &str = "make the picture smaller; sides that are powers of two take the least memory";

const HELP: &str = "save the picture again, as exr with ZIP compression or as png";

/// The texels of red, green and blue in rows of length `row`, and true if all values are finite. Infinities and NaN
/// become 0.
fn texels<T: FromColor>(planes: [&[f32]; 3], row: usize, settings: &PictureSettings) -> (Vec<T>, bool) {
    let (mut texels, mut is_finite) = (Vec::with_capacity(planes[0].len()), true);
    let mut convert = |color: Vec3| {
        let finite = color.is_finite_mask();
        is_finite &= finite.all();
        T::from_color(Vec3::select(finite, color, Vec3::ZERO), settings)
    };
    let [mut r, mut g, mut b] = planes.map(|plane| plane.chunks_exact(row));
    while let (Some(r), Some(g), Some(b)) = if settings.bottom_up {
        (r.next_back(), g.next_back(), b.next_back())
    } else {
        (r.next(), g.next(), b.next())
    } {
        texels.extend(r.iter().zip(g).zip(b).map(|((r, g), b)| convert(Vec3::new(*r, *g, *b))));
    }
    (texels, is_finite)
}

#[cfg(test)]
mod tests {
    use lookat_image::Wrap;

    use super::*;

    fn settings(gamma: bool, scale: f32) -> PictureSettings {
        PictureSettings {
            wrap: Wrap::Repeat,
            gamma,
            scale: scale.to_bits(),
            bottom_up: true,
            not_negative: false,
        }
    }

    /// pbrt-v3 converts a color to its luminance first, then from sRGB to linear.
    #[test]
    fn numbers_are_luminances() {
        let color = Vec3::new(1.0, 0.0, 0.0);
        assert_eq!(f32::from_color(color, &settings(false, 2.0)), 2.0 * 0.212671);
        let linear = ((0.212671_f32 + 0.055) / 1.055).powf(2.4);
        assert!((f32::from_color(color, &settings(true, 1.0)) - linear).abs() < 1e-6);
        assert_eq!(Vec3::from_color(color * 0.5, &settings(true, 1.0)).x, linear_from_srgb(0.5));
    }

    #[test]
    fn texels_are_finite() {
        let all = Vec3::from_color(Vec3::new(f32::MAX, -f32::MAX, 0.0), &settings(true, f32::INFINITY));
        assert_eq!(all, Vec3::new(LARGEST, -LARGEST, 0.0));
        let planes: [&[f32]; 3] = [&[1.0, 4.0], &[f32::NAN, 5.0], &[f32::INFINITY, 6.0]];
        let (top, bottom) = (Vec3::X, Vec3::new(4.0, 5.0, 6.0));
        let as_stored = settings(false, 1.0);
        assert_eq!(texels(planes, 1, &as_stored), (vec![bottom, top], false));
        let top_down = PictureSettings { bottom_up: false, ..as_stored };
        assert_eq!(texels(planes, 2, &top_down), (vec![top, bottom], false));
        let planes: [&[f32]; 3] = [&[1.0, 2.0, 3.0, 4.0]; 3];
        assert_eq!(texels(planes, 2, &as_stored), ([3.0, 4.0, 1.0, 2.0].map(Vec3::splat).to_vec(), true));
        let (numbers, is_finite) = texels::<f32>(planes, 2, &as_stored);
        assert!(is_finite && (numbers[0] - 3.0).abs() < 1e-5, "{numbers:?}");
    }
}
