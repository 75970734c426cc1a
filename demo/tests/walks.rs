//! Walks through the built-in gallery by the built binary: `render`, `record`, and the walkthrough without a display.

mod binary;

use binary::{assert_fails, assert_succeeds, command, demo};
use image::RgbImage;
use quell_demo::capture::{CaptureReader, Frame};
use std::path::Path;
use std::process::Output;

const SIZE: (u32, u32) = (48, 27);
const FRAMES: usize = 3;

/// `render` or `record` of a tiny walk.
fn walk(what: &str, out: &Path, more: &[&str]) -> Output {
    let out = out.to_str().unwrap();
    demo(&[&[what, "--size", "48x27", "--frames", "3", "--seed", "7", "--out", out], more].concat())
}

fn png(path: &Path) -> RgbImage {
    let image = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    image.to_rgb8()
}

fn frame_png(folder: &Path, index: usize) -> RgbImage {
    let image = png(&folder.join(format!("frame_{index:04}.png")));
    assert_eq!(image.dimensions(), SIZE);
    image
}

fn files_in(folder: &Path) -> usize {
    std::fs::read_dir(folder).unwrap().count()
}

/// Mean difference of two images as shown, in steps of 8 bits.
fn mean_difference(a: &RgbImage, b: &RgbImage) -> f64 {
    let sum: u64 = a.iter().zip(b.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

#[test]
fn render_and_record_leave_the_same_walk() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let references = ["--reference", "4", "--reference-frames", "1,2"];
    let summary = assert_succeeds(&walk("render", &at("render"), &references));
    for part in ["gallery", "48x27", "none", "accumulate", "quell", "wrote"] {
        assert!(summary.contains(part), "`{part}` is not in: {summary}");
    }
    for i in 0..FRAMES {
        let (noisy, denoised) = (frame_png(&at("render/noisy"), i), frame_png(&at("render/denoised"), i));
        assert!(mean_difference(&noisy, &denoised) > 1.0, "frame {i} is denoised");
        assert_eq!(at(&format!("render/reference/frame_{i:04}.png")).exists(), i > 0);
    }
    assert_eq!(files_in(&at("render/noisy")), FRAMES);
    assert_eq!(files_in(&at("render/denoised")), FRAMES);
    assert_eq!(frame_png(&at("render/reference"), 2).dimensions(), SIZE);
    let sheet = png(&at("render/contact_sheet.png"));
    // Both frames with a reference, four images each.
    assert!(sheet.width() >= 4 * SIZE.0 && sheet.height() >= 2 * SIZE.1, "{:?}", sheet.dimensions());
    check_metrics(&at("render/metrics.json"));

    assert_succeeds(&walk("record", &at("capture"), &references));
    let (capture, replayed) = (at("capture"), at("replayed"));
    let table = assert_succeeds(&demo(&[
        "replay",
        capture.to_str().unwrap(),
        "--method",
        "quell",
        "--out",
        replayed.to_str().unwrap(),
    ]));
    assert!(table.contains("PSNR"), "{table}");
    for i in 0..FRAMES {
        let (rendered, replayed) = (frame_png(&at("render/denoised"), i), frame_png(&replayed, i));
        let difference = mean_difference(&rendered, &replayed);
        println!("frame {i}: replayed and rendered differ by {difference:.3} of 255");
        // A capture keeps some images in half precision.
        assert!(difference < 0.1, "frame {i}: {difference}");
        // Where the comparison is with another frame, it fails.
        let other = frame_png(&at("render/denoised"), (i + 1) % FRAMES);
        assert!(mean_difference(&other, &rendered) > 0.5, "frame {i}");
    }
}

#[test]
fn record_leaves_what_the_split_says() {
    let folder = tempfile::tempdir().unwrap();
    let recorded = |name: &str, options: &[&str]| {
        let out = folder.path().join(name);
        assert_succeeds(&walk("record", &out, options));
        CaptureReader::open(&out).unwrap().read(FRAMES - 1).unwrap()
    };
    let [full, distances, combined] = [
        ("full", &["--split", "full"][..]),
        ("distances", &["--split", "hit-distance"]),
        ("none", &["--no-split"]),
    ]
    .map(|(name, options)| recorded(name, options));
    assert!(full.specular.is_some() && full.specular_albedo.is_some() && full.hit_distance.is_some());
    assert!(distances.specular.is_none() && distances.specular_albedo.is_none());
    assert_eq!(distances, Frame { hit_distance: full.hit_distance.clone(), ..combined.clone() });
    let sums = full.combined_radiance();
    let pairs = sums.iter().flatten().zip(combined.radiance.iter().flatten());
    // Some tens of roundings, of parts and of their sum.
    pairs.for_each(|(sum, &whole)| assert!((sum - whole).abs() <= 1e-5 * (1.0 + whole), "{sum} for {whole}"));
}

fn check_metrics(path: &Path) {
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(json["spp"], 1.0);
    assert_eq!(json["reference_spp"], 4);
    assert_eq!(json["seed"], 7);
    let methods = json["methods"].as_array().unwrap();
    let names: Vec<_> = methods.iter().map(|method| method["method"].as_str().unwrap()).collect();
    assert_eq!(names, ["none", "accumulate", "quell"]);
    for (method, name) in methods.iter().zip(names) {
        assert_eq!((&method["width"], &method["height"]), (&SIZE.0.into(), &SIZE.1.into()));
        let frames: Vec<_> = method["frames"].as_array().unwrap().iter().map(|f| &f["frame"]).collect();
        assert_eq!(frames, [1, 2], "{name}");
        for key in ["psnr_db", "ssim", "flip", "relative_mse", "tpsnr_db"] {
            // What is not finite is null in JSON.
            assert!(method["mean"][key].is_f64(), "{name}, {key}: {}", method["mean"]);
        }
        assert!(json["wall_ms"][name].as_f64().unwrap() > 0.0, "{name}");
    }
}

#[test]
fn any_methods_are_rendered_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let more =
        ["--reference", "2", "--reference-frames", "2", "--method", "svgf,bmfr", "--method", "none,svgf"];
    let summary = assert_succeeds(&walk("render", folder.path(), &more));
    assert!(!summary.contains("quell"), "{summary}");
    let json = std::fs::read_to_string(folder.path().join("metrics.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let names: Vec<_> = json["methods"].as_array().unwrap().iter().map(|m| &m["method"]).collect();
    assert_eq!(names, ["svgf", "bmfr", "none"], "in the order asked for, none twice");
    let [noisy, svgf, bmfr] = ["noisy", "svgf", "bmfr"].map(|name| {
        assert_eq!(files_in(&folder.path().join(name)), FRAMES, "{name}");
        frame_png(&folder.path().join(name), 2)
    });
    assert!(mean_difference(&noisy, &svgf) > 1.0 && mean_difference(&svgf, &bmfr) > 1.0);
    assert!(!folder.path().join("denoised").exists());
    // Three methods and the reference in one row.
    let sheet = png(&folder.path().join("contact_sheet.png"));
    assert!(sheet.width() >= 4 * SIZE.0 && sheet.height() < 2 * SIZE.1, "{:?}", sheet.dimensions());
    let wrong = ["--method", "svgf,magic"];
    assert_fails(
        &walk("render", folder.path(), &wrong),
        2,
        &["magic", "quell", "svgf", "bmfr", "accumulate"],
    );
}

#[test]
fn jitter_and_antialiasing_change_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let rendered = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let references = ["--method", "none", "--reference", "4", "--reference-frames", "2"];
        let summary = assert_succeeds(&walk("render", &out, &[&references, more].concat()));
        let json = std::fs::read_to_string(out.join("metrics.json")).unwrap();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["jitter"], more.contains(&"--jitter"));
        assert_eq!(json["antialias"], more.contains(&"--antialias"));
        assert_eq!(summary.contains("antialiased"), more.contains(&"--antialias"), "{summary}");
        [frame_png(&out.join("noisy"), 2), frame_png(&out.join("reference"), 2)]
    };
    let [plain, plain_reference] = rendered("plain", &[]);
    let [jittered, jittered_reference] = rendered("jittered", &["--jitter"]);
    let [antialiased, antialiased_reference] = rendered("antialiased", &["--jitter", "--antialias"]);
    assert!(mean_difference(&plain, &jittered) > 1.0 && mean_difference(&jittered, &antialiased) > 1.0);
    assert!(mean_difference(&plain_reference, &jittered_reference) > 1.0);
    assert_eq!(jittered_reference, antialiased_reference);

    let capture = folder.path().join("capture");
    assert_succeeds(&walk("record", &capture, &["--jitter"]));
    let json = std::fs::read_to_string(capture.join("capture.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    for (i, frame) in (0..).zip(json["frames"].as_array().unwrap()) {
        let jitter = quell_demo::halton::jitter_px(i);
        let found = &frame["jitter_px"];
        let near = |axis: usize| (found[axis].as_f64().unwrap() - f64::from(jitter[axis])).abs() < 1e-6;
        assert!(near(0) && near(1), "{found}, not {jitter}");
    }

    let alone = walk("render", folder.path(), &["--antialias"]);
    assert_fails(&alone, 2, &["--jitter", "required", "not provided"]);
    assert_fails(&walk("record", folder.path(), &["--antialias"]), 2, &["--antialias"]);
}

#[test]
fn history_ends_where_the_tour_goes_on_in_another_scene() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("capture");
    // Frames at 23, 23.5, 24 and 24.5 s.
    let times = ["--frames", "4", "--fps", "2", "--start", "23"];
    let out = ["--size", "16x9", "--out", capture.to_str().unwrap()];
    assert_succeeds(&demo(&[&["record"], &times[..], &out].concat()));
    let json = std::fs::read_to_string(capture.join("capture.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let restarts: Vec<_> = json["frames"].as_array().unwrap().iter().map(|frame| &frame["restart"]).collect();
    assert_eq!(restarts, [true, false, true, false]);
}

#[test]
fn the_seed_decides_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    let noisy = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let out = out.to_str().unwrap();
        assert_succeeds(&demo(
            &[&["render", "--size", "48x27", "--frames", "1", "--out", out], more].concat(),
        ));
        frame_png(&folder.path().join(name).join("noisy"), 0)
    };
    let first = noisy("first", &[]);
    assert_eq!(first, noisy("again", &["--seed", "0"]));
    assert!(mean_difference(&first, &noisy("other", &["--seed", "1"])) > 1.0);
    assert!(!folder.path().join("first/reference").exists());
    let json = std::fs::read_to_string(folder.path().join("first/metrics.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["methods"].as_array().unwrap().len(), 0, "nothing to measure against");
}

#[test]
fn wrong_numbers_are_explained() {
    let out = ["--out", "never written"];
    for (arguments, parts) in [
        (["--size", "0x5"], ["0x5", "--size", "1 to 8192"]),
        (["--size", "abc"], ["abc", "--size", "WIDTHxHEIGHT"]),
        (["--size", "9000x9"], ["9000x9", "--size", "1 to 8192"]),
        (["--frames", "0"], ["0", "--frames", "1..=100000"]),
        (["--fps", "0"], ["0", "--fps", "above 0"]),
        (["--start", "nan"], ["nan", "--start", "finite"]),
        (["--spp", "0"], ["0", "--spp", "0.0625 to 64"]),
        (["--reference-frames", "1"], ["--reference <SPP>", "required", "not provided"]),
    ] {
        for what in ["render", "record"] {
            assert_fails(&demo(&[&[what], &arguments[..], &out].concat()), 2, &parts);
        }
    }
    assert_fails(&demo(&["render"]), 2, &["--out <DIR>"]);
    assert_fails(&demo(&["--exit-after", "0"]), 2, &["0", "--exit-after"]);
    assert!(!Path::new("never written").exists());
}

#[test]
fn wrong_walks_are_explained_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (out, text) = (folder.path().join("out"), folder.path().join("text.glb"));
    std::fs::write(&text, "this is no glTF").unwrap();
    let missing = folder.path().join("no such scene.gltf");
    for what in ["render", "record"] {
        let beyond = walk(what, &out, &["--reference", "1", "--reference-frames", "1,3"]);
        assert_fails(&beyond, 1, &["error: ", "reference frame 3", "3 frames"]);
        let unfound = walk(what, &out, &["--scene", missing.to_str().unwrap()]);
        assert_fails(&unfound, 1, &["error: ", "no such scene.gltf", "No such file"]);
        assert_fails(&walk(what, &out, &["--scene", text.to_str().unwrap()]), 1, &["error: ", "text.glb"]);
        assert!(!out.exists(), "a walk that cannot be traced leaves nothing behind");
        // A file where a folder should be: refused to everyone, even where permissions are not.
        let below = walk(what, &text.join("out"), &[]);
        assert_fails(&below, 1, &["error: ", "text.glb", "cannot create the folder"]);
    }
    assert_fails(&demo(&["--scene", missing.to_str().unwrap()]), 1, &["error: ", "no such scene.gltf"]);
}

#[test]
fn recording_never_replaces_what_is_no_capture() {
    let folder = tempfile::tempdir().unwrap();
    let (foreign, capture) = (folder.path().join("foreign"), folder.path().join("capture"));
    std::fs::create_dir(&foreign).unwrap();
    std::fs::write(foreign.join("thesis.txt"), "years of work").unwrap();
    for more in [&[][..], &["--overwrite"]] {
        let refused = walk("record", &foreign, more);
        assert_fails(&refused, 1, &["foreign", "not empty", "thesis.txt", "not overwritten"]);
        assert_eq!(std::fs::read_to_string(foreign.join("thesis.txt")).unwrap(), "years of work");
        assert_eq!(files_in(&foreign), 1);
    }
    let longer = ["record", "--size", "8x8", "--frames", "5", "--out", capture.to_str().unwrap()];
    assert_succeeds(&demo(&longer));
    let manifest = std::fs::read(capture.join("capture.json")).unwrap();
    assert_fails(&walk("record", &capture, &[]), 1, &["capture", "not empty", "--overwrite"]);
    assert_eq!(std::fs::read(capture.join("capture.json")).unwrap(), manifest);
    assert_succeeds(&walk("record", &capture, &["--overwrite"]));
    assert_eq!(files_in(&capture), FRAMES + 1);
}

#[test]
fn without_a_display_the_walkthrough_renders_headless() {
    let folder = tempfile::tempdir().unwrap();
    let output = command(&["--exit-after", "1", "--seed", "3"])
        .current_dir(folder.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = assert_succeeds(&output);
    assert!(said.contains("no display") && said.contains("wrote out/walk"), "{said}");
    let out = folder.path().join("out/walk");
    assert_eq!(png(&out.join("denoised/frame_0000.png")).dimensions(), (320, 180));
    assert_eq!(files_in(&out.join("noisy")), 1);
    assert!(out.join("contact_sheet.png").exists());
}
