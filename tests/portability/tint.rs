//! Shaders through Tint, the WGSL compiler of Chromium and of Dawn. It knows rules that naga does not check, such as uniform
//! control flow around barriers.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{
    OnceLock,
    atomic::{AtomicU32, Ordering},
};

/// A pipeline to be.
pub struct Pipeline<'a> {
    pub name: String,
    pub wgsl: String,
    pub stages: Stages<'a>,
    /// Names and values of the WGSL's `override`s.
    pub constants: &'a [(&'a str, f64)],
}

/// Entry points.
pub enum Stages<'a> {
    Compute(&'a str),
    #[allow(dead_code, reason = "the library draws nothing; the demo does")]
    Render {
        vertex: &'a str,
        fragment: &'a str,
    },
}

/// The npm package, Dawn for Node; its version and hash stand in `package-lock.json`.
const PACKAGE: [(&str, &str); 2] = [
    ("package.json", include_str!("package.json")),
    ("package-lock.json", include_str!("package-lock.json")),
];
const SCRIPT: &str = include_str!("tint.mjs");

/// What Tint says against each pipeline, by name; nothing where all is well. Warnings count.
///
/// # Panics
/// Where Tint cannot be asked: shaders that it has not seen would pass unseen.
pub fn complaints(pipelines: &[Pipeline<'_>]) -> Vec<(String, String)> {
    static CALLS: AtomicU32 = AtomicU32::new(0);
    let call = format!("{}-{}", std::process::id(), CALLS.fetch_add(1, Ordering::Relaxed));
    let shaders = installed().join(call);
    std::fs::create_dir_all(&shaders).unwrap();
    let mut lines = String::new();
    for Pipeline { name, wgsl, stages, constants } in pipelines {
        let file = shaders.join(format!("{name}.wgsl"));
        std::fs::write(&file, wgsl).unwrap();
        let (kind, entries) = match stages {
            Stages::Compute(entry) => ("compute", (*entry).to_owned()),
            Stages::Render { vertex, fragment } => ("render", format!("{vertex},{fragment}")),
        };
        let constants: Vec<_> = constants.iter().map(|(name, value)| format!("{name}={value}")).collect();
        lines += &format!("{name}\t{}\t{kind}\t{entries}\t{}\n", file.display(), constants.join(","));
    }
    let mut node = Command::new("node")
        .arg(installed().join("tint.mjs"))
        .arg(installed())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("node: {error}\n{HOW_TO}"));
    // The answers wait in the pipe until all is said: they are shorter than its buffer by far.
    node.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let output = node.wait_with_output().unwrap();
    std::fs::remove_dir_all(shaders).unwrap();
    let answers = String::from_utf8(output.stdout.clone()).unwrap();
    let answers: Vec<_> = answers.lines().filter_map(|line| line.split_once('\t')).collect();
    let names: Vec<_> = pipelines.iter().map(|pipeline| pipeline.name.as_str()).collect();
    let answered: Vec<_> = answers.iter().map(|(name, _)| *name).collect();
    assert!(output.status.success() && answered == names, "Tint did not answer: {}", said(&output));
    answers.into_iter().map(|(name, complaint)| (name.to_owned(), complaint.to_owned())).collect()
}

/// # Panics
/// Where Tint refuses one of them, or warns.
pub fn assert_accepts(pipelines: &[Pipeline<'_>]) {
    let complaints: Vec<_> =
        complaints(pipelines).into_iter().filter(|(_, complaint)| !complaint.is_empty()).collect();
    let lines: String =
        complaints.iter().map(|(name, complaint)| format!("  {name}: {complaint}\n")).collect();
    assert!(lines.is_empty(), "Tint, the browser's validator, says:\n{lines}");
}

const HOW_TO: &str = "This test gives every shader to the browser's validator. It needs Node 18 or newer and npm (Debian: \
    apt-get install nodejs npm, or tests/run.sh, which installs what is missing), and once the network, to fetch the package \
    `webgpu`.";

/// The folder where the package is; installs it where it is not, or is another version.
fn installed() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tint");
        let stamp = folder.join("installed");
        let lock = PACKAGE[1].1;
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("tint.mjs"), SCRIPT).unwrap();
        if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == lock) {
            return folder;
        }
        for (name, text) in PACKAGE {
            std::fs::write(folder.join(name), text).unwrap();
        }
        let npm = Command::new("npm")
            .args(["ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"])
            .current_dir(&folder)
            .stdin(Stdio::null())
            .output()
            .unwrap_or_else(|error| panic!("npm: {error}\n{HOW_TO}"));
        assert!(npm.status.success(), "npm could not install: {}\n{HOW_TO}", said(&npm));
        std::fs::write(stamp, lock).unwrap();
        folder
    })
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).join("\n")
}
