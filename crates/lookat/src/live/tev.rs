//! The viewer tev, through the packets that its README and `Ipc.cpp` describe.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

use lookat_image::{Image, io_reason};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use crate::writer::Writer;

/// The longest wait for tev.
const PATIENCE: Duration = Duration::from_secs(5);
/// The most pixels of a packet.
const PIXELS: usize = 1 << 18;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A connection to tev, on a thread of its own.
pub struct Tev {
    writer: Writer<Frame>,
    address: String,
    /// The picture that is rendered, without planes.
    begun: Frame,
}

/// A picture so far.
#[derive(Clone, Default)]
struct Frame {
    /// Counts the pictures of a run.
    number: u32,
    name: String,
    size: [u32; 2],
    /// Red, green and blue. `None` for a black picture.
    planes: Option<[Vec<f32>; 3]>,
}

impl Tev {
    /// Connects to tev. Warns if nothing answers.
    pub fn connect(address: &str) -> Option<Tev> {
        let connected = connection(address).and_then(|stream| {
            let (mut client, mut number, name) = (TevClient::wrap(stream), 0, address.to_owned());
            Writer::new(move |frame: Frame, progress| {
                let is_new = frame.number != std::mem::replace(&mut number, frame.number);
                match frame.send(&mut client, is_new, progress) {
                    Ok(()) => ControlFlow::Continue(()),
                    Err(error) => {
                        let reason = io_reason(&error);
                        say!("warning: lost tev at {name}: {reason}; rendering without it");
                        ControlFlow::Break(())
                    }
                }
            })
        });
        match connected {
            Ok(writer) => Some(Tev { writer, address: address.into(), begun: Frame::default() }),
            Err(error) => {
                let reason = io_reason(&error);
                say!(
                    "warning: cannot reach tev at {address}: {reason}; start tev, or correct --tev; rendering without it"
                );
                None
            }
        }
    }

    /// Creates a black picture. A picture of the same name is replaced.
    pub fn begin(&mut self, file: &Path, size: [u32; 2]) {
        let name = file.display().to_string().replace('\0', "");
        self.begun = Frame { number: self.begun.number + 1, name, size, planes: None };
        self.put(self.begun.clone());
    }

    /// Shows the picture so far, in place of what waits of it.
    pub fn show(&self, image: &Image) {
        let planes = image.rgb_planes().map(|planes| planes.map(|plane| plane.to_vec()));
        self.put(Frame { planes, ..self.begun.clone() });
    }

    fn put(&self, frame: Frame) {
        self.writer.put(|queue| {
            queue.retain(|other| other.number != frame.number);
            queue.push_back(frame);
        });
    }

    /// True if tev has taken all pictures so far.
    pub fn is_idle(&self) -> bool {
        self.writer.is_idle()
    }

    /// Waits until tev has the picture. Warns if it does not read.
    pub fn wait(&self) {
        if !self.writer.wait(|| true) {
            let address = &self.address;
            say!("warning: tev at {address} does not respond; it does not show the newest picture");
        }
    }
}

impl Frame {
    /// Sends all pixels, in bands of rows, and first creates the picture if it is new.
    fn send(&self, client: &mut TevClient, is_new: bool, progress: &dyn Fn()) -> io::Result<()> {
        let (image_name, [width, height]) = (self.name.as_str(), self.size);
        if is_new {
            client.send(PacketCreateImage {
                image_name,
                grab_focus: true,
                width,
                height,
                channel_names: &CHANNELS,
            })?;
        }
        let Some(planes) = &self.planes else { return Ok(()) };
        let rows = (PIXELS / width as usize).max(1);
        for y in (0..height).step_by(rows) {
            let band = (height - y).min(rows as u32);
            let (start, pixels) = ((y * width) as usize, u64::from(band) * u64::from(width));
            let data: Vec<f32> =
                planes.iter().flat_map(|plane| &plane[start..start + pixels as usize]).copied().collect();
            client.send(PacketUpdateImage {
                image_name,
                grab_focus: false,
                channel_names: &CHANNELS,
                channel_offsets: &[0, pixels, 2 * pixels],
                channel_strides: &[1; 3],
                x: 0,
                y,
                width,
                height: band,
                data: &data,
            })?;
            progress();
        }
        Ok(())
    }
}

fn connection(address: &str) -> io::Result<TcpStream> {
    let mut error = io::ErrorKind::NotFound.into();
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE))?;
                return Ok(stream);
            }
            Err(other) => error = other,
        }
    }
    Err(error)
}
