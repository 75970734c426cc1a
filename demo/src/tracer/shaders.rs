//! The tracer's WGSL, joined from files: a line `//!include name` stands for `shaders/include/name.wgsl`.

use crate::compute::{join_wgsl, wgsl_files};

/// Every pass, by the name of its file, its entry point and its label.
const PASSES: [(&str, &str); 7] =
    wgsl_files!["", "visibility", "surface", "lobes", "plan", "trace", "trace_split", "accumulate"];

const INCLUDES: [(&str, &str); 10] = wgsl_files![
    "",
    "include/random",
    "include/scene",
    "include/images",
    "include/intersect",
    "include/camera",
    "include/surface",
    "include/bsdf",
    "include/lights",
    "include/primary",
    "include/path",
];

/// Names of the passes.
pub fn passes() -> impl Iterator<Item = &'static str> {
    PASSES.into_iter().map(|(name, _)| name)
}

/// The WGSL of a pass with everything it includes; `None` for a name that is no pass.
pub fn source(pass: &str) -> Option<String> {
    let (_, text) = PASSES.into_iter().find(|(name, _)| *name == pass)?;
    join_wgsl(text, &INCLUDES)
}
