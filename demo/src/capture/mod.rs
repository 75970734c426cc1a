//! Captures: a sequence of frames on disk, as a folder with `capture.json` and one OpenEXR file per frame.
//!
//! A capture holds everything the denoiser reads, and the converged image where there is one. It is what is
//! recorded, replayed and attached to a bug report, and how frames of other renderers come in.
//!
//! | channels | needed | meaning |
//! | --- | --- | --- |
//! | `radiance.R .G .B` | yes | noisy scene-linear radiance, direct emission included |
//! | `albedo.R .G .B` | yes | reflectance at the first hit, 1 at a miss |
//! | `normal.X .Y .Z` | yes | world-space unit normal, 0 at a miss |
//! | `depth.Z` | yes | positive linear view depth; at or beyond `far` is a miss |
//! | `motion.X .Y` | yes | previous minus current pixel position, +x right, +y down, without jitter |
//! | `motion.Z` | no | previous minus current view depth of the surface point |
//! | `roughness.Y` | no | linear roughness; 1 where missing |
//! | `surface.id` | no | 32-bit identity of object and material |
//! | `emission.R .G .B` | no | radiance seen directly |
//! | `samples.N` | no | samples traced at the pixel; 1 where missing |
//! | `reference.R .G .B` | no | converged radiance of the same frame |
//!
//! Matrices are column-major for column vectors, right-handed, view space looking down -z, clip depth 0 to 1.

mod channels;
mod download;
mod error;
mod guard;
mod manifest;
mod reader;
mod upload;
mod writer;

pub use download::download;
pub use error::CaptureError;
pub use reader::CaptureReader;
pub use upload::{gbuffer_for, upload};
pub use writer::CaptureWriter;

use crate::image::ImageRgb;
use glam::{Mat4, Vec2};

/// File that makes a folder a capture.
pub const MANIFEST: &str = "capture.json";

/// Longest side of a frame in pixels: what every WebGPU device can hold in a texture.
pub const MAX_SIDE: u32 = 8192;

/// What all frames of a capture share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaptureHeader {
    /// Size of every frame in pixels, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// See [`width`](Self::width).
    pub height: u32,
    /// View depth at and beyond which a pixel is a miss, above 0. Infinity is stored as the largest `f32`.
    pub far: f32,
    /// Time from one frame to the next in seconds, at least 0.
    pub frame_time_s: f32,
}

/// The camera of a frame, and whether it continues the one before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameInfo {
    /// View from world, unjittered.
    pub view: Mat4,
    /// Clip from view, unjittered.
    pub projection: Mat4,
    /// Where the samples lie relative to pixel centres, in pixels, +y down.
    pub jitter_px: Vec2,
    /// A cut: history does not continue.
    pub restart: bool,
}

impl FrameInfo {
    /// The same camera in the library's words.
    pub fn camera(&self) -> quell::Camera {
        quell::Camera {
            view_from_world: self.view,
            clip_from_view: self.projection,
            jitter_px: self.jitter_px,
        }
    }
}

/// The images of one frame: `width * height` values each, rows from top to bottom. See the module for meanings.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    pub width: u32,
    pub height: u32,
    pub radiance: Vec<[f32; 3]>,
    pub albedo: Vec<[f32; 3]>,
    pub normal: Vec<[f32; 3]>,
    pub depth: Vec<f32>,
    pub motion: Vec<[f32; 2]>,
    /// Previous minus current view depth (`motion.Z`).
    pub motion_depth: Option<Vec<f32>>,
    pub roughness: Option<Vec<f32>>,
    pub surface_id: Option<Vec<u32>>,
    pub emission: Option<Vec<[f32; 3]>>,
    pub samples: Option<Vec<u32>>,
    pub reference: Option<Vec<[f32; 3]>>,
}

impl Frame {
    /// A frame of misses: black, facing nowhere, infinitely far, at rest, without optional images.
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            radiance: vec![[0.0; 3]; pixels],
            albedo: vec![[1.0; 3]; pixels],
            normal: vec![[0.0; 3]; pixels],
            depth: vec![f32::INFINITY; pixels],
            motion: vec![[0.0; 2]; pixels],
            motion_depth: None,
            roughness: None,
            surface_id: None,
            emission: None,
            samples: None,
            reference: None,
        }
    }

    /// The converged image, where the frame has one.
    pub fn reference_image(&self) -> Option<ImageRgb> {
        let pixels = self.reference.clone()?;
        Some(ImageRgb { width: self.width, height: self.height, pixels })
    }
}
