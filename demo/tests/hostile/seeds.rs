//! Whole files to start from: a scene that uses every part of the loader, and a capture in every compression.

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, WritableImage,
};
use glam::{Mat4, Vec2};
use half::f16;
use image::ImageFormat;
use quell_demo::capture::{CaptureHeader, CaptureWriter, Frame, FrameInfo};
use serde_json::{Value, json};
use std::io::Cursor;
use std::path::Path;

/// A coordinate and a radiance that only files outside the folder hold.
pub const SECRET: f32 = 777.0;
/// As [`SECRET`], of images.
pub const SECRET_COLOR: [u8; 3] = [201, 33, 77];

pub fn picture(format: ImageFormat, color: [u8; 3]) -> Vec<u8> {
    let image = image::RgbImage::from_fn(8, 8, |x, y| {
        image::Rgb(if (x + y) % 2 == 0 { color } else { color.map(|c| c / 2) })
    });
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// The buffer of [`scene_json`]: a triangle with all attributes, keys, sparse values and a PNG at its end.
pub fn buffer(size: f32) -> Vec<u8> {
    let floats: [&[f32]; 3] = [
        &[0.0, 0.0, 0.0, size, 0.0, 0.0, 0.0, size, 0.0],
        &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0],
        &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0],
    ];
    let keys: [&[f32]; 3] =
        [&[0.0, 1.0], &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]];
    let mut bytes = Vec::new();
    let add = |bytes: &mut Vec<u8>, values: &[f32]| values.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    floats.iter().for_each(|values| add(&mut bytes, values));
    [0_u16, 1, 2, 0].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    keys.iter().for_each(|values| add(&mut bytes, values));
    [1_u16, 0].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    add(&mut bytes, &[0.5, 0.0, 0.0]);
    add(&mut bytes, &[1.0; 18]);
    assert_eq!(bytes.len(), 256);
    bytes.extend(picture(ImageFormat::Png, [90, 90, 90]));
    bytes
}

pub fn scene_json(buffer_length: usize) -> Value {
    let image_length = buffer_length - 256;
    let jpeg = base64::encode(picture(ImageFormat::Jpeg, [50, 60, 70]));
    let views: [(usize, usize); 11] = [
        (0, 36),
        (36, 36),
        (72, 24),
        (96, 6),
        (104, 8),
        (112, 24),
        (136, 32),
        (168, 2),
        (172, 12),
        (184, 72),
        (256, image_length),
    ];
    let view = |(start, length)| json!({"buffer": 0, "byteOffset": start, "byteLength": length});
    let mut scene = json!({
      "asset": {"version": "2.0"},
      "extensionsUsed": ["KHR_texture_transform", "KHR_materials_emissive_strength", "KHR_lights_punctual"],
      "scene": 0,
      "scenes": [{"nodes": [0, 2, 4, 5]}],
      "nodes": [
        {"name": "mover", "mesh": 0, "children": [1]},
        {"mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]},
        {"camera": 0, "translation": [0, 0, 5], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1], "children": [3]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
      "extensions": {"KHR_lights_punctual": {"lights": [
        {"type": "spot", "intensity": 5, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}},
        {"type": "directional", "intensity": 3, "color": [1, 0.5, 0]},
        {"type": "point", "intensity": 2, "range": 10}]}},
      "meshes": [
        {"name": "tri", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
          "indices": 3, "material": 0, "mode": 4}]},
        {"primitives": [{"attributes": {"POSITION": 7}, "mode": 5}]}],
      "skins": [{"joints": [0]}],
      "textures": [{"source": 0, "sampler": 0}, {"source": 1}, {"source": 2}],
      "samplers": [{"wrapS": 10497, "magFilter": 9729}],
      "images": [{"name": "wall", "uri": "image.png"}, {"bufferView": 10, "mimeType": "image/png"},
        {"uri": format!("data:image/jpeg;base64,{jpeg}")}],
      "animations": [{"name": "walk",
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}},
          {"sampler": 1, "target": {"node": 2, "path": "rotation"}},
          {"sampler": 2, "target": {"node": 0, "path": "scale"}}],
        "samplers": [{"input": 4, "output": 5, "interpolation": "LINEAR"},
          {"input": 4, "output": 6, "interpolation": "STEP"},
          {"input": 4, "output": 8, "interpolation": "CUBICSPLINE"}]}],
      "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
        {"bufferView": 3, "componentType": 5123, "count": 3, "type": "SCALAR"},
        {"bufferView": 4, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
        {"bufferView": 5, "componentType": 5126, "count": 2, "type": "VEC3"},
        {"bufferView": 6, "componentType": 5126, "count": 2, "type": "VEC4"},
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0],
          "sparse": {"count": 1, "indices": {"bufferView": 7, "componentType": 5123}, "values": {"bufferView": 8}}},
        {"bufferView": 9, "componentType": 5126, "count": 6, "type": "VEC3"}],
      "buffers": [{"uri": "tri.bin", "byteLength": buffer_length}]
    });
    scene["materials"] = json!([{"name": "paint", "emissiveFactor": [0.5, 0.5, 0.5], "alphaMode": "MASK",
        "alphaCutoff": 0.3, "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0.1, "roughnessFactor": 0.5,
          "baseColorTexture": {"index": 0, "texCoord": 0,
            "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 0.5, "scale": [2, 2]}}},
          "metallicRoughnessTexture": {"index": 1}},
        "normalTexture": {"index": 2, "scale": 0.5}, "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}}]);
    scene["bufferViews"] = views.into_iter().map(view).collect();
    scene
}

/// A `.glb` file of these two chunks.
pub fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, binary) = (padded(json, b' '), padded(binary, 0));
    let mut glb = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + binary.len();
    [2, total as u32, json.len() as u32].iter().for_each(|v| glb.extend(v.to_le_bytes()));
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((binary.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(binary);
    glb
}

pub const SIZE: [u32; 2] = [12, 8];

/// A capture of two frames; `radiance` is in every pixel.
pub fn write_capture(folder: &Path, radiance: f32) {
    let header = CaptureHeader { width: SIZE[0], height: SIZE[1], far: 100.0, frame_time_s: 0.03 };
    let mut writer = CaptureWriter::create(folder, header, false).unwrap();
    let mut frame = Frame::new(SIZE[0], SIZE[1]);
    let pixels = frame.depth.len();
    frame.radiance = (0..pixels).map(|i| [radiance, radiance * i as f32, 0.5]).collect();
    frame.surface_id = Some((0..pixels as u32).collect());
    frame.samples = Some(vec![1; pixels]);
    frame.reference = Some(vec![[radiance; 3]; pixels]);
    let info = FrameInfo {
        view: Mat4::IDENTITY,
        projection: glam::camera::rh::proj::directx::perspective(1.0, 1.5, 0.1, 100.0),
        jitter_px: Vec2::ZERO,
        restart: false,
    };
    for _ in 0..2 {
        writer.write_frame(&frame, &info).unwrap();
    }
    writer.finish().unwrap();
}

/// The needed channels in all sample types, and one that no capture knows.
fn channels(pixels: usize) -> Vec<AnyChannel<FlatSamples>> {
    let half =
        |i: usize| FlatSamples::F16((0..pixels).map(|p| f16::from_f32((p * i) as f32 * 0.01)).collect());
    let float = |i: usize| FlatSamples::F32((0..pixels).map(|p| (p * i) as f32 * 0.37).collect());
    let rgb = ["R", "G", "B"].into_iter().enumerate();
    let mut list: Vec<(String, FlatSamples)> = rgb
        .flat_map(|(i, c)| [(format!("radiance.{c}"), half(i + 1)), (format!("albedo.{c}"), half(3))])
        .collect();
    list.extend(["X", "Y", "Z"].map(|c| (format!("normal.{c}"), float(1))));
    list.extend(["depth.Z", "motion.X", "motion.Y", "unknown"].map(|name| (name.to_owned(), float(2))));
    list.push(("surface.id".to_owned(), FlatSamples::U32((0..pixels as u32).collect())));
    list.into_iter().map(|(name, samples)| AnyChannel::new(name.as_str(), samples)).collect()
}

/// A frame's file as another program writes it.
pub fn exr_file(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let size = (SIZE[0] as usize, SIZE[1] as usize);
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort(channels(size.0 * size.1).into());
    let layer = Layer::new(size, LayerAttributes::named("frame"), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}
