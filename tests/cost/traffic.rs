//! Compulsory traffic: what each kernel must read from and write to memory, however good the caches are.

use crate::shader::{REFLECTIONS_PREFIX, SPECULAR_PREFIX, Shader};
use quell::gpu::Kind;
use quell::layout::TILE;
use std::collections::BTreeMap;
use std::ops::AddAssign;
use wgpu::TextureFormat;

pub const RULES: &str = "\
Bytes per pixel at 1920x1080. An image or buffer that a kernel binds counts once, whole, as read where the shader reads it \
and as written where it writes it; an atomic operation does both. So this is the traffic of perfect caches: taps of \
neighbours, tiles that several windows share and the three levels of `centres` and `fit` count once. Buffers per tile are \
spread over its 64 pixels. `models` and `windows` count whole, though only few tiles have a model; of `moments`, `centres` reads one word \
a tile, which counts as a sector of 32 bytes. Uniforms and other \
resources of constant size count nothing. `clears` is what `encode` sets to 0 before the passes. The first three columns \
take the caller's images at the smallest accepted formats and without the optional ones, the last three at the largest and \
with all. `frame` is the sum without `debug_view` and the `sample_` kernels, which run on request (the expected error that `compose` \
then writes counts with those), and without `gains` and `choose`, which run under a budget. `split frame` is that of a \
frame whose specular radiance came apart: also the `specular` kernels, and a second time those that both signals share.";

/// Bytes per pixel, with the caller's images at their smallest and at their largest.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bytes {
    pub read: [f64; 2],
    pub written: [f64; 2],
}

impl Bytes {
    pub fn total(self, formats: usize) -> f64 {
        self.read[formats] + self.written[formats]
    }
}

impl AddAssign for Bytes {
    fn add_assign(&mut self, other: Self) {
        for formats in 0..2 {
            self.read[formats] += other.read[formats];
            self.written[formats] += other.written[formats];
        }
    }
}

/// The caller's images: smallest format, none for an optional image; largest format. As `FrameInputs` documents them.
const CALLERS: [(&str, Option<TextureFormat>, TextureFormat); 13] = [
    ("radiance", Some(TextureFormat::Rgba16Float), TextureFormat::Rgba32Float),
    ("albedo", Some(TextureFormat::Rgba8Unorm), TextureFormat::Rgba16Float),
    ("normal_roughness", Some(TextureFormat::Rgba8Snorm), TextureFormat::Rgba16Float),
    ("roughness", None, TextureFormat::R32Float),
    ("depth", Some(TextureFormat::R32Float), TextureFormat::R32Float),
    ("motion", Some(TextureFormat::Rg16Float), TextureFormat::Rgba16Float),
    ("surface_id", None, TextureFormat::R32Uint),
    ("emission", None, TextureFormat::Rgba16Float),
    ("sample_count", None, TextureFormat::R32Uint),
    ("hit_distance", None, TextureFormat::R32Float),
    ("samples", Some(TextureFormat::R32Uint), TextureFormat::R32Uint),
    ("output", Some(TextureFormat::Rgba16Float), TextureFormat::Rgba16Float),
    ("debug", Some(TextureFormat::Rgba16Float), TextureFormat::Rgba16Float),
];

/// Names in the shaders for what is owned under another name.
const ALIASES: [(&str, &str); 1] = [("prediction", "reprojected")];

/// What `encode` clears.
const CLEARED: [&str; 2] = ["windows", "coverage"];

/// What not every frame runs.
const OUTSIDE_FRAME: [&str; 6] =
    ["gains", "choose", "sample_gains", "sample_rate", "sample_map", "debug_view"];

/// What runs once for each of two signals, compiled once.
pub const SHARED: [&str; 4] = ["clears", "innovation", "centres", "fit"];

/// What a GPU's memory delivers at least.
const SECTOR: f64 = 32.0;

/// Every kernel's traffic, `clears`, and the sum of a frame. `owned` is what a denoiser holds, in bytes per pixel.
pub fn all(shaders: &[Shader], owned: &BTreeMap<&str, f64>) -> Vec<(String, Bytes)> {
    let clears: f64 = CLEARED.iter().map(|name| owned[name]).sum();
    let mut rows = vec![("clears".to_owned(), Bytes { read: [0.0; 2], written: [clears; 2] })];
    rows.extend(shaders.iter().map(|shader| (shader.name().to_owned(), of_kernel(shader, owned))));
    let sum = |counts: &dyn Fn(&str) -> bool| {
        let mut sum = Bytes::default();
        rows.iter().filter(|(name, _)| counts(name)).for_each(|&(_, bytes)| sum += bytes);
        sum
    };
    let frame = sum(&is_in_frame);
    let mut split = frame;
    split += sum(&|name| name.starts_with(SPECULAR_PREFIX) || SHARED.contains(&name));
    rows.extend([("frame".to_owned(), frame), ("split frame".to_owned(), split)]);
    rows
}

/// Whether a frame of one signal runs it.
pub fn is_in_frame(name: &str) -> bool {
    let is_variant = [SPECULAR_PREFIX, REFLECTIONS_PREFIX].iter().any(|prefix| name.starts_with(prefix));
    !OUTSIDE_FRAME.contains(&name) && !is_variant
}

fn of_kernel(shader: &Shader, owned: &BTreeMap<&str, f64>) -> Bytes {
    let mut sum = Bytes::default();
    for &(name, kind) in shader.descriptor.bindings {
        if matches!(kind, Kind::Frame | Kind::Uniform) {
            continue;
        }
        let bytes = of_binding(shader, name, owned);
        let (read, written) = shader.access(name);
        let moved = |really: bool| if really { bytes } else { [0.0; 2] };
        sum += Bytes { read: moved(read), written: moved(written) };
    }
    sum
}

fn of_binding(shader: &Shader, name: &str, owned: &BTreeMap<&str, f64>) -> [f64; 2] {
    let texel = |format: TextureFormat| format.block_copy_size(None).map_or(0.0, f64::from);
    if let Some(&(_, smallest, largest)) = CALLERS.iter().find(|(caller, ..)| *caller == name) {
        return [smallest.map_or(0.0, texel), texel(largest)];
    }
    // What a shader says of its own layout.
    let per_tile = |stride: u32| f64::from(stride * shader.element_bytes(name)) / f64::from(TILE * TILE);
    let bytes = match name {
        // Written on request only.
        "prediction" | "mix_weight" | "error" if shader.descriptor.name == "compose" => 0.0,
        // Stands in for an image where there is one signal.
        "rest" if shader.name() == "compose" => 0.0,
        "mix_weight" => owned["signal"],
        "error" => owned["reprojected_noise"],
        // A few words.
        "levels" | "histogram" | "sample_histogram" => 0.0,
        // Of each tile the weight alone: a sector.
        "moments" if shader.name() == "centres" => SECTOR / f64::from(TILE * TILE),
        // Those of the change of the light are smaller than the buffer that both kinds use in turn.
        "moments" => per_tile(shader.constant("TILE_STRIDE").expect("what binds moments has their layout")),
        _ => {
            let alias = ALIASES.iter().find(|(alias, _)| *alias == name);
            let owner = alias.map_or(name, |(_, owner)| owner);
            *owned.get(owner).unwrap_or_else(|| {
                let kernel = shader.name();
                panic!("{kernel} binds `{name}`, of which tests/cost/traffic.rs does not know the size")
            })
        }
    };
    [bytes; 2]
}

/// Tiles for which there is one model of the innovation.
pub fn tiles_of(shader: &Shader) -> f64 {
    f64::from(shader.constant("INNOVATION_TILES").unwrap_or(1)).powi(2)
}
