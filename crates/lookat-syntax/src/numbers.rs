//! Reads decimal numbers, and long lists of them: most of a large scene is numbers.

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
    number_of_any_size(text).filter(|(value, _)| value.is_finite())
}

/// Like [`decimal`], but infinite for a number beyond the range of `f64`, and for words such as `inf`.
#[inline(always)]
pub(crate) fn number_of_any_size(text: &[u8]) -> Option<(f64, usize)> {
    fast_float2::parse_partial(text).ok()
}

/// The digits at the start of the text as an integer, and their count. The integer is right for at most 19 digits.
#[inline(always)]
pub fn digits(text: &[u8]) -> (u64, usize) {
    let (mut value, mut count) = (0_u64, 0);
    while let Some(digit @ b'0'..=b'9') = text.get(count) {
        value = value.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
        count += 1;
    }
    (value, count)
}

/// Appends and counts numbers while only white space separates them. Stops at comments, commas and mistakes, which the
/// grammar handles.
///
/// `index` is the count of numbers so far; each number of a point counts.
pub(crate) fn plain<'a>(input: Input<'a>, values: &mut Values, index: usize) -> (Input<'a>, usize) {
    match values {
        Values::Numbers(list) => all(input, list, number),
        Values::Integers(list) => all(input, list, integer),
        Values::Pairs(list) if index.is_multiple_of(2) => groups(input, list),
        Values::Triples(list) if index.is_multiple_of(3) => groups(input, list),
        _ => (input, 0),
    }
}

/// Appends and counts values while `next` reads one.
#[inline(always)]
fn all<'a, T>(
    input: Input<'a>,
    list: &mut Vec<T>,
    next: impl Fn(Input<'a>) -> Option<(T, Input<'a>)>,
) -> (Input<'a>, usize) {
    let (mut input, before) = (input, list.len());
    while let Some((value, rest)) = next(input) {
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
            assert_eq!(at("1e+"), Some((1.0, 1)));
            for text in ["", "-", ".", "-.", "e1", "--1", "1e309", "inf", "-nan"] {
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
