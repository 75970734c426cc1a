//! Captures: what is written comes back, foreign files are understood, and each mistake is named.

mod synthetic;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, WritableImage,
};
use glam::Mat4;
use half::f16;
use quell_demo::capture::{
    CaptureError, CaptureHeader, CaptureReader, CaptureWriter, Frame, FrameInfo, download, gbuffer_for,
    upload,
};
use quell_demo::gpu::Gpu;
use serde_json::json;
use std::path::{Path, PathBuf};
use synthetic::{HEIGHT, WIDTH, edit_channels, edit_manifest, frame, header, info, split_frame};
use tempfile::TempDir;

fn capture(frames: usize) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    synthetic::write(folder.path(), frames);
    folder
}

fn first_file(folder: &TempDir) -> PathBuf {
    folder.path().join("frame_0000.exr")
}

/// Message of opening and reading frame 0, which must fail.
fn error_of(folder: &TempDir) -> String {
    let result = CaptureReader::open(folder.path()).and_then(|capture| capture.read(0));
    let error = anyhow::Error::from(result.expect_err("should have been refused"));
    format!("{error:#}")
}

fn assert_mentions(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

fn assert_close(found: &[[f32; 3]], expected: &[[f32; 3]]) {
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() <= 1e-3 * expected.abs(), "{found} for {expected}");
    }
}

#[test]
fn a_capture_comes_back_as_it_was_written() {
    let folder = capture(3);
    let capture = CaptureReader::open(folder.path()).unwrap();
    assert_eq!(capture.len(), 3);
    assert_eq!(*capture.header(), header());
    for i in 0..3 {
        assert_eq!(capture.info(i), FrameInfo { restart: i == 0, ..info() });
        let (read, written) = (capture.read(i).unwrap(), frame(i));
        assert_eq!(read.radiance, written.radiance);
        assert_eq!(read.reference, written.reference);
        assert_eq!(read.depth, written.depth);
        assert_eq!(read.motion, written.motion);
        assert_eq!(read.motion_depth, written.motion_depth);
        assert_eq!(read.surface_id, written.surface_id, "identities must be exact");
        assert_eq!(read.samples, written.samples);
        // Half precision.
        assert_close(&read.albedo, &written.albedo);
        assert_close(&read.normal, &written.normal);
        assert_close(&read.emission.unwrap(), &written.emission.unwrap());
    }
}

#[test]
fn split_images_come_back_as_far_as_they_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let distances_alone = |i| Frame { hit_distance: split_frame(i).hit_distance, ..frame(i) };
    let without_albedo = |i| Frame { specular_albedo: None, hit_distance: None, ..split_frame(i) };
    let written = [split_frame(0), frame(1), distances_alone(2), without_albedo(3)];
    synthetic::write_each(folder.path(), written.len(), |i| written[i].clone());
    let capture = CaptureReader::open(folder.path()).unwrap();
    for (i, written) in written.iter().enumerate() {
        let read = capture.read(i).unwrap();
        assert_eq!(read.radiance, written.radiance);
        assert_eq!(read.specular, written.specular);
        assert_eq!(read.specular_albedo, written.specular_albedo, "exact in half precision");
        assert_eq!(read.hit_distance, written.hit_distance, "infinity too");
    }
}

#[test]
fn a_specular_albedo_alone_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    synthetic::write_each(folder.path(), 1, split_frame);
    edit_channels(&first_file(&folder), |channels| {
        channels.retain(|(name, _)| !name.starts_with("specular."));
    });
    assert_mentions(&error_of(&folder), &["frame_0000.exr", "has `specular_albedo` but no `specular`"]);
    let mut writer = writer(folder.path(), true).unwrap();
    let error = writer.write_frame(&Frame { specular: None, ..split_frame(0) }, &info()).unwrap_err();
    assert!(matches!(error, CaptureError::Alone { .. }), "{error}");
}

#[test]
fn optional_images_may_be_missing_and_invalid_radiance_survives() {
    let folder = tempfile::tempdir().unwrap();
    let mut written = Frame::new(WIDTH, HEIGHT);
    written.radiance[3] = [f32::NAN, f32::INFINITY, -1.0];
    let far = CaptureHeader { far: f32::INFINITY, ..header() };
    let mut writer = CaptureWriter::create(folder.path(), far, false).unwrap();
    writer.write_frame(&written, &info()).unwrap();
    writer.finish().unwrap();
    let capture = CaptureReader::open(folder.path()).unwrap();
    assert_eq!(capture.header().far, f32::MAX, "JSON has no infinity");
    let read = capture.read(0).unwrap();
    assert!(read.radiance[3][0].is_nan());
    assert_eq!(read.radiance[3][1..], written.radiance[3][1..]);
    assert!(read.motion_depth.is_none() && read.roughness.is_none() && read.surface_id.is_none());
    assert!(read.emission.is_none() && read.samples.is_none() && read.reference.is_none());
}

/// What a tracer leaves on the GPU is what a capture holds, and what a replay puts back.
#[test]
fn frames_survive_the_way_to_the_gpu_and_back() {
    let gpu = Gpu::new().expect("tests need a Vulkan driver");
    // One set of images for all, as frames of a capture may differ in what they have.
    let mut gbuffer = gbuffer_for(&gpu.device, &frame(0));
    for (with_z, is_split) in [(true, false), (false, true), (false, false), (true, true)] {
        let mut written = if is_split { split_frame(1) } else { frame(1) };
        written.reference = None;
        // Exact in half precision.
        written.albedo.iter_mut().for_each(|albedo| *albedo = albedo.map(|a| f16::from_f32(a).to_f32()));
        if !with_z {
            written.motion_depth = None;
        }
        upload(&gpu.device, &gpu.queue, &written, &mut gbuffer);
        let read = download(&gpu, &gbuffer).unwrap();
        assert_eq!(read, written, "with motion.Z: {with_z}, split: {is_split}");
        let whole: Vec<[f32; 4]> =
            bytemuck::pod_collect_to_vec(&gpu.read_texture(gbuffer.radiance.texture()).unwrap());
        let whole: Vec<[f32; 3]> = whole.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        assert_eq!(whole, written.combined_radiance(), "what is not told apart gets the sum");
    }
}

/// The channels of `frame(0)` as another program may write them: other sample types, extra channels.
fn foreign_channels() -> Vec<AnyChannel<FlatSamples>> {
    let frame = frame(0);
    let half = |values: Vec<f32>| FlatSamples::F16(values.into_iter().map(f16::from_f32).collect());
    let column = |plane: &[[f32; 3]], c: usize| plane.iter().map(|v| v[c]).collect::<Vec<f32>>();
    let pixels = frame.depth.len();
    let mut list = vec![
        ("surface.id", FlatSamples::U32(frame.surface_id.clone().unwrap())),
        ("Z.extra", FlatSamples::F32(vec![7.0; pixels])),
        ("samples.N", half(vec![2.0; pixels])),
        ("motion.Y", half(frame.motion.iter().map(|m| m[1]).collect())),
        ("motion.X", FlatSamples::F32(frame.motion.iter().map(|m| m[0]).collect())),
        ("roughness.Y", FlatSamples::U32(vec![1; pixels])),
        ("depth.Z", FlatSamples::F32(frame.depth.clone())),
        ("A", half(vec![1.0; pixels])),
    ];
    for (c, [radiance, albedo, normal]) in [
        ["radiance.R", "albedo.R", "normal.X"],
        ["radiance.G", "albedo.G", "normal.Y"],
        ["radiance.B", "albedo.B", "normal.Z"],
    ]
    .into_iter()
    .enumerate()
    {
        list.push((normal, FlatSamples::F32(column(&frame.normal, c))));
        list.push((albedo, FlatSamples::F32(column(&frame.albedo, c))));
        list.push((radiance, half(column(&frame.radiance, c))));
    }
    list.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect()
}

fn assert_is_frame_0(read: &Frame) {
    let written = frame(0);
    assert_close(&read.radiance, &written.radiance);
    assert_eq!(read.albedo, written.albedo);
    assert_eq!(read.normal, written.normal);
    assert_eq!(read.depth, written.depth);
    assert_eq!(read.motion, written.motion);
    assert_eq!(read.surface_id, written.surface_id);
    assert_eq!(read.samples, Some(vec![2; written.depth.len()]));
    assert_eq!(read.roughness, Some(vec![1.0; written.depth.len()]));
    assert!(read.motion_depth.is_none());
}

#[test]
fn foreign_files_with_other_types_order_and_compression_are_read() {
    let folder = capture(1);
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
    ];
    for compression in compressions {
        // Tiles, and lines from the bottom: neither changes where a pixel is.
        let encoding =
            Encoding { compression, blocks: Blocks::Tiles((8, 8).into()), line_order: LineOrder::Decreasing };
        let layer = Layer::new(
            (WIDTH as usize, HEIGHT as usize),
            LayerAttributes::named("anything"),
            encoding,
            AnyChannels::sort(foreign_channels().into()),
        );
        Image::from_layer(layer).write().to_file(first_file(&folder)).unwrap();
        assert_is_frame_0(&CaptureReader::open(folder.path()).unwrap().read(0).unwrap());
    }
}

/// OpenEXR sorts the channel list; a file that does not could hand the wrong values to a name.
#[test]
fn an_unsorted_channel_list_is_an_error_and_never_swapped_colours() {
    let folder = capture(1);
    let path = first_file(&folder);
    let mut bytes = std::fs::read(&path).unwrap();
    let (a, b) = (find(&bytes, b"radiance.B\0"), find(&bytes, b"radiance.R\0"));
    bytes[a..a + 10].copy_from_slice(b"radiance.R");
    bytes[b..b + 10].copy_from_slice(b"radiance.B");
    std::fs::write(&path, bytes).unwrap();
    assert_mentions(&error_of(&folder), &["frame_0000.exr", "channel names are not sorted"]);
}

fn find(bytes: &[u8], wanted: &[u8]) -> usize {
    bytes.windows(wanted.len()).position(|window| window == wanted).unwrap()
}

#[test]
fn parts_named_after_groups_are_read() {
    let folder = capture(1);
    let (radiance, rest): (Vec<_>, Vec<_>) =
        foreign_channels().into_iter().partition(|c| c.name.to_string().starts_with("radiance."));
    let bare = radiance.into_iter().map(|mut channel| {
        channel.name = channel.name.to_string().trim_start_matches("radiance.").into();
        channel
    });
    let layer = |name: &str, channels| {
        let size = (WIDTH as usize, HEIGHT as usize);
        Layer::new(size, LayerAttributes::named(name), Encoding::FAST_LOSSLESS, AnyChannels::sort(channels))
    };
    let image = Image::empty(exr::meta::header::ImageAttributes::new(
        exr::meta::attribute::IntegerBounds::new((0, 0), (WIDTH as usize, HEIGHT as usize)),
    ))
    .with_layer(layer("radiance", bare.collect()))
    .with_layer(layer("features", rest.into()));
    image.write().to_file(first_file(&folder)).unwrap();
    assert_is_frame_0(&CaptureReader::open(folder.path()).unwrap().read(0).unwrap());
}

#[test]
fn a_missing_folder_and_broken_json_are_named() {
    let folder = tempfile::tempdir().unwrap();
    assert_mentions(&error_of(&folder), &["capture.json", "cannot read", "No such file"]);
    for text in
        ["", "{", "[1, 2]", "{\"version\": 1, \"width\": NaN}", "{\"version\": 1}", "{\"version\": -1}"]
    {
        std::fs::write(folder.path().join("capture.json"), text).unwrap();
        assert_mentions(&error_of(&folder), &["capture.json", "not a valid capture description", "line 1"]);
    }
}

type Edit = fn(&mut serde_json::Value);

#[test]
fn each_mistake_in_the_description_is_named() {
    let cases: [(&str, Edit, &[&str]); 17] = [
        ("version", |j| j["version"] = json!(2), &["version is 2, expected 1"]),
        ("future", |j| *j = json!({"version": 3, "anything": []}), &["version is 3, expected 1"]),
        ("no width", |j| drop(j.as_object_mut().unwrap().remove("width")), &["missing field `width`"]),
        ("width 0", |j| j["width"] = json!(0), &["`width` is 0", "1 to 8192"]),
        ("height", |j| j["height"] = json!(100_000), &["`height` is 100000"]),
        ("far", |j| j["far"] = json!(-1.0), &["`far` is -1"]),
        ("time", |j| j["frame_time_s"] = json!(-0.5), &["`frame_time_s` is -0.5"]),
        ("no frames", |j| j["frames"] = json!([]), &["has no frames"]),
        (
            "count",
            |j| j["frames"][0]["view"] = json!([1.0, 2.0]),
            &["frame 0: `view` has 2 numbers, expected 16"],
        ),
        ("null", |j| j["frames"][0]["view"][5] = json!(null), &["expected f32"]),
        (
            "huge",
            |j| j["frames"][0]["view"][5] = json!(1e300),
            &["frame 0: `view` has an entry that is not finite"],
        ),
        (
            "singular",
            |j| j["frames"][0]["projection"] = json!(vec![0.0; 16]),
            &["`projection` cannot be inverted"],
        ),
        ("jitter", |j| j["frames"][0]["jitter_px"] = json!([1.0]), &["jitter_px` is 1 numbers, expected 2"]),
        ("up", |j| j["frames"][0]["file"] = json!("../frame_0000.exr"), &["`../frame_0000.exr` leaves"]),
        ("root", |j| j["frames"][0]["file"] = json!("/etc/passwd"), &["frame 0", "`/etc/passwd` leaves"]),
        ("empty", |j| j["frames"][0]["file"] = json!(""), &["frame 0"]),
        ("gone", |j| j["frames"][0]["file"] = json!("other.exr"), &["other.exr", "cannot open"]),
    ];
    for (name, edit, parts) in cases {
        let folder = capture(1);
        edit_manifest(folder.path(), edit);
        println!("{name}: {}", error_of(&folder));
        assert_mentions(&error_of(&folder), parts);
    }
}

#[test]
fn each_mistake_in_a_frame_is_named() {
    let folder = capture(1);
    edit_manifest(folder.path(), |json| json["width"] = json!(25));
    assert_mentions(&error_of(&folder), &["frame_0000.exr", "is 24x16, expected 25x16"]);

    let needed = ["radiance.G", "albedo.B", "normal.X", "depth.Z", "motion.Y"];
    // An optional group with a hole in it is a mistake as well.
    let optional = ["emission.G", "reference.R", "specular.B", "specular_albedo.R"];
    for gone in needed.into_iter().chain(optional) {
        let folder = tempfile::tempdir().unwrap();
        synthetic::write_each(folder.path(), 1, split_frame);
        edit_channels(&first_file(&folder), |channels| channels.retain(|(name, _)| name != gone));
        let channel = format!("channel `{gone}` is missing");
        assert_mentions(&error_of(&folder), &["frame_0000.exr", &channel, "radiance.R"]);
    }

    let folder = capture(1);
    edit_channels(&first_file(&folder), |channels| {
        channels.retain(|(name, _)| name != "surface.id");
        let mut ids = vec![3.0; (WIDTH * HEIGHT) as usize];
        ids[WIDTH as usize + 2] = 1.5;
        channels.push(("surface.id".to_owned(), FlatSamples::F32(ids)));
    });
    assert_mentions(&error_of(&folder), &["`surface.id` has 1.5 at pixel (2, 1)"]);
}

#[test]
fn broken_exr_files_are_errors_and_never_panics() {
    let folder = capture(1);
    let path = first_file(&folder);
    let good = std::fs::read(&path).unwrap();
    std::fs::write(&path, b"this is no image").unwrap();
    assert_mentions(&error_of(&folder), &["frame_0000.exr", "cannot read OpenEXR"]);
    for length in [0, 4, 100, good.len() / 2, good.len() - 1] {
        std::fs::write(&path, &good[..length]).unwrap();
        assert_mentions(&error_of(&folder), &["frame_0000.exr"]);
    }
    // Damage anywhere: any answer but a panic.
    let capture = CaptureReader::open(folder.path()).unwrap();
    // The wrong decompressor for the data; some of them panic, on threads of their own when they may.
    let compression = find(&good, b"compression\0compression\0") + 28;
    for kind in 0..12 {
        let mut bytes = good.clone();
        bytes[compression] = kind;
        std::fs::write(&path, &bytes).unwrap();
        let read = capture.read(0);
        assert!(read.is_ok() || kind != good[compression], "compression {kind}");
    }
    for i in 0..300 {
        let mut bytes = good.clone();
        let at = (synthetic::noise(i, 0, 0) * if i % 2 == 0 { 1800.0 } else { bytes.len() as f32 }) as usize;
        bytes[at.min(good.len() - 1)] ^= 1 << (i % 8);
        std::fs::write(&path, &bytes).unwrap();
        let _ = capture.read(0);
    }
}

fn writer(folder: &Path, overwrite: bool) -> Result<CaptureWriter, CaptureError> {
    CaptureWriter::create(folder, header(), overwrite)
}

#[test]
fn only_captures_are_overwritten_and_only_when_asked() {
    let folder = capture(3);
    let error = writer(folder.path(), false).unwrap_err().to_string();
    assert_mentions(&error, &["not empty", "--overwrite"]);
    assert!(folder.path().join("capture.json").exists());

    std::fs::write(folder.path().join("thesis.txt"), "years of work").unwrap();
    let error = writer(folder.path(), true).unwrap_err().to_string();
    assert_mentions(&error, &["not empty", "`thesis.txt`", "not overwritten"]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);

    std::fs::remove_file(folder.path().join("thesis.txt")).unwrap();
    let mut new = writer(folder.path(), true).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    new.write_frame(&frame(0), &info()).unwrap();
    assert!(CaptureReader::open(folder.path()).is_err(), "a capture begins to exist when it is finished");
    new.finish().unwrap();
    assert_eq!(CaptureReader::open(folder.path()).unwrap().len(), 1);

    let nested = folder.path().join("made/on/the/way");
    assert!(writer(&nested, false).unwrap().finish().unwrap_err().to_string().contains("no frames"));
}

#[test]
fn the_writer_refuses_what_the_reader_would() {
    let folder = tempfile::tempdir().unwrap();
    let bad = CaptureHeader { width: 0, ..header() };
    assert!(matches!(CaptureWriter::create(folder.path(), bad, false), Err(CaptureError::Field { .. })));
    let mut writer = writer(folder.path(), false).unwrap();
    let mut write =
        |frame: &Frame, info: &FrameInfo| writer.write_frame(frame, info).unwrap_err().to_string();
    assert_mentions(&write(&Frame::new(3, 3), &info()), &["is 3x3, expected 24x16"]);
    let mut short = frame(0);
    short.surface_id.as_mut().unwrap().pop();
    assert_mentions(&write(&short, &info()), &["`surface_id` has 383 pixels, expected 384"]);
    let mut short = split_frame(0);
    short.hit_distance.as_mut().unwrap().pop();
    assert_mentions(&write(&short, &info()), &["`hit_distance` has 383 pixels, expected 384"]);
    let singular = FrameInfo { projection: Mat4::ZERO, ..info() };
    assert_mentions(&write(&frame(0), &singular), &["`projection` cannot be inverted"]);
}
