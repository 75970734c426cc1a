//! That B44 blocks hold pixel values, before they are decoded: the decoder's arithmetic overflows on others.
//!
//! A block of 4 x 4 half floats is its first value, a shift, and 15 differences of 6 bits to a neighbour (OpenEXR's technical
//! introduction, "B44"); 3 bytes stand for 16 equal values.

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::error::{Error, Result};
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::Compression;
use std::fs::File;
use std::io::BufReader;

/// Shifts from here on mark blocks of equal values.
const FLAT: u8 = 13 << 2;
/// Half of the range of a difference.
const BIAS: u32 = 32;

pub fn uses(headers: &[Header]) -> bool {
    headers.iter().any(is_b44)
}

fn is_b44(header: &Header) -> bool {
    matches!(header.compression, Compression::B44 | Compression::B44A)
}

/// Checks all blocks of a file, which is at its start.
pub fn check(file: &File) -> Result<()> {
    let reader = exr::block::read(BufReader::new(file), false)?;
    let headers = reader.headers().to_vec();
    let with_b44: Vec<bool> = headers.iter().map(is_b44).collect();
    let chunks = reader.filter_chunks(false, |_, _, block| with_b44[block.layer])?;
    for chunk in chunks {
        check_chunk(&headers, &chunk?)?;
    }
    Ok(())
}

fn check_chunk(headers: &[Header], chunk: &Chunk) -> Result<()> {
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    // A chunk says itself what layer it is of, whatever the table that led here says.
    let header = headers.get(chunk.layer_index).ok_or_else(|| Error::Invalid("chunk layer index".into()))?;
    if !is_b44(header) {
        return Ok(());
    }
    let place = header.get_block_data_indices(&chunk.compressed_block)?;
    let size = header.get_absolute_block_pixel_coordinates(place)?.size;
    if bytes.len() == size.area() * header.channels.bytes_per_pixel {
        // Stored as they are, where blocks would have been longer.
        return Ok(());
    }
    let mut rest = bytes.as_slice();
    for channel in &header.channels.list {
        if channel.sample_type == SampleType::F16 {
            for _ in 0..size.width().div_ceil(4) * size.height().div_ceil(4) {
                rest = check_block(rest)?;
            }
        } else {
            rest = rest.get(4 * size.area()..).ok_or_else(short)?;
        }
    }
    Ok(())
}

fn short() -> Error {
    Error::Invalid("B44 data, which ends too early".into())
}

/// Returns what follows the block.
fn check_block(bytes: &[u8]) -> Result<&[u8]> {
    if *bytes.get(2).ok_or_else(short)? >= FLAT {
        return Ok(&bytes[3..]);
    }
    let (block, rest) = bytes.split_first_chunk::<14>().ok_or_else(short)?;
    let bits = block.iter().fold(0_u128, |bits, &byte| bits << 8 | u128::from(byte));
    let six = |at: u32| (bits >> (106 - at)) as u32 & 63;
    let shift = six(16);
    let difference = |i: u32| six(22 + 6 * i) << shift;
    let add = |value: u16, i: u32| {
        let sum = u32::from(value) + difference(i);
        let sum = sum.checked_sub(BIAS << shift).ok_or_else(|| Error::Invalid("B44 block".into()))?;
        // Beyond 16 bits only the low ones count.
        Ok::<_, Error>(sum as u16)
    };
    // Down the first column, then each row from the left.
    let mut column = [(bits >> 96) as u16; 4];
    for row in 1..4 {
        column[row] = add(column[row - 1], row as u32 - 1)?;
    }
    for x in 0..3 {
        for (row, value) in column.iter_mut().enumerate() {
            *value = add(*value, 3 + 4 * x + row as u32)?;
        }
    }
    Ok(rest)
}
