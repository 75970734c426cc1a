//! `bench` through the built binary, on a CPU adapter as all tests.

mod binary;

use binary::{assert_fails, assert_succeeds, demo};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

const FRAMES: usize = 3;

/// Three frames at 64x36 after two of warm-up, unless `more` says otherwise.
fn bench(out: &Path, more: &[&str]) -> Output {
    let fixed = ["bench", "--frames", "3", "--warm-up", "2", "--out", out.to_str().unwrap()];
    demo(&[&fixed[..], more].concat())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn names(methods: &Value) -> Vec<&str> {
    methods.as_array().unwrap().iter().map(|method| method["method"].as_str().unwrap()).collect()
}

fn check_method(method: &Value, pixels: f64) {
    for key in ["frame_ms", "cpu_ms"] {
        let percentiles = &method[key];
        let [median, p95, p99] = ["median", "p95", "p99"].map(|key| number(&percentiles[key]));
        assert!(0.0 < median && median <= p95 && p95 <= p99, "{key}: {percentiles}");
        let mut samples = numbers(&method["samples"][key]);
        assert_eq!(samples.len(), FRAMES, "warm-up is not counted");
        samples.sort_by(f64::total_cmp);
        assert_eq!(median, samples[FRAMES / 2]);
    }
    // A CPU adapter's timestamps are wrong; quell's passes are waited for one by one.
    let passes = method.get("passes").map(|passes| passes.as_array().unwrap().as_slice());
    assert_eq!(passes.is_some(), method["method"] == "quell");
    let longest = passes.into_iter().flatten().map(|pass| number(&pass["ms"]["median"])).fold(0.0, f64::max);
    assert!(longest <= number(&method["frame_ms"]["median"]), "{passes:?}");

    let memory = &method["memory"];
    let bytes = memory["resources"].as_array().unwrap().iter().map(|resource| number(&resource["bytes"]));
    let total = number(&memory["total_bytes"]);
    assert!(total > 0.0);
    assert_eq!(bytes.sum::<f64>(), total);
    // JSON's numbers are read to within a rounding or two.
    assert!((number(&memory["bytes_per_pixel"]) * pixels / total - 1.0).abs() < 1e-12, "{memory}");
    assert!(method["method"] != "quell" || number(&method["models"]) >= 1.0, "{}", method["models"]);
}

/// No method runs a frame before all have run the one before it, and none is always the first.
fn check_turns(methods: &[Value]) {
    let started: Vec<_> = methods.iter().map(|method| numbers(&method["samples"]["started_ms"])).collect();
    let at = |frame: usize| started.iter().map(move |times| times[frame]);
    for frame in 1..FRAMES {
        let last_before = at(frame - 1).fold(f64::MIN, f64::max);
        let first = at(frame).fold(f64::MAX, f64::min);
        assert!(last_before < first, "frame {frame}: {started:?}");
    }
    let leader = |frame: usize| {
        let first = at(frame).fold(f64::MAX, f64::min);
        at(frame).position(|time| time == first)
    };
    assert_ne!(leader(0), leader(1), "{started:?}");
}

#[test]
fn all_methods_are_timed_in_turns() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let printed = assert_succeeds(&bench(&out, &["--size", "64x36", "--size", "17x9"]));
    let json = std::fs::read_to_string(out.join("bench.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["clock"], &json["frames"]), (&"wall".into(), &FRAMES.into()));
    assert!(json["note"].as_str().unwrap().contains("wall clock"), "{}", json["note"]);
    for key in ["adapter", "driver", "backend", "os"] {
        assert!(!json["machine"][key].as_str().unwrap().is_empty(), "{key}");
    }
    assert_eq!(json["skipped"].as_array().unwrap().len(), 0);

    let sizes = json["sizes"].as_array().unwrap();
    assert_eq!(sizes.len(), 2);
    let baseline = json["baseline"].as_str().unwrap();
    assert_ne!(baseline, "quell");
    for (size, expected) in sizes.iter().zip([[64.0, 36.0], [17.0, 9.0]]) {
        assert_eq!([&size["width"], &size["height"]].map(number), expected);
        let names = names(&size["methods"]);
        assert!(names.contains(&"quell") && names.contains(&"accumulate"), "{names:?}");
        assert!(names.contains(&baseline) && !names.contains(&"none"), "{names:?}");
        let methods = size["methods"].as_array().unwrap();
        methods.iter().for_each(|method| check_method(method, expected[0] * expected[1]));
        check_turns(methods);

        let median = |method: &Value| number(&method["frame_ms"]["median"]);
        let of_baseline = methods.iter().find(|method| method["method"] == baseline).unwrap();
        assert_eq!(number(&of_baseline["ratio"]), 1.0);
        for method in methods {
            // JSON's numbers are read to within a rounding or two.
            let expected = median(method) / median(of_baseline);
            assert!((number(&method["ratio"]) / expected - 1.0).abs() < 1e-12, "{method}");
        }
    }

    let tables = std::fs::read_to_string(out.join("bench.md")).unwrap();
    assert!(printed.starts_with(&tables), "{printed}");
    for part in ["llvmpipe", "wall clock", "64x36", "17x9", "quell", "median ms", "total"] {
        assert!(printed.contains(part), "`{part}` is not in: {printed}");
    }
}

#[test]
fn methods_and_baseline_can_be_chosen_and_a_size_too_large_is_skipped() {
    let folder = tempfile::tempdir().unwrap();
    // At the largest size, quell's buffers exceed what a binding may have.
    let choice =
        ["--method", "quell,none,quell", "--baseline", "quell", "--size", "8192x8192,8x8", "--motion", "cut"];
    let printed = assert_succeeds(&bench(folder.path(), &choice));
    let json = std::fs::read_to_string(folder.path().join("bench.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!([&json["baseline"], &json["motion"]], ["quell", "cut"]);
    assert_eq!(json["sizes"].as_array().unwrap().len(), 1);
    assert_eq!(names(&json["sizes"][0]["methods"]), ["quell", "none"]);
    assert_eq!(number(&json["sizes"][0]["methods"][0]["ratio"]), 1.0);
    let reason = json["skipped"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("quell") && reason.contains("max_storage_buffer_binding_size"), "{reason}");
    assert!(printed.contains("skipped: 8192x8192"), "{printed}");
}

#[test]
fn two_runs_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
    assert_succeeds(&bench(&a, &["--size", "17x9", "--method", "quell,accumulate"]));
    assert_succeeds(&bench(&b, &["--size", "17x9", "--method", "quell,svgf"]));
    let [a, b] = [a, b].map(|out| out.join("bench.json").to_str().unwrap().to_owned());
    let printed = assert_succeeds(&demo(&["bench", "--compare", &a, &b]));
    for part in
        ["only in A: accumulate at 17x9", "only in B: svgf at 17x9", "| quell", "frame", "±", "memory, MB"]
    {
        assert!(printed.contains(part), "`{part}` is not in: {printed}");
    }
    assert!(!printed.contains("not the same"), "{printed}");

    assert_fails(&demo(&["bench", "--compare", &a]), 2, &["2 values required"]);
    assert_fails(&demo(&["bench", "--compare", &a, &b, "--out", "x"]), 2, &["--compare"]);
    assert_fails(&demo(&["bench", "--compare", &a, "nothing.json"]), 1, &["nothing.json"]);
}

#[test]
fn wrong_arguments_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for size in ["0x0", "abc", "64", "9000x4"] {
        assert_fails(&bench(&out, &["--size", size]), 2, &["--size", size, "WIDTHxHEIGHT"]);
    }
    let out_text = out.to_str().unwrap();
    for option in ["--frames", "--warm-up"] {
        assert_fails(&demo(&["bench", "--out", out_text, option, "0"]), 2, &[option, "1..=100000"]);
    }
    assert_fails(&bench(&out, &["--method", "magic"]), 2, &["magic", "quell", "accumulate"]);
    assert_fails(&demo(&["bench"]), 2, &["--out"]);
    let choice = ["--method", "quell", "--baseline", "accumulate"];
    assert_fails(&bench(&out, &choice), 1, &["baseline accumulate", "which are quell"]);
    assert!(!out.exists(), "what is wrong from the start leaves nothing behind");
    let missing = ["--scene", "nothing here.glb", "--size", "8x8"];
    assert_fails(&bench(&out, &missing), 1, &["nothing here.glb"]);
}
