//! A WebSocket: requests come in, pictures and news go out.

use std::io::{Read, Result, Write};
use std::net::{Shutdown, TcpStream};
use std::thread::Builder;
use std::time::Duration;

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, WebSocket};

use super::messages::Request;
use super::outbox::{Hub, Outbox};
use super::requests::Requests;
use super::timed::Timed;

/// The most bytes of a message from the page.
const LONGEST_REQUEST: usize = 64 << 10;
/// The time that the page has to take a message. Then its connection is closed.
const PATIENCE: Duration = Duration::from_secs(5);

/// The reading side. Answers to pings and closing are not sent: they could fall into the middle of a picture.
struct Incoming(TcpStream);

impl Read for Incoming {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        self.0.read(buffer)
    }
}

impl Write for Incoming {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

/// Serves a page until it leaves, sends nonsense or takes no more messages.
pub fn talk(client: Timed, requests: &Requests, hub: &Hub) {
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
            Message::Text(text) => serde_json::from_str::<Request>(&text),
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
        // One second more for each 4 MiB.
        socket.get_mut().allow(PATIENCE + Duration::from_secs(message.len() as u64 >> 22));
        if socket.send(message).is_err() {
            break;
        }
    }
    // The reading side ends, too.
    let _ = socket.get_ref().stream.shutdown(Shutdown::Both);
}
