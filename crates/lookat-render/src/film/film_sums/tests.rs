//! Sums that add up, and their form in files.

use super::*;
use crate::film::SumsHeader;
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
        assert_eq!(sums.image(true), *image);
        assert!(sums.all.counts.iter().all(|count| *count == 5));
    }
    let sum = |order: [usize; 3]| {
        let mut sum = parts[order[0]].0.clone();
        order[1..].iter().for_each(|part| sum.add(&parts[*part].0).unwrap());
        sum
    };
    let all = sum([0, 1, 2]);
    assert_eq!(all, sum([2, 0, 1]));
    assert!(all.all.counts.iter().all(|count| *count == 15));
    let means = |image: &Image| -> f64 {
        image.channels.iter().flat_map(|channel| &channel.samples).map(|value| f64::from(*value)).sum()
    };
    let mean = parts.iter().map(|(_, image)| means(image)).sum::<f64>() / 3.0;
    assert!((means(&all.image(true)) / mean - 1.0).abs() < 1e-3);
}

/// The sums of any number of parts add up to those of the whole, bit for bit.
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
    sums.all.counts[7] += 3;
    let (header, mut channels) = sums.clone().into_channels();
    assert_eq!(header.samples(), None);
    let bytes = header.to_bytes();
    let read = |bytes: &[u8]| FilmSums::from_channels(SumsHeader::from_bytes(bytes)?, &channels);
    assert_eq!(read(&bytes), Ok(sums));
    for bad in [&bytes[..bytes.len() / 2], &bytes[1..], b"", b"PF\n8 8\n"] {
        assert_eq!(read(bad), Err(FilmSumsError::Unreadable));
    }
    // Without the lowest word of one color, it is none of these files.
    for at in 0..channels.len() {
        let name = std::mem::replace(&mut channels[at].name, "sums.other".into());
        let found = FilmSums::from_channels(header.clone(), &channels);
        assert_eq!(found.is_err(), name.ends_with(".0"), "{name}");
        channels[at].name = name;
    }
    let read = |bytes: &[u8]| FilmSums::from_channels(SumsHeader::from_bytes(bytes)?, &channels);
    // Damaged bytes never panic.
    for (at, bit) in (0..bytes.len()).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
        let mut bad = bytes.clone();
        bad[at] ^= 1 << bit;
        if let Ok(sums) = read(&bad) {
            sums.image(true);
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
    full.all.counts[7] = u32::MAX;
    assert_eq!(own.add(&full), Err(FilmSumsError::TooManySamples));
    assert_eq!(own, before);
}
