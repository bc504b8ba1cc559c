//! Streams the bytes of a file, with one piece in memory.

use std::io::{self, ErrorKind, Read};

/// The bytes to read at once, which fit the cache of a core. Tests use few bytes, so that pieces end everywhere.
const PIECE: usize = if cfg!(test) { 7 } else { 1 << 16 };

/// The longest word or line, in bytes.
pub const LONGEST: usize = 1 << 16;

/// A file that is read from start to end.
pub struct Stream<R> {
    file: R,
    /// The bytes of the file from `before` on, valid up to `end`.
    piece: Vec<u8>,
    /// The next byte to read.
    at: usize,
    end: usize,
    /// The bytes of the file before the piece, and their line ends.
    before: u64,
    lines_before: u64,
    ended: bool,
    /// The error that stopped reading.
    error: Option<io::Error>,
}

impl<R: Read> Stream<R> {
    pub fn new(file: R) -> Self {
        let piece = vec![0; PIECE];
        Stream { file, piece, at: 0, end: 0, before: 0, lines_before: 0, ended: false, error: None }
    }

    /// Bytes read so far.
    pub fn position(&self) -> u64 {
        self.before + self.at as u64
    }

    /// The line ends read so far.
    pub fn lines(&self) -> u64 {
        self.lines_before + line_ends(&self.piece[..self.at])
    }

    /// The error that stopped reading. After an error, the file seems to end.
    pub fn error(self) -> Option<io::Error> {
        self.error
    }

    /// The next bytes in memory.
    #[inline]
    pub fn rest(&self) -> &[u8] {
        &self.piece[self.at..self.end]
    }

    /// Skips bytes in memory.
    #[inline]
    pub fn step(&mut self, count: usize) {
        self.at = self.end.min(self.at + count);
    }

    /// The next `count` bytes, if they exist.
    #[inline]
    pub fn take(&mut self, count: usize) -> Option<&[u8]> {
        while self.end - self.at < count {
            if !self.more() {
                return None;
            }
        }
        self.at += count;
        Some(&self.piece[self.at - count..self.at])
    }

    /// The bytes before the next byte accepted by `ends`, or before the end of the file. Returns at most [`LONGEST`]
    /// bytes, to limit memory.
    pub fn until(&mut self, ends: impl Fn(&u8) -> bool) -> &[u8] {
        let mut length = 0;
        loop {
            let known = length;
            length = self.rest().len();
            if let Some(more) = self.rest()[known..].iter().position(&ends) {
                length = known + more;
                break;
            }
            if length >= LONGEST || !self.more() {
                break;
            }
        }
        let length = length.min(LONGEST);
        self.step(length);
        &self.piece[self.at - length..self.at]
    }

    /// The next line with its line end; empty at the end of the file.
    pub fn line(&mut self) -> &[u8] {
        let length = self.until(|byte| *byte == b'\n').len();
        let end = usize::from(self.rest().first() == Some(&b'\n'));
        self.step(end);
        &self.piece[self.at - length - end..self.at]
    }

    /// Skips white space and zeros. True if more data follows.
    pub fn goes_on(&mut self) -> bool {
        loop {
            let is_blank = |byte: &u8| byte.is_ascii_whitespace() || *byte == 0;
            if !self.rest().iter().all(is_blank) {
                return true;
            }
            self.step(self.rest().len());
            if !self.more() {
                return false;
            }
        }
    }

    /// Skips bytes. False if there are fewer.
    pub fn skip(&mut self, count: u64) -> bool {
        let mut left = count;
        loop {
            let here = left.min(self.rest().len() as u64);
            self.step(here as usize);
            left -= here;
            if left == 0 || !self.more() {
                return left == 0;
            }
        }
    }

    /// Skips to the end and returns the size of the file.
    pub fn skip_all(&mut self) -> u64 {
        self.skip(u64::MAX);
        self.position()
    }

    /// Reads more. False at the end of the file.
    #[cold]
    pub fn more(&mut self) -> bool {
        self.lines_before += line_ends(&self.piece[..self.at]);
        self.before += self.at as u64;
        self.piece.copy_within(self.at..self.end, 0);
        (self.at, self.end) = (0, self.end - self.at);
        if self.end == self.piece.len() {
            // A token is longer than a piece.
            self.piece.resize(2 * self.end, 0);
        }
        while !self.ended {
            match self.file.read(&mut self.piece[self.end..]) {
                Ok(0) => self.ended = true,
                Ok(count) => {
                    self.end += count;
                    return true;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => (self.error, self.ended) = (Some(error), true),
            }
        }
        false
    }
}

fn line_ends(bytes: &[u8]) -> u64 {
    // Byte sums vectorize. A chunk is so short that its sum fits a byte.
    let ends = |some: &[u8]| u64::from(some.iter().map(|byte| u8::from(*byte == b'\n')).sum::<u8>());
    bytes.chunks(u8::MAX.into()).map(ends).sum()
}
