//! Texel loads that a pixel executes, counted by hand from the shaders' loops.

use crate::shader::Shader;

pub const RULES: &str = "\
Texel loads executed per pixel; loads from buffers are not among them. `still`: nothing moves, history is long, no optional \
image. `moving`: history is resampled and all its taps belong to the surface. `worst`: this, where the history is nearly \
empty, with all optional images. `sites` are the loads in the code; where they change, the rows must be counted again.";

pub struct Taps {
    pub kernel: &'static str,
    pub still: f64,
    pub moving: f64,
    pub worst: f64,
    /// Of the shader that was counted.
    pub sites: usize,
    pub of_what: &'static str,
}

/// Cells of compose's 14x14 window, by each of its 8x8 pixels.
const CELLS: f64 = 196.0 / 64.0;

/// Inputs of `reproject`: radiance, depth, normal, albedo twice, motion.
const INPUTS: f64 = 6.0;
const BILINEAR: f64 = 4.0;
const BICUBIC: f64 = 16.0;
/// Pixels that tell the spread of a short history.
const SPREAD: f64 = 49.0;

pub const ALL: [Taps; 8] = [
    Taps {
        kernel: "reproject",
        // A tap is of three images: guide, history, noise.
        still: INPUTS + 3.0,
        moving: INPUTS + 3.0 * (BILINEAR + BICUBIC),
        worst: INPUTS + 3.0 + 3.0 * (BILINEAR + BICUBIC),
        sites: 15,
        of_what: "6 to 9 of the inputs; 1, or 4 + 16, of previous guide, history, noise",
    },
    Taps { kernel: "innovation", still: 0.0, moving: 0.0, worst: 0.0, sites: 0, of_what: "buffers only" },
    Taps {
        kernel: "accumulate",
        still: 4.0,
        moving: 4.0,
        // Each of signal, guide and sample count; the middle of the spread is loaded once more.
        worst: 5.0 + 2.0 + 3.0 * SPREAD,
        sites: 6,
        of_what: "own guide, signal, history, noise; 7x7 of signal and guide below 4 samples",
    },
    Taps { kernel: "centres", still: 0.0, moving: 0.0, worst: 0.0, sites: 0, of_what: "buffers only" },
    Taps { kernel: "fit", still: 0.0, moving: 0.0, worst: 0.0, sites: 0, of_what: "buffers only" },
    Taps { kernel: "predict", still: 1.0, moving: 1.0, worst: 1.0, sites: 1, of_what: "guide" },
    Taps {
        kernel: "compose",
        still: 4.0 * CELLS + 4.0,
        moving: 4.0 * CELLS + 4.0,
        worst: 4.0 * CELLS + 5.0,
        sites: 9,
        of_what: "14x14 a workgroup of guide, history, prediction, noise; own three again, albedo, emission",
    },
    Taps { kernel: "debug_view", still: 3.0, moving: 3.0, worst: 4.0, sites: 6, of_what: "own pixel" },
];

pub fn of(kernel: &str) -> Option<&'static Taps> {
    ALL.iter().find(|taps| taps.kernel == kernel)
}

/// Kernels of which the count by hand is missing or of an older shader.
pub fn outdated(shaders: &[Shader]) -> Vec<String> {
    let wrong = |shader: &Shader| {
        let (name, sites) = (shader.name(), shader.load_sites());
        match of(name) {
            None => Some(format!("{name}: count its texel loads in tests/cost/taps.rs")),
            Some(taps) if taps.sites != sites => Some(format!(
                "{name}: taps were counted with {} loads in the code, now there are {sites}: count again in \
                 tests/cost/taps.rs",
                taps.sites
            )),
            Some(_) => None,
        }
    };
    shaders.iter().filter_map(wrong).collect()
}
