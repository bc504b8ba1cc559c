//! The viewer tev, through the packets that its README and `Ipc.cpp` describe.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::time::Duration;

use lookat_image::{Image, io_reason};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

/// The longest wait for tev.
const PATIENCE: Duration = Duration::from_secs(5);
/// The most pixels of a packet.
const PIXELS: usize = 1 << 18;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A connection to tev.
pub struct Tev {
    client: TevClient,
    address: String,
    /// The name of the picture.
    name: String,
}

impl Tev {
    /// Connects to tev. Warns if nothing answers.
    pub fn connect(address: &str) -> Option<Tev> {
        match connection(address) {
            Ok(stream) => {
                Some(Tev { client: TevClient::wrap(stream), address: address.into(), name: String::new() })
            }
            Err(error) => {
                let reason = io_reason(&error);
                crate::say(&format!(
                    "warning: cannot reach tev at {address}: {reason}; start tev, or correct --tev; rendering without it"
                ));
                None
            }
        }
    }

    /// Creates a black picture. A picture of the same name is replaced.
    pub fn begin(&mut self, file: &Path, [width, height]: [u32; 2]) -> Result<(), String> {
        self.name = file.display().to_string().replace('\0', "");
        let packet = PacketCreateImage {
            image_name: &self.name,
            grab_focus: true,
            width,
            height,
            channel_names: &CHANNELS,
        };
        let sent = self.client.send(packet);
        self.lost(sent)
    }

    /// Sends all pixels, in bands of rows.
    pub fn update(&mut self, image: &Image) -> Result<(), String> {
        let (Some(planes), [width, height]) = (image.rgb_planes(), image.data_window.size()) else {
            return Ok(());
        };
        let rows = (PIXELS / width as usize).max(1);
        for y in (0..height).step_by(rows) {
            let band = (height - y).min(rows as u32);
            let (start, pixels) = ((y * width) as usize, u64::from(band) * u64::from(width));
            let data: Vec<f32> =
                planes.iter().flat_map(|plane| &plane[start..start + pixels as usize]).copied().collect();
            let packet = PacketUpdateImage {
                image_name: &self.name,
                grab_focus: false,
                channel_names: &CHANNELS,
                channel_offsets: &[0, pixels, 2 * pixels],
                channel_strides: &[1; 3],
                x: 0,
                y,
                width,
                height: band,
                data: &data,
            };
            let sent = self.client.send(packet);
            self.lost(sent)?;
        }
        Ok(())
    }

    fn lost(&self, sent: io::Result<()>) -> Result<(), String> {
        let warning = |error| {
            let (address, reason) = (&self.address, io_reason(&error));
            format!("warning: lost tev at {address}: {reason}; rendering without it")
        };
        sent.map_err(warning)
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
