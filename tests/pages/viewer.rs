//! `lookat view` as a process, and a page without a browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

const PATIENCE: Duration = Duration::from_secs(60);

pub struct Viewer {
    process: Child,
    /// The address and the port.
    pub host: String,
    pub token: String,
    pub folder: TempDir,
    pub scene: PathBuf,
}

impl Viewer {
    pub fn start(text: &str) -> Viewer {
        Viewer::start_with(text, &[])
    }

    pub fn start_with(text: &str, arguments: &[&str]) -> Viewer {
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("scene.pbrt");
        std::fs::write(&scene, text).unwrap();
        let mut process = Command::new(env!("CARGO_BIN_EXE_lookat"))
            .args(["view", "--threads", "2"])
            .args(arguments)
            .arg(&scene)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let (host, token) = address.trim().strip_prefix("http://").unwrap().split_once('/').unwrap();
        let token = token.strip_suffix('/').unwrap().to_owned();
        assert_eq!(token.len(), 32);
        assert!(host.starts_with("127.0.0.1:"));
        Viewer { process, host: host.into(), token, folder, scene }
    }

    /// The number of the process.
    pub fn process(&self) -> u32 {
        self.process.id()
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// The answer to a request, or its beginning if the connection stays open.
    pub fn ask(&self, request: &str) -> String {
        String::from_utf8_lossy(&self.ask_bytes(request)).into_owned()
    }

    fn ask_bytes(&self, request: &str) -> Vec<u8> {
        let mut stream = self.connect();
        // The server may answer before it has read everything.
        let _ = stream.write_all(request.as_bytes());
        let (mut answer, mut buffer) = (Vec::new(), [0; 4096]);
        while let Ok(count @ 1..) = stream.read(&mut buffer) {
            answer.extend_from_slice(&buffer[..count]);
            if answer.starts_with(b"HTTP/1.1 101") {
                break;
            }
        }
        answer
    }

    /// The answer to a page of the browser.
    pub fn get(&self, name: &str) -> String {
        String::from_utf8_lossy(&self.get_bytes(name)).into_owned()
    }

    pub fn get_bytes(&self, name: &str) -> Vec<u8> {
        self.ask_bytes(&format!("GET /{}/{name} HTTP/1.1\r\nHost: {}\r\n\r\n", self.token, self.host))
    }

    pub fn page(&self) -> Page {
        let address = format!("ws://{}/{}/socket", self.host, self.token);
        let mut request = address.into_client_request().unwrap();
        request.headers_mut().insert("origin", format!("http://{}", self.host).parse().unwrap());
        Page(tungstenite::client(request, self.connect()).unwrap().0)
    }

    pub fn write(&self, text: &str) {
        std::fs::write(&self.scene, text).unwrap();
    }

    pub fn text(&self) -> String {
        std::fs::read_to_string(&self.scene).unwrap()
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// What the numbers of a picture stand for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Content {
    Growing,
    Finished,
    Reference,
    Layer,
    Errors,
}

pub struct Picture {
    pub size: [u32; 2],
    pub generation: u32,
    pub number: u32,
    pub done: f64,
    pub total: f64,
    pub content: Content,
    pub is_final: bool,
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    fn new(bytes: &[u8]) -> Picture {
        let (head, body) = bytes.split_at(64);
        let head: Vec<f64> = head.as_chunks().0.iter().map(|it| f64::from_le_bytes(*it)).collect();
        let values: Vec<f32> = body.as_chunks().0.iter().map(|it| f32::from_le_bytes(*it)).collect();
        let size = [head[0] as u32, head[1] as u32];
        let pixels = values.as_chunks().0.to_vec();
        assert_eq!(pixels.len() as u32, size[0] * size[1]);
        assert!(head[4] <= head[5] && head[6] >= 0.0);
        let all = [Content::Growing, Content::Finished, Content::Reference, Content::Layer, Content::Errors];
        let content = all[head[7] as usize];
        let [generation, number] = [head[2], head[3]].map(|number| number as u32);
        let is_final = content == Content::Finished;
        Picture { size, generation, number, done: head[4], total: head[5], content, is_final, pixels }
    }
}

/// A page.
pub struct Page(WebSocket<TcpStream>);

impl Page {
    /// Asks for the lines that writing changes, or changes the files.
    pub fn edit(&mut self, by: u32, action: &str) -> Value {
        self.request(&match action {
            "show" => json!({"type": "show", "by": by}),
            _ => json!({"type": "edit", "by": by, "action": action}),
        });
        self.news("edited", |_| true)
    }

    pub fn send(&mut self, text: &str) {
        // The other side may have closed already.
        let _ = self.0.send(Message::text(text));
    }

    pub fn request(&mut self, request: &Value) {
        self.0.send(Message::text(request.to_string())).unwrap();
    }

    pub fn binary(&mut self, bytes: Vec<u8>) {
        self.0.send(Message::binary(bytes)).unwrap();
    }

    /// Waits for news of this type.
    pub fn news(&mut self, kind: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        self.wait(|message| {
            let news: Value = serde_json::from_str(message.to_text().ok()?).ok()?;
            (news["type"] == kind && is_it(&news)).then_some(news)
        })
    }

    pub fn picture(&mut self, is_it: impl Fn(&Picture) -> bool) -> Picture {
        self.wait(|message| match message {
            Message::Binary(bytes) => Some(Picture::new(bytes)).filter(&is_it),
            _ => None,
        })
    }

    /// Waits for the picture that `render` makes.
    pub fn finished(&mut self) -> Picture {
        self.picture(|picture| picture.is_final)
    }

    fn wait<T>(&mut self, find: impl Fn(&Message) -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        loop {
            let message = self.0.read().unwrap();
            if let Some(found) = find(&message) {
                return found;
            }
            assert!(Instant::now() < end);
        }
    }

    /// Waits until the other side has closed the connection.
    pub fn is_ended(&mut self) -> bool {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            match self.0.read() {
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => {
                    return false;
                }
                Err(_) => return true,
            }
        }
        false
    }
}
