//! Exposure and tone curves, which fit linear values to the range of 8-bit formats.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::array::from_fn;

use crate::{Image, luminance};

/// A curve from linear values of any size to linear values from 0 to 1. Each maps 0 to 0 and does not decrease.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ToneCurve {
    /// No curve: values above 1 clip.
    #[default]
    None,
    /// Equation 4 of Reinhard et al., "Photographic Tone Reproduction for Digital Images" (2002): L (1 + L / W²) / (1 + L)
    /// of the luminance L, which keeps the ratios of the channels. The luminance W that becomes white is `WHITE` in every
    /// picture, so that frames and crops match.
    Reinhard,
    /// The fit of the ACES reference curve by Krzysztof Narkowicz, "ACES Filmic Tone Mapping Curve" (2016), for each
    /// channel. It maps 1 to about 0.8.
    Aces,
    /// The Khronos PBR Neutral tone mapper (specification of 2024). It keeps colors up to 0.8, less an offset of at most
    /// 0.04, and compresses brighter ones towards white without a change of hue.
    Neutral,
}

impl ToneCurve {
    /// All curves with their names.
    pub const ALL: [(&str, ToneCurve); 4] = [
        ("none", ToneCurve::None),
        ("reinhard", ToneCurve::Reinhard),
        ("aces", ToneCurve::Aces),
        ("neutral", ToneCurve::Neutral),
    ];
}

/// The luminance that [`ToneCurve::Reinhard`] maps to 1: two stops above white.
const WHITE: f32 = 4.0;

/// Larger values count as this one, so that no curve overflows.
const MOST: f32 = 1e6;

/// Fits linear values to 8 bits: by an exposure, then by a curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ToneMapping {
    /// The exposure in stops: each stop doubles all values. 0 by default.
    pub exposure: f64,
    /// The curve, applied after the exposure.
    pub curve: ToneCurve,
}

impl ToneMapping {
    /// The function of a pixel. Values above 1 clip in 8 bits. NaN stays NaN without a curve and becomes 0 with one.
    pub fn function(self) -> impl Fn([f32; 3]) -> [f32; 3] + Sync {
        let gain = libm::exp2(self.exposure) as f32;
        move |pixel| {
            let exposed = pixel.map(|value| value * gain);
            // NaN becomes 0.
            let bounded = exposed.map(|value| if value > 0.0 { value.min(MOST) } else { 0.0 });
            match self.curve {
                ToneCurve::None => exposed,
                ToneCurve::Reinhard => reinhard(bounded),
                ToneCurve::Aces => bounded.map(aces),
                ToneCurve::Neutral => neutral(bounded),
            }
        }
    }

    /// Maps the channels that a format without channel names shows: R, G and B, or else Y or the only channel. Changes
    /// nothing if the picture has none of these.
    pub fn apply(self, image: &mut Image) {
        let Ok(places) = image.visible_channels() else { return };
        if self == ToneMapping::default() {
            return;
        }
        let function = self.function();
        for i in 0..image.data_window.area() as usize {
            let mapped = function(from_fn(|c| image.channels[places[c % places.len()]].samples[i]));
            for (place, value) in places.iter().zip(mapped) {
                image.channels[*place].samples[i] = value;
            }
        }
    }
}

fn reinhard(pixel: [f32; 3]) -> [f32; 3] {
    let luminance = luminance(pixel);
    pixel.map(|value| value * (1.0 + luminance / (WHITE * WHITE)) / (1.0 + luminance))
}

fn aces(x: f32) -> f32 {
    let value = (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
    value.min(1.0)
}

fn neutral(pixel: [f32; 3]) -> [f32; 3] {
    /// The reflectance of glass at normal incidence.
    const F90: f32 = 0.04;
    /// The peak at which compression starts.
    const START: f32 = 0.8 - F90;
    const DESATURATION: f32 = 0.15;
    let least = pixel.into_iter().fold(f32::INFINITY, f32::min);
    let offset = if least <= 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let pixel = pixel.map(|value| value - offset);
    let peak = pixel.into_iter().fold(0.0, f32::max);
    if peak <= START {
        return pixel;
    }
    let new_peak = 1.0 - (1.0 - START) * (1.0 - START) / (peak + 1.0 - 2.0 * START);
    let kept = 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    pixel.map(|value| value * new_peak / peak * kept + new_peak * (1.0 - kept))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Window;

    fn gray(curve: ToneCurve, value: f32) -> f32 {
        let [r, g, b] = ToneMapping { exposure: 0.0, curve }.function()([value; 3]);
        assert!((r - g).abs() <= 1e-6 && (r - b).abs() <= 1e-6, "{curve:?} {value}");
        r
    }

    #[track_caller]
    fn close(found: [f32; 3], expected: [f32; 3]) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
    }

    #[test]
    fn curves_begin_at_0_do_not_decrease_and_take_any_value() {
        for (name, curve) in ToneCurve::ALL {
            assert_eq!(gray(curve, 0.0), 0.0, "{name}");
            let ramp: Vec<f32> =
                (0..4000).map(|i| gray(curve, 1e-4 * (f64::from(i) / 200.0).exp() as f32)).collect();
            // But for rounding.
            assert!(ramp.windows(2).all(|pair| pair[1] >= pair[0] - f32::EPSILON), "{name}");
            let function = ToneMapping { exposure: 100.0, curve }.function();
            let bright = function([f32::INFINITY, f32::MAX, 1.0]);
            assert!(bright.iter().all(|value| *value > 0.99), "{name}: {bright:?}");
            assert!(function([-1.0, 0.0, -f32::MAX]).iter().all(|value| *value <= 0.0), "{name}");
        }
    }

    /// Equation 4: W becomes 1, and 1 becomes half of 1 + 1 / W².
    #[test]
    fn reinhard_maps_white_to_1_and_keeps_ratios() {
        assert!((gray(ToneCurve::Reinhard, WHITE) - 1.0).abs() < 1e-6);
        assert!((gray(ToneCurve::Reinhard, 1.0) - 0.5 * (1.0 + 1.0 / 16.0)).abs() < 1e-6);
        let [r, g, b] = reinhard([0.2, 0.4, 1.6]);
        assert!((g / r - 2.0).abs() < 1e-5 && (b / g - 4.0).abs() < 1e-5);
    }

    /// "1 on input maps to ~0.8 on output", and the fit at 0.18, by hand: 0.086724 / 0.324932.
    #[test]
    fn aces_maps_1_to_four_fifths() {
        assert!((gray(ToneCurve::Aces, 1.0) - 0.8038).abs() < 1e-4);
        assert!((gray(ToneCurve::Aces, 0.18) - 0.086_724 / 0.324_932).abs() < 1e-6);
        assert_eq!(gray(ToneCurve::Aces, 100.0), 1.0);
    }

    /// The notes of the specification, and its equations by hand.
    #[test]
    fn neutral_keeps_base_colors_less_an_offset() {
        close(neutral([0.08, 0.3, 0.8]), [0.04, 0.26, 0.76]);
        close(neutral([0.04; 3]), [0.01; 3]);
        // p = 0.96 and p_n = 1 - 0.0576 / 0.44 for a gray of 1.
        close(neutral([1.0; 3]), [1.0 - 0.0576 / 0.44; 3]);
        // p = 2 and p_n = 1 - 0.0576 / 1.48, so g = 1 / (0.15 (p - p_n) + 1).
        let (peak, kept) = (1.0 - 0.0576 / 1.48, 1.0 / (0.15 * (1.0 + 0.0576 / 1.48) + 1.0));
        close(neutral([2.0, 0.0, 1.0]), [peak, peak * (1.0 - kept), peak * (0.5 * kept + 1.0 - kept)]);
    }

    #[test]
    fn visible_channels_are_mapped_and_others_stay() {
        let window = Window { x: 3, y: 4, width: 2, height: 1 };
        let mut image = Image::from_rgb(window, window, &[[0.1, 0.2, 0.3], [1.0, 2.0, f32::INFINITY]]);
        let mut depth = image.channels[0].clone();
        depth.name = "Z".into();
        image.channels.insert(0, depth.clone());
        ToneMapping { exposure: -1.0, ..ToneMapping::default() }.apply(&mut image);
        assert_eq!(image.channels[0], depth);
        assert_eq!(image.rgb().unwrap(), [[0.05, 0.1, 0.15], [0.5, 1.0, f32::INFINITY]]);
        // Gray, and nothing to see.
        image.channels.truncate(1);
        ToneMapping { exposure: 3.0, ..ToneMapping::default() }.apply(&mut image);
        assert_eq!(image.channels[0].samples, [0.8, 8.0]);
        image.channels.push(image.channels[0].clone());
        let before = image.clone();
        ToneMapping { exposure: 3.0, ..ToneMapping::default() }.apply(&mut image);
        assert_eq!(image, before);
    }
}
