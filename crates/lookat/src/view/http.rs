//! HTTP: the head of a request, and answers.

use std::io::{Read, Write};

use tungstenite::http::{Request, Response, StatusCode, Version};

use super::timed::Timed;

/// The most bytes of the head of a request.
const LONGEST_HEAD: usize = 8 << 10;
/// The most header lines.
const MOST_HEADERS: usize = 64;

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

/// Reads the head of a request. Fails with the status of the answer.
pub fn read_head(client: &mut Timed) -> Result<Request<()>, StatusCode> {
    let mut head = Vec::new();
    let mut buffer = [0; 1024];
    loop {
        let count = client.read(&mut buffer).map_err(|_| StatusCode::REQUEST_TIMEOUT)?;
        if count == 0 {
            return Err(StatusCode::BAD_REQUEST);
        }
        head.extend_from_slice(&buffer[..count]);
        if let Some(request) = parse(&head)? {
            return Ok(request);
        }
        if head.len() > LONGEST_HEAD {
            return Err(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE);
        }
    }
}

/// The request, if its head is whole.
fn parse(head: &[u8]) -> Result<Option<Request<()>>, StatusCode> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let state = parsed.parse(head).map_err(|error| match error {
        httparse::Error::TooManyHeaders => StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE,
        _ => StatusCode::BAD_REQUEST,
    })?;
    if state.is_partial() {
        return Ok(None);
    }
    let version = if parsed.version == Some(1) { Version::HTTP_11 } else { Version::HTTP_10 };
    let mut request = Request::builder()
        .method(parsed.method.unwrap_or_default())
        .uri(parsed.path.unwrap_or_default())
        .version(version);
    for header in parsed.headers.iter() {
        request = request.header(header.name, header.value);
    }
    request.body(()).map(Some).map_err(|_| StatusCode::BAD_REQUEST)
}

/// The only value of a header.
pub fn header<'r>(request: &'r Request<()>, name: &str) -> Option<&'r str> {
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
pub fn upgrade(client: &mut Timed, answer: &Response<()>) -> std::io::Result<()> {
    let mut head = String::from("HTTP/1.1 101 Switching Protocols\r\n");
    for (name, value) in answer.headers() {
        head += &format!("{name}: {}\r\n", value.to_str().unwrap_or_default());
    }
    client.write_all((head + "\r\n").as_bytes())
}
