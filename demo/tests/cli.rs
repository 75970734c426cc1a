//! `replay` through the built binary: what it writes, and what it says when something is wrong.

mod binary;
mod synthetic;

use binary::{assert_fails, demo};
use exr::prelude::FlatSamples;
use quell_demo::capture::Frame;
use quell_demo::image::ImageRgb;
use std::path::Path;
use std::process::Output;
use synthetic::{HEIGHT, WIDTH, edit_channels};

fn replay(capture: &Path, out: &Path, method: &str) -> Output {
    demo(&["replay", capture.to_str().unwrap(), "--out", out.to_str().unwrap(), "--method", method])
}

#[test]
fn wrong_arguments_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let (missing, out) = (folder.path().join("nothing here"), folder.path().join("out"));
    assert_fails(&replay(&missing, &out, "none"), 1, &["error: ", "nothing here", "capture.json"]);
    assert!(!out.exists(), "a capture that cannot be read leaves nothing behind");
    assert_fails(
        &replay(&missing, &out, "magic"),
        2,
        &["magic", "quell", "svgf", "bmfr", "accumulate", "none"],
    );
    assert_fails(
        &demo(&["replay", "x", "--out", "y", "--max-history", "0"]),
        2,
        &["--max-history", "1..=1024"],
    );
    assert_fails(&demo(&["replay", "x"]), 2, &["--out"]);
    let replay_as = |split: &[&str]| demo(&[&["replay", "x", "--out", "y"], split].concat());
    assert_fails(&replay_as(&["--split", "half"]), 2, &["half", "full", "hit-distance", "none"]);
    assert_fails(&replay_as(&["--no-split", "--split", "full"]), 2, &["--no-split", "--split"]);
}

#[test]
fn broken_captures_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, out) = (folder.path().join("capture"), folder.path().join("out"));
    synthetic::write(&capture, 1);
    // Results have the names of a capture's frames.
    assert_fails(&replay(&capture, &capture, "none"), 1, &["holds a capture", "choose another folder"]);

    edit_channels(&capture.join("frame_0000.exr"), |channels| {
        for (name, _) in channels {
            *name = name.replace("albedo.R", "albedo.red");
        }
    });
    let parts = ["frame_0000.exr", "`albedo.R` is missing", "albedo.red"];
    assert_fails(&replay(&capture, &out, "none"), 1, &parts);

    let unsplit = folder.path().join("unsplit");
    synthetic::write_each(&unsplit, 1, synthetic::split_frame);
    edit_channels(&unsplit.join("frame_0000.exr"), |channels| {
        channels.retain(|(name, _)| !name.starts_with("specular."));
    });
    assert_fails(&replay(&unsplit, &out, "none"), 1, &["has `specular_albedo` but no `specular`"]);

    std::fs::write(capture.join("capture.json"), "{ \"version\": 1, ").unwrap();
    assert_fails(&replay(&capture, &out, "none"), 1, &["capture.json", "not a valid capture", "EOF"]);

    let file = folder.path().join("a file");
    std::fs::write(&file, "").unwrap();
    synthetic::write(&folder.path().join("good"), 1);
    assert_fails(&replay(&folder.path().join("good"), &file, "none"), 1, &["a file", "cannot create"]);
}

#[test]
fn a_reference_with_nan_is_an_error_not_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("capture");
    synthetic::write(&capture, 1);
    edit_channels(&capture.join("frame_0000.exr"), |channels| {
        for (name, samples) in channels {
            if let (true, FlatSamples::F32(values)) = (name == "reference.G", samples) {
                values[WIDTH as usize + 4] = f32::NAN;
            }
        }
    });
    let output = replay(&capture, &folder.path().join("out"), "none");
    assert_fails(&output, 1, &["metrics of frame 0", "reference has NaN at pixel (4, 1), channel G"]);
}

/// Mean PSNR in `metrics.json`, after checking that the results are whole.
fn replayed_psnr(capture: &Path, out: &Path, method: &str, frames: usize) -> f64 {
    let output = replay(capture, out, method);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for i in 0..frames {
        let image = ImageRgb::read_exr(&out.join(format!("frame_{i:04}.exr"))).unwrap();
        assert_eq!((image.width, image.height), (WIDTH, HEIGHT));
        let png = image::open(out.join(format!("frame_{i:04}.png"))).unwrap().to_rgb8();
        assert_eq!(png.as_raw(), &image.to_display_rgb8(), "the PNG is the EXR as shown");
    }
    let json = std::fs::read_to_string(out.join("metrics.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["method"], method);
    assert!(!json["adapter"].as_str().unwrap().is_empty());
    assert_eq!(json["frames"].as_array().unwrap().len(), frames);
    for key in ["psnr_db", "ssim", "flip", "relative_mse", "tpsnr_db"] {
        assert!(json["mean"][key].is_f64(), "{key}: {}", json["mean"]);
        assert!(json["frames"][1][key].is_f64(), "{key}");
    }
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("PSNR") && table.contains("mean"), "{table}");
    json["mean"]["psnr_db"].as_f64().unwrap()
}

#[test]
fn replay_writes_images_and_metrics_and_accumulation_helps() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("capture");
    synthetic::write(&capture, 6);
    let none = replayed_psnr(&capture, &folder.path().join("none"), "none", 6);
    let accumulated = replayed_psnr(&capture, &folder.path().join("accumulate"), "accumulate", 6);
    assert!(accumulated > none + 2.0, "{accumulated} dB accumulated, {none} dB noisy");
}

#[test]
fn without_references_there_are_no_metrics() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, out) = (folder.path().join("capture"), folder.path().join("out"));
    synthetic::write(&capture, 1);
    edit_channels(&capture.join("frame_0000.exr"), |channels| {
        channels.retain(|(name, _)| !name.starts_with("reference") && !name.starts_with("motion.Z"));
    });
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("metrics.json"), "of another run").unwrap();
    let output = replay(&capture, &out, "accumulate");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(out.join("frame_0000.png").exists());
    assert!(!out.join("metrics.json").exists(), "metrics of other images must not stay");
}

/// Images that a replay of 4 frames wrote.
fn replayed(capture: &Path, out: &Path, options: &[&str]) -> Vec<ImageRgb> {
    let paths = ["replay", capture.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let output = demo(&[&paths, options].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (0..4).map(|i| ImageRgb::read_exr(&out.join(format!("frame_{i:04}.exr"))).unwrap()).collect()
}

#[test]
fn a_split_capture_is_replayed_split_or_combined() {
    let folder = tempfile::tempdir().unwrap();
    let [split, whole, out] = ["split", "whole", "out"].map(|name| folder.path().join(name));
    synthetic::write_each(&split, 4, synthetic::split_frame);
    synthetic::write_each(&whole, 4, |i| {
        let frame = synthetic::split_frame(i);
        let radiance = frame.combined_radiance();
        Frame { radiance, specular: None, specular_albedo: None, hit_distance: None, ..frame }
    });
    let combined = replayed(&whole, &out, &[]);
    assert_eq!(replayed(&split, &out, &["--no-split"]), combined);
    assert_eq!(replayed(&split, &out, &["--split", "none"]), combined);
    assert_ne!(replayed(&split, &out, &["--split", "full"]), combined);
    assert_eq!(replayed(&split, &out, &["--method", "svgf"]), replayed(&whole, &out, &["--method", "svgf"]));
}

#[test]
fn reflective_surfaces_are_measured_where_there_are_any() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mean = |name: &str, roughness: f32| {
        let capture = folder.path().join(name);
        synthetic::write_each(&capture, 1, |i| {
            let frame = synthetic::frame(i);
            Frame { roughness: Some(vec![roughness; frame.depth.len()]), ..frame }
        });
        assert!(replay(&capture, &out, "none").status.success());
        let json = std::fs::read_to_string(out.join("metrics.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&json).unwrap()["mean"].clone()
    };
    assert!(mean("rough", 0.5).get("reflective_psnr_db").is_none());
    // All but the sky, which is exact: the same error over fewer pixels.
    let [all, reflective] =
        ["psnr_db", "reflective_psnr_db"].map(|key| mean(key, 0.25)[key].as_f64().unwrap());
    let share = f64::from(HEIGHT - synthetic::SKY) / f64::from(HEIGHT);
    assert!((all - reflective + 10.0 * share.log10()).abs() < 0.01, "{all} {reflective}");
}
