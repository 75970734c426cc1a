//! `bench --compare A B`: two results side by side, with what can be told from noise.

use super::percentiles::Percentiles;
use crate::input_file;
use crate::table::aligned;
use anyhow::{Context, Result, bail};
use serde::Deserialize;
use std::fmt::Write;
use std::path::Path;

/// 100 000 frames of all methods at four sizes take less.
const MOST_BYTES: u64 = 200_000_000;

/// What is compared of a `bench.json`.
#[derive(Debug, Clone, Deserialize)]
struct Bench {
    machine: Machine,
    clock: String,
    scene: String,
    start_s: f64,
    /// Not in older results, which are of a walk.
    #[serde(default = "walk")]
    motion: String,
    /// Where they are not the default.
    #[serde(default)]
    settings: Option<String>,
    spp: u32,
    warm_up: u32,
    frames: u32,
    sizes: Vec<Size>,
}

#[derive(Debug, Clone, Deserialize)]
struct Machine {
    adapter: String,
    driver_info: String,
    optimised: bool,
}

#[derive(Debug, Clone, Deserialize)]
struct Size {
    width: u32,
    height: u32,
    methods: Vec<Method>,
}

#[derive(Debug, Clone, Deserialize)]
struct Method {
    method: String,
    #[serde(default)]
    passes: Vec<Pass>,
    memory: Memory,
    samples: Samples,
}

#[derive(Debug, Clone, Deserialize)]
struct Pass {
    name: String,
    ms: Median,
}

#[derive(Debug, Clone, Deserialize)]
struct Median {
    median: Option<f64>,
}

#[derive(Debug, Clone, Deserialize)]
struct Memory {
    total_bytes: f64,
}

#[derive(Debug, Clone, Deserialize)]
struct Samples {
    frame_ms: Vec<f64>,
}

/// The report: what differs between the runs themselves, then times and memory of all that both have, B over A.
pub fn compare([a, b]: [&Path; 2]) -> Result<String> {
    let read = |path: &Path| -> Result<Bench> {
        let bytes = input_file::read(path, MOST_BYTES).with_context(|| path.display().to_string())?;
        serde_json::from_slice(&bytes).with_context(|| format!("{}: is not a bench.json", path.display()))
    };
    let (first, second) = (read(a)?, read(b)?);
    let mut out = format!("- A: {}\n- B: {}\n", a.display(), b.display());
    for difference in differences(&first, &second) {
        let _ = writeln!(out, "- not the same: {difference}");
    }
    let rows = rows(&first, &second, &mut out);
    if rows.len() == 1 {
        bail!("{} and {} have no method at a size in common", a.display(), b.display());
    }
    let _ = write!(
        out,
        "\nMedians in ms; B / A with twice its standard error where frames are known one by one. Below 1, B is faster.\n\n{}",
        aligned(&rows, 3)
    );
    Ok(out)
}

fn walk() -> String {
    "walk".to_owned()
}

/// What makes times hard to compare.
fn differences(a: &Bench, b: &Bench) -> Vec<String> {
    let text = |name: &str, a: &dyn ToString, b: &dyn ToString| {
        let (a, b) = (a.to_string(), b.to_string());
        (a != b).then(|| format!("{name}: {a}, {b}"))
    };
    let settings = |bench: &Bench| bench.settings.clone().unwrap_or_else(|| "default".to_owned());
    let rows = [
        text("adapter", &a.machine.adapter, &b.machine.adapter),
        text("driver", &a.machine.driver_info, &b.machine.driver_info),
        text("optimised", &a.machine.optimised, &b.machine.optimised),
        text("clock", &a.clock, &b.clock),
        text("scene", &a.scene, &b.scene),
        text("first frame in seconds", &a.start_s, &b.start_s),
        text("motion", &a.motion, &b.motion),
        text("settings", &settings(a), &settings(b)),
        text("samples per pixel", &a.spp, &b.spp),
        text("frames of warm-up", &a.warm_up, &b.warm_up),
        text("frames", &a.frames, &b.frames),
    ];
    rows.into_iter().flatten().collect()
}

/// Says in `out` what only one of the two has.
fn rows(a: &Bench, b: &Bench, out: &mut String) -> Vec<Vec<String>> {
    let mut rows = vec![["size", "method", "what", "A", "B", "B / A"].map(str::to_owned).to_vec()];
    for (name, one, other) in [("A", a, b), ("B", b, a)] {
        for (size, method) in methods(one).filter(|(size, method)| find(other, size, method).is_none()) {
            let _ = writeln!(out, "- only in {name}: {} at {}x{}", method.method, size.width, size.height);
        }
    }
    for (size, in_a) in methods(a) {
        let Some(in_b) = find(b, size, in_a) else { continue };
        let mut row = |what: &str, a: f64, b: f64, ratio: String| {
            let name = format!("{}x{}", size.width, size.height);
            rows.push(vec![name, in_a.method.clone(), what.to_owned(), short(a), short(b), ratio]);
        };
        let (a_ms, b_ms) = (Spread::of(&in_a.samples.frame_ms), Spread::of(&in_b.samples.frame_ms));
        row("frame", a_ms.median, b_ms.median, a_ms.ratio(&b_ms));
        let ratio = |a: f64, b: f64| if a > 0.0 { format!("{:.3}", b / a) } else { "-".to_owned() };
        for pass in &in_a.passes {
            let other = in_b.passes.iter().find(|other| other.name == pass.name);
            if let (Some(a), Some(b)) = (pass.ms.median, other.and_then(|other| other.ms.median)) {
                row(&pass.name, a, b, ratio(a, b));
            }
        }
        let [a, b] = [in_a, in_b].map(|method| method.memory.total_bytes * 1e-6);
        row("memory, MB", a, b, ratio(a, b));
    }
    rows
}

fn methods(bench: &Bench) -> impl Iterator<Item = (&Size, &Method)> {
    bench.sizes.iter().flat_map(|size| size.methods.iter().map(move |method| (size, method)))
}

fn find<'a>(bench: &'a Bench, size: &Size, method: &Method) -> Option<&'a Method> {
    let is_it = |(other_size, other): &(&Size, &Method)| {
        [other_size.width, other_size.height] == [size.width, size.height] && other.method == method.method
    };
    Some(methods(bench).find(is_it)?.1)
}

fn short(value: f64) -> String {
    format!("{value:.3}")
}

/// A median, and how sure it is.
struct Spread {
    median: f64,
    /// Of the median.
    standard_error: f64,
}

impl Spread {
    /// Frames of a walk differ, and some are slow for reasons of their own, so the spread is that of the middle half: of normal
    /// values, 1.349 deviations. A median's variance is pi / 2 times a mean's.
    fn of(values: &[f64]) -> Self {
        let [low, median, high] = [0.25, 0.5, 0.75].map(|fraction| Percentiles::at(values, fraction));
        let deviation = (high - low) / 1.349;
        let standard_error = (std::f64::consts::FRAC_PI_2 / values.len() as f64).sqrt() * deviation;
        Self { median, standard_error }
    }

    fn ratio(&self, other: &Self) -> String {
        if self.median.is_nan() || self.median <= 0.0 || other.median.is_nan() {
            return "-".to_owned();
        }
        let ratio = other.median / self.median;
        let relative = (self.standard_error / self.median).hypot(other.standard_error / other.median);
        format!("{ratio:.3} ±{:.3}", 2.0 * ratio * relative)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bench(adapter: &str, frames_ms: &[f64], pass_ms: f64) -> String {
        serde_json::json!({
            "machine": { "adapter": adapter, "driver_info": "1", "optimised": true },
            "clock": "gpu", "scene": "s", "start_s": 0.0, "spp": 1, "warm_up": 2, "frames": frames_ms.len(),
            "sizes": [{ "width": 64, "height": 36, "methods": [{
                "method": "quell",
                "passes": [{ "name": "fit", "ms": { "median": pass_ms, "p95": null, "p99": 1.0 } }],
                "memory": { "total_bytes": 2_000_000 },
                "samples": { "frame_ms": frames_ms },
            }] }],
        })
        .to_string()
    }

    fn compared(a: &str, b: &str) -> Result<String> {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.json", "b.json"].map(|name| folder.path().join(name));
        std::fs::write(&paths[0], a).unwrap();
        std::fs::write(&paths[1], b).unwrap();
        compare([&paths[0], &paths[1]])
    }

    #[test]
    fn ratios_come_with_what_they_may_be_off_by() {
        let a: Vec<f64> = (0..101).map(|i| 4.0 + 0.01 * f64::from(i % 11)).collect();
        let b: Vec<f64> = a.iter().map(|ms| 0.5 * ms).collect();
        let text = compared(&bench("x", &a, 1.0), &bench("x", &b, 0.25)).unwrap();
        assert!(!text.contains("not the same"), "{text}");
        let line = |what: &str| text.lines().find(|line| line.contains(what)).unwrap().to_owned();
        assert!(line("| frame").contains("4.050 | 2.025 | 0.500 ±0.002"), "{text}");
        assert!(line("| fit").contains("0.250"), "{text}");
        assert!(line("memory").contains("1.000"), "{text}");
    }

    /// Of medians of 101 draws, most lie within two of the standard errors that are given.
    #[test]
    fn the_standard_error_is_that_of_medians() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| random()).sum::<f64>() - 6.0;
        let inside = (0..1000)
            .filter(|_| {
                let values: Vec<f64> = (0..101).map(|_| normal()).collect();
                let spread = Spread::of(&values);
                spread.median.abs() < 2.0 * spread.standard_error
            })
            .count();
        assert!((920..980).contains(&inside), "{inside} of 1000");
    }

    #[test]
    fn what_differs_and_what_is_missing_is_said() {
        let one = bench("x", &[1.0, 1.0], 1.0);
        let text = compared(&one, &bench("y", &[2.0, 2.0, 2.0], 1.0)).unwrap();
        assert!(text.contains("not the same: adapter: x, y") && text.contains("frames: 2, 3"), "{text}");
        let other = one.replace("quell", "svgf");
        let error = compared(&one, &other).unwrap_err().to_string();
        assert!(error.contains("no method at a size in common"), "{error}");
        let error = format!("{:#}", compared(&one, "{}").unwrap_err());
        assert!(error.contains("b.json") && error.contains("machine"), "{error}");
    }
}
