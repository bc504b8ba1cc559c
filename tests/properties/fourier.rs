//! Material `fourier`: tables computed here, and damaged ones.

use std::io;
use std::path::Path;

use lookat_scene::{FourierTable, LoadOptions, load};

use crate::albedo::{near, of_sheet_with};

/// What a table has for the cosines of the viewer and of the direction of travel of light, and the cosine of the azimuth between them: red,
/// green and blue of the BSDF.
type Bsdf = fn(f64, f64, f64) -> [f64; 3];

/// The cosine between two directions of these cosines and this cosine of the azimuth between them.
fn between(o: f64, i: f64, cos_phi: f64) -> f64 {
    ((1.0 - o * o) * (1.0 - i * i)).sqrt() * cos_phi + o * i
}

/// Painted wood under a lacquer: diffuse light, and a gloss around the mirrored direction.
fn lacquer(o: f64, i: f64, cos_phi: f64) -> [f64; 3] {
    if o * i > 0.0 {
        return [0.0; 3];
    }
    let gloss = 0.8 * (15.0 * (between(o, -i, cos_phi) - 1.0)).exp();
    [0.5, 0.2, 0.1].map(|color| color / std::f64::consts::PI + gloss)
}

/// Paper: light that goes through keeps its direction a little.
fn paper(o: f64, i: f64, cos_phi: f64) -> [f64; 3] {
    if o * i < 0.0 {
        return [0.45 / std::f64::consts::PI; 3];
    }
    [0.15 + 0.4 * (6.0 * (between(o, i, cos_phi) - 1.0)).exp(); 3].map(|f| 0.6 * f)
}

/// A diffuse surface of one color on both sides.
fn diffuse(o: f64, i: f64, _: f64) -> [f64; 3] {
    if o * i > 0.0 { [0.0; 3] } else { [0.8, 0.4, 0.1].map(|color| color / std::f64::consts::PI) }
}

/// The bytes of a table with cosines that are closer near the horizon and along the normal, as in the scenes' tables.
fn table(bsdf: Bsdf, channels: usize, half: usize) -> Vec<u8> {
    let positive = (0..half).map(|at| {
        let x = (at as f64 + 0.2) / (half as f64 - 0.8);
        0.5 * (x + x * x * (3.0 - 2.0 * x))
    });
    let positive: Vec<f32> = positive.map(|cosine| cosine as f32).collect();
    let cosines: Vec<f32> =
        positive.iter().rev().map(|cosine| -cosine).chain(positive.iter().copied()).collect();
    table_of(bsdf, channels, &cosines)
}

/// The bytes of a table.
fn table_of(bsdf: Bsdf, channels: usize, cosines: &[f32]) -> Vec<u8> {
    // The sides of the surface at 0 and -0.
    let on_side = |cosine: f32| f64::from(if cosine == 0.0 { 1e-9_f32.copysign(cosine) } else { cosine });
    let (mut places, mut coefficients) = (Vec::new(), Vec::new());
    for o in cosines {
        for i in cosines {
            let series = series(bsdf, on_side(*o), on_side(*i), channels);
            places.extend([coefficients.len() as i32, (series.len() / channels) as i32]);
            coefficients.extend(series);
        }
    }
    let mut file = file(cosines, &places, &coefficients, channels);
    let read = FourierTable::from_bytes(&file).unwrap();
    let sums: Vec<u8> =
        (0..cosines.len()).flat_map(|o| read.sums(o)).flat_map(|sum| sum.to_le_bytes()).collect();
    file[64 + 4 * cosines.len()..][..sums.len()].copy_from_slice(&sums);
    file
}

/// The Fourier series of all channels, times the cosine of the light, without small coefficients at the end.
fn series(bsdf: Bsdf, o: f64, i: f64, channels: usize) -> Vec<f32> {
    const STEPS: usize = 128;
    let angle = |step: usize| std::f64::consts::TAU * (step as f64 + 0.5) / STEPS as f64;
    let of = |channel: usize, order: usize| {
        let one = |step: usize| {
            let [red, green, blue] = bsdf(o, i, angle(step).cos());
            let luminance = (green + 0.100913 * blue + 0.297375 * red) / 1.39829;
            [luminance, red, blue][channel] * (order as f64 * angle(step)).cos()
        };
        let mean = (0..STEPS).map(one).sum::<f64>() / STEPS as f64;
        (if order == 0 { mean } else { 2.0 * mean }) * i.abs()
    };
    let all: Vec<Vec<f64>> =
        (0..channels).map(|channel| (0..24).map(|order| of(channel, order)).collect()).collect();
    let least = 3e-4 * all[0][0].abs();
    let count =
        all.iter().map(|all| all.iter().rposition(|value| value.abs() > least).map_or(0, |at| at + 1));
    let count = count.max().unwrap();
    all.iter().flat_map(|all| &all[..count]).map(|value| *value as f32).collect()
}

fn file(cosines: &[f32], places: &[i32], coefficients: &[f32], channels: usize) -> Vec<u8> {
    let angles = cosines.len();
    let most = places.chunks(2).map(|place| place[1]).max().unwrap();
    let header = [1, angles as i32, coefficients.len() as i32, most, channels as i32, 1, 0, 0, 0];
    let integers = |all: &[i32]| all.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let floats = |all: &[f32]| all.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    [
        b"SCATFUN\x01".to_vec(),
        integers(&header),
        floats(&[1.0, 0.0, 0.0, 0.0, 0.0]),
        floats(cosines),
        floats(&vec![0.0; angles * angles]),
        integers(places),
        floats(coefficients),
    ]
    .concat()
}

/// `UPDATE_EXPECTED=1` writes them.
#[test]
fn tables_of_scenes_are_computed_here() {
    for (name, bsdf, channels) in [("lacquer", lacquer as Bsdf, 3), ("paper", paper, 1)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes/materials");
        let path = path.join(name).with_extension("bsdf");
        let computed = table(bsdf, channels, 9);
        if std::env::var_os("UPDATE_EXPECTED").is_some() {
            std::fs::write(&path, &computed).unwrap();
        }
        let [stored, computed] =
            [std::fs::read(path).unwrap(), computed].map(|bytes| FourierTable::from_bytes(&bytes).unwrap());
        assert_eq!(stored.cosines(), computed.cosines(), "{name}");
        for (o, i) in (0..18).flat_map(|o| (0..18).map(move |i| (o, i))) {
            assert_eq!(stored.series(o, i), computed.series(o, i), "{name}");
        }
        // Other platforms have other functions.
        let mut pairs = stored.coefficients().iter().zip(computed.coefficients());
        assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-5), "{name}");
    }
}

/// A diffuse table has the albedo that it was made with.
#[test]
fn a_diffuse_table_reflects_its_color() {
    // As layerlab makes tables, the second has 0 twice.
    let twice = [-1.0, -0.9, -0.7, -0.4, -0.2, -0.0, 0.0, 0.2, 0.4, 0.7, 0.9, 1.0];
    for bytes in [table(diffuse, 3, 9), table_of(diffuse, 3, &twice)] {
        let open = |_: &Path| Ok(bytes.clone());
        near(of_sheet_with(r#""fourier" "string bsdffile" "a.bsdf""#, &open), [0.8, 0.4, 0.1], 0.004);
    }
    let thrice = [-1.0, -0.0, 0.0, 0.0, 1.0];
    let integers = [0; 50];
    let refused = fault(&file(&thrice, &integers, &[], 1));
    assert_eq!(refused.unwrap(), "its cosines do not increase from -1 to 1");
}

/// The error about a table, without its beginning.
fn fault(bytes: &[u8]) -> Option<String> {
    FourierTable::from_bytes(bytes).err()
}

#[test]
fn damaged_tables_are_explained() {
    let whole = table(diffuse, 3, 3);
    let with = |at: usize, word: [u8; 4]| {
        let mut damaged = whole.clone();
        damaged[at..at + 4].copy_from_slice(&word);
        fault(&damaged).unwrap_or_default()
    };
    let integer = |at: usize, value: i32| with(at, value.to_le_bytes());
    let number = |at: usize, value: f32| with(at, value.to_le_bytes());
    assert_eq!(fault(&whole), None);
    assert_eq!(fault(b"").unwrap(), "it does not start with SCATFUN");
    assert_eq!(fault(b"SCATFUN\x02").unwrap(), "its version is not 1");
    assert!(integer(8, 3).contains("flags 3"));
    assert!(integer(12, -1).contains("-1 angles") && integer(12, 1).contains("1 angles"));
    assert_eq!(integer(12, i32::MAX), "it ends too early");
    assert_eq!(integer(16, i32::MAX), "it ends too early");
    assert!(integer(24, 2).contains("2 channels") && integer(28, 4).contains("4 basis functions"));
    assert!(number(44, f32::NAN).contains("index of refraction is NaN") && number(44, 0.0).contains("is 0"));
    // The cosines, the places of the coefficients, and these themselves.
    for cosine in [f32::NAN, 5.0, -1.0] {
        assert_eq!(number(64 + 4, cosine), "its cosines do not increase from -1 to 1");
    }
    let places = 64 + 4 * (6 + 36);
    let reflected = places + 8 * 3;
    for (at, value) in
        [(reflected, -1), (reflected, i32::MAX), (reflected + 4, i32::MAX), (reflected + 4, -3)]
    {
        assert_eq!(integer(at, value), "it refers to coefficients that it does not have");
    }
    assert!(number(whole.len() - 4, f32::INFINITY).contains("no finite number"));
    for length in (0..whole.len()).step_by(7) {
        assert!(fault(&whole[..length]).is_some(), "{length}");
    }
}

/// Whatever a file has, it renders or is refused.
#[test]
fn any_table_is_read_or_refused() {
    let whole = table(lacquer, 3, 3);
    for at in 0..whole.len().min(2000) {
        for byte in [0, 0x7f, 0xff] {
            let mut damaged = whole.clone();
            damaged[at] = byte;
            let _ = FourierTable::from_bytes(&damaged);
        }
    }
    for bytes in [table(diffuse, 3, 2), b"SCATFUN\x01".to_vec()] {
        let scene = r#"WorldBegin Material "fourier" "string bsdffile" "a.bsdf" Shape "sphere" WorldEnd"#;
        let read = |path: &Path| -> io::Result<Vec<u8>> {
            Ok(if path.ends_with("a.bsdf") { bytes.clone() } else { scene.into() })
        };
        let loaded = load(Path::new("a.pbrt"), &read, &LoadOptions::default());
        assert_eq!(loaded.scene.is_some(), bytes.len() > 8);
    }
}
