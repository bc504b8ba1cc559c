//! The server of the page: who may connect, and what they get.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::hint::black_box;
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread::Builder;
use std::time::Duration;

use lookat_image::io_reason;
use tungstenite::handshake::server::{Request, create_response};
use tungstenite::http::StatusCode;

use crate::failure::Failure;
use crate::view::http::{PATIENCE, Timed, answer, header, read_head, refuse, talk, upgrade};
use crate::view::reference::Shared;
use crate::writer::lock;

/// The most connections at a time.
const MOST_CONNECTIONS: usize = 32;
/// The name of the WebSocket.
const SOCKET: &str = "socket";

/// The names of the finished picture, and their media types.
const PICTURES: [(&str, &str); 2] = [("picture.exr", "image/x-exr"), ("picture.png", "image/png")];

/// A server for one scene.
pub struct Server {
    /// The name and port that the browser must ask for. Another name is a page elsewhere that had its name point here.
    host: String,
    /// The host and port with the name `localhost`.
    local: String,
    /// The first part of all paths. Only who has seen the address knows it.
    token: String,
    shared: Arc<Shared>,
    connections: Mutex<Connections>,
}

/// The connections that are served.
#[derive(Default)]
struct Connections {
    /// The number of the next one.
    next: u64,
    /// The connections that have not shown the token, by their numbers: the first is the oldest.
    strangers: BTreeMap<u64, TcpStream>,
    /// The connections that have shown the token.
    known: BTreeSet<u64>,
}

impl Server {
    pub fn new(listener: &TcpListener, shared: Arc<Shared>) -> Result<Server, Failure> {
        let place = listener.local_addr().map_err(|error| io_reason(&error))?;
        let mut token = [0; 16];
        getrandom::fill(&mut token).map_err(|error| format!("the system gives no random bytes: {error}"))?;
        let token = token.iter().map(|byte| format!("{byte:02x}")).collect();
        // Browsers leave the usual port out.
        let host = if place.port() == 80 { place.ip().to_string() } else { place.to_string() };
        let local = host.replace(&place.ip().to_string(), "localhost");
        Ok(Server { host, local, token, shared, connections: Mutex::default() })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.host, self.token)
    }

    /// Serves from now on, on threads of its own.
    pub fn start(self, listener: TcpListener) -> Result<(), Failure> {
        let server = Arc::new(self);
        let accept = move || {
            for stream in listener.incoming() {
                match stream {
                    Ok(stream) => server.clone().connect(stream),
                    // Too many files are open: some will be closed.
                    Err(_) => std::thread::sleep(Duration::from_millis(50)),
                }
            }
        };
        Ok(Builder::new().spawn(accept).map(drop).map_err(|error| io_reason(&error))?)
    }

    /// Gives a connection a thread. If there are too many, closes the oldest one that has not shown the token, or else this one.
    fn connect(self: Arc<Self>, stream: TcpStream) {
        let Ok(other) = stream.try_clone() else { return };
        let mut connections = lock(&self.connections);
        if connections.strangers.len() + connections.known.len() >= MOST_CONNECTIONS {
            let Some((_, oldest)) = connections.strangers.pop_first() else { return };
            // Its thread ends.
            let _ = oldest.shutdown(Shutdown::Both);
        }
        let number = connections.next;
        connections.next += 1;
        connections.strangers.insert(number, other);
        drop(connections);
        let connection = Connection { server: self, number };
        let _ = Builder::new().spawn(move || connection.server.serve(stream, number));
    }

    /// Notes that a connection has shown the token. False if it has been closed before.
    fn welcome(&self, number: u64) -> bool {
        let mut connections = lock(&self.connections);
        let is_open = connections.strangers.remove(&number).is_some();
        is_open && connections.known.insert(number)
    }

    fn serve(&self, stream: TcpStream, number: u64) {
        let _ = stream.set_nodelay(true);
        let mut client = Timed::new(stream, PATIENCE);
        let request =
            read_head(&mut client).and_then(|request| Ok((self.name(&request)?.to_owned(), request)));
        client.allow(PATIENCE);
        match request {
            Ok(_) if !self.welcome(number) => {}
            Err(status) => refuse(&mut client, status),
            Ok((name, request)) if name == SOCKET => match create_response(&request) {
                Err(_) => refuse(&mut client, StatusCode::BAD_REQUEST),
                Ok(response) => {
                    if upgrade(&mut client, &response).is_ok() {
                        talk(client, &self.shared);
                    }
                }
            },
            Ok((name, _)) => match self.file(&name) {
                Some((kind, bytes)) => {
                    client.allow_bytes(bytes.len());
                    answer(&mut client, StatusCode::OK, kind, &bytes);
                }
                None => refuse(&mut client, StatusCode::NOT_FOUND),
            },
        }
    }

    /// The media type and the contents of a file of the page, or of the finished picture.
    fn file(&self, name: &str) -> Option<(&'static str, Cow<'static, [u8]>)> {
        let page_file = if name.is_empty() { "index.html" } else { name };
        if let Some((_, text)) = FILES.iter().find(|(known, _)| *known == page_file) {
            let kind = match name.rsplit_once('.') {
                Some((_, "js")) => "text/javascript; charset=utf-8",
                Some((_, "css")) => "text/css; charset=utf-8",
                _ => "text/html; charset=utf-8",
            };
            return Some((kind, text.as_bytes().into()));
        }
        let (name, kind) = PICTURES.iter().find(|(picture, _)| *picture == name)?;
        Some((kind, self.shared.gallery.file(name)?.into()))
    }

    /// The name that a request asks for, after the token. Fails with the status of the answer.
    fn name<'r>(&self, request: &'r Request) -> Result<&'r str, StatusCode> {
        let host = header(request, "host").filter(|host| *host == self.host || *host == self.local);
        let host = host.ok_or(StatusCode::FORBIDDEN)?;
        let path = request.uri().path_and_query().map_or("", |path| path.as_str());
        let (token, name) = path.strip_prefix('/').and_then(|path| path.split_once('/')).unwrap_or_default();
        // A browser names the origin of each WebSocket, and of each request from another page.
        let has_origin = request.headers().contains_key("origin") || name == SOCKET;
        if has_origin && header(request, "origin") != Some(&format!("http://{host}")) {
            return Err(StatusCode::FORBIDDEN);
        }
        if !is_same(token, &self.token) {
            return Err(StatusCode::NOT_FOUND);
        }
        Ok(name)
    }
}

/// A connection that counts until it is dropped.
struct Connection {
    server: Arc<Server>,
    number: u64,
}

impl Drop for Connection {
    fn drop(&mut self) {
        let mut connections = lock(&self.server.connections);
        connections.strangers.remove(&self.number);
        connections.known.remove(&self.number);
    }
}

/// Compares in the same time wherever the texts differ.
fn is_same(one: &str, other: &str) -> bool {
    let pairs = one.bytes().zip(other.bytes());
    one.len() == other.len() && pairs.fold(0, |all, (a, b)| black_box(all | (a ^ b))) == 0
}

/// The files of the page, inside the program.
macro_rules! files {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("../../page/", $name)))),*]
    };
}

/// Names and texts of the files of the page.
const FILES: &[(&str, &str)] = files![
    "index.html" "viewer.css" "style.css" "main.js" "ask.js" "blur.js" "parameters.js" "pointing.js" "places.js" "socket.js"
    "picture.js" "display.js" "zoom.js" "compare.js" "layers.js" "reading.js" "status.js" "save.js" "paint.js" "ramp.js"
    "readout.js" "wipe.js" "typing.js" "tone.js" "camera.js" "gestures.js" "panel.js" "edit.js"
];
