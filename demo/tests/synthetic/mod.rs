//! A tiny sequence made in code: a tilted plane, a patch that moves one pixel a frame over it, and sky above.
#![allow(dead_code, reason = "each test binary uses its part")]

use glam::camera::rh::{proj::directx, view};
use glam::{Vec2, Vec3};
use quell_demo::capture::{CaptureHeader, CaptureWriter, Frame, FrameInfo};
use std::path::Path;

pub const WIDTH: u32 = 24;
pub const HEIGHT: u32 = 16;
/// Rows of sky.
pub const SKY: u32 = 3;
pub const FAR: f32 = 100.0;

pub fn header() -> CaptureHeader {
    CaptureHeader { width: WIDTH, height: HEIGHT, far: FAR, frame_time_s: 1.0 / 30.0 }
}

pub fn info() -> FrameInfo {
    FrameInfo {
        view: view::look_at_mat4(Vec3::new(0.3, 1.0, 4.0), Vec3::ZERO, Vec3::Y),
        projection: directx::perspective(1.0, WIDTH as f32 / HEIGHT as f32, 0.1, FAR),
        jitter_px: Vec2::new(0.25, -0.125),
        restart: false,
    }
}

/// Uniform in 0 to 1, from a hash of its arguments.
pub fn noise(frame: usize, pixel: usize, channel: usize) -> f32 {
    let mut h = (frame as u32).wrapping_mul(0x9e37_79b9) ^ (pixel as u32 * 3 + channel as u32);
    for _ in 0..3 {
        h = (h ^ (h >> 16)).wrapping_mul(0x45d9_f3b5);
    }
    (h >> 8) as f32 / (1 << 24) as f32
}

pub fn frame(index: usize) -> Frame {
    let mut frame = Frame::new(WIDTH, HEIGHT);
    let pixels = (WIDTH * HEIGHT) as usize;
    frame.motion_depth = Some(vec![0.0; pixels]);
    frame.roughness = Some(vec![1.0; pixels]);
    frame.surface_id = Some(vec![0; pixels]);
    frame.emission = Some(vec![[0.0; 3]; pixels]);
    frame.samples = Some(vec![1; pixels]);
    frame.reference = Some(vec![[0.0; 3]; pixels]);
    for i in 0..pixels {
        let (x, y) = (i as u32 % WIDTH, i as u32 / WIDTH);
        let truth = if y < SKY {
            frame.depth[i] = FAR * 2.0;
            [0.3, 0.5, 0.9]
        } else {
            let on_patch = (4 + index as u32..10 + index as u32).contains(&x) && (6..12).contains(&y);
            frame.normal[i] = [0.0, 1.0, 0.0];
            frame.depth[i] = if on_patch { 2.0 } else { 4.0 + 0.01 * y as f32 };
            frame.albedo[i] = if on_patch { [0.8, 0.2, 0.1] } else { [0.5, 0.5, 0.5] };
            frame.motion[i] = if on_patch { [-1.0, 0.0] } else { [0.0, 0.0] };
            // Beyond 2^24, where a float would round it.
            frame.surface_id.as_mut().unwrap()[i] = if on_patch { 0xdead_beef } else { 16_777_217 };
            frame.albedo[i].map(|a| a * 1.5)
        };
        frame.reference.as_mut().unwrap()[i] = truth;
        frame.radiance[i] =
            if y < SKY { truth } else { [0, 1, 2].map(|c| truth[c] * 2.0 * noise(index, i, c)) };
    }
    frame
}

/// The same frame, split: a third of what is not sky left through a specular lobe, towards something behind the plane.
pub fn split_frame(index: usize) -> Frame {
    let mut frame = frame(index);
    let is_sky = |i: usize| (i as u32) < SKY * WIDTH;
    let pixels = 0..frame.depth.len();
    let share = |i: usize| if is_sky(i) { 0.0 } else { 1.0 / 3.0 };
    frame.specular = Some(pixels.clone().map(|i| frame.radiance[i].map(|value| share(i) * value)).collect());
    for (i, radiance) in frame.radiance.iter_mut().enumerate() {
        *radiance = radiance.map(|value| (1.0 - share(i)) * value);
    }
    frame.specular_albedo = Some(pixels.clone().map(|i| [if is_sky(i) { 1.0 } else { 0.125 }; 3]).collect());
    let distance = |i: usize| match i % 3 {
        _ if is_sky(i) => 0.0,
        0 => f32::INFINITY,
        1 => 0.0,
        _ => 1.5 + i as f32,
    };
    frame.hit_distance = Some(pixels.map(distance).collect());
    frame
}

/// Writes `frames` frames to `folder`.
pub fn write(folder: &Path, frames: usize) {
    write_each(folder, frames, frame);
}

/// Writes `frames` frames, made by `frame`.
pub fn write_each(folder: &Path, frames: usize, frame: impl Fn(usize) -> Frame) {
    let mut writer = CaptureWriter::create(folder, header(), false).unwrap();
    for i in 0..frames {
        writer.write_frame(&frame(i), &FrameInfo { restart: i == 0, ..info() }).unwrap();
    }
    writer.finish().unwrap();
}

/// Changes `capture.json` by hand.
pub fn edit_manifest(folder: &Path, edit: impl FnOnce(&mut serde_json::Value)) {
    let path = folder.join("capture.json");
    let mut json = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    edit(&mut json);
    std::fs::write(path, json.to_string()).unwrap();
}

/// Changes the channels of a frame's file by hand.
pub fn edit_channels(path: &Path, edit: impl FnOnce(&mut Vec<(String, exr::prelude::FlatSamples)>)) {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, Image, Layer, LayerAttributes, WritableImage,
        read_all_flat_layers_from_file,
    };
    let image = read_all_flat_layers_from_file(path).unwrap();
    let list = image.layer_data[0].channel_data.list.clone();
    let mut channels = list.into_iter().map(|c| (c.name.to_string(), c.sample_data)).collect();
    edit(&mut channels);
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name.as_str(), samples));
    let layer = Layer::new(
        image.layer_data[0].size,
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    Image::from_layer(layer).write().to_file(path).unwrap();
}
