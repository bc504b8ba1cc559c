//! The blocks of a part: rows or tiles, each compressed by itself, anywhere in the file.
//!
//! The crate reads blocks too, but takes as much memory for them as the file says.

use std::io::{Read, Seek, SeekFrom};

use ::exr::error::Error;
use ::exr::math::Vec2;
use ::exr::meta::attribute::IntegerBounds;
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};

use crate::ImageFault;

/// No compression shrinks more: 1032 is the bound of ZIP, 1376 that of PXR24.
pub(crate) const DENSEST: usize = 2048;

/// Calls `take` for each block of a part, with its bounds relative to the data window, and its numbers: row by row, in each row
/// channel by channel, in the byte order of the machine. Of several resolutions, only the full one is read. The file, of
/// `length` bytes, is positioned after the headers.
pub(crate) fn read(
    file: &mut (impl Read + Seek),
    length: u64,
    meta: &MetaData,
    part: usize,
    mut take: impl FnMut(IntegerBounds, &[u8]),
) -> Result<(), ImageFault> {
    let header = &meta.headers[part];
    let grid = Grid::of(header);
    let before =
        meta.headers[..part].iter().fold(0, |sum: u64, part| sum.saturating_add(part.chunk_count as u64));
    let offsets = offsets(file, length, before, grid.columns as u64 * grid.rows as u64)?;

    let mut is_read = vec![false; offsets.len()];
    for offset in offsets {
        // A renderer that was stopped leaves zeros.
        if offset == 0 {
            return Err(missing());
        }
        if offset >= length {
            return Err(ImageFault::Damaged("the file ends too early".into()));
        }
        file.seek(SeekFrom::Start(offset))?;
        if meta.requirements.is_multilayer() && int(file)? as usize != part {
            return Err(missing());
        }
        let [column, row] = position(file, header, &grid)?;
        if std::mem::replace(&mut is_read[row * grid.columns + column], true) {
            return Err(missing());
        }
        let bounds = grid.bounds(column, row);
        let data = data(file, length, bounds.size.area() * header.channels.bytes_per_pixel)?;
        let numbers = header.compression.decompress_image_section_from_le(header, data, bounds, false);
        take(bounds, &numbers.map_err(undecodable)?);
    }
    Ok(())
}

/// The bytes that reading takes besides the pixels: the largest block as it is stored, decompressed, and in between; and for each
/// block its offset, twice, and whether it was read.
pub(crate) fn bytes(header: &Header) -> u64 {
    let grid = Grid::of(header);
    let block = grid.bounds(0, 0).size.area() as u64 * header.channels.bytes_per_pixel as u64;
    3 * block + 17 * grid.columns as u64 * grid.rows as u64
}

/// The division of a picture into blocks.
struct Grid {
    picture: Vec2<usize>,
    block: Vec2<usize>,
    columns: usize,
    rows: usize,
}

impl Grid {
    fn of(header: &Header) -> Self {
        let (picture, block) = (header.layer_size, header.max_block_pixel_size());
        let (columns, rows) = (picture.0.div_ceil(block.0), picture.1.div_ceil(block.1));
        Grid { picture, block, columns, rows }
    }

    fn bounds(&self, column: usize, row: usize) -> IntegerBounds {
        let (x, y) = (column * self.block.0, row * self.block.1);
        let (width, height) = (self.block.0.min(self.picture.0 - x), self.block.1.min(self.picture.1 - y));
        IntegerBounds::new((x as i32, y as i32), (width, height))
    }
}

/// The offsets of the blocks in the file: `count` numbers after `before` ones of other parts.
fn offsets(
    file: &mut (impl Read + Seek),
    length: u64,
    before: u64,
    count: u64,
) -> Result<Vec<u64>, ImageFault> {
    let start = before.checked_mul(8).and_then(|bytes| bytes.checked_add(file.stream_position().ok()?));
    let end = start.and_then(|start| start.checked_add(count.checked_mul(8)?));
    let (Some(start), Some(..)) = (start, end.filter(|end| *end <= length)) else {
        return Err(ImageFault::Damaged("the file ends too early".into()));
    };
    file.seek(SeekFrom::Start(start))?;
    let mut bytes = vec![0; 8 * count as usize];
    file.read_exact(&mut bytes)?;
    Ok(bytes.as_chunks().0.iter().map(|eight| u64::from_le_bytes(*eight)).collect())
}

/// Reads the column and row of the next block.
fn position(file: &mut impl Read, header: &Header, grid: &Grid) -> Result<[usize; 2], ImageFault> {
    let [column, row] = match header.blocks {
        BlockDescription::ScanLines => {
            let below = i64::from(int(file)?) - i64::from(header.own_attributes.layer_position.1);
            let height = grid.block.1 as i64;
            [0, if below % height == 0 { below / height } else { -1 }]
        }
        BlockDescription::Tiles(_) => {
            let [column, row, x_level, y_level] = [int(file)?, int(file)?, int(file)?, int(file)?];
            [column, if (x_level, y_level) == (0, 0) { row } else { -1 }].map(i64::from)
        }
    };
    let within = |index: i64, count| usize::try_from(index).ok().filter(|index| *index < count);
    Option::zip(within(column, grid.columns), within(row, grid.rows)).map(<[_; 2]>::from).ok_or_else(missing)
}

/// Reads the bytes of a block of `size` decompressed bytes.
fn data(file: &mut (impl Read + Seek), length: u64, size: usize) -> Result<Vec<u8>, ImageFault> {
    let stored = u64::try_from(int(file)?).unwrap_or(u64::MAX);
    if stored > length - file.stream_position()?.min(length) {
        return Err(ImageFault::Damaged("the file ends too early".into()));
    }
    // What would grow by compression is stored as it is.
    if stored > size as u64 || size as u64 / DENSEST as u64 > stored {
        return Err(ImageFault::Damaged("the length of a block is wrong".into()));
    }
    let mut data = vec![0; stored as usize];
    file.read_exact(&mut data)?;
    Ok(data)
}

fn int(file: &mut impl Read) -> Result<i32, ImageFault> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes)?;
    Ok(i32::from_le_bytes(bytes))
}

fn missing() -> ImageFault {
    ImageFault::Damaged("a block is missing".into())
}

fn undecodable(error: Error) -> ImageFault {
    match error {
        Error::NotSupported(reason) => ImageFault::Refused(reason.into()),
        _ => ImageFault::Damaged("a block cannot be decompressed".into()),
    }
}
