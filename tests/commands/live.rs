//! Pictures that are shown as they grow, and rendered again.

use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::process::Child;
use std::time::{Duration, Instant};

use super::*;

/// A packet of tev, as its `Ipc.cpp` reads it.
struct Packet {
    bytes: Vec<u8>,
    at: usize,
}

impl Packet {
    /// The next packet: its length, which counts itself, and its type first.
    fn read(stream: &mut TcpStream) -> Option<Packet> {
        let mut length = [0; 4];
        stream.read_exact(&mut length).ok()?;
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut bytes).unwrap();
        Some(Packet { bytes, at: 0 })
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.at += N;
        self.bytes[self.at - N..self.at].try_into().unwrap()
    }

    fn byte(&mut self) -> u8 {
        self.take::<1>()[0]
    }

    fn int(&mut self) -> usize {
        i32::from_le_bytes(self.take()) as usize
    }

    fn text(&mut self) -> String {
        let end = self.bytes[self.at..].iter().position(|byte| *byte == 0).unwrap();
        let text = String::from_utf8(self.bytes[self.at..self.at + end].to_vec()).unwrap();
        self.at += end + 1;
        text
    }
}

/// A picture as tev has it: its name, size and channels.
#[derive(Default)]
struct Viewer {
    name: String,
    size: [usize; 2],
    channels: Vec<(String, Vec<f32>)>,
    updates: usize,
}

impl Viewer {
    fn receive(&mut self, packet: &mut Packet) {
        match packet.byte() {
            // CreateImage
            4 => {
                assert_eq!(packet.byte(), 1, "it comes to the front");
                self.name = packet.text();
                self.size = [packet.int(), packet.int()];
                let count = packet.int();
                let pixels = self.size[0] * self.size[1];
                self.channels = (0..count).map(|_| (packet.text(), vec![0.0; pixels])).collect();
            }
            // UpdateImage, version 3
            6 => {
                self.updates += 1;
                packet.byte();
                assert_eq!(packet.text(), self.name);
                let count = packet.int();
                let names: Vec<String> = (0..count).map(|_| packet.text()).collect();
                let [x, y, width, height] = [(); 4].map(|()| packet.int());
                let mut longs = || -> Vec<usize> {
                    (0..count).map(|_| i64::from_le_bytes(packet.take()) as usize).collect()
                };
                let (offsets, strides) = (longs(), longs());
                let data: Vec<f32> = packet.bytes[packet.at..]
                    .chunks(4)
                    .map(|it| f32::from_le_bytes(it.try_into().unwrap()))
                    .collect();
                for (channel, name) in names.iter().enumerate() {
                    let (_, samples) = self.channels.iter_mut().find(|(known, _)| known == name).unwrap();
                    for pixel in 0..width * height {
                        let place = (y + pixel / width) * self.size[0] + x + pixel % width;
                        samples[place] = data[offsets[channel] + pixel * strides[channel]];
                    }
                }
                return;
            }
            other => panic!("packet {other}"),
        }
        assert_eq!(packet.at, packet.bytes.len());
    }
}

#[test]
fn tev_gets_the_picture_as_it_grows() {
    let folder = Folder::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let viewer = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut viewer = Viewer::default();
        while let Some(mut packet) = Packet::read(&mut stream) {
            viewer.receive(&mut packet);
        }
        viewer
    });
    // Longer than a few updates take.
    let image = folder.picture(&["--tev", &address, "--time", "2", "--crop", "0", "0.5", "0", "1"]);
    let viewer = viewer.join().unwrap();
    assert_eq!((viewer.name.as_str(), viewer.size), ("picture.exr", [16, 24]));
    assert!(viewer.updates > 2, "{}", viewer.updates);
    assert_eq!(viewer.channels.len(), 3);
    for (name, samples) in &viewer.channels {
        assert_eq!(image.channel(name).unwrap(), samples, "{name}");
    }
}

#[test]
fn without_tev_a_warning_is_given_and_the_picture_is_rendered() {
    let folder = Folder::new();
    // Nothing listens at a port that was free a moment ago.
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let run = folder.run(&["render", "fine.pbrt", "--tev", &address]);
    let warning = format!("warning: cannot reach tev at {address}: ");
    assert!(
        run.status == 0 && run.err.matches("tev").count() >= 1 && run.err.starts_with(&warning),
        "{}",
        run.err
    );
    assert!(folder.path("fine.exr").exists());
    let run = folder.run(&["render", "fine.pbrt", "--tev", "localhost"]);
    assert!(
        run.status == 2 && run.err.contains("expected a host and a port, as in 127.0.0.1:14158"),
        "{}",
        run.err
    );
}

#[test]
fn a_picture_is_shown_in_terminals_alone() {
    let folder = Folder::new();
    let before = folder.names();
    let run = folder.run(&["render", "fine.pbrt", "--show"]);
    assert_eq!((run.status, run.out.as_str()), (2, ""));
    assert_eq!(
        run.err,
        "error: --show draws in the terminal, but standard error is not a terminal; remove --show\n"
    );
    assert_eq!(folder.names(), before);
}

/// `lookat render --watch`, and what it has said so far.
struct Watching<'f> {
    folder: &'f Folder,
    child: Child,
}

impl Watching<'_> {
    fn begin<'f>(folder: &'f Folder, arguments: &[&str]) -> Watching<'f> {
        let out = std::fs::File::create(folder.path("said.txt")).unwrap();
        let mut command =
            folder.command(&[&["render", "fine.pbrt", "-o", "a.exr", "--watch"], arguments].concat());
        let child = command.stdout(Stdio::null()).stderr(out).spawn().unwrap();
        Watching { folder, child }
    }

    fn said(&self) -> String {
        std::fs::read_to_string(self.folder.path("said.txt")).unwrap()
    }

    /// Waits until it has said something so many times.
    #[track_caller]
    fn wait(&self, text: &str, times: usize) {
        let started = Instant::now();
        while self.said().matches(text).count() < times {
            assert!(started.elapsed() < Duration::from_secs(100), "{text}: {}", self.said());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn picture(&self) -> Image {
        Image::read(&self.folder.path("a.exr")).unwrap()
    }
}

impl Drop for Watching<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_saved_scene_is_rendered_again() {
    const WAITS: &str = "watching for changes";
    let folder = Folder::new();
    folder.write("fine.pbrt", &FINE.replace("Shape \"sphere\"", "Include \"part.pbrt\""));
    folder.write("part.pbrt", "Shape \"sphere\"");
    let mut watching = Watching::begin(&folder, &[]);
    watching.wait(WAITS, 1);
    let first = watching.picture();
    // An included file, saved in place.
    folder.write("part.pbrt", "Shape \"sphere\" \"float radius\" .5");
    watching.wait(WAITS, 2);
    let second = watching.picture();
    assert_ne!(first.channels, second.channels);
    // A mistake, saved by renaming.
    folder.write("new.pbrt", "Shape \"sphrere\"");
    std::fs::rename(folder.path("new.pbrt"), folder.path("part.pbrt")).unwrap();
    watching.wait(WAITS, 3);
    assert!(watching.said().contains("did you mean \"sphere\"?"), "{}", watching.said());
    assert_eq!(watching.picture().channels, second.channels);
    // A missing file, which appears later.
    std::fs::remove_file(folder.path("part.pbrt")).unwrap();
    watching.wait(WAITS, 4);
    assert!(watching.said().contains("cannot include part.pbrt"), "{}", watching.said());
    folder.write("part.pbrt", "Shape \"sphere\"");
    watching.wait(WAITS, 5);
    assert_eq!(watching.picture().channels, first.channels);
    // Nothing is saved, and nothing is rendered.
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(watching.said().matches(WAITS).count(), 5);
    #[cfg(unix)]
    {
        let id = watching.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        assert_eq!(watching.child.wait().unwrap().code(), Some(130));
    }
}

/// What is saved while a picture is rendered begins another one.
#[test]
fn a_save_interrupts_the_rendering() {
    let folder = Folder::new();
    let slow = FINE.replace("pixelsamples\" 4", "pixelsamples\" 1000000000");
    folder.write("fine.pbrt", &slow);
    let watching = Watching::begin(&folder, &[]);
    // Says how much is left.
    watching.wait(" left", 1);
    folder.write("fine.pbrt", FINE);
    watching.wait("watching for changes", 1);
    assert_eq!(watching.picture().channels, folder.picture(&[]).channels);
    assert!(!folder.path("a.partial.exr").exists());
    for (arguments, message) in [
        (&["fine.pbrt", "wrong.pbrt", "--watch"][..], "--watch takes one scene"),
        (&["-", "--watch"], "with --watch, name a file"),
        (&["fine.pbrt", "--watch", "--turntable", "3"], "cannot be used with"),
    ] {
        let run = folder.run(&[&["render"], arguments].concat());
        assert!(run.status == 2 && run.err.contains(message), "{arguments:?}: {}", run.err);
    }
}
