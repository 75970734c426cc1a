//! Decoding an OpenEXR file: its headers first, then of its pixels only what a capture knows, both bounded.

use super::CaptureError;
use super::b44;
use super::channels::{full_name, is_known};
use super::guard::guarded;
use exr::block::{chunk::TileCoordinates, lines::LineRef};
use exr::error::{Result as ExrResult, UnitResult};
use exr::image::read::any_channels::{ReadAnyChannels, ReadSamples, SamplesReader};
use exr::image::read::levels::ReadSamplesLevel;
use exr::image::read::samples::{FlatSamplesReader, ReadFlatSamples};
use exr::meta::attribute::ChannelDescription;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use std::collections::HashMap;
use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::Path;

/// Bytes that a byte of a file can decode to: a little more than deflate's 1032, the most of all compressions.
const MOST_EXPANSION: u64 = 1100;
/// Bytes of a block of rows: 256 of 8192 pixels, with 29 channels of 4 bytes.
const MOST_BLOCK_BYTES: u64 = 256 << 20;
/// Bytes of a tile, which may be larger than the image: 512 x 512 pixels with 16 channels of 4 bytes.
const MOST_TILE_BYTES: u64 = 16 << 20;
/// Headers may have this many channels in all, known or not; renderers write some hundreds.
const MOST_CHANNELS: u64 = 4096;

pub struct ExrFile<'a> {
    path: &'a Path,
    file: File,
    length: u64,
    meta: MetaData,
}

impl<'a> ExrFile<'a> {
    /// Reads the headers and no pixels: what these say must be checked before it becomes an allocation.
    pub fn open(path: &'a Path, file: File) -> Result<Self, CaptureError> {
        let io = |source| CaptureError::Io { path: path.to_owned(), action: "read", source };
        let length = file.metadata().map_err(io)?.len();
        let meta = guarded(|| MetaData::read_from_unbuffered(&file, false));
        let meta = meta.ok_or_else(|| damaged(path))?.map_err(|source| unreadable(path, source))?;
        let channels = meta.headers.iter().map(|header| header.channels.list.len() as u64).sum();
        within(path, "channels", "its headers", channels, MOST_CHANNELS)?;
        for header in &meta.headers {
            let bytes_in = |size: exr::math::Vec2<usize>| {
                area(size).saturating_mul(header.channels.bytes_per_pixel as u64)
            };
            let most = match header.blocks {
                BlockDescription::ScanLines => MOST_BLOCK_BYTES,
                BlockDescription::Tiles(_) => MOST_TILE_BYTES.max(bytes_in(header.layer_size)),
            };
            let bytes = bytes_in(header.max_block_pixel_size());
            within(path, "bytes", "a block of its pixels", bytes, most)?;
        }
        Ok(Self { path, file, length, meta })
    }

    pub fn headers(&self) -> &[Header] {
        &self.meta.headers
    }

    /// Samples of the channels that a capture knows, whose sizes the caller has checked.
    pub fn known_samples(mut self) -> Result<HashMap<String, FlatSamples>, CaptureError> {
        let bytes: u64 = self.meta.headers.iter().map(known_bytes).sum();
        let most = self.length.saturating_mul(MOST_EXPANSION);
        within(self.path, "bytes", "what it decodes to", bytes, most)?;
        let io = |source| CaptureError::Io { path: self.path.to_owned(), action: "read", source };
        self.file.seek(SeekFrom::Start(0)).map_err(io)?;
        if b44::uses(self.headers()) {
            let checked = guarded(|| b44::check(&self.file)).ok_or_else(|| damaged(self.path))?;
            checked.map_err(|source| unreadable(self.path, source))?;
            self.file.seek(SeekFrom::Start(0)).map_err(io)?;
        }
        // On this thread: a panic on one of the decoder's own would end the program.
        let reader = ReadAnyChannels { read_samples: ReadKnown }.all_layers().all_attributes().non_parallel();
        let image = guarded(|| reader.from_unbuffered(&self.file)).ok_or_else(|| damaged(self.path))?;
        let image = image.map_err(|source| unreadable(self.path, source))?;
        let mut samples = HashMap::new();
        for layer in image.layer_data {
            let layer_name = layer.attributes.layer_name;
            for channel in layer.channel_data.list {
                if let Some(data) = channel.sample_data {
                    samples.insert(full_name(layer_name.as_ref(), &channel.name), data);
                }
            }
        }
        Ok(samples)
    }
}

fn area(size: exr::math::Vec2<usize>) -> u64 {
    (size.width() as u64).saturating_mul(size.height() as u64)
}

fn known_bytes(header: &Header) -> u64 {
    let pixels = area(header.layer_size);
    let known = header.channels.list.iter().filter(|channel| is_known_in(header, channel));
    known.map(|channel| pixels.saturating_mul(channel.sample_type.bytes_per_sample() as u64)).sum()
}

fn is_known_in(header: &Header, channel: &ChannelDescription) -> bool {
    is_known(&full_name(header.own_attributes.layer_name.as_ref(), &channel.name))
}

fn damaged(path: &Path) -> CaptureError {
    CaptureError::Damaged { path: path.to_owned() }
}

fn unreadable(path: &Path, source: exr::error::Error) -> CaptureError {
    CaptureError::Exr { path: path.to_owned(), action: "read", source }
}

fn within(path: &Path, unit: &'static str, what: &str, found: u64, most: u64) -> Result<(), CaptureError> {
    if found <= most {
        return Ok(());
    }
    Err(CaptureError::TooMuch { path: path.to_owned(), what: what.to_owned(), unit, found, most })
}

/// Makes no room for channels that a capture does not know: their size is whatever the file says.
struct ReadKnown;

struct KnownReader(Option<FlatSamplesReader>);

impl ReadSamples for ReadKnown {
    type Reader = KnownReader;

    fn create_sample_reader(&self, header: &Header, channel: &ChannelDescription) -> ExrResult<KnownReader> {
        if !is_known_in(header, channel) {
            return Ok(KnownReader(None));
        }
        let level = exr::math::Vec2(0, 0);
        let size = header.layer_size;
        Ok(KnownReader(Some(ReadFlatSamples.create_samples_level_reader(header, channel, level, size)?)))
    }
}

impl SamplesReader for KnownReader {
    type Samples = Option<FlatSamples>;

    fn filter_block(&self, tile: TileCoordinates) -> bool {
        self.0.as_ref().is_some_and(|reader| reader.filter_block(tile))
    }

    fn read_line(&mut self, line: LineRef<'_>) -> UnitResult {
        let Some(reader) = &mut self.0 else {
            return Ok(());
        };
        // A tile says itself what level it is of, whatever the table that led to it says.
        if line.location.level != exr::math::Vec2(0, 0) {
            return Err(exr::error::Error::Invalid("tile of another level".into()));
        }
        reader.read_line(line)
    }

    fn into_samples(self) -> Self::Samples {
        self.0.map(SamplesReader::into_samples)
    }
}
