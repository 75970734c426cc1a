//! The tracer's WGSL, joined from files: a line `//!include name` stands for `shaders/include/name.wgsl`.

use std::borrow::Cow;

macro_rules! wgsl {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../shaders/", $name, ".wgsl")))),*]
    };
}

/// Every pass, by the name of its file, its entry point and its label.
const PASSES: [(&str, &str); 4] = wgsl!["visibility", "surface", "trace", "accumulate"];

const INCLUDES: [(&str, &str); 9] = wgsl![
    "include/random",
    "include/scene",
    "include/images",
    "include/intersect",
    "include/camera",
    "include/surface",
    "include/bsdf",
    "include/lights",
    "include/primary",
];

/// Names of the passes.
pub fn passes() -> impl Iterator<Item = &'static str> {
    PASSES.into_iter().map(|(name, _)| name)
}

/// The WGSL of a pass with everything it includes; `None` for a name that is no pass.
pub fn source(pass: &str) -> Option<String> {
    let (_, text) = PASSES.into_iter().find(|(name, _)| *name == pass)?;
    let mut joined = String::new();
    for line in text.lines() {
        let part: Cow<str> = match line.strip_prefix("//!include ") {
            Some(name) => {
                let file = format!("include/{}", name.trim());
                INCLUDES.into_iter().find(|(name, _)| *name == file)?.1.into()
            }
            None => line.into(),
        };
        joined.push_str(&part);
        joined.push('\n');
    }
    Some(joined)
}
