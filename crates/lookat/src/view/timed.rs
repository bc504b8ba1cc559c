//! A connection with a deadline.

use std::io::{ErrorKind, Read, Result, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// A connection whose reads and writes together end by a deadline, however slowly the other side goes.
pub struct Timed {
    pub stream: TcpStream,
    deadline: Instant,
}

impl Timed {
    pub fn new(stream: TcpStream, time: Duration) -> Timed {
        Timed { stream, deadline: Instant::now() + time }
    }

    /// Sets a new deadline.
    pub fn allow(&mut self, time: Duration) {
        self.deadline = Instant::now() + time;
    }

    fn left(&self) -> Result<Option<Duration>> {
        let left = self.deadline.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }

    /// Ends the connection. Reads what the other side still sends, because an answer is lost if unread bytes are left.
    pub fn finish(&mut self) {
        const TIME: Duration = Duration::from_millis(500);
        const BYTES: u64 = 1 << 18;
        self.allow(TIME);
        let _ = self.stream.shutdown(Shutdown::Write);
        let _ = std::io::copy(&mut self.take(BYTES), &mut std::io::sink());
    }
}

impl Read for Timed {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(buffer)
    }
}

impl Write for Timed {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> Result<()> {
        self.stream.flush()
    }
}
