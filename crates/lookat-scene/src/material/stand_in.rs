//! Stand-ins for unsupported materials: the nearest supported material with the same mean color.

use glam::Vec3;

use crate::material::models::gray;
use crate::material::{MaterialKind, Matte, Roughness, Translucent, subsurface};
use crate::params::Params;
use crate::params::value::Name;
use crate::schema::{Key, Keys};
use crate::texture::Texture;

pub(super) fn stand_in(params: &mut Params) -> MaterialKind {
    let (replacement, material) = match params.kind() {
        "kdsubsurface" => ("\"uber\" with the same Kd and index", subsurface::of_color(params)),
        "subsurface" => (
            "\"uber\" with the same index and the diffuse color of the coefficients",
            subsurface::of_coefficients(params),
        ),
        "fourier" => fourier(params),
        other => unreachable!("material::material has no arm for {other}"),
    };
    let message =
        format!("lookat does not support Material \"{}\": it renders {replacement} instead", params.kind());
    params.unsupported(message);
    material
}

/// A distribution of normals of this width.
fn width(width: f64) -> Roughness {
    Roughness { u: Texture::Constant(width), v: None, remap: false }
}

fn matte(kd: Texture<Vec3>) -> MaterialKind {
    MaterialKind::Matte(Matte { kd, sigma: Texture::Constant(0.0) })
}

// `fourier` as a diffuse surface of the mean color that its table of coefficients gives (FourierBSDFTable in
// core/reflection.cpp).

const FILE: Key<Name> =
    Key::string("bsdffile", "the file of the scattering table; without it, the surface is gray");

pub(in crate::material) const FOURIER_KEYS: Keys = &[&FILE];

/// Shares of diffuse light.
#[derive(Debug, PartialEq)]
struct Albedo {
    reflected: Vec3,
    transmitted: Vec3,
}

pub(super) fn fourier(params: &mut Params) -> (&'static str, MaterialKind) {
    let file = params.take(&FILE).and_then(|name| params.file_if_readable(&name));
    let Some(albedo) = file.and_then(|bytes| albedo(&bytes)) else {
        return ("gray \"matte\"", matte(gray(0.5)));
    };
    let reflected = Texture::Constant(albedo.reflected);
    if albedo.transmitted.max_element() <= 0.0 {
        return ("\"matte\" with the same mean color", matte(reflected));
    }
    let transmit = Texture::Constant(albedo.transmitted);
    let [kd, ks] = [gray(1.0), gray(0.0)];
    let sheet = Translucent { kd, ks, reflect: reflected, transmit, roughness: width(1.0) };
    ("\"translucent\" with the same mean color", MaterialKind::Translucent(sheet))
}

/// The numbers of a file, in order.
struct Numbers<'b>(&'b [u8]);

impl<'b> Numbers<'b> {
    /// The next words. They stay in the file: it is large, and few of them are used.
    fn words(&mut self, count: usize) -> Option<&'b [[u8; 4]]> {
        let (taken, rest) = self.0.split_at_checked(count.checked_mul(4)?)?;
        self.0 = rest;
        Some(taken.as_chunks().0)
    }
}

fn count(word: &[u8; 4]) -> Option<usize> {
    usize::try_from(i32::from_le_bytes(*word)).ok()
}

/// The albedo of the front, the mean over directions. `None` of a file that is no such table.
fn albedo(bytes: &[u8]) -> Option<Albedo> {
    let mut numbers = Numbers(bytes.strip_prefix(b"SCATFUN\x01")?);
    let header = numbers.words(6)?.iter().map(count).collect::<Option<Vec<_>>>()?;
    let [flags, angles, coefficients, _, channels, bases] = header[..] else { return None };
    // The only kind of table that pbrt-v3 takes.
    if flags != 1 || ![1, 3].contains(&channels) || bases != 1 || angles < 2 {
        return None;
    }
    // Three unused words, the index of refraction and four more unused words.
    numbers.words(8)?;
    let cosines = numbers.words(angles)?;
    let cosine = |at: usize| f32::from_le_bytes(cosines[at]);
    let pairs = angles.checked_mul(angles)?;
    numbers.words(pairs)?;
    let places = numbers.words(pairs.checked_mul(2)?)?;
    let table = numbers.words(coefficients)?;
    // The mean over the azimuth of what one pair of cosines scatters, times the cosine of the light.
    let mean = |out: usize, light: usize| {
        let [first, orders] = [0, 1].map(|at| count(&places[2 * (out * angles + light) + at]));
        let (first, orders) = (first?, orders?);
        let of = |channel: usize| {
            let word = table.get(first + channel * orders);
            if orders == 0 { Some(0.0) } else { word.map(|word| f32::from_le_bytes(*word)) }
        };
        let luminance = of(0)?;
        if channels == 1 {
            return Some(Vec3::splat(luminance));
        }
        let [red, blue] = [of(1)?, of(2)?];
        // The file has luminance, red and blue.
        Some(Vec3::new(red, 1.39829 * luminance - 0.100913 * blue - 0.297375 * red, blue))
    };
    let width = |at: usize| 0.5 * (cosine((at + 1).min(angles - 1)) - cosine(at.saturating_sub(1)));
    let (mut reflected, mut transmitted) = (Vec3::ZERO, Vec3::ZERO);
    for out in (0..angles).filter(|out| cosine(*out) > 0.0) {
        for light in 0..angles {
            // 2 cos is the density of directions from the front, 2 pi the integral over the azimuth of the light.
            let weight = std::f32::consts::TAU * width(light) * 2.0 * cosine(out) * width(out);
            let scattered = mean(out, light)? * weight;
            // In such tables light that is reflected has the other sign.
            let sum = if cosine(light) < 0.0 { &mut reflected } else { &mut transmitted };
            *sum += scattered;
        }
    }
    let in_range = |sum: Vec3| sum.is_finite().then(|| sum.clamp(Vec3::ZERO, Vec3::ONE));
    Some(Albedo { reflected: in_range(reflected)?, transmitted: in_range(transmitted)? })
}

#[cfg(test)]
mod tests {
    mod stand_in {
        use std::path::Path;

        use super::super::*;

        /// The material of a sphere after a directive.
        fn material(directive: &str) -> MaterialKind {
            let scene = format!("WorldBegin\n{directive}\nShape \"sphere\"\nWorldEnd");
            let read = |_: &Path| Ok(scene.clone().into_bytes());
            let loaded = crate::load(Path::new("a.pbrt"), &read, &Default::default());
            loaded.scene.unwrap().world.primitives[0].material.kind.clone()
        }

        #[track_caller]
        fn diffuse(directive: &str) -> Vec3 {
            match material(directive) {
                MaterialKind::Matte(matte) => matte.kd.constant().unwrap(),
                MaterialKind::Uber(uber) => uber.kd.constant().unwrap(),
                other => panic!("{other:?}"),
            }
        }

        #[test]
        fn media_have_the_color_of_their_coefficients() {
            let ketchup = diffuse("Material \"subsurface\" \"string name\" \"Ketchup\" \"float eta\" 1.3");
            assert!(ketchup.x < 0.2 && ketchup.x > 10.0 * ketchup.z, "{ketchup}");
            let black = diffuse("Material \"subsurface\" \"rgb sigma_s\" [0 0 0]");
            assert_eq!(black, Vec3::ZERO);
            let kd = diffuse("Material \"kdsubsurface\" \"rgb Kd\" [0.8 0.4 0.2]");
            assert!(kd.y > 0.36 && kd.y < 0.4 && (kd.x - 2.0 * kd.y).abs() < 1e-6, "{kd}");
        }
    }
    mod fourier {
        use super::super::*;

        /// A table of a diffuse surface whose front reflects shares of red, green and blue.
        fn table(color: [f32; 3]) -> Vec<u8> {
            const ANGLES: usize = 40;
            let cosine = |at: usize| 2.0 * at as f32 / (ANGLES - 1) as f32 - 1.0;
            let [red, green, blue] = color;
            let luminance = (green + 0.100913 * blue + 0.297375 * red) / 1.39829;
            let (mut places, mut values) = (Vec::new(), Vec::new());
            for out in 0..ANGLES {
                for light in 0..ANGLES {
                    let is_reflected = cosine(out) > 0.0 && cosine(light) < 0.0;
                    places.extend([values.len() as i32, i32::from(is_reflected)]);
                    if is_reflected {
                        let of = |albedo: f32| albedo / std::f32::consts::PI * cosine(light).abs();
                        values.extend([luminance, red, blue].map(of));
                    }
                }
            }
            let header = [1, ANGLES as i32, values.len() as i32, 1, 3, 1, 0, 0, 0];
            let floats =
                |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
            let counts =
                |values: &[i32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
            let cosines: Vec<f32> = (0..ANGLES).map(cosine).collect();
            [
                b"SCATFUN\x01".to_vec(),
                counts(&header),
                floats(&[1.0, 0.0, 0.0, 0.0, 0.0]),
                floats(&cosines),
                floats(&[0.0; ANGLES * ANGLES]),
                counts(&places),
                floats(&values),
            ]
            .concat()
        }

        #[test]
        fn the_mean_color_is_that_of_the_table() {
            let found = albedo(&table([0.8, 0.4, 0.1])).unwrap();
            assert!((found.reflected - Vec3::new(0.8, 0.4, 0.1)).abs().max_element() < 0.02, "{found:?}");
            assert_eq!(found.transmitted, Vec3::ZERO);
        }

        #[test]
        fn unused_words_may_have_any_value() {
            let table = table([0.5; 3]);
            for word in [6, 7, 8, 9, 10, 11, 12, 13] {
                let mut other = table.clone();
                other[8 + 4 * word..][..4].fill(0xff);
                assert_eq!(albedo(&other), albedo(&table), "word {word}");
            }
        }

        #[test]
        fn damaged_tables_have_no_color() {
            let whole = table([0.5; 3]);
            for length in (0..whole.len()).step_by(97) {
                assert_eq!(albedo(&whole[..length]), None);
            }
            for at in 8..44 {
                let mut damaged = whole.clone();
                damaged[at] = 0xff;
                let shares = albedo(&damaged).map(|albedo| albedo.reflected + albedo.transmitted);
                assert!(
                    shares.is_none_or(|shares| shares.min_element() >= 0.0 && shares.max_element() <= 2.0)
                );
            }
        }
    }
}
