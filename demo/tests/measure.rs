//! `measure` and `demo/gpu.sh` through the built binary, on a CPU adapter as all tests.

mod binary;

use binary::{assert_fails, assert_succeeds};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/gpu.sh");

fn gpu_sh(out: &Path, more: &[&str]) -> Output {
    Command::new("bash").arg(SCRIPT).arg(out).args(more).output().expect("bash runs")
}

#[test]
fn a_binary_that_is_brought_along_measures_all() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a folder");
    let options = [
        "--size",
        "17x9,34x18",
        "--at",
        "34x18",
        "--frames",
        "6",
        "--warm-up",
        "2",
        "--budget-ms",
        "10000,0.001",
    ];
    let printed =
        assert_succeeds(&gpu_sh(&out, &[&[env!("CARGO_BIN_EXE_quell-demo")], &options[..]].concat()));
    for part in [
        "quell grows with the pixels",
        "4 views: median",
        "budget of 10000 ms",
        "kept after",
        "budget of 0.001 ms",
        "not kept",
    ] {
        assert!(printed.contains(part), "`{part}` is not in: {printed}");
    }

    let json: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("measure.json")).unwrap()).unwrap();
    let methods = |bench: &Value, size: usize| {
        let methods = bench["sizes"][size]["methods"].as_array().unwrap();
        methods.iter().map(|method| method["method"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    for size in 0..2 {
        assert_eq!(methods(&json["walk"], size), ["quell", "svgf", "bmfr", "accumulate"]);
    }
    for motion in ["walk", "still", "cut"] {
        assert_eq!(json[motion]["motion"], motion);
        assert!(out.join(motion).join("bench.json").is_file(), "{motion}");
    }
    assert_eq!(methods(&json["cut"], 0), ["quell", "svgf"]);
    // Four times the pixels: memory has to follow.
    let memory = json["growth"]["memory"].as_f64().unwrap();
    assert!((0.5..1.1).contains(&memory), "{memory}");
    let paces = json["paces"].as_array().unwrap();
    assert_eq!(
        paces.iter().map(|pace| pace["frame_ms"].as_array().unwrap().len()).collect::<Vec<_>>(),
        [18, 18]
    );
    assert!(!paces[0]["settled_after"].is_null() && paces[1]["settled_after"].is_null(), "{paces:?}");

    let views = json["views"].as_array().unwrap();
    let memory = |of: usize| views[of]["memory_bytes"].as_f64().unwrap();
    assert_eq!(views.iter().map(|found| found["views"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2, 4]);
    assert!(views.iter().all(|found| found["frame_ms"]["median"].as_f64().unwrap() > 0.0), "{views:?}");
    assert_eq!([memory(1), memory(2)], [2.0 * memory(0), 4.0 * memory(0)]);

    let page = std::fs::read_to_string(out.join("measure.html")).unwrap();
    assert!(!page.contains("{{"), "a place was not filled");
    // Four methods twice, two budgets.
    assert_eq!(page.matches("<polyline").count(), 10);
    for part in ["llvmpipe", "wall clock", "34x18", "reproject", "over one view", "10000 ms"] {
        assert!(page.contains(part), "`{part}` is not in the page");
    }
}

#[test]
fn what_cannot_be_measured_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("nothing");
    assert_fails(&gpu_sh(folder.path(), &[missing.to_str().unwrap()]), 1, &["nothing: not a program"]);
    let binary = env!("CARGO_BIN_EXE_quell-demo");
    assert_fails(&gpu_sh(folder.path(), &[binary, "--budget-ms", "0"]), 2, &["--budget-ms", "0"]);
}
