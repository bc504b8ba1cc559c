//! How fast `lookat view` shows that the camera moves and that the file changes. A client takes the place of the page.

use std::io::{BufRead, BufReader, ErrorKind};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, Message, WebSocket};

use crate::bench::{BenchRow, BenchTable, Cell};

/// As often as a display shows a frame, a page sends a camera.
const FRAME: Duration = Duration::from_micros(16_667);
/// How long the camera moves.
const MOVING: Duration = Duration::from_secs(5);
/// How long a client waits for an answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// The angle that the camera turns in a frame, in radians.
const TURN: f64 = 0.01;
/// How often the file is saved, and the time in between.
const SAVES: u32 = 20;
const BETWEEN_SAVES: Duration = Duration::from_millis(400);

const COLUMNS: [&str; 9] = [
    "pictures/s",
    "between, p50 ms",
    "p99",
    "camera to picture, p50 ms",
    "p99",
    "save to picture, p50 ms",
    "p99",
    "start to picture, ms",
    "moving width",
];

/// Measures `lookat view` of scenes; `program` is lookat. Saves copies of the scenes beside them. Fails with the reason.
pub fn latency(program: &Path, scenes: &[PathBuf]) -> Result<BenchTable, String> {
    let row = |scene: &PathBuf| {
        let cells = measured(program, scene).map_err(|reason| format!("{}: {reason}", scene.display()))?;
        let name = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let cell = |value: f64| Cell { median: value, low: value, high: value };
        Ok(BenchRow { name, cells: cells.map(cell).to_vec() })
    };
    let rows = scenes.iter().map(row).collect::<Result<_, String>>()?;
    let title = format!("a camera that moves for {} s, and {SAVES} saves", MOVING.as_secs());
    Ok(BenchTable { name: "view", title, columns: COLUMNS.to_vec(), rows })
}

fn measured(program: &Path, scene: &Path) -> Result<[f64; COLUMNS.len()], String> {
    let text = std::fs::read(scene).map_err(|error| error.to_string())?;
    let folder = scene.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let copy = tempfile::Builder::new().prefix("lookat-bench-").suffix(".pbrt").tempfile_in(folder);
    let copy = copy.map_err(|error| error.to_string())?;
    // As many editors do: another file is renamed. Returns the time before that.
    let save = |number: u32| {
        // Before LookAt, so that only the camera changes.
        let moved = [format!("Translate {number}e-6 0 0 ").as_bytes(), &text].concat();
        let other = copy.path().with_extension("new");
        std::fs::write(&other, moved).map_err(|error| error.to_string())?;
        let saved = Instant::now();
        std::fs::rename(&other, copy.path()).map(|()| saved).map_err(|error| error.to_string())
    };
    save(0)?;
    let started = Instant::now();
    let mut client = Client::start(program, copy.path())?;
    client.picture(|_| true)?;
    let start = ms(started.elapsed());
    let moving = moving(&mut client)?;
    let mut saves = Vec::new();
    for number in 1..=SAVES {
        client.rest(BETWEEN_SAVES)?;
        let before = client.generation;
        let saved = save(number)?;
        client.picture(|picture| picture.generation != before)?;
        saves.push(ms(saved.elapsed()));
    }
    let rate = moving.between.len() as f64 / MOVING.as_secs_f64();
    let [b50, b99] = quantiles(moving.between);
    let [c50, c99] = quantiles(moving.answers);
    let [s50, s99] = quantiles(saves);
    Ok([rate, b50, b99, c50, c99, s50, s99, start, moving.width])
}

/// The times of a camera that moves, in milliseconds.
struct Moving {
    between: Vec<f64>,
    answers: Vec<f64>,
    width: f64,
}

/// Turns the camera around its target.
fn moving(client: &mut Client) -> Result<Moving, String> {
    let look_at = client.look_at.clone();
    let at = |index: usize| look_at.get(index).and_then(Value::as_f64).unwrap_or(0.0);
    let point = |first: usize| DVec3::new(at(first), at(first + 1), at(first + 2));
    let (eye, target, up) = (point(0), point(3), point(6));
    let axis = up.try_normalize().unwrap_or(DVec3::Y);
    let mut moving = Moving { between: Vec::new(), answers: Vec::new(), width: 0.0 };
    let (started, mut last, mut sent) = (Instant::now(), None, Vec::new());
    while started.elapsed() < MOVING {
        let turned = DQuat::from_axis_angle(axis, TURN * (sent.len() + 1) as f64) * (eye - target);
        let points = [target + turned, target, up].map(|p| p.to_array()).concat();
        sent.push(Instant::now());
        client.send(&json!({"type": "view", "by": 1, "number": sent.len(), "camera": {"lookAt": points}}))?;
        let end = started + FRAME * sent.len() as u32;
        while let Some(picture) = client.next(end.saturating_duration_since(Instant::now()))? {
            // Of the cameras before the first one, there is no time.
            let Some(asked) = sent.get((picture.number as usize).wrapping_sub(1)) else { continue };
            moving.answers.push(ms(asked.elapsed()));
            moving.between.extend(last.replace(Instant::now()).map(|last: Instant| ms(last.elapsed())));
            moving.width = picture.width;
        }
    }
    Ok(moving)
}

/// What the client needs to know of a picture.
struct Picture {
    width: f64,
    generation: f64,
    number: f64,
}

/// A page without a browser.
struct Client {
    program: Child,
    socket: WebSocket<TcpStream>,
    /// The newest camera and picture.
    look_at: Vec<Value>,
    generation: f64,
}

impl Client {
    fn start(program: &Path, scene: &Path) -> Result<Client, String> {
        let mut program = Command::new(program)
            .arg("view")
            .arg(scene)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| error.to_string())?;
        let mut address = String::new();
        let out = program.stdout.take().ok_or("lookat prints nothing")?;
        BufReader::new(out).read_line(&mut address).map_err(|error| error.to_string())?;
        let connected = connect(address.trim());
        if connected.is_err() {
            // It has no owner yet that ends it.
            let _ = program.kill();
        }
        Ok(Client { program, socket: connected?, look_at: Vec::new(), generation: 0.0 })
    }

    fn send(&mut self, request: &Value) -> Result<(), String> {
        self.socket.send(Message::text(request.to_string())).map_err(|error| error.to_string())
    }

    /// The next picture within this time.
    fn next(&mut self, time: Duration) -> Result<Option<Picture>, String> {
        let end = Instant::now() + time;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.socket.get_mut().set_read_timeout(Some(left)).map_err(|error| error.to_string())?;
            match self.socket.read() {
                Ok(Message::Binary(bytes)) => {
                    let picture = picture(&bytes).ok_or("a picture is too short")?;
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
                Err(error) => return Err(error.to_string()),
            }
        }
    }

    /// Waits for a picture.
    fn picture(&mut self, is_it: impl Fn(&Picture) -> bool) -> Result<(), String> {
        while let Some(picture) = self.next(PATIENCE)? {
            if is_it(&picture) {
                return Ok(());
            }
        }
        Err("no picture comes: check the scene".into())
    }

    /// Takes what comes for a while.
    fn rest(&mut self, time: Duration) -> Result<(), String> {
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

fn connect(address: &str) -> Result<WebSocket<TcpStream>, String> {
    let host = address.strip_prefix("http://").and_then(|rest| rest.split('/').next());
    let host = host.ok_or("lookat prints no address")?;
    let stream = TcpStream::connect(host).map_err(|error| error.to_string())?;
    let socket = format!("{}socket", address.replacen("http", "ws", 1));
    let mut request = socket.into_client_request().map_err(|error| error.to_string())?;
    let origin = format!("http://{host}").parse().map_err(|_| "the address is none")?;
    request.headers_mut().insert("origin", origin);
    tungstenite::client(request, stream).map(|(socket, _)| socket).map_err(|error| error.to_string())
}

/// The numbers before the pixels of a picture.
fn picture(bytes: &[u8]) -> Option<Picture> {
    let number = |at: usize| Some(f64::from_le_bytes(*bytes.get(8 * at..)?.first_chunk()?));
    Some(Picture { width: number(0)?, generation: number(2)?, number: number(3)? })
}

fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

/// The median and the 99th percentile.
fn quantiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * values.len() as f64).ceil() as usize;
        values.get(index.saturating_sub(1)).copied().unwrap_or(f64::NAN)
    };
    [at(0.5), at(0.99)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_were_measured() {
        assert_eq!(quantiles((1..=200).map(f64::from).rev().collect()), [100.0, 198.0]);
        assert_eq!(quantiles(vec![3.0]), [3.0, 3.0]);
        assert!(quantiles(Vec::new())[0].is_nan());
    }
}
