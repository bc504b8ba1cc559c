//! Connections: HTTP requests and answers, and WebSockets, all with deadlines.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::thread::Builder;
use std::time::{Duration, Instant};

use tungstenite::error::{Error, ProtocolError};
use tungstenite::handshake::machine::TryParse;
use tungstenite::handshake::server::{Request, Response};
use tungstenite::http::StatusCode;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, WebSocket};

use crate::view::messages;
use crate::view::outbox::{Outbox, Requests};
use crate::view::reference::Shared;

/// The most bytes of the head of a request.
const LONGEST_HEAD: usize = 8 << 10;

/// The headers of every answer.
const HEADERS: [(&str, &str); 9] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("cache-control", "no-store"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cross-origin-embedder-policy", "require-corp"),
    ("connection", "close"),
];

/// Reads the head of a GET request. Fails with the status of the answer.
pub fn read_head(client: &mut Timed) -> Result<Request, StatusCode> {
    let mut head = Vec::new();
    let mut buffer = [0; 1024];
    loop {
        let count = client.read(&mut buffer).map_err(|_| StatusCode::REQUEST_TIMEOUT)?;
        if count == 0 {
            return Err(StatusCode::BAD_REQUEST);
        }
        head.extend_from_slice(&buffer[..count]);
        match Request::try_parse(&head) {
            Ok(Some((_, request))) => return Ok(request),
            Ok(None) if head.len() <= LONGEST_HEAD => {}
            Ok(None) | Err(Error::Capacity(_)) => return Err(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE),
            Err(Error::Protocol(ProtocolError::WrongHttpMethod)) => {
                return Err(StatusCode::METHOD_NOT_ALLOWED);
            }
            Err(_) => return Err(StatusCode::BAD_REQUEST),
        }
    }
}

/// The only value of a header.
pub fn header<'r>(request: &'r Request, name: &str) -> Option<&'r str> {
    let mut values = request.headers().get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// Answers, and ends the connection.
pub fn answer(client: &mut Timed, status: StatusCode, kind: &str, body: &[u8]) {
    let mut head =
        format!("HTTP/1.1 {} {}\r\n", status.as_u16(), status.canonical_reason().unwrap_or_default());
    let length = body.len().to_string();
    for (name, value) in HEADERS.into_iter().chain([("content-type", kind), ("content-length", &length)]) {
        head += &format!("{name}: {value}\r\n");
    }
    // A client that has gone needs no answer.
    let _ = client.write_all(&[(head + "\r\n").as_bytes(), body].concat());
    client.finish();
}

/// Answers with the reason alone.
pub fn refuse(client: &mut Timed, status: StatusCode) {
    let reason = status.canonical_reason().unwrap_or_default();
    answer(client, status, "text/plain; charset=utf-8", format!("{reason}\n").as_bytes());
}

/// The answer that turns the connection into a WebSocket.
pub fn upgrade(client: &mut Timed, answer: &Response) -> io::Result<()> {
    let mut head = String::from("HTTP/1.1 101 Switching Protocols\r\n");
    for (name, value) in answer.headers() {
        head += &format!("{name}: {}\r\n", value.to_str().unwrap_or_default());
    }
    client.write_all((head + "\r\n").as_bytes())
}

/// The most bytes of a message from the page.
const LONGEST_REQUEST: usize = 64 << 10;
/// The time to send the head of a request, and to take an answer or a message. Then the connection is closed.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// The reading side. Answers to pings and closing are not sent: they could fall into the middle of a picture.
struct Incoming(TcpStream);

impl Read for Incoming {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }
}

impl Write for Incoming {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Serves a page until it leaves, sends nonsense or takes no more messages.
pub fn talk(client: Timed, Shared { requests, hub, .. }: &Shared) {
    let Ok(incoming) = client.stream.try_clone() else { return };
    let _ = incoming.set_read_timeout(None);
    let outbox = hub.join();
    let sender = outbox.clone();
    if Builder::new().spawn(move || send(client, &sender)).is_ok() {
        receive(incoming, requests);
    }
    outbox.close();
}

fn receive(incoming: TcpStream, requests: &Requests) {
    let config = WebSocketConfig::default()
        .max_message_size(Some(LONGEST_REQUEST))
        .max_frame_size(Some(LONGEST_REQUEST))
        .read_buffer_size(LONGEST_REQUEST);
    let mut socket = WebSocket::from_raw_socket(Incoming(incoming), Role::Server, Some(config));
    while let Ok(message) = socket.read() {
        let request = match message {
            Message::Ping(_) | Message::Pong(_) => continue,
            Message::Text(text) => serde_json::from_str::<messages::Request>(&text),
            _ => return,
        };
        match request {
            Ok(request) => requests.put(request),
            Err(_) => return,
        }
    }
}

fn send(client: Timed, outbox: &Outbox) {
    let mut socket = WebSocket::from_raw_socket(client, Role::Server, None);
    while let Some(message) = outbox.next() {
        socket.get_mut().allow_bytes(message.len());
        if socket.send(message).is_err() {
            break;
        }
    }
    // The reading side ends, too.
    let _ = socket.get_ref().stream.shutdown(Shutdown::Both);
}

/// A connection whose reads and writes together end by a deadline, however slowly the other side goes.
pub struct Timed {
    pub stream: TcpStream,
    deadline: Instant,
}

impl Timed {
    pub fn new(stream: TcpStream, time: Duration) -> Timed {
        Timed { stream, deadline: Instant::now() + time }
    }

    /// Sets a new deadline to take a message: the usual time, and one second more for each 4 MiB.
    pub fn allow_bytes(&mut self, count: usize) {
        self.allow(PATIENCE + Duration::from_secs(count as u64 >> 22));
    }

    /// Sets a new deadline.
    pub fn allow(&mut self, time: Duration) {
        self.deadline = Instant::now() + time;
    }

    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.deadline.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }

    /// Ends the connection. Reads what the other side still sends, because an answer is lost if unread bytes are left.
    pub fn finish(&mut self) {
        const TIME: Duration = Duration::from_millis(500);
        const BYTES: u64 = 1 << 18;
        self.allow(TIME);
        let _ = self.stream.shutdown(Shutdown::Write);
        let _ = io::copy(&mut self.take(BYTES), &mut io::sink());
    }
}

impl Read for Timed {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(buffer)
    }
}

impl Write for Timed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}
