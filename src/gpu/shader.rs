//! Joins a pass's WGSL with the includes that it names in `//!include a b c`.

const INCLUDES: [(&str, &str); 29] = [
    ("frame", include_str!("../../shaders/include/frame.wgsl")),
    ("numbers", include_str!("../../shaders/include/numbers.wgsl")),
    ("noise", include_str!("../../shaders/include/noise.wgsl")),
    ("surface", include_str!("../../shaders/include/surface.wgsl")),
    ("signal", include_str!("../../shaders/include/signal.wgsl")),
    ("inputs", include_str!("../../shaders/include/inputs.wgsl")),
    ("motion", include_str!("../../shaders/include/motion.wgsl")),
    ("reflection", include_str!("../../shaders/include/reflection.wgsl")),
    ("memory", include_str!("../../shaders/include/memory.wgsl")),
    ("demodulate", include_str!("../../shaders/include/demodulate.wgsl")),
    ("features", include_str!("../../shaders/include/features.wgsl")),
    ("tile_moments", include_str!("../../shaders/include/tile_moments.wgsl")),
    ("windows", include_str!("../../shaders/include/windows.wgsl")),
    ("window", include_str!("../../shaders/include/window.wgsl")),
    ("linear_model", include_str!("../../shaders/include/linear_model.wgsl")),
    ("models", include_str!("../../shaders/include/models.wgsl")),
    ("prediction", include_str!("../../shaders/include/prediction.wgsl")),
    ("cover", include_str!("../../shaders/include/cover.wgsl")),
    ("listing", include_str!("../../shaders/include/listing.wgsl")),
    ("innovations", include_str!("../../shaders/include/innovations.wgsl")),
    ("error", include_str!("../../shaders/include/error.wgsl")),
    ("sampling", include_str!("../../shaders/include/sampling.wgsl")),
    ("sample_gain", include_str!("../../shaders/include/sample_gain.wgsl")),
    ("tally", include_str!("../../shaders/include/tally.wgsl")),
    ("check_geometry", include_str!("../../shaders/include/check_geometry.wgsl")),
    ("check_motion", include_str!("../../shaders/include/check_motion.wgsl")),
    ("check_light", include_str!("../../shaders/include/check_light.wgsl")),
    ("check_reflection", include_str!("../../shaders/include/check_reflection.wgsl")),
    ("ridge", include_str!("../../shaders/include/ridge.wgsl")),
];

/// The WGSL module that the GPU compiles: `source` with each `//!include` line replaced by the files it names.
///
/// # Panics
/// If a name is unknown. Sources are part of the crate and a test assembles them all.
pub fn assemble(source: &str) -> String {
    let mut assembled = String::new();
    for line in source.lines() {
        match line.strip_prefix("//!include ") {
            Some(names) => names.split_whitespace().for_each(|name| assembled += include(name)),
            None => {
                assembled += line;
                assembled.push('\n');
            }
        }
    }
    assembled
}

fn include(wanted: &str) -> &'static str {
    let found = INCLUDES.iter().find(|(name, _)| *name == wanted);
    found.unwrap_or_else(|| panic!("no shader include named `{wanted}`")).1
}
