//! The fuzz targets. Numbers of cases are for 15 to 40 seconds in all on two cores, as busy as they are.

use crate::files::{load_scene, read_capture};
use crate::harness::{Check, fuzz};
use crate::mutate::{mutate_bytes, mutate_json, pick};
use crate::oracle::{check_error, check_frame, check_scene};
use crate::seeds;
use exr::prelude::{Blocks, Compression};
use image::ImageFormat;
use rand::Rng;
use serde_json::Value;
use std::cell::OnceCell;
use std::path::PathBuf;

fn scene_case(path: PathBuf) -> Box<dyn FnOnce() -> Check + Send> {
    Box::new(move || match load_scene(&path) {
        Ok(scene) => check_scene(&scene),
        Err(error) => check_error(&error, &path),
    })
}

#[test]
fn fuzz_gltf() {
    let whole_picture = seeds::picture(ImageFormat::Png, [1, 2, 3]);
    fuzz("gltf", 2500, |random, place| {
        let mut buffer = seeds::buffer(1.0);
        let mut json = seeds::scene_json(buffer.len());
        let mut picture = whole_picture.clone();
        let (paths, mut words) = (place.hostile_paths(), Vec::new());
        for _ in 0..*pick(random, &[1, 1, 2, 3, 10]) {
            words.push(mutate_json(random, &mut json, &paths));
        }
        if random.random_ratio(1, 5) {
            words.push(format!("tri.bin: {}", mutate_bytes(random, &mut buffer, 256)));
        }
        if random.random_ratio(1, 5) {
            words.push(format!("image.png: {}", mutate_bytes(random, &mut picture, 40)));
        }
        place.write_scene(&json, &buffer, &picture);
        if random.random_ratio(1, 8) {
            let mut text = json.to_string().into_bytes();
            words.push(format!("text: {}", mutate_bytes(random, &mut text, 200)));
            place.write("scene.gltf", &text);
        }
        (words.join("; "), scene_case(place.inside.join("scene.gltf")))
    });
}

#[test]
fn fuzz_glb() {
    fuzz("glb", 1500, |random, place| {
        let buffer = seeds::buffer(1.0);
        let mut json = seeds::scene_json(buffer.len());
        json["buffers"][0].as_object_mut().unwrap().remove("uri");
        let mut words = Vec::new();
        if random.random_bool(0.3) {
            words.push(mutate_json(random, &mut json, &place.hostile_paths()));
        }
        let mut glb = seeds::glb(json.to_string().as_bytes(), &buffer);
        words.push(mutate_bytes(random, &mut glb, 24));
        place.write("scene.glb", &glb);
        place.write("image.png", &seeds::picture(ImageFormat::Png, [1, 2, 3]));
        (words.join("; "), scene_case(place.inside.join("scene.glb")))
    });
}

/// Images alone, as most bytes of a scene's folder are theirs.
#[test]
fn fuzz_images() {
    fuzz("images", 1500, |random, place| {
        let format = *pick(random, &[ImageFormat::Png, ImageFormat::Jpeg]);
        let mut picture = seeds::picture(format, [1, 2, 3]);
        let words = format!("{format:?}: {}", mutate_bytes(random, &mut picture, 700));
        let buffer = seeds::buffer(1.0);
        place.write_scene(&seeds::scene_json(buffer.len()), &buffer, &picture);
        (words, scene_case(place.inside.join("scene.gltf")))
    });
}

fn capture_case(folder: PathBuf) -> Box<dyn FnOnce() -> Check + Send> {
    Box::new(move || match read_capture(&folder) {
        Ok(frames) => frames.iter().try_for_each(check_frame),
        Err(error) => check_error(&error, &folder),
    })
}

#[test]
fn fuzz_capture_description() {
    let whole = OnceCell::new();
    fuzz("capture.json", 2500, |random, place| {
        let manifest = place.inside.join("capture.json");
        let whole: &Value =
            whole.get_or_init(|| serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap());
        let mut json = whole.clone();
        let paths = place.hostile_paths();
        let mut words: Vec<String> =
            (0..*pick(random, &[1, 2, 5])).map(|_| mutate_json(random, &mut json, &paths)).collect();
        let mut text = json.to_string().into_bytes();
        if random.random_ratio(1, 4) {
            words.push(format!("text: {}", mutate_bytes(random, &mut text, 300)));
        }
        std::fs::write(&manifest, text).unwrap();
        (words.join("; "), capture_case(place.inside.clone()))
    });
}

#[test]
fn fuzz_capture_frames() {
    let tiles = Blocks::Tiles((8, 8).into());
    let seeds: Vec<(String, Vec<u8>)> = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ]
    .into_iter()
    .flat_map(|c| [(c, Blocks::ScanLines), (c, tiles)])
    .map(|(c, blocks)| (format!("{c:?} {blocks:?}"), seeds::exr_file(c, blocks)))
    .collect();
    fuzz("frames", 5000, |random, place| {
        let (name, whole) = pick(random, &seeds);
        let mut bytes = whole.clone();
        let mut words = vec![name.clone()];
        if random.random_ratio(1, 4) {
            // Another decoder for the same data, those included that nothing here can encode.
            let at = bytes.windows(24).position(|w| w == b"compression\0compression\0").unwrap() + 28;
            bytes[at] = random.random_range(0..13);
            words.push(format!("compression {}", bytes[at]));
        }
        words.push(mutate_bytes(random, &mut bytes, 900));
        std::fs::write(place.inside.join("frame_0000.exr"), bytes).unwrap();
        (words.join(", "), capture_case(place.inside.clone()))
    });
}
