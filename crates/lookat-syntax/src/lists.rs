//! The fast loop for long lists of numbers.

use crate::decimal::{decimal, digits};
use crate::param::Values;
use crate::token::{Input, ends_number, is_blank};

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
        for (ty, numbers) in [("integer", &integers), ("float", &all), ("point2", &all), ("point3", &all)] {
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
