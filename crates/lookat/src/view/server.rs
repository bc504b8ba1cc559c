//! The server of the page: who may connect, and what they get.

use std::borrow::Cow;
use std::hint::black_box;
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::Builder;
use std::time::Duration;

use lookat_image::io_reason;
use tungstenite::handshake::server::create_response;
use tungstenite::http::{Method, Request, StatusCode};

use super::files::FILES;
use super::gallery::Gallery;
use super::http::{answer, header, read_head, refuse, upgrade};
use super::outbox::Hub;
use super::requests::Requests;
use super::socket::talk;
use super::timed::Timed;

/// The most connections at a time.
const MOST_CONNECTIONS: usize = 32;
/// The time to send the head of a request, and then to take the answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// The name of the WebSocket.
const SOCKET: &str = "socket";

/// The names of the finished picture, and their media types.
const PICTURES: [(&str, &str); 2] = [("picture.exr", "image/x-exr"), ("picture.png", "image/png")];

/// A server for one scene.
pub struct Server {
    /// The name and port that the browser must ask for. Another name is a page elsewhere that had its name point here.
    host: String,
    /// The same with the name `localhost`.
    local: String,
    /// The first part of all paths. Only who has seen the address knows it.
    token: String,
    requests: Arc<Requests>,
    hub: Arc<Hub>,
    gallery: Arc<Gallery>,
    connections: AtomicUsize,
}

impl Server {
    pub fn new(
        listener: &TcpListener,
        requests: Arc<Requests>,
        hub: Arc<Hub>,
        gallery: Arc<Gallery>,
    ) -> Result<Server, String> {
        let place = listener.local_addr().map_err(|error| io_reason(&error))?;
        let mut token = [0; 16];
        getrandom::fill(&mut token).map_err(|error| format!("the system gives no random bytes: {error}"))?;
        let token = token.iter().map(|byte| format!("{byte:02x}")).collect();
        // Browsers leave the usual port out.
        let host = if place.port() == 80 { place.ip().to_string() } else { place.to_string() };
        let local = host.replace(&place.ip().to_string(), "localhost");
        Ok(Server { host, local, token, requests, hub, gallery, connections: AtomicUsize::new(0) })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.host, self.token)
    }

    /// Serves from now on, on threads of its own.
    pub fn start(self, listener: TcpListener) -> Result<(), String> {
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
        Builder::new().spawn(accept).map(drop).map_err(|error| io_reason(&error))
    }

    /// Gives a connection a thread, or closes it if there are too many.
    fn connect(self: Arc<Self>, stream: TcpStream) {
        if self.connections.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
            self.connections.fetch_sub(1, Ordering::Relaxed);
            return;
        }
        let connection = Connection(self);
        let _ = Builder::new().spawn(move || connection.0.serve(stream));
    }

    fn serve(&self, stream: TcpStream) {
        let _ = stream.set_nodelay(true);
        let mut client = Timed::new(stream, PATIENCE);
        let request =
            read_head(&mut client).and_then(|request| Ok((self.name(&request)?.to_owned(), request)));
        client.allow(PATIENCE);
        match request {
            Err(status) => refuse(&mut client, status),
            Ok((name, request)) if name == SOCKET => match create_response(&request) {
                Err(_) => refuse(&mut client, StatusCode::BAD_REQUEST),
                Ok(response) => {
                    if upgrade(&mut client, &response).is_ok() {
                        talk(client, &self.requests, &self.hub);
                    }
                }
            },
            Ok((name, _)) => match self.file(&name) {
                Some((kind, bytes)) => {
                    // One second more for each 4 MiB.
                    client.allow(PATIENCE + Duration::from_secs(bytes.len() as u64 >> 22));
                    answer(&mut client, StatusCode::OK, kind, &bytes);
                }
                None => refuse(&mut client, StatusCode::NOT_FOUND),
            },
        }
    }

    /// The media type and the contents of a file of the page, or of the finished picture.
    fn file(&self, name: &str) -> Option<(&'static str, Cow<'static, [u8]>)> {
        if let Some(file) = FILES.iter().find(|file| file.name == name) {
            return Some((file.kind, file.text.as_bytes().into()));
        }
        let (name, kind) = PICTURES.iter().find(|(picture, _)| *picture == name)?;
        Some((kind, self.gallery.file(name)?.into()))
    }

    /// The name that a request asks for, after the token. Fails with the status of the answer.
    fn name<'r>(&self, request: &'r Request<()>) -> Result<&'r str, StatusCode> {
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
        if request.method() != Method::GET {
            return Err(StatusCode::METHOD_NOT_ALLOWED);
        }
        Ok(name)
    }
}

/// A connection that counts until it is dropped.
struct Connection(Arc<Server>);

impl Drop for Connection {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Compares in the same time wherever the texts differ.
fn is_same(one: &str, other: &str) -> bool {
    let pairs = one.bytes().zip(other.bytes());
    one.len() == other.len() && pairs.fold(0, |all, (a, b)| black_box(all | (a ^ b))) == 0
}
