//! What the built binary says of hostile files: one line of its own, and no panic.

use crate::binary::{assert_fails, demo};
use crate::files::temporary;
use crate::seeds;
use image::ImageFormat;
use serde_json::json;

#[cfg(unix)]
#[test]
fn hostile_files_end_in_one_line() {
    let temporary = temporary();
    let place = &temporary.place;
    let out = place.inside.join("out");
    let out = out.to_str().unwrap();
    let inside = place.inside.to_str().unwrap();
    let fails = |arguments: &[&str], parts: &[&str]| {
        let output = demo(arguments);
        assert_fails(&output, 1, parts);
        // Drivers may write lines too.
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!text.contains("backtrace"), "{text}");
        assert_eq!(text.lines().filter(|line| line.contains(inside)).count(), 1, "{text}");
    };
    let scene = place.inside.join("scene.gltf");
    let render = ["render", "--scene", scene.to_str().unwrap(), "--frames", "1", "--out", out];
    let write = |change: &dyn Fn(&mut serde_json::Value)| {
        let buffer = seeds::buffer(1.0);
        let mut json = seeds::scene_json(buffer.len());
        change(&mut json);
        place.write_scene(&json, &buffer, &seeds::picture(ImageFormat::Png, [1, 2, 3]));
    };
    write(&|j| j["buffers"][0]["uri"] = json!("../outside/tri.bin"));
    fails(&render, &["error: ", "scene.gltf: buffer 0: cannot read ../outside/tri.bin: leaves the folder"]);
    write(&|j| j["animations"][0]["channels"][0]["target"]["node"] = json!(99));
    fails(&render, &["error: ", "animation 0 (walk), channel 0: moves node 99, the file has 6"]);

    let replay = ["replay", place.inside.to_str().unwrap(), "--out", out];
    let manifest = place.inside.join("capture.json");
    std::fs::remove_file(&manifest).unwrap();
    std::fs::rename(place.inside.join("pipe"), &manifest).unwrap();
    fails(&replay, &["error: ", "capture.json: cannot read: is a named pipe, expected a regular file"]);
    std::fs::remove_file(&manifest).unwrap();
    place.write("capture.json", format!("{{\"version\": \"{}\"}}", "x".repeat(100_000)).as_bytes());
    fails(
        &replay,
        &["error: ", "capture.json: not a valid capture description: invalid type: string", "..."],
    );
}
