//! How fast `lookat view` shows a moving camera and a saved file. A client takes the place of a page.

mod client;

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{DQuat, DVec3};
use lookat_image::{MemoryBudget, TemporaryFile, TemporaryName, open_file};
use serde_json::{Value, json};

use super::bench_table::{BenchRow, BenchTable, Cell};
use client::{Client, ClientError};

/// As often as a display shows a frame, a page sends a camera.
const FRAME: Duration = Duration::from_micros(16_667);
/// How long the camera moves.
const MOVING: Duration = Duration::from_secs(5);
/// The angle that the camera turns in a frame, in radians.
const TURN: f64 = 0.01;
/// How often the file is saved, and the time in between.
const SAVES: u32 = 20;
const BETWEEN_SAVES: Duration = Duration::from_millis(400);

/// The copy of the scene that is saved.
const COPY: TemporaryName = TemporaryName { prefix: "lookat-bench-", suffix: ".pbrt", is_private: false };

const COLUMNS: [&str; 11] = [
    "pictures/s",
    "between, p50 ms",
    "p99",
    "camera to picture, p50 ms",
    "p99",
    "saved camera to picture, p50 ms",
    "p99",
    "saved light to picture, p50 ms",
    "p99",
    "start to picture, ms",
    "moving width",
];

/// Measures `lookat view` of scenes; `program` is lookat. Saves copies of the scenes beside them. Fails with the reason.
pub(super) fn latency(program: &Path, scenes: &[PathBuf]) -> Result<BenchTable, String> {
    let row = |scene: &PathBuf| {
        let cells = measured(program, scene).map_err(|reason| format!("{}: {reason}", scene.display()))?;
        let name = scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(BenchRow { name, cells: cells.map(|value| Cell::of([value])).to_vec() })
    };
    let rows = scenes.iter().map(row).collect::<Result<_, String>>()?;
    let title = format!(
        "a camera that moves for {} s, and {SAVES} saves of a camera and of a light",
        MOVING.as_secs()
    );
    Ok(BenchTable { name: "view", title, columns: COLUMNS.to_vec(), rows })
}

fn measured(program: &Path, scene: &Path) -> Result<[f64; COLUMNS.len()], ClientError> {
    let text = text(scene)?;
    world_begin(&text).ok_or(ClientError::Failed("WorldBegin is not in the scene file itself"))?;
    let folder = scene.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let mut copy = TemporaryFile::new(folder, COPY)?;
    save(&mut copy, &text)?;
    let started = Instant::now();
    let mut client = Client::start(program, copy.path())?;
    client.picture(|_| true)?;
    let start = ms(started.elapsed());
    let moving = moving(&mut client)?;
    let mut saves = |text: &[u8], edited: fn(&[u8], u32) -> Vec<u8>| {
        let mut times = Vec::new();
        for number in 1..=SAVES {
            // The full picture has begun.
            client.picture(|picture| picture.is_full)?;
            client.rest(BETWEEN_SAVES)?;
            let before = client.generation;
            let saved = save(&mut copy, &edited(text, number))?;
            client.picture(|picture| picture.generation != before)?;
            times.push(ms(saved.elapsed()));
        }
        Ok::<_, ClientError>(quantiles(times))
    };
    let [[s50, s99], [l50, l99]] =
        [saves(&text, with_camera)?, saves(&with_camera(&text, SAVES), with_light)?];
    let rate = moving.between.len() as f64 / MOVING.as_secs_f64();
    let [b50, b99] = quantiles(moving.between);
    let [c50, c99] = quantiles(moving.answers);
    Ok([rate, b50, b99, c50, c99, s50, s99, l50, l99, start, moving.width])
}

fn text(scene: &Path) -> io::Result<Vec<u8>> {
    let mut file = open_file(scene)?;
    let _twice = MemoryBudget::default().reserve(2 * file.metadata()?.len()).map_err(io::Error::other)?;
    let mut text = Vec::new();
    file.read_to_end(&mut text).map(|_| text)
}

/// As many editors do: another file is renamed. Returns the time before that.
fn save(copy: &mut TemporaryFile, text: &[u8]) -> io::Result<Instant> {
    let other = copy.path().with_extension("new");
    let mut file = File::create(&other)?;
    file.write_all(text)?;
    // On disk, so that renaming has nothing to write.
    file.sync_all()?;
    // The new file takes over the lock of the copy.
    let _ = file.try_lock();
    let saved = Instant::now();
    std::fs::rename(&other, copy.path())?;
    copy.file = file;
    Ok(saved)
}

/// The text with another camera.
fn with_camera(text: &[u8], number: u32) -> Vec<u8> {
    [format!("Translate {number}e-6 0 0 ").as_bytes(), text].concat()
}

/// The text with another light after `WorldBegin`, too faint to be seen.
fn with_light(text: &[u8], number: u32) -> Vec<u8> {
    let (before, after) = text.split_at(world_begin(text).unwrap_or(text.len()));
    [before, format!(" LightSource \"point\" \"rgb I\" [{number}e-9 0 0]").as_bytes(), after].concat()
}

/// The end of `WorldBegin`.
fn world_begin(text: &[u8]) -> Option<usize> {
    const WORLD: &[u8] = b"WorldBegin";
    text.windows(WORLD.len()).position(|word| word == WORLD).map(|start| start + WORLD.len())
}

/// The times of a camera that moves, in milliseconds.
struct Moving {
    between: Vec<f64>,
    answers: Vec<f64>,
    width: f64,
}

/// Turns the camera around its target.
fn moving(client: &mut Client) -> Result<Moving, ClientError> {
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
