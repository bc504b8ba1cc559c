//! The bytes of a file, of which only a piece is in memory.

use std::io::{self, ErrorKind, Read};

/// Bytes to read at once: small enough to stay in the cache of a core. Tests meet the end of a piece everywhere.
const PIECE: usize = if cfg!(test) { 7 } else { 1 << 16 };

/// The longest word or line, in bytes.
pub const LONGEST: usize = 1 << 16;

/// A file that is read from its beginning to its end.
pub struct Stream<R> {
    file: R,
    /// The file from `before` on; what is beyond `end` does not count.
    piece: Vec<u8>,
    /// The next byte to read.
    at: usize,
    end: usize,
    /// Bytes of the file before the piece, and the line ends among them.
    before: u64,
    lines_before: u64,
    ended: bool,
    /// Why the file could not be read to its end.
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

    /// Line ends read so far.
    pub fn lines(&self) -> u64 {
        self.lines_before + line_ends(&self.piece[..self.at])
    }

    /// Why the file could not be read to its end; until then it seems to end there.
    pub fn error(self) -> Option<io::Error> {
        self.error
    }

    /// The next bytes, as far as they are in memory.
    #[inline]
    pub fn rest(&self) -> &[u8] {
        &self.piece[self.at..self.end]
    }

    /// Steps over bytes that are in memory.
    #[inline]
    pub fn step(&mut self, count: usize) {
        self.at = self.end.min(self.at + count);
    }

    /// The next bytes, if there are so many.
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

    /// The bytes up to the next one that `ends` knows, or to the end of the file; that one is not stepped over. At most
    /// [`LONGEST`] of them, so that what has no end does not fill the memory.
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

    /// The next line with its end; nothing at the end of the file.
    pub fn line(&mut self) -> &[u8] {
        let length = self.until(|byte| *byte == b'\n').len();
        let end = usize::from(self.rest().first() == Some(&b'\n'));
        self.step(end);
        &self.piece[self.at - length - end..self.at]
    }

    /// Steps over blanks and zeros. Whether anything else follows.
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

    /// Steps over bytes. Whether there are so many.
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

    /// Steps over everything, and gives the size of the file.
    pub fn skip_all(&mut self) -> u64 {
        self.skip(u64::MAX);
        self.position()
    }

    /// Reads on. Whether there was more.
    #[cold]
    pub fn more(&mut self) -> bool {
        self.lines_before += line_ends(&self.piece[..self.at]);
        self.before += self.at as u64;
        self.piece.copy_within(self.at..self.end, 0);
        (self.at, self.end) = (0, self.end - self.at);
        if self.end == self.piece.len() {
            // Something is longer than a piece.
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
    // Sums of bytes, which are added many at a time; so few of them fit a byte.
    let ends = |some: &[u8]| u64::from(some.iter().map(|byte| u8::from(*byte == b'\n')).sum::<u8>());
    bytes.chunks(u8::MAX.into()).map(ends).sum()
}
