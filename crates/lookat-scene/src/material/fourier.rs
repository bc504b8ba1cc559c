//! `Material "fourier"`: tables of measured or simulated scattering (Jakob et al., "A Comprehensive Framework for Rendering Layered
//! Materials", SIGGRAPH 2014; materials/fourier.cpp).

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use lookat_syntax::Diagnostic;

use crate::files::Files;
use crate::params::Params;
use crate::params::value::Name;
use crate::schema::{Key, Keys};

/// Isotropic scattering in a table: for each pair of zenith angles the Fourier series of the azimuth between them, times the cosine of the
/// light. Cosines are of the direction to the viewer and of the direction of travel of the light, so light that is reflected has the
/// other sign.
#[derive(Debug, PartialEq)]
pub struct FourierTable {
    /// The index of refraction, inside over outside.
    eta: f32,
    /// 1 for luminance; 3 for luminance, red and blue.
    channels: usize,
    /// The cosines of the zenith angles, increasing.
    cosines: Vec<f32>,
    /// The series for each pair: that of the viewer times the number of cosines, plus that of the light.
    series: Vec<Series>,
    /// The integrals of the luminance over the cosines of the light, up to each of them, for each of the viewer.
    sums: Vec<f32>,
    /// With [`FourierTable::PADDING`] zeros at the end.
    coefficients: Vec<f32>,
}

/// The place of the coefficients of a pair of cosines: those of all channels, one channel after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series {
    /// The number of the first one.
    pub first: u32,
    /// The number of coefficients of each channel.
    pub count: u32,
}

/// The most terms of a series: ten times those of the sharpest tables in use.
const MOST_ORDERS: i32 = 10_000;

impl FourierTable {
    /// The number of zeros after the coefficients, so that this many can be read at any place.
    pub const PADDING: usize = 8;

    /// The table in a `.bsdf` file of version 1. Explains what is wrong with another file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let bytes = bytes
            .strip_prefix(b"SCATFUN")
            .ok_or("it does not start with SCATFUN")?
            .strip_prefix(b"\x01")
            .ok_or("its version is not 1")?;
        let mut words = Words(bytes);
        let header = words.take(6)?;
        let number = |at: usize| i32::from_le_bytes(header[at]);
        if number(0) != 1 {
            return Err(format!(
                "it has flags {}, and only 1, a BSDF without harmonic extrapolation, is supported",
                number(0)
            ));
        }
        let size = |at: usize, what: &str| {
            usize::try_from(number(at)).map_err(|_| format!("it says that it has {} {what}", number(at)))
        };
        let (angles, count) = (size(1, "angles")?, size(2, "coefficients")?);
        let (largest, channels, bases) = (number(3), number(4), number(5));
        if largest > MOST_ORDERS {
            return Err(format!("it has series of {largest} terms, and at most {MOST_ORDERS} are supported"));
        }
        if angles < 2 {
            return Err(format!("it has {angles} angles, and needs at least 2"));
        }
        if ![1, 3].contains(&channels) {
            return Err(format!("it has {channels} channels, and only 1 and 3 are supported"));
        }
        if bases != 1 {
            return Err(format!(
                "it has {bases} basis functions, and only 1, without textures, is supported"
            ));
        }
        let channels = channels as usize;
        let eta = f32::from_le_bytes(words.take(8)?[3]);
        if !(eta.is_finite() && eta > 0.0) {
            return Err(format!("its index of refraction is {eta}"));
        }
        let pairs = angles.checked_mul(angles).ok_or(TRUNCATED)?;
        let cosines = floats(words.take(angles)?);
        // The sums of the file would have to agree with its coefficients: they are added up again.
        words.take(pairs)?;
        let places = words.take(pairs.checked_mul(2).ok_or(TRUNCATED)?)?;
        let mut coefficients = floats(words.take(count)?);
        // Programs that make tables write 0 twice, once for each side of the surface.
        let is_increasing = cosines.is_sorted()
            && cosines.windows(3).all(|three| three[0] < three[2])
            && cosines[0] < cosines[1]
            && cosines[angles - 2] < cosines[angles - 1];
        if !(is_increasing && cosines[0] >= -1.0 && cosines[angles - 1] <= 1.0) {
            return Err("its cosines do not increase from -1 to 1".into());
        }
        if !coefficients.iter().all(|coefficient| coefficient.is_finite()) {
            return Err("it has a coefficient that is no finite number".into());
        }
        let series = places.chunks_exact(2).map(|place| {
            let [first, count] = [place[0], place[1]].map(i32::from_le_bytes);
            let [first, count] = [u32::try_from(first).ok()?, u32::try_from(count).ok()?];
            let end = u64::from(first) + channels as u64 * u64::from(count);
            let is_inside =
                count == 0 || end <= coefficients.len() as u64 && i64::from(count) <= largest.into();
            is_inside.then_some(Series { first: if count == 0 { 0 } else { first }, count })
        });
        let series =
            series.collect::<Option<Vec<_>>>().ok_or("it refers to coefficients that it does not have")?;
        coefficients.extend([0.0; Self::PADDING]);
        let mut table = FourierTable { eta, channels, cosines, series, sums: Vec::new(), coefficients };
        table.sums = (0..angles).flat_map(|viewer| table.integrals(viewer)).collect();
        Ok(table)
    }

    /// The integrals of the mean over the azimuth, by a Catmull-Rom spline, up to each cosine (PBR3 8.6, IntegrateCatmullRom).
    fn integrals(&self, viewer: usize) -> Vec<f32> {
        let (x, n) = (&self.cosines, self.cosines.len());
        let f = |at: usize| self.mean(viewer, at);
        let mut sum = 0.0;
        let mut sums = vec![sum];
        for at in 0..n - 1 {
            let width = x[at + 1] - x[at];
            let chord = f(at + 1) - f(at);
            let before =
                if at > 0 { width * (f(at + 1) - f(at - 1)) / (x[at + 1] - x[at - 1]) } else { chord };
            let after = if at + 2 < n { width * (f(at + 2) - f(at)) / (x[at + 2] - x[at]) } else { chord };
            sum += ((before - after) * (1.0 / 12.0) + (f(at) + f(at + 1)) * 0.5) * width;
            sums.push(sum);
        }
        sums
    }

    /// The index of refraction, inside over outside.
    #[inline]
    pub fn eta(&self) -> f32 {
        self.eta
    }

    /// 1 for luminance; 3 for luminance, red and blue.
    #[inline]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The cosines of the zenith angles, increasing.
    #[inline]
    pub fn cosines(&self) -> &[f32] {
        &self.cosines
    }

    /// The place of the coefficients for a pair of cosines, by their numbers.
    #[inline]
    pub fn series(&self, viewer: usize, light: usize) -> Series {
        self.series[viewer * self.cosines.len() + light]
    }

    /// The coefficients of all series, and [`FourierTable::PADDING`] zeros.
    #[inline]
    pub fn coefficients(&self) -> &[f32] {
        &self.coefficients
    }

    /// The mean of the luminance over the azimuth, for a pair of cosines.
    #[inline]
    pub fn mean(&self, viewer: usize, light: usize) -> f32 {
        let Series { first, count } = self.series(viewer, light);
        if count == 0 { 0.0 } else { self.coefficients[first as usize] }
    }

    /// The integrals of [`FourierTable::mean`] over the cosines of the light, up to each of them.
    #[inline]
    pub fn sums(&self, viewer: usize) -> &[f32] {
        let n = self.cosines.len();
        &self.sums[viewer * n..][..n]
    }

    /// The size of the table in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.series[..])
            + size_of::<f32>() * (self.cosines.len() + self.sums.len() + self.coefficients.len())
    }
}

const TRUNCATED: &str = "it ends too early";

/// The 32-bit words of a file.
struct Words<'b>(&'b [u8]);

impl<'b> Words<'b> {
    fn take(&mut self, count: usize) -> Result<&'b [[u8; 4]], &'static str> {
        let bytes = count.checked_mul(4).ok_or(TRUNCATED)?;
        let (taken, rest) = self.0.split_at_checked(bytes).ok_or(TRUNCATED)?;
        self.0 = rest;
        Ok(taken.as_chunks().0)
    }
}

fn floats(words: &[[u8; 4]]) -> Vec<f32> {
    words.iter().map(|word| f32::from_le_bytes(*word)).collect()
}

const FILE: Key<Name> = Key::string("bsdffile", "the file of the table").required();

pub(super) const KEYS: Keys = &[&FILE];

/// The tables of a scene so far, by their files.
pub(crate) type Tables = HashMap<PathBuf, Arc<FourierTable>>;

/// The table that `bsdffile` names. `None` after an error.
pub(super) fn fourier(params: &mut Params, tables: &mut Tables) -> Option<Arc<FourierTable>> {
    let name = params.take(&FILE)?;
    let (path, bytes) = params.file(&name, Files::read_named)?;
    if let Some(table) = tables.get(&path) {
        return Some(table.clone());
    }
    // About as much as the file has.
    let charge = params.reserve(FILE.name, bytes.len())?;
    match FourierTable::from_bytes(&bytes) {
        Ok(table) => {
            charge.keep();
            let table = Arc::new(table);
            tables.insert(path, table.clone());
            Some(table)
        }
        Err(fault) => {
            let message = format!("cannot use {}: {fault}", crate::files::shown_path(&path));
            let help = "write the file again with layerlab or Mitsuba, or use Material \"matte\"";
            params.error_surely(Diagnostic::error(name.span, message).help(help));
            None
        }
    }
}
