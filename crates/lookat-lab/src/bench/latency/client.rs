//! A client that takes the place of a page.

use std::io::{self, BufRead, BufReader, ErrorKind};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use lookat_image::io_reason;
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, Message, WebSocket};

/// How long a client waits for an answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// The number of finished pictures in messages.
const FINISHED: f64 = 1.0;

/// The reason why a client cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    #[error("{}", io_reason(.0))]
    Io(#[from] io::Error),
    #[error(transparent)]
    Socket(#[from] Error),
    #[error("{0}")]
    Failed(&'static str),
}

/// What the client needs to know of a picture.
pub struct Picture {
    pub width: f64,
    pub generation: f64,
    pub number: f64,
    /// Whether it is the picture that `render` makes, finished or not.
    pub is_full: bool,
}

/// A page without a browser.
pub struct Client {
    program: Child,
    socket: WebSocket<TcpStream>,
    /// The newest camera and picture.
    pub look_at: Vec<Value>,
    pub generation: f64,
}

impl Client {
    pub fn start(program: &Path, scene: &Path) -> Result<Client, ClientError> {
        let mut program = Command::new(program)
            .arg("view")
            .arg(scene)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let mut address = String::new();
        let out = program.stdout.take().ok_or(ClientError::Failed("lookat prints nothing"))?;
        BufReader::new(out).read_line(&mut address)?;
        let connected = connect(address.trim());
        if connected.is_err() {
            // It has no owner yet that ends it.
            let _ = program.kill();
        }
        Ok(Client { program, socket: connected?, look_at: Vec::new(), generation: 0.0 })
    }

    pub fn send(&mut self, request: &Value) -> Result<(), ClientError> {
        Ok(self.socket.send(Message::text(request.to_string()))?)
    }

    /// The next picture within this time.
    pub fn next(&mut self, time: Duration) -> Result<Option<Picture>, ClientError> {
        let end = Instant::now() + time;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.socket.get_mut().set_read_timeout(Some(left))?;
            match self.socket.read() {
                Ok(Message::Binary(bytes)) => {
                    let picture = picture(&bytes).ok_or(ClientError::Failed("a picture is too short"))?;
                    self.generation = picture.generation;
                    return Ok(Some(picture));
                }
                Ok(Message::Text(text)) => {
                    let news: Value = serde_json::from_str(&text).unwrap_or_default();
                    if let Some(points) = news["camera"]["lookAt"].as_array() {
                        self.look_at = points.clone();
                    }
                }
                Ok(_) => {}
                Err(Error::Io(error))
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    return Ok(None);
                }
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// Waits for a picture.
    pub fn picture(&mut self, is_it: impl Fn(&Picture) -> bool) -> Result<(), ClientError> {
        while let Some(picture) = self.next(PATIENCE)? {
            if is_it(&picture) {
                return Ok(());
            }
        }
        Err(ClientError::Failed("no picture comes: check the scene"))
    }

    /// Takes what comes for a while.
    pub fn rest(&mut self, time: Duration) -> Result<(), ClientError> {
        let end = Instant::now() + time;
        while self.next(end.saturating_duration_since(Instant::now()))?.is_some() {}
        Ok(())
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn connect(address: &str) -> Result<WebSocket<TcpStream>, ClientError> {
    let host = address.strip_prefix("http://").and_then(|rest| rest.split('/').next());
    let host = host.ok_or(ClientError::Failed("lookat prints no address"))?;
    let stream = TcpStream::connect(host)?;
    let socket = format!("{}socket", address.replacen("http", "ws", 1));
    let mut request = socket.into_client_request()?;
    let origin = format!("http://{host}").parse().map_err(|_| ClientError::Failed("the address is none"))?;
    request.headers_mut().insert("origin", origin);
    let (socket, _) = tungstenite::client(request, stream)
        .map_err(|_| ClientError::Failed("lookat does not accept the connection"))?;
    Ok(socket)
}

/// The numbers before the pixels of a picture.
fn picture(bytes: &[u8]) -> Option<Picture> {
    let number = |at: usize| Some(f64::from_le_bytes(*bytes.get(8 * at..)?.first_chunk()?));
    let (done, total, content) = (number(4)?, number(5)?, number(7)?);
    let is_full = done < total || content == FINISHED;
    Some(Picture { width: number(0)?, generation: number(2)?, number: number(3)?, is_full })
}
