//! Where samples go, by the built binary: `render --sampling`, `sampling` and `still`.

mod binary;

use binary::{assert_fails, assert_succeeds, demo};
use serde_json::Value;
use std::path::Path;

fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap()
}

#[test]
fn a_walk_is_rendered_adaptively_or_says_what_it_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("walk");
    let render = |more: &[&str]| {
        let size = ["render", "--size", "48x27", "--frames", "3", "--spp", "0.5", "--sampling", "adaptive"];
        demo(&[&size, more, &["--out", out.to_str().unwrap()]].concat())
    };
    assert_fails(&render(&["--method", "svgf"]), 1, &["adaptive", "quell"]);
    let record = ["record", "--sampling", "adaptive", "--out", out.to_str().unwrap()];
    assert_fails(&demo(&record), 1, &["adaptive", "recorded"]);
    assert!(!out.exists());
    let summary = assert_succeeds(&render(&["--reference", "4", "--reference-frames", "2"]));
    assert!(summary.contains("0.5 spp adaptive"), "{summary}");
    let metrics = json(&out.join("metrics.json"));
    assert_eq!((metrics["spp"].as_f64(), metrics["sampling"].as_str()), (Some(0.5), Some("adaptive")));
}

#[test]
fn ways_of_sampling_are_compared_on_the_walk_that_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let record = |frames: &str, out: &str| {
        let walk = ["record", "--size", "48x27", "--frames", "6", "--start", "2", "--reference", "4"];
        demo(&[&walk[..], &["--reference-frames", frames, "--out", out]].concat())
    };
    assert_succeeds(&record("1,4,5", &at("capture")));
    let sampling = |capture: &str, start: &str| {
        demo(&["sampling", capture, "--start", start, "--spp", "0.5,2", "--runs", "2", "--out", &at("out")])
    };
    assert_fails(&sampling(&at("capture"), "3"), 1, &["frame 0", "another camera", "gallery", "--start"]);
    let table = assert_succeeds(&sampling(&at("capture"), "2"));
    assert!(table.contains("| quell") && table.contains("checkerboard"), "{table}");

    let report = json(&folder.path().join("out/sampling.json"));
    let rows = report["rows"].as_array().unwrap();
    let ways: Vec<_> =
        rows.iter().map(|row| (row["sampling"].as_str().unwrap(), row["spp"].as_f64())).collect();
    let half = ["uniform", "checkerboard", "adaptive"].map(|sampling| (sampling, Some(0.5)));
    let two = ["uniform", "adaptive"].map(|sampling| (sampling, Some(2.0)));
    assert_eq!(ways, [[("uniform", Some(1.0))].as_slice(), &half, &two].concat());
    for row in rows {
        let (asked, traced) = (row["spp"].as_f64().unwrap(), row["traced_spp"].as_f64().unwrap());
        assert!((traced / asked - 1.0).abs() < 0.06, "{traced} instead of {asked}");
        for part in ["walk", "after_cut"] {
            assert!(row[part]["relative_mse"].is_f64(), "{row}");
        }
        assert!(row["walk"]["tpsnr_db"].is_f64(), "frames 4 and 5 follow each other: {row}");
        assert_eq!(row["error_correlation"].is_f64(), row["method"] == "quell");
    }
    for name in ["svgf_uniform_1.png", "quell_adaptive_2.png", "quell_adaptive_2_map.png", "sampling.md"] {
        assert!(folder.path().join("out").join(name).exists(), "{name}");
    }

    assert_succeeds(&record("5", &at("late")));
    assert_fails(
        &sampling(&at("late"), "2"),
        1,
        &["0 references among its first 4 frames", "--reference-frames"],
    );
}

#[test]
fn a_still_stops_by_samples_by_time_and_by_error() {
    let folder = tempfile::tempdir().unwrap();
    let still = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let options = ["still", "--size", "64x36", "--out", out.to_str().unwrap()];
        let summary = assert_succeeds(&demo(&[&options, more].concat()));
        (json(&out.join("still.json")), summary)
    };
    let spp = |report: &Value| report["rounds"].as_array().unwrap().last().unwrap()["spp"].as_f64().unwrap();

    let (all, summary) = still("all", &["--spp", "9", "--reference", "16"]);
    assert_eq!(all["stop"], "samples_spent");
    assert!((spp(&all) - 9.0).abs() < 0.5, "{all}");
    assert!(summary.contains("adaptive") && summary.contains("uniform"), "{summary}");
    let uniform = all["uniform"].as_array().unwrap();
    assert!(uniform.last().unwrap()["spp"].as_f64().unwrap() > 30.0, "as far as it takes: {uniform:?}");
    for name in [
        "still.png",
        "still.exr",
        "samples.png",
        "expected_error.png",
        "reference.png",
        "uniform.png",
        "error.svg",
    ] {
        assert!(folder.path().join("all").join(name).exists(), "{name}");
    }
    // The same samples again give the same image.
    let (again, _) = still("again", &["--spp", "9"]);
    assert_eq!(again["rounds"][2]["expected_mse"], all["rounds"][2]["expected_mse"]);
    assert!(again.get("uniform").is_none() && !folder.path().join("again/error.svg").exists());

    let first = all["rounds"][0]["expected_mse"].as_f64().unwrap();
    let third = all["rounds"][2]["expected_mse"].as_f64().unwrap();
    assert!(third < first, "expected errors fall: {first}, {third}");
    let target = (0.5 * (first + third)).to_string();
    let (early, _) = still("early", &["--spp", "64", "--target-error", &target]);
    assert_eq!(early["stop"], "error_reached");
    assert!(spp(&early) < 9.0, "{early}");
    let (short, _) = still("short", &["--spp", "64", "--time", "0.001"]);
    assert_eq!(short["stop"], "time_spent");
    assert_eq!(short["rounds"].as_array().unwrap().len(), 1, "{short}");

    let out = folder.path().join("few");
    let few = demo(&["still", "--spp", "0.5", "--out", out.to_str().unwrap()]);
    assert_fails(&few, 1, &["0.5 samples per pixel", "at least 1"]);
    assert!(!out.exists());
}
