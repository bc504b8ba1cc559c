//! A picture shown while it is rendered: in the terminal, in the viewer tev, and again after each change of its files.

pub mod protocol;
mod tev;
mod watch;

use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use lookat_image::{Encoded, Image};
use lookat_render::Progress;

use crate::args::{LiveView, Protocol, Tone};
use crate::failure::Failure;
use crate::live::protocol::Drawing;
use crate::live::tev::Tev;
pub use crate::live::watch::Watch;
use crate::writer::lock;
use crate::{interrupt, standard_error};

/// The shortest time between two updates. The picture takes at most a tenth of the time of a thread.
const STEP: Duration = Duration::from_millis(250);

/// Where the picture is shown.
pub struct Live {
    views: Mutex<Views>,
    tone: Tone,
    /// The files of the scene, with `--watch`.
    pub watch: Option<Watch>,
}

struct Views {
    terminal: Option<Terminal>,
    tev: Option<Tev>,
    next: Instant,
}

impl Live {
    /// Fails without a terminal for `--show`.
    pub fn new(arguments: &LiveView, tone: Tone) -> Result<Live, Failure> {
        let terminal = arguments.show.map(Terminal::new).transpose()?;
        let tev = arguments.tev.as_deref().and_then(Tev::connect);
        let views = Mutex::new(Views { terminal, tev, next: Instant::now() });
        Ok(Live { views, tone, watch: arguments.watch.then(|| Watch::new(|| ())) })
    }

    /// Begins a picture of this file and size.
    pub fn begin(&self, file: &Path, size: [u32; 2]) {
        let mut views = lock(&self.views);
        views.next = Instant::now() + STEP;
        if let Some(terminal) = &mut views.terminal {
            terminal.begin();
        }
        if let Some(tev) = &mut views.tev {
            tev.begin(file, size);
        }
    }

    /// Shows the picture so far, a few times per second, where the one before is shown.
    pub fn update(&self, progress: &Progress) {
        // Another thread is showing the picture.
        let Ok(mut views) = self.views.try_lock() else { return };
        let started = Instant::now();
        if started < views.next || !views.any_is_idle() || interrupt::flow().is_break() {
            return;
        }
        views.show(progress.snapshot(), self.tone);
        views.next = Instant::now() + STEP.max(10 * started.elapsed());
    }

    /// Shows the finished picture.
    pub fn finish(&self, image: &Image) {
        let views = lock(&self.views);
        if views.is_used() && interrupt::flow().is_continue() {
            views.show(image.clone(), self.tone);
        }
    }

    /// Waits until the picture is shown, unless its viewer does not read.
    pub fn wait(&self) {
        crate::wait_for_messages();
        if let Some(tev) = &lock(&self.views).tev {
            tev.wait();
        }
    }

    /// Tells the rendering to stop after a signal, or after a change of its files.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.is_outdated() { ControlFlow::Break(()) } else { interrupt::flow() }
    }

    /// True if a file of the scene has changed since it was read.
    pub fn is_outdated(&self) -> bool {
        self.watch.as_ref().is_some_and(Watch::has_changed)
    }
}

impl Views {
    fn is_used(&self) -> bool {
        self.terminal.is_some() || self.tev.is_some()
    }

    /// True if a view would show a picture at once.
    fn any_is_idle(&self) -> bool {
        self.terminal.is_some() && standard_error::is_idle() || self.tev.as_ref().is_some_and(Tev::is_idle)
    }

    /// Shows the picture with the exposure and the tone curve of an 8-bit file.
    fn show(&self, mut image: Image, tone: Tone) {
        tone.mapping(&image).apply(&mut image);
        if let Some(terminal) = &self.terminal {
            terminal.show(&image);
        }
        if let Some(tev) = &self.tev {
            tev.show(&image);
        }
    }
}

/// Lines of the terminal that stay free for the bar and the prompt.
const FREE: u32 = 2;

/// The terminal of standard error.
pub struct Terminal {
    protocol: Protocol,
    /// The number of the picture for the terminal.
    id: u32,
}

/// The size of a terminal, in characters and in pixels.
#[derive(Debug, Clone, Copy)]
struct Size {
    characters: [u32; 2],
    pixels: [u32; 2],
}

impl Terminal {
    /// Fails without a terminal.
    pub fn new(protocol: Protocol) -> Result<Terminal, Failure> {
        if !io::stderr().is_terminal() {
            bail!("--show draws in the terminal, but standard error is not a terminal; remove --show");
        }
        let variable = |name: &str| std::env::var(name).ok();
        let protocol = if protocol == Protocol::Auto { protocol::known(&variable) } else { protocol };
        Ok(Terminal { protocol, id: std::process::id() << 8 })
    }

    /// Begins another picture below.
    pub fn begin(&mut self) {
        self.id += 1;
    }

    /// Draws the picture, over the one before.
    pub fn show(&self, image: &Image) {
        if let Some(drawing) = self.drawing(image, size()) {
            standard_error::draw(drawing);
        }
    }

    /// `None` for a picture without colors.
    fn drawing(&self, image: &Image, size: Size) -> Option<Drawing> {
        let (pixels, source) = (image.rgb()?, image.data_window.size());
        let cell = match self.protocol {
            Protocol::Blocks => [1, 2],
            _ => [0, 1].map(|axis| (size.pixels[axis] / size.characters[axis]).max(1)),
        };
        let area = [size.characters[0] * cell[0], size.characters[1].saturating_sub(FREE).max(1) * cell[1]];
        let target = fitting(source, area);
        Some(Drawing {
            size: target,
            cells: [target[0].div_ceil(cell[0]), target[1].div_ceil(cell[1])],
            pixels: bytes(&Encoded::from_linear(&shrunk(&pixels, source, target))),
            id: self.id,
            protocol: self.protocol,
        })
    }
}

/// The largest size within an area that has the proportions of a picture, and is not larger than it.
fn fitting([width, height]: [u32; 2], area: [u32; 2]) -> [u32; 2] {
    let share = (f64::from(area[0]) / f64::from(width)).min(f64::from(area[1]) / f64::from(height)).min(1.0);
    [width, height].map(|side| ((f64::from(side) * share) as u32).max(1))
}

/// A smaller picture: each pixel is the mean of the pixels that it covers.
fn shrunk(pixels: &[[f32; 3]], [width, height]: [u32; 2], [columns, rows]: [u32; 2]) -> Vec<[f32; 3]> {
    let span = |at: u32, from: u32, to: u32| {
        let edge = |at: u32| (u64::from(at) * u64::from(from) / u64::from(to)) as usize;
        edge(at)..edge(at + 1)
    };
    let mut out = Vec::with_capacity((columns * rows) as usize);
    for row in 0..rows {
        for column in 0..columns {
            let (across, down) = (span(column, width, columns), span(row, height, rows));
            let count = (across.len() * down.len()) as f32;
            let mut sum = [0.0; 3];
            for y in down {
                for pixel in &pixels[y * width as usize..][across.clone()] {
                    for (sum, value) in sum.iter_mut().zip(pixel) {
                        *sum += value;
                    }
                }
            }
            out.push(sum.map(|sum| sum / count));
        }
    }
    out
}

fn bytes(encoded: &Encoded) -> Vec<[u8; 3]> {
    encoded.pixels.iter().map(|pixel| pixel.map(|value| (255.0 * value).round() as u8)).collect()
}

/// The size of the terminal. Where it is unknown, 80 by 24 characters of 8 by 16 pixels.
fn size() -> Size {
    let known = known_size().filter(|size| size.characters.iter().all(|count| *count > 0));
    let Size { characters, pixels } = known.unwrap_or(Size { characters: [80, 24], pixels: [0; 2] });
    let pixels = if pixels.contains(&0) { [characters[0] * 8, characters[1] * 16] } else { pixels };
    Size { characters, pixels }
}

#[cfg(unix)]
fn known_size() -> Option<Size> {
    let size = rustix::termios::tcgetwinsize(io::stderr()).ok()?;
    let [columns, rows, x, y] = [size.ws_col, size.ws_row, size.ws_xpixel, size.ws_ypixel].map(u32::from);
    Some(Size { characters: [columns, rows], pixels: [x, y] })
}

#[cfg(not(unix))]
fn known_size() -> Option<Size> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use lookat_image::Window;

    const SIZE: Size = Size { characters: [80, 24], pixels: [640, 384] };

    fn picture(width: u32, height: u32, color: impl Fn(u32, u32) -> [f32; 3]) -> Image {
        let window = Window { x: 0, y: 0, width, height };
        let pixels: Vec<_> =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| color(x, y)).collect();
        Image::from_rgb(window, window, &pixels)
    }

    #[test]
    fn pictures_shrink_to_the_terminal_and_never_grow() {
        assert_eq!(fitting([800, 400], [80, 44]), [80, 40]);
        assert_eq!(fitting([400, 800], [80, 44]), [22, 44]);
        assert_eq!(fitting([10, 10], [80, 44]), [10, 10]);
        assert_eq!(fitting([100_000, 1], [80, 44]), [80, 1]);
        let mean = shrunk(&[[1.0; 3], [3.0; 3], [5.0; 3], [7.0; 3], [0.0; 3], [2.0; 3]], [2, 3], [1, 2]);
        assert_eq!(mean, [[2.0; 3], [3.5; 3]]);
    }

    /// A new drawing begins where the one before began, and ends on the line below it.
    #[test]
    fn drawings_replace_each_other() {
        for protocol in [Protocol::Blocks, Protocol::Kitty, Protocol::Iterm, Protocol::Sixel] {
            let terminal = Terminal { protocol, id: 7 };
            let draw = |image: &Image, before: u32| {
                String::from_utf8(terminal.drawing(image, SIZE).unwrap().over(before)).unwrap()
            };
            let image = picture(64, 32, |x, y| [x as f32 / 64.0, y as f32 / 32.0, 0.5]);
            let lines = if protocol == Protocol::Blocks { 16 } else { 2 };
            let (first, second) = (draw(&image, 0), draw(&image, lines));
            assert_eq!(second, format!("\x1b[{lines}A\r{}", first.strip_prefix("\x1b[J").unwrap()));
            assert_eq!(first.matches('\n').count(), lines as usize, "{protocol:?}");
            // A picture of another size clears what it does not cover.
            let higher = picture(64, 64, |_, _| [0.0; 3]);
            let third = draw(&higher, lines);
            assert!(third.starts_with(&format!("\x1b[{lines}A\r\x1b[J")), "{protocol:?}");
        }
    }
}
