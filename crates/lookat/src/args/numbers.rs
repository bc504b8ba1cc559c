//! Parsers of numbers and names in options.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use lookat_scene::MAX_SIDE;

use crate::failure::Failure;

/// Finds a name among all, or fails with the list.
pub fn named<T>(
    found: Option<T>,
    what: &str,
    names: impl IntoIterator<Item = &'static str>,
) -> Result<T, Failure> {
    let names = || names.into_iter().collect::<Vec<_>>().join(", ");
    found.ok_or_else(|| format!("the {what} are {}", names()).into())
}

pub fn resolution(text: &str) -> Result<[u32; 2], Failure> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| format!("expected width and height from 1 to {MAX_SIDE} pixels, as in 640x480").into())
}

/// A number of the command line.
pub trait Number: FromStr + PartialOrd + Copy + Send + Sync + 'static {}

impl<T: FromStr + PartialOrd + Copy + Send + Sync + 'static> Number for T {}

/// Parses a number in a range.
pub fn number_in<T: Number>(
    range: RangeInclusive<T>,
    expected: &str,
) -> impl Fn(&str) -> Result<T, Failure> + Clone + use<T> {
    let expected = format!("expected {expected}");
    move |text| text.parse().ok().filter(|number| range.contains(number)).ok_or(expected.as_str().into())
}

/// Parses a whole number from `least` to `most`.
pub fn whole<T: Number + Display>(least: T, most: T) -> impl Fn(&str) -> Result<T, Failure> + Clone + use<T> {
    number_in(least..=most, &format!("a whole number from {least} to {most}"))
}

pub fn stops(text: &str) -> Result<f64, Failure> {
    number_in(-100.0..=100.0, "a number from -100 to 100")(text)
}
