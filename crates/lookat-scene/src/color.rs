//! Converts all colors to linear RGB, as in pbrt-v3's default build.

use std::sync::LazyLock;

use glam::{DMat3, DVec3, Vec3};
use lookat_syntax::{Diagnostic, Param, ParamType, Span, Text, Values};

use crate::files::Files;
use crate::report::Report;

/// The largest component of a color, and the largest factor of one. It is far above any light. Sums of many colors and products of
/// two fit `f32`.
pub(crate) const LARGEST: f64 = 1e18;

/// True if the components are not too large.
pub(crate) fn is_in_range(color: Vec3) -> bool {
    color.to_array().iter().all(|x| f64::from(x.abs()) <= LARGEST)
}

/// The CIE 1931 color matching functions x, y and z of the 2 degree observer, for each nanometer from 360 to 830, as tabulated by CVRL
/// and used by pbrt-v3 (spectrum.cpp).
static COLOR_MATCHING: LazyLock<Vec<Vec3>> = LazyLock::new(|| {
    let table = include_str!("cie_1931.txt").split_ascii_whitespace();
    let numbers: Vec<f32> = table.filter_map(|number| number.parse().ok()).collect();
    numbers.chunks_exact(3).map(Vec3::from_slice).collect()
});
/// The first wavelength of the table, in nanometers.
const FIRST: f64 = 360.0;
/// The integral of y over wavelength, in nanometers.
const Y_INTEGRAL: f64 = 106.856_895;

pub use lookat_image::LUMINANCE;

/// The color of a parameter. If it has several colors, the first one counts.
pub(crate) fn from_param(param: &Param, files: &Files, report: &mut Report) -> Result<Vec3, Box<Diagnostic>> {
    let at = param.values.span;
    Ok(match (&param.values.value, param.ty) {
        (Values::Triples(values), ParamType::Xyz) => from_xyz(values[0].into()),
        (Values::Triples(values), _) => DVec3::from(values[0]).as_vec3(),
        (Values::Pairs(values), _) => from_blackbody(values[0][0], values[0][1]),
        (Values::Numbers(values), _) => from_samples(values, false, at, report)?,
        (Values::Strings(names), _) => from_file(names, at, files, report)?,
        _ => Vec3::ZERO,
    })
}

/// pbrt-v3's XYZToRGB: the primaries of ITU-R BT.709.
fn from_xyz(xyz: DVec3) -> Vec3 {
    let rgb_from_xyz = DMat3::from_cols_array(&[
        3.240479, -0.969256, 0.055648, //
        -1.537150, 1.875991, -0.204043, //
        -0.498535, 0.041556, 1.057311,
    ]);
    (rgb_from_xyz * xyz).as_vec3()
}

/// The color of light with the given spectral radiance at the wavelengths of the CIE table (pbrt-v3's
/// RGBSpectrum::FromSampled). A constant 1 has a luminance of 1.
fn from_spectrum(radiance: impl Fn(f64) -> f64) -> Vec3 {
    let mut xyz = DVec3::ZERO;
    for (index, response) in COLOR_MATCHING.iter().enumerate() {
        xyz += response.as_dvec3() * radiance(FIRST + index as f64);
    }
    // pbrt-v3 divides by the number of samples, not by the number of steps between them.
    let samples = COLOR_MATCHING.len() as f64;
    from_xyz(xyz * (samples - 1.0) / (Y_INTEGRAL * samples))
}

/// A black body of the given temperature in kelvin, scaled so that its peak over wavelength is `scale`.
fn from_blackbody(kelvin: f64, scale: f64) -> Vec3 {
    if kelvin <= 0.0 {
        return Vec3::ZERO;
    }
    // Planck's law without its constant factor, which normalization removes.
    let planck = |nanometers: f64| {
        let meters = nanometers * 1e-9;
        // h c / k, CODATA 2010, as pbrt-v3.
        let exponent = 6.626_069_57e-34 * 299_792_458.0 / 1.380_648_8e-23 / (meters * kelvin);
        meters.powi(-5) / libm::expm1(exponent)
    };
    // Wien's displacement law.
    let peak = planck(2.897_772_1e-3 / kelvin * 1e9);
    // The peak overflows or underflows.
    if !peak.is_normal() {
        return Vec3::ZERO;
    }
    from_spectrum(|nanometers| planck(nanometers) / peak) * scale as f32
}

/// A spectrum of alternating wavelengths and values, in any order of wavelengths. `is_file`: true for the numbers of a file.
fn from_samples(flat: &[f64], is_file: bool, at: Span, report: &mut Report) -> Result<Vec3, Box<Diagnostic>> {
    let what = if is_file { "the file of a spectrum has" } else { "a spectrum takes" };
    let message = |given: &str| format!("{what} pairs of wavelength and value, found {given}");
    if let [] | [_] = flat {
        let given = if flat.is_empty() { "0 numbers" } else { "1 number" };
        let help = flat
            .first()
            .map(|gray| format!("for the same value at all wavelengths, write [400 {gray} 700 {gray}]"));
        let error = Diagnostic::error(at, message(given));
        return Diagnostic { help, ..error }.fail();
    }
    if flat.len() % 2 == 1 {
        let help = match flat {
            [_, _, _] if !is_file => {
                "declare red, green and blue as \"rgb\": the last number is ignored here, as in pbrt-v3"
            }
            _ => "the last number is ignored, as in pbrt-v3",
        };
        report.push(Diagnostic::warning(at, message(&format!("{} numbers", flat.len()))).help(help));
    }
    let mut samples: Vec<(f64, f64)> = flat.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(from_spectrum(|nanometers| interpolate(&samples, nanometers)))
}

/// Linear interpolation, constant outside the samples.
fn interpolate(samples: &[(f64, f64)], at: f64) -> f64 {
    let after = samples.partition_point(|(wavelength, _)| *wavelength <= at);
    match (after.checked_sub(1).map(|before| samples[before]), samples.get(after)) {
        (Some((x0, y0)), Some((x1, y1))) => y0 + (y1 - y0) * (at - x0) / (x1 - x0),
        (Some((_, y)), None) | (None, Some(&(_, y))) => y,
        (None, None) => 0.0,
    }
}

/// A spectrum from a file of numbers, separated by spaces or commas. `#` starts a comment.
fn from_file(names: &[Text], at: Span, files: &Files, report: &mut Report) -> Result<Vec3, Box<Diagnostic>> {
    let Some(name) = names.first() else {
        return Diagnostic::error(at, "a spectrum needs the name of a file").fail();
    };
    let (path, bytes) = files
        .read_named(&name.value, name.span)
        .map_err(|(path, error)| Box::new(files.unreadable("read", name, &path, &error)))?;
    report.extend(files.not_found_by_pbrt(name, &path));
    let text = String::from_utf8_lossy(&bytes);
    let mut numbers = Vec::new();
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let refused = |what: String| {
            let message = format!("{} line {}: {what}", path.display(), index + 1);
            Diagnostic::error(name.span, message)
        };
        if let Some(word) = decimal_comma(line) {
            let help = "use a decimal point: 0.5";
            return refused(format!("pbrt reads `{word}` as two numbers")).help(help).fail();
        }
        for word in line.split([' ', '\t', ',']).filter(|word| !word.is_empty()) {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                _ => return refused(format!("`{word}` is not a number")).fail(),
            }
        }
    }
    from_samples(&numbers, true, name.span, report)
}

/// A word with a decimal comma in a line that has other words without commas, such as `400 0,5`.
fn decimal_comma(line: &str) -> Option<&str> {
    let is_whole = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let is_decimal =
        |word: &&str| word.split_once(',').is_some_and(|(whole, rest)| is_whole(whole) && is_whole(rest));
    let mut words = line.split_ascii_whitespace();
    let has_plain = words.clone().any(|word| !word.contains(','));
    if has_plain { words.find(is_decimal) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vec3, b: [f32; 3]) {
        assert!((a - Vec3::from(b)).abs().max_element() < 2e-3, "{a} {b:?}");
    }

    #[test]
    fn equal_energy_is_nearly_white() {
        // pbrt-v3 prints these for Spectrum::FromSampled of a constant 1.
        near(from_spectrum(|_| 1.0), [1.2022, 0.9465, 0.9068]);
    }

    #[test]
    fn hot_bodies_are_blue_and_cool_ones_red() {
        let (hot, cool) = (from_blackbody(10000.0, 1.0), from_blackbody(2700.0, 1.0));
        assert!(hot.z > hot.x && cool.x > 3.0 * cool.z, "{hot} {cool}");
        assert_eq!(from_blackbody(0.0, 1.0), Vec3::ZERO);
    }

    #[test]
    fn spectra_are_interpolated_between_their_samples() {
        let samples = [(400.0, 1.0), (500.0, 3.0)];
        assert_eq!(
            [300.0, 400.0, 450.0, 500.0, 600.0].map(|at| interpolate(&samples, at)),
            [1.0, 1.0, 2.0, 3.0, 3.0]
        );
    }
}
