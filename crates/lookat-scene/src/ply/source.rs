//! The numbers of a PLY body, in text or binary.

use std::io::Read;

use lookat_syntax::{decimal, digits};

use super::header::{Kind, Scalar};
use super::quote;
use super::stream::{LONGEST, Stream};

/// The reason why a row is unreadable.
pub enum Fault {
    /// The file ends inside the row.
    End,
    /// Another reason, as a text to follow "vertex 3".
    Bad(String),
}

/// A source of numbers in the body.
pub trait Source {
    /// The bytes read so far, including the header.
    fn position(&self) -> u64;

    /// The place of a fault in the row that starts at `row_start`.
    fn place(&self, row_start: u64) -> String;

    /// The next number.
    fn real(&mut self, scalar: Scalar) -> Result<f64, Fault>;

    /// The next `N` numbers of an integer type.
    fn integers<const N: usize>(&mut self, scalar: Scalar) -> Result<[i64; N], Fault>;

    /// Skips numbers.
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Fault>;

    /// The next number as the length of a list.
    #[inline]
    fn length(&mut self, scalar: Scalar) -> Result<u64, Fault> {
        let [length] = self.integers(scalar)?;
        u64::try_from(length).map_err(|_| Fault::Bad(format!("has a list of {length} values")))
    }

    /// Skips a property.
    fn skip_property(&mut self, kind: Kind) -> Result<(), Fault> {
        match kind {
            Kind::One(scalar) => self.skip(scalar, 1),
            Kind::List { count, item } => {
                let length = self.length(count)?;
                self.skip(item, length)
            }
        }
    }
}

/// Words between white space. Line ends have no other meaning, as in pbrt-v3.
pub struct Ascii<'s, R>(pub &'s mut Stream<R>);

impl<R: Read> Ascii<'_, R> {
    /// The bytes in memory after white space.
    #[inline(always)]
    fn rest(&mut self) -> &[u8] {
        let rest = self.0.rest();
        let blanks = rest.iter().position(|byte| !byte.is_ascii_whitespace());
        let count = blanks.unwrap_or(rest.len());
        self.0.step(count);
        self.0.rest()
    }

    fn word(&mut self) -> Result<&[u8], Fault> {
        while self.rest().is_empty() {
            if !self.0.more() {
                return Err(Fault::End);
            }
        }
        Ok(self.0.until(u8::is_ascii_whitespace))
    }

    /// Reads a number in any form that Rust accepts.
    #[cold]
    fn number<T: std::str::FromStr>(&mut self, wanted: &str) -> Result<T, Fault> {
        let word = self.word()?;
        // A word of the longest length may continue.
        let whole = Some(word).filter(|word| word.len() < LONGEST);
        let parsed = whole.and_then(|word| std::str::from_utf8(word).ok()?.parse().ok());
        parsed.ok_or_else(|| Fault::Bad(format!("has {} in place of {wanted}", quote(word))))
    }
}

/// True if a word ends after `length` bytes. False at the end of a piece, where this is unknown.
#[inline]
fn ends(rest: &[u8], length: usize) -> bool {
    rest.get(length).is_some_and(u8::is_ascii_whitespace)
}

impl<R: Read> Source for Ascii<'_, R> {
    fn position(&self) -> u64 {
        self.0.position()
    }

    fn place(&self, _row_start: u64) -> String {
        format!("line {}", 1 + self.0.lines())
    }

    #[inline]
    fn real(&mut self, _scalar: Scalar) -> Result<f64, Fault> {
        let rest = self.rest();
        match decimal(rest) {
            Some((value, length)) if ends(rest, length) => {
                self.0.step(length);
                Ok(value)
            }
            _ => self.number("a number"),
        }
    }

    #[inline]
    fn integers<const N: usize>(&mut self, _scalar: Scalar) -> Result<[i64; N], Fault> {
        let mut integers = [0; N];
        for value in &mut integers {
            let rest = self.rest();
            *value = match digits(rest) {
                // 18 digits fit the type.
                (value, length @ 1..=18) if ends(rest, length) => {
                    self.0.step(length);
                    value as i64
                }
                _ => self.number("an integer")?,
            };
        }
        Ok(integers)
    }

    fn skip(&mut self, _scalar: Scalar, count: u64) -> Result<(), Fault> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }
}

/// Binary numbers, most significant byte first if `BIG`.
pub struct Binary<'s, R, const BIG: bool>(pub &'s mut Stream<R>);

impl<R: Read, const BIG: bool> Source for Binary<'_, R, BIG> {
    fn position(&self) -> u64 {
        self.0.position()
    }

    fn place(&self, row_start: u64) -> String {
        format!("byte {row_start}")
    }

    #[inline]
    fn real(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        self.0.take(scalar.size()).map(|bytes| decode_real::<BIG>(scalar, bytes)).ok_or(Fault::End)
    }

    #[inline]
    fn integers<const N: usize>(&mut self, scalar: Scalar) -> Result<[i64; N], Fault> {
        let size = scalar.size();
        let bytes = self.0.take(N * size).ok_or(Fault::End)?;
        Ok(decode_integers::<BIG, N>(scalar, bytes))
    }

    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Fault> {
        let size = count.checked_mul(scalar.size() as u64);
        size.is_some_and(|size| self.0.skip(size)).then_some(()).ok_or(Fault::End)
    }
}

/// The first `N` bytes, least significant first.
#[inline]
fn little_endian<const BIG: bool, const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut word = [0; N];
    word.copy_from_slice(&bytes[..N]);
    if BIG {
        word.reverse();
    }
    word
}

#[inline]
fn decode_integers<const BIG: bool, const N: usize>(scalar: Scalar, bytes: &[u8]) -> [i64; N] {
    match scalar {
        Scalar::I8 => decode_all::<BIG, N, _>(bytes, |word| i8::from_le_bytes(word).into()),
        Scalar::U8 => decode_all::<BIG, N, _>(bytes, |word| u8::from_le_bytes(word).into()),
        Scalar::I16 => decode_all::<BIG, N, _>(bytes, |word| i16::from_le_bytes(word).into()),
        Scalar::U16 => decode_all::<BIG, N, _>(bytes, |word| u16::from_le_bytes(word).into()),
        Scalar::I32 => decode_all::<BIG, N, _>(bytes, |word| i32::from_le_bytes(word).into()),
        Scalar::U32 => decode_all::<BIG, N, _>(bytes, |word| u32::from_le_bytes(word).into()),
        // Unreachable: the header rejects counts and indices of these types.
        Scalar::F32 | Scalar::F64 => [0; N],
    }
}

#[inline]
fn decode_all<const BIG: bool, const N: usize, const SIZE: usize>(
    bytes: &[u8],
    decode: impl Fn([u8; SIZE]) -> i64,
) -> [i64; N] {
    std::array::from_fn(|at| decode(little_endian::<BIG, SIZE>(&bytes[at * SIZE..])))
}

#[inline]
fn decode_real<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> f64 {
    match scalar {
        Scalar::F32 => f64::from(f32::from_le_bytes(little_endian::<BIG, 4>(bytes))),
        Scalar::F64 => f64::from_le_bytes(little_endian::<BIG, 8>(bytes)),
        integer => decode_integers::<BIG, 1>(integer, bytes)[0] as f64,
    }
}
