//! Reads decimal numbers many digits at a time, and long lists of them: most of a large scene is numbers.

use crate::param::Values;

pub(crate) type Input<'a> = &'a [u8];

pub(crate) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | b'\n')
}

/// True for bytes that end a word. A `#` inside a word does not start a comment, as in pbrt-v3.
pub(crate) fn is_delimiter(byte: u8) -> bool {
    is_blank(byte) || matches!(byte, b'"' | b'[' | b']')
}

/// True if a number can end before `rest`.
#[inline]
pub(crate) fn ends_number(rest: Input) -> bool {
    rest.first().is_none_or(|byte| is_delimiter(*byte) || *byte == b',')
}

/// The number at the start of the text, such as `-1.5e-3`, to the nearest `f64`, and its length in bytes. The caller
/// checks the following byte. `None` without a number, and for a number beyond the range of `f64`.
#[inline(always)]
pub fn decimal(text: &[u8]) -> Option<(f64, usize)> {
    short(text).or_else(|| long(text))
}

/// Reads a number of at most 15 bytes without exponent. Does not branch on the number of digits or on the sign, which
/// the processor cannot predict.
#[inline(always)]
fn short(text: &[u8]) -> Option<(f64, usize)> {
    let word = u128::from_le_bytes(*text.first_chunk()?);
    let sign = usize::from(text[0] == b'-');
    // Bit 16 and 17 end a number that fills the word.
    let others = (non_digits(word) | 3 << 16) & !(sign as u32);
    let point = others.trailing_zeros() as usize;
    let dotted = text.get(point) == Some(&b'.');
    let end = if dotted { (others & (others - 1)).trailing_zeros() as usize } else { point };
    let length = end - usize::from(dotted);
    if length == sign || end > 15 || matches!(text[end], b'e' | b'E') {
        return None;
    }
    // Removes the sign and the point, then shifts the digits to the last places, after zeros.
    let digits = word & !(0xFF * sign as u128);
    let whole = (1 << (8 * point)) - 1;
    let digits = if dotted { digits & whole | digits >> 8 & !whole } else { digits };
    let digits = digits << (128 - 8 * length);
    let mantissa = eight(digits as u64) * 100_000_000 + eight((digits >> 64) as u64);
    // 15 digits and a power of ten up to 1e15 are exact in f64, so that the division rounds once.
    Some((mantissa as f64 * [1.0, -1.0][sign] / POWERS[length - point.min(length)], end))
}

/// Reads any number.
#[inline(never)]
fn long(text: &[u8]) -> Option<(f64, usize)> {
    let (mantissa, scale, length) = parts(text)?;
    let value = match mantissa.and_then(|mantissa| exact(mantissa, scale)) {
        Some(value) if text[0] == b'-' => -value,
        Some(value) => value,
        None => std::str::from_utf8(&text[..length]).ok()?.parse().ok()?,
    };
    value.is_finite().then_some((value, length))
}

/// The digits of a number as an integer (`None` for more than 19 digits), its power of ten, and its length in bytes.
pub(crate) fn parts(text: &[u8]) -> Option<(Option<u64>, i32, usize)> {
    let whole_at = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let (mut mantissa, mut count) = digits(&text[whole_at..]);
    let (mut at, mut scale) = (whole_at + count, 0);
    if text.get(at) == Some(&b'.') {
        let (fraction, length) = digits(&text[at + 1..]);
        mantissa = mantissa.wrapping_mul(TENS[length.min(19)]).wrapping_add(fraction);
        count += length;
        at += 1 + length;
        scale = -i32::try_from(length).unwrap_or(i32::MAX);
    }
    if count == 0 {
        return None;
    }
    if matches!(text.get(at), Some(b'e' | b'E')) {
        let (exponent, length) = exponent(&text[at + 1..])?;
        scale = scale.saturating_add(exponent);
        at += 1 + length;
    }
    Some(((count <= 19).then_some(mantissa), scale, at))
}

/// The digits at the start of the text as an integer, and their count. The integer is right for at most 19 digits.
#[inline(always)]
pub fn digits(text: &[u8]) -> (u64, usize) {
    let (value, count) = up_to_eight(text);
    if count < 8 { (value, count) } else { more_digits(text, value, count) }
}

/// Continues after the first digits.
#[inline(never)]
fn more_digits(text: &[u8], first: u64, length: usize) -> (u64, usize) {
    let (mut value, mut count) = (first, length);
    loop {
        let (more, length) = up_to_eight(&text[count..]);
        value = value.wrapping_mul(TENS[length]).wrapping_add(more);
        count += length;
        if length < 8 {
            return (value, count);
        }
    }
}

/// The first digits, at most eight, and their count. Has no branches, because the count is unpredictable.
#[inline(always)]
fn up_to_eight(text: &[u8]) -> (u64, usize) {
    let word = u64::from_le_bytes(text.first_chunk().copied().unwrap_or_else(|| padded(text)));
    let count = high_bits(word).trailing_zeros() / 8;
    // Shifts the digits to the last places, after zeros.
    (eight(word.checked_shl(64 - 8 * count).unwrap_or(0)), count as usize)
}

/// A mask of the bytes that are not digits. The lowest bit is the first byte.
#[inline(always)]
fn non_digits(word: u128) -> u32 {
    let marks = |half: u64| (high_bits(half) >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56;
    (marks(word as u64) | marks((word >> 64) as u64) << 8) as u32
}

/// Sets the highest bit of each byte that is not a digit.
#[inline(always)]
fn high_bits(word: u64) -> u64 {
    // Digits become 0 to 9, and stay below 128 after adding 118.
    let values = word ^ 0x3030_3030_3030_3030;
    let sums = (values & 0x7F7F_7F7F_7F7F_7F7F) + 0x7676_7676_7676_7676;
    (values | sums) & 0x8080_8080_8080_8080
}

/// The number with these eight digits, the first in the lowest byte. A zero byte counts as the digit 0.
#[inline(always)]
fn eight(digits: u64) -> u64 {
    // Joins neighbors three times: pairs, fours, eight digits.
    let ones = digits & 0x0F0F_0F0F_0F0F_0F0F;
    let pairs = (ones.wrapping_mul(10 << 8 | 1) >> 8) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs.wrapping_mul(100 << 16 | 1) >> 16) & 0x0000_FFFF_0000_FFFF;
    fours.wrapping_mul(10_000 << 32 | 1) >> 32
}

/// The last bytes of a text, padded with zeros.
#[cold]
fn padded<const N: usize>(text: &[u8]) -> [u8; N] {
    let mut bytes = [0; N];
    bytes[..text.len()].copy_from_slice(text);
    bytes
}

/// The exponent after `e`, and its length in bytes. Saturates at the range of `i32`.
fn exponent(text: &[u8]) -> Option<(i32, usize)> {
    let signed = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let (value, count) = digits(&text[signed..]);
    let value = if count > 19 { i32::MAX } else { i32::try_from(value).unwrap_or(i32::MAX) };
    (count > 0).then_some((if text.first() == Some(&b'-') { -value } else { value }, signed + count))
}

/// The powers of ten that are exact in `f64`.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// `mantissa * 10^scale` if both factors are exact in `f64`, so that one rounding suffices (Clinger 1990).
fn exact(mantissa: u64, scale: i32) -> Option<f64> {
    if mantissa > 1 << 53 {
        return None;
    }
    let power = *POWERS.get(scale.unsigned_abs() as usize)?;
    Some(if scale < 0 { mantissa as f64 / power } else { mantissa as f64 * power })
}

/// The powers of ten that fit a `u64`.
const TENS: [u64; 20] = {
    let mut tens = [1; 20];
    let mut at = 1;
    while at < 20 {
        tens[at] = 10 * tens[at - 1];
        at += 1;
    }
    tens
};

/// Appends and counts numbers while only white space separates them. Stops at comments, commas and mistakes, which the
/// grammar handles.
///
/// `index` is the count of numbers so far; each number of a point counts.
pub(crate) fn plain<'a>(input: Input<'a>, values: &mut Values, index: usize) -> (Input<'a>, usize) {
    match values {
        Values::Numbers(list) => numbers(input, list),
        Values::Integers(list) => integers(input, list),
        Values::Pairs(list) if index.is_multiple_of(2) => groups(input, list),
        Values::Triples(list) if index.is_multiple_of(3) => groups(input, list),
        _ => (input, 0),
    }
}

fn numbers<'a>(input: Input<'a>, list: &mut Vec<f64>) -> (Input<'a>, usize) {
    let (mut input, before) = (input, list.len());
    while let Some((value, rest)) = number(input) {
        list.push(value);
        input = rest;
    }
    (input, list.len() - before)
}

fn integers<'a>(input: Input<'a>, list: &mut Vec<i32>) -> (Input<'a>, usize) {
    let (mut input, before) = (input, list.len());
    while let Some((value, rest)) = integer(input) {
        list.push(value);
        input = rest;
    }
    (input, list.len() - before)
}

/// Reads whole points or colors. Stops before an incomplete one.
fn groups<'a, const N: usize>(input: Input<'a>, list: &mut Vec<[f64; N]>) -> (Input<'a>, usize) {
    let (mut input, before) = (input, list.len());
    'groups: loop {
        let (mut group, mut at) = ([0.0; N], input);
        for value in &mut group {
            let Some(next) = number(at) else { break 'groups };
            (*value, at) = next;
        }
        list.push(group);
        input = at;
    }
    (input, N * (list.len() - before))
}

/// The number after white space, and the rest of the input.
#[inline(always)]
fn number(input: Input) -> Option<(f64, Input)> {
    let input = after_blanks(input);
    let (value, length) = decimal(input)?;
    let rest = input.get(length..)?;
    ends_number(rest).then_some((value, rest))
}

/// The integer after white space, without point and exponent, and the rest of the input.
#[inline(always)]
fn integer(input: Input) -> Option<(i32, Input)> {
    let input = after_blanks(input);
    let sign = usize::from(input.first() == Some(&b'-'));
    let (value, count) = digits(input.get(sign..)?);
    let value = i32::try_from(value).ok().filter(|_| (1..=19).contains(&count))?;
    let rest = input.get(sign + count..)?;
    ends_number(rest).then_some((if sign == 1 { -value } else { value }, rest))
}

#[inline(always)]
fn after_blanks(input: Input) -> Input {
    let mut input = input;
    while let [byte, rest @ ..] = input
        && is_blank(*byte)
    {
        input = rest;
    }
    input
}

#[cfg(test)]
mod tests {
    mod decimal {
        use proptest::prelude::*;

        use super::super::*;

        #[test]
        fn digits_end_at_any_other_byte() {
            for count in 0..=19 {
                let number = &"1234567890987654321"[..count];
                let value = number.parse().unwrap_or(0);
                assert_eq!(digits(number.as_bytes()), (value, count));
                for byte in (0..=255_u8).filter(|byte| !byte.is_ascii_digit()) {
                    // The text after the byte does not matter.
                    for rest in ["", "7", "12345678901", "\u{ff}\u{ff}\u{ff}\u{ff}"] {
                        let text = [number.as_bytes(), &[byte], rest.as_bytes()].concat();
                        assert_eq!(digits(&text), (value, count), "{text:?}");
                    }
                }
            }
        }

        #[test]
        fn a_number_may_be_the_end_of_the_text_or_not() {
            let at = |text: &str| decimal(text.as_bytes());
            assert_eq!(at("-1.5e-3"), Some((-0.0015, 7)));
            assert_eq!(at("-1.5e-3]"), Some((-0.0015, 7)));
            assert_eq!(at("12.x"), Some((12.0, 3)));
            assert_eq!(at(".5.5"), Some((0.5, 2)));
            assert_eq!(at("+7 8"), Some((7.0, 2)));
            assert_eq!(at("12345678901234567890"), Some((12345678901234567890.0, 20)));
            for text in ["", "-", ".", "-.", "e1", "1e", "1e+", "--1", "1e309"] {
                assert_eq!(at(text), None, "{text}");
            }
        }

        proptest! {
            #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

            #[test]
            fn numbers_are_the_nearest(
                text in r"[+-]?([0-9]{1,20}\.?[0-9]{0,20}|\.[0-9]{1,20})([eE][+-]?[0-9]{1,3})?",
                rest in "[ \\]\"x,].{0,20}",
            ) {
                let expected: f64 = text.parse().unwrap();
                for text in [text.clone(), text.clone() + &rest, text.clone() + &" ".repeat(20)] {
                    match decimal(text.as_bytes()) {
                        Some((value, length)) => {
                            prop_assert_eq!(value.to_bits(), expected.to_bits());
                            prop_assert_eq!(text[..length].parse(), Ok(expected));
                            prop_assert!(!text[length..].starts_with(|c: char| c.is_ascii_digit()));
                        }
                        None => prop_assert!(expected.is_infinite()),
                    }
                }
            }
        }
    }
    mod lists {
        use crate::{Directive, FileId, parse};

        /// Parses one directive with one list of `numbers`, separated by `between`.
        fn read(ty: &str, numbers: &[&str], between: &str) -> Directive {
            let text = format!("Shape \"a\" \"{ty} x\" [{}]", numbers.join(between));
            let mut parsed = parse(FileId(0), text.as_bytes());
            let commas = usize::from(between.contains(','));
            assert_eq!((parsed.diagnostics.len(), parsed.statements.len()), (commas, 1), "{text}");
            parsed.statements.remove(0).directive
        }

        #[test]
        fn what_is_between_numbers_does_not_change_them() {
            let whole = ["0", "-1", "22", "-333", "2147483647", "-2147483648", "00000000000000000000000007"];
            let other = ["+1", "2.", "3e0", "40E-1", "-5.0000000000000000000000", "6.0", "1e9"];
            let broken = ["-0.5", ".25", "1e-7", "-123.456789", "0.30000000000000004", "-9.87654321e-300"];
            let integers = [&whole[..], &other[..5]].concat();
            let all = [&whole[..], &other, &broken[..], &["123456789012345678901234567890"; 4]].concat();
            for (ty, numbers) in [("integer", &integers), ("float", &all), ("point2", &all), ("point3", &all)]
            {
                let expected = read(ty, numbers, " ");
                for between in ["\n", "\t \r\n", " # 7 [\n", ",", " , ", "\n#\n"] {
                    assert_eq!(read(ty, numbers, between), expected, "{ty} {between:?}");
                }
                let values: Vec<f64> = numbers.iter().map(|number| number.parse().unwrap()).collect();
                let printed: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
                let printed: Vec<&str> = printed.iter().map(String::as_str).collect();
                assert_eq!(read(ty, &printed, " "), expected, "{ty}");
            }
        }
    }
}
