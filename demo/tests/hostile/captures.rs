//! Hostile captures, each with the error that a user sees.

use crate::files::{Place, read_capture, temporary};
use crate::harness::{LIMITS, run};
use crate::oracle::check_error;
use crate::seeds;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    WritableImage,
};
use serde_json::{Value, json};
use std::io::Cursor;

/// The reader's own hook for panics is in place after this.
pub fn read_one_frame() {
    let folder = tempfile::tempdir().unwrap();
    seeds::write_capture(folder.path(), 1.0);
    read_capture(folder.path()).unwrap();
}

/// The capture must be refused, within the limits of a case, with an error that says all of `parts`.
fn assert_refused(place: &Place, parts: &[&str]) {
    let folder = place.inside.clone();
    let parts: Vec<String> = parts.iter().map(ToString::to_string).collect();
    let check = move || {
        let error = read_capture(&folder).err().ok_or("it was read")?;
        check_error(&error, &folder)?;
        match parts.iter().find(|part| !error.contains(*part)) {
            Some(part) => Err(format!("`{part}` is not in: {error}")),
            None => Ok(()),
        }
    };
    assert_eq!(run(LIMITS, 0, check), Ok(()));
}

fn edit(place: &Place, change: impl FnOnce(&mut Value)) {
    let path = place.inside.join("capture.json");
    let mut json = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    change(&mut json);
    std::fs::write(path, json.to_string()).unwrap();
}

fn find(bytes: &[u8], wanted: &[u8]) -> usize {
    bytes.windows(wanted.len()).position(|window| window == wanted).unwrap()
}

/// Sets the size of the last header, and the count of chunks that must go with it.
fn set_size(bytes: &mut [u8], side: i32, chunks: i32) {
    let mut set = |attribute: &[u8], at: usize, value: i32| {
        let start = bytes.windows(attribute.len()).rposition(|window| window == attribute).unwrap();
        // The attribute's name and type, its size, then its value.
        let start = start + attribute.len() + 4 + at;
        bytes[start..start + 4].copy_from_slice(&value.to_le_bytes());
    };
    set(b"dataWindow\0box2i\0", 8, side - 1);
    set(b"dataWindow\0box2i\0", 12, side - 1);
    set(b"chunkCount\0int\0", 0, chunks);
}

#[test]
fn the_seeds_are_whole() {
    let temporary = temporary();
    let place = &temporary.place;
    assert_eq!(read_capture(&place.inside).unwrap().len(), 2);
    let kinds = [Compression::B44, Compression::B44A, Compression::PXR24, Compression::PIZ];
    for (kind, blocks) in
        kinds.into_iter().flat_map(|kind| [(kind, Blocks::ScanLines), (kind, Blocks::Tiles((8, 8).into()))])
    {
        place.write("frame_0000.exr", &seeds::exr_file(kind, blocks));
        assert_eq!(read_capture(&place.inside).unwrap().len(), 2, "{kind:?} {blocks:?}");
    }
}

#[cfg(unix)]
#[test]
fn frames_that_are_no_files_of_the_folder_are_refused() {
    for (file, parts) in [
        ("pipe", &["inside/pipe: cannot open: is a named pipe, expected a regular file"][..]),
        ("folder.bin", &["is a folder, expected a regular file"]),
        // Links are followed: what is at their end counts.
        ("zero", &["zero: cannot open: leaves the folder"]),
        ("link_frame_0000.exr", &["link_frame_0000.exr: cannot open: leaves the folder"]),
        ("link/frame_0000.exr", &["leaves the folder"]),
        ("loop", &["cannot open", "symbolic links"]),
        ("../outside/frame_0000.exr", &["capture.json: frame 0: file `../outside/frame_0000.exr` leaves"]),
        ("a\u{1b}[31m", &["`frames[0].file` is a?[31m, expected a name of at most 255 printable letters"]),
    ] {
        let temporary = temporary();
        edit(&temporary.place, |json| json["frames"][0]["file"] = json!(file));
        assert_refused(&temporary.place, parts);
    }
}

#[cfg(unix)]
#[test]
fn descriptions_that_are_no_files_or_too_large_are_refused() {
    let temporary = temporary();
    let place = &temporary.place;
    let path = place.inside.join("capture.json");
    std::fs::File::options().write(true).open(&path).unwrap().set_len(1 << 40).unwrap();
    assert_refused(
        place,
        &["capture.json: cannot read: has 1099511627776 bytes, expected at most 134217728"],
    );
    std::fs::remove_file(&path).unwrap();
    std::fs::rename(place.inside.join("pipe"), &path).unwrap();
    assert_refused(place, &["capture.json: cannot read: is a named pipe"]);
    std::fs::remove_file(&path).unwrap();
    std::os::unix::fs::symlink(place.outside.join("capture.json"), &path).unwrap();
    assert_refused(place, &["capture.json: cannot read: leaves the folder"]);
}

#[test]
fn long_values_are_not_quoted_in_full() {
    let temporary = temporary();
    edit(&temporary.place, |json| json["width"] = json!("x".repeat(100_000)));
    assert_refused(&temporary.place, &["invalid type: string \"xxxx", "...", "line 1"]);
}

#[test]
fn a_header_that_claims_more_than_the_file_holds_is_refused() {
    let temporary = temporary();
    let place = &temporary.place;
    edit(place, |json| (json["width"], json["height"]) = (json!(8192), json!(8192)));
    let mut bytes = seeds::exr_file(Compression::ZIP16, Blocks::ScanLines);
    set_size(&mut bytes, 8192, 512);
    place.write("frame_0000.exr", &bytes);
    assert_refused(
        place,
        &["cannot read OpenEXR: what it decodes to has 2684354560 bytes, expected at most"],
    );
}

#[test]
fn a_tile_of_gigabytes_is_refused() {
    let temporary = temporary();
    let mut bytes = seeds::exr_file(Compression::PIZ, Blocks::Tiles((8, 8).into()));
    let size = find(&bytes, b"tiles\0tiledesc\0") + 15 + 4;
    bytes[size..size + 8].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
    let count = find(&bytes, b"chunkCount\0int\0") + 15 + 4;
    bytes[count] = 1;
    temporary.place.write("frame_0000.exr", &bytes);
    assert_refused(&temporary.place, &["a block of its pixels has", "expected at most 16777216"]);
}

/// Parts that no capture knows may have any size, and take no memory.
#[test]
fn an_unknown_part_of_gigabytes_is_not_decoded() {
    let temporary = temporary();
    let place = &temporary.place;
    let layer = |name: &str, size: (usize, usize), channel: &str| {
        let samples = FlatSamples::F32(vec![0.0; size.0 * size.1]);
        let channels = AnyChannels::sort([AnyChannel::new(channel, samples)].into_iter().collect());
        Layer::new(size, LayerAttributes::named(name), Encoding::UNCOMPRESSED, channels)
    };
    let window = exr::meta::attribute::IntegerBounds::new((0, 0), (12, 8));
    let image = Image::empty(exr::meta::header::ImageAttributes::new(window))
        .with_layer(layer("a", (12, 8), "depth.Z"))
        .with_layer(layer("b", (12, 7), "unknown"));
    let mut file = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut file).unwrap();
    let mut bytes = file.into_inner();
    set_size(&mut bytes, 60_000, 60_000);
    // Room for the table of so many rows, at places that are none.
    bytes.resize(bytes.len() + 8 * 60_000, 0);
    place.write("frame_0000.exr", &bytes);
    assert_refused(place, &["frame_0000.exr"]);
}

/// Where the first chunk starts of a file that has `count` of them.
fn first_chunk(bytes: &[u8], count: usize) -> usize {
    // The table of places ends where the first of them is.
    let is_table =
        |&at: &usize| bytes.get(at..at + 8).is_some_and(|place| place == (at + 8 * count).to_le_bytes());
    (0..bytes.len()).find(is_table).unwrap() + 8 * count
}

/// The decoder subtracts below 0.
#[test]
fn a_b44_block_of_no_pixel_values_is_refused() {
    let temporary = temporary();
    let mut bytes = seeds::exr_file(Compression::B44, Blocks::ScanLines);
    // After the row and the length; `albedo.B` comes first.
    let block = first_chunk(&bytes, 1) + 8;
    bytes[block..block + 14].fill(0);
    temporary.place.write("frame_0000.exr", &bytes);
    assert_refused(&temporary.place, &["frame_0000.exr: cannot read OpenEXR", "B44 block"]);
}

/// The decoder takes it for a part of the image.
#[test]
fn a_tile_of_another_level_is_refused() {
    let temporary = temporary();
    let mut bytes = seeds::exr_file(Compression::Uncompressed, Blocks::Tiles((8, 8).into()));
    let chunk = first_chunk(&bytes, 2);
    bytes[chunk + 12] = 1;
    // Half as high, so half as long.
    let length = i32::from_le_bytes(bytes[chunk + 16..chunk + 20].try_into().unwrap()) / 2;
    bytes[chunk + 16..chunk + 20].copy_from_slice(&length.to_le_bytes());
    temporary.place.write("frame_0000.exr", &bytes);
    assert_refused(&temporary.place, &["frame_0000.exr: cannot read OpenEXR"]);
}
