//! Hostile scenes, each with the error that a user sees.

use crate::files::{Place, load_scene, temporary};
use crate::harness::{Check, LIMITS, Limits, run};
use crate::oracle::{check_error, check_scene};
use crate::seeds;
use image::ImageFormat;
use serde_json::{Value, json};
use std::time::Duration;

/// Files of megabytes take longer, and more memory.
const LARGE: Limits = Limits { time: Duration::from_secs(60), memory: 1 << 30 };

/// A place with the seed as `scene.gltf`, its JSON changed.
fn edited(place: &Place, change: impl FnOnce(&mut Value)) {
    let buffer = seeds::buffer(1.0);
    let mut json = seeds::scene_json(buffer.len());
    change(&mut json);
    place.write_scene(&json, &buffer, &seeds::picture(ImageFormat::Png, [1, 2, 3]));
}

fn assert_error(limits: Limits, place: &Place, name: &str, parts: &[&str]) {
    let path = place.inside.join(name);
    let parts: Vec<String> = parts.iter().map(ToString::to_string).collect();
    let expected = format!("{name}, {parts:?}");
    let check = move || -> Check {
        let error = load_scene(&path).err().ok_or("it was loaded")?;
        check_error(&error, &path)?;
        match parts.iter().find(|part| !error.contains(*part)) {
            Some(part) => Err(format!("`{part}` is not in: {error}")),
            None => Ok(()),
        }
    };
    assert_eq!(run(limits, 0, check), Ok(()), "{expected}");
}

/// The seed with this change is refused with an error that says all of `parts`.
fn assert_refused(change: impl FnOnce(&mut Value), parts: &[&str]) {
    let temporary = temporary();
    edited(&temporary.place, change);
    assert_error(LIMITS, &temporary.place, "scene.gltf", parts);
}

/// The seed's buffer with floats replaced from `at` on.
fn assert_buffer_refused(at: usize, floats: &[f32], parts: &[&str]) {
    let temporary = temporary();
    edited(&temporary.place, |_| ());
    let mut buffer = seeds::buffer(1.0);
    for (i, value) in floats.iter().enumerate() {
        buffer[at + 4 * i..at + 4 * i + 4].copy_from_slice(&value.to_le_bytes());
    }
    temporary.place.write("tri.bin", &buffer);
    assert_error(LIMITS, &temporary.place, "scene.gltf", parts);
}

#[test]
fn the_seed_is_whole() {
    let temporary = temporary();
    edited(&temporary.place, |_| ());
    let scene = load_scene(&temporary.place.inside.join("scene.gltf")).unwrap();
    check_scene(&scene).unwrap();
    // The directional light has become the sun.
    assert_eq!((scene.images.len(), scene.instances.len(), scene.punctual_lights.len()), (3, 2, 2));
}

/// The gltf crate panics on each of these.
#[test]
fn references_that_the_parser_trusts_are_checked() {
    assert_refused(
        |j| j["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = json!(2_147_483_647),
        &["mesh 1, primitive 0: uses accessor 2147483647, the file has 9"],
    );
    assert_refused(
        |j| j["animations"][0]["channels"][1]["target"]["node"] = json!(6),
        &["animation 0 (walk), channel 1: moves node 6, the file has 6"],
    );
    assert_refused(
        |j| j["animations"][0]["channels"][0]["target"]["path"] = json!("teleport"),
        &["animation 0 (walk), channel 0: its `path` is unknown"],
    );
    assert_refused(
        |j| {
            j["cameras"][0] = json!({"type": "perspective",
                "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 1}});
        },
        &["camera 0: is of the type perspective but has no `perspective`"],
    );
    assert_refused(
        |j| drop(j["images"][1].as_object_mut().unwrap().remove("mimeType")),
        &["image 1: has a `bufferView` but no `mimeType`"],
    );
    assert_refused(|j| j["images"][0] = json!({"name": "wall"}), &["image 0 (wall): has neither `uri` nor"]);
}

#[test]
fn a_glb_header_shorter_than_itself_is_refused() {
    let temporary = temporary();
    let mut glb = seeds::glb(b"{}", &[]);
    glb[8..12].copy_from_slice(&3_u32.to_le_bytes());
    temporary.place.write("scene.glb", &glb);
    assert_error(LIMITS, &temporary.place, "scene.glb", &["its header is shorter than 12 bytes"]);
    temporary.place.write("scene.glb", &glb[..9]);
    assert_error(LIMITS, &temporary.place, "scene.glb", &["its header is shorter than 12 bytes"]);
}

#[cfg(unix)]
#[test]
fn uris_stay_in_the_folder_and_name_files() {
    let outside = "leaves the folder";
    for (uri, reason) in [
        ("../outside/tri.bin", outside),
        ("..%2foutside%2Ftri.bin", outside),
        ("%2e%2e/outside/tri.bin", outside),
        ("folder.bin/../../outside/tri.bin", outside),
        ("link_tri.bin", outside),
        ("link/tri.bin", outside),
        ("zero", outside),
        ("/etc/passwd", "is no relative path"),
        ("/dev/stdin", "is no relative path"),
        ("file:///etc/passwd", "its scheme is file, expected a relative path or data"),
        ("http://127.0.0.1/tri.bin", "its scheme is http"),
        ("pipe", "is a named pipe, expected a regular file"),
        ("folder.bin", "is a folder, expected a regular file"),
        ("loop", "symbolic links"),
        ("missing.bin", "cannot read missing.bin: No such file"),
        ("data:nothing", "no comma"),
        ("data:,plain", "is not base64"),
        ("data:;base64,####", "bad data URI"),
    ] {
        assert_refused(|j| j["buffers"][0]["uri"] = json!(uri), &["buffer 0", reason]);
        assert_refused(|j| j["images"][0]["uri"] = json!(uri), &["image 0 (wall)", reason]);
    }
}

#[cfg(unix)]
#[test]
fn scenes_that_are_no_files_or_too_large_are_refused() {
    let temporary = temporary();
    let place = &temporary.place;
    assert_error(LIMITS, place, "pipe", &["cannot be read: is a named pipe, expected a regular file"]);
    assert_error(LIMITS, place, "zero", &["is a device"]);
    assert_error(LIMITS, place, "folder.bin", &["is a folder"]);
    // Holes take no disk.
    let grow = |name: &str, bytes| {
        std::fs::File::create(place.inside.join(name)).unwrap().set_len(bytes).unwrap();
    };
    grow("large.glb", 1 << 40);
    assert_error(LIMITS, place, "large.glb", &["has 1099511627776 bytes, expected at most 3221225472"]);
    edited(place, |_| ());
    grow("tri.bin", 1 << 40);
    assert_error(LIMITS, place, "scene.gltf", &["buffer 0", "tri.bin", "expected at most 3221225472"]);
}

#[test]
fn nodes_form_a_tree_of_any_depth() {
    assert_refused(|j| j["nodes"][1]["children"] = json!([0]), &["node 0 (mover)", "reached twice"]);
    assert_refused(|j| j["nodes"][1]["children"] = json!([1]), &["node 1", "reached twice"]);
    assert_refused(|j| j["nodes"][5]["children"] = json!([1]), &["node 1", "reached twice"]);
    // A chain that no recursion survives.
    let temporary = temporary();
    edited(&temporary.place, |j| {
        j["nodes"] = (1..=100_000).map(|i| json!({"children": [i]})).collect();
        j["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0}));
        (j["scenes"], j["animations"]) = (json!([{"nodes": [0]}]), json!([]));
    });
    let path = temporary.place.inside.join("scene.gltf");
    assert_eq!(run(LARGE, 0, move || check_scene(&load_scene(&path)?)), Ok(()));
}

#[test]
fn numbers_that_lead_to_nan_or_infinity_are_refused() {
    assert_buffer_refused(
        12,
        &[f32::NAN],
        &["mesh 0 (tri), primitive 0", "position of vertex 1 is not finite"],
    );
    assert_buffer_refused(12, &[f32::INFINITY], &["position of vertex 1 is not finite"]);
    assert_buffer_refused(12, &[1e20], &["vertex 1 lies at", "expected at most 1e9"]);
    assert_buffer_refused(
        124,
        &[f32::NAN],
        &["animation 0 (walk), channel 0", "value of key 1 is not finite"],
    );
    assert_buffer_refused(
        136,
        &[0.0; 4],
        &["animation 0 (walk), channel 1", "value of key 0", "no rotation"],
    );
    assert_buffer_refused(124, &[1e12], &["node 0 (mover): it reaches 1.0e12 from the origin"]);
    assert_refused(|j| j["nodes"][2]["rotation"] = json!([0, 0, 0, 0]), &["node 2", "no finite translation"]);
    assert_refused(|j| j["nodes"][1]["matrix"] = json!(vec![0; 16]), &["node 1", "no finite translation"]);
    assert_refused(
        |j| j["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(1e30),
        &["light 0: its light is", "expected 0 to 1e15"],
    );
    assert_refused(
        |j| j["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]["outerConeAngle"] = json!(1e300),
        &["light 0: its cone angles are", "expected 0 to pi"],
    );
    assert_refused(
        |j| j["materials"][0]["emissiveFactor"][0] = json!(1e38),
        &["material 0 (paint): its emission is"],
    );
    assert_refused(
        |j| {
            j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
                json!({"KHR_texture_transform": {"offset": [1e300, 0]}})
        },
        &["material 0 (paint): a factor or a texture transform is not finite"],
    );
}

#[test]
fn a_scene_that_is_a_point_is_refused() {
    let temporary = temporary();
    edited(&temporary.place, |j| drop(j["nodes"][1].as_object_mut().unwrap().remove("mesh")));
    let mut buffer = seeds::buffer(1.0);
    buffer[..36].fill(0);
    temporary.place.write("tri.bin", &buffer);
    assert_error(LIMITS, &temporary.place, "scene.gltf", &["scene: all it shows lies within 0.0e0"]);
}

#[test]
fn images_that_claim_more_than_they_hold_are_refused() {
    for (side, reason) in [
        (60_000_u32, "is 60000x60000, expected 1 to 8192 pixels a side"),
        (8000, "is 8000x8000, more than its"),
    ] {
        let temporary = temporary();
        edited(&temporary.place, |_| ());
        let mut picture = seeds::picture(ImageFormat::Png, [1, 2, 3]);
        picture[16..20].copy_from_slice(&side.to_be_bytes());
        picture[20..24].copy_from_slice(&side.to_be_bytes());
        let checksum = crc(&picture[12..29]);
        picture[29..33].copy_from_slice(&checksum.to_be_bytes());
        temporary.place.write("image.png", &picture);
        assert_error(LIMITS, &temporary.place, "scene.gltf", &["image 0 (wall): image.png:", reason]);
    }
    let temporary = temporary();
    edited(&temporary.place, |_| ());
    let mut picture = seeds::picture(ImageFormat::Jpeg, [1, 2, 3]);
    let size = picture.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap() + 5;
    picture[size..size + 4].fill(0xff);
    temporary.place.write("image.png", &picture);
    assert_error(LIMITS, &temporary.place, "scene.gltf", &["is 65535x65535, expected 1 to 8192"]);
}

/// Of a PNG's chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 },
        )
    })
}

#[test]
fn counts_are_bounded_by_what_is_there() {
    assert_refused(
        |j| {
            j["accessors"][7]["count"] = json!(16_000_000);
            j["accessors"][7].as_object_mut().unwrap().remove("bufferView");
        },
        &["mesh 1, primitive 0, POSITION", "accessor 7 has 16000000 elements, the file"],
    );
    assert_refused(
        |j| j["accessors"][0]["count"] = json!(9_007_199_254_740_992_u64),
        &["mesh 0 (tri), primitive 0, POSITION: with it more than", "elements would be read"],
    );
    // A few kilobytes of nodes that place a mesh of many primitives come to billions of triangles.
    let temporary = temporary();
    edited(&temporary.place, |j| {
        let primitive = j["meshes"][0]["primitives"][0].clone();
        j["meshes"][0]["primitives"] = json!(vec![primitive; 2000]);
        j["nodes"] = json!(vec![json!({"mesh": 0}); 10_000]);
        (j["scenes"], j["animations"]) = (json!([{"nodes": (0..10_000).collect::<Vec<_>>()}]), json!([]));
    });
    let parts = ["node ", "with its mesh the scene shows more than 16777216 triangles"];
    assert_error(LARGE, &temporary.place, "scene.gltf", &parts);
}

#[test]
fn json_that_multiplies_in_memory_is_refused() {
    let temporary = temporary();
    let place = &temporary.place;
    let many = |start: &str, item: &str, times| format!("{start}{}", item.repeat(times));
    place.write("scene.gltf", many("{\"nodes\":[", "{},", (1 << 20) + 1).as_bytes());
    assert_error(LARGE, place, "scene.gltf", &["has 1048578 objects, expected at most 1048576"]);
    place.write("scene.gltf", many("{\"extensions\":{\"a\":[", "0,", (1 << 24) + 1).as_bytes());
    assert_error(LARGE, place, "scene.gltf", &["values, expected at most 16777216"]);
    place.write("scene.gltf", "[".repeat(100_000).as_bytes());
    assert_error(LIMITS, place, "scene.gltf", &["not a valid glTF file"]);
    place.write("scene.gltf", many("{\"extensions\":{\"a\":", "[", 100_000).as_bytes());
    assert_error(LIMITS, place, "scene.gltf", &["not a valid glTF file", "recursion limit"]);
}

#[test]
fn names_from_files_stay_short_and_printable() {
    assert_refused(
        |j| {
            j["meshes"][0]["name"] = json!("\u{1b}[31m".to_owned() + &"x".repeat(100_000));
            j["meshes"][0]["primitives"][0]["indices"] = json!(0);
        },
        &["mesh 0 (?[31mxxx", "x...)"],
    );
    assert_refused(
        |j| j["nodes"][2]["scale"] = json!("x".repeat(100_000)),
        &["not a valid glTF file", "invalid type: string"],
    );
}
