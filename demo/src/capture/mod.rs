//! Captures: a sequence of frames on disk, as a folder with `capture.json` and one OpenEXR file per frame.
//!
//! A capture holds everything the denoiser reads, and the converged image where there is one. It is what is
//! recorded, replayed and attached to a bug report, and how frames of other renderers come in.
//!
//! | channels | needed | meaning |
//! | --- | --- | --- |
//! | `radiance.R .G .B` | yes | noisy scene-linear radiance, direct emission included |
//! | `albedo.R .G .B` | yes | diffuse reflectance at the first hit, specular colour at normal incidence for metals, the same with and without `specular`; 1 at a miss |
//! | `normal.X .Y .Z` | yes | world-space unit normal, 0 at a miss |
//! | `depth.Z` | yes | positive linear view depth; at or beyond `far` is a miss |
//! | `motion.X .Y` | yes | previous minus current pixel position, +x right, +y down, without jitter |
//! | `motion.Z` | no | previous minus current view depth of the surface point |
//! | `roughness.Y` | no | linear roughness; 1 where missing |
//! | `surface.id` | no | 32-bit identity of object and material |
//! | `emission.R .G .B` | no | radiance seen directly |
//! | `samples.N` | no | samples traced at the pixel; 1 where missing |
//! | `specular.R .G .B` | no | the part of the radiance that left the first hit through its specular lobe, 0 at a miss; `radiance` then holds the rest |
//! | `specular_albedo.R .G .B` | no | what that lobe reflects towards the camera of light that comes evenly from all sides, 0 to 1, 1 at a miss; only with `specular` |
//! | `hit_distance.Y` | no | world-space distance from the first hit along a direction of its specular lobe to the next; at or beyond `far` for the sky; 0, negative or NaN where unknown and at a miss |
//! | `reference.R .G .B` | no | converged, combined radiance of the same frame |
//!
//! With `specular`, whatever works on combined radiance (the peers, the noisy input, quell without the split) gets the sum of the
//! two.
//!
//! Matrices are column-major for column vectors, right-handed, view space looking down -z, clip depth 0 to 1.

mod b44;
mod channels;
mod decode;
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
use std::path::Path;

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
    /// Without what is in `specular`, where that is there.
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
    pub specular: Option<Vec<[f32; 3]>>,
    /// Only with `specular`.
    pub specular_albedo: Option<Vec<[f32; 3]>>,
    pub hit_distance: Option<Vec<f32>>,
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
            specular: None,
            specular_albedo: None,
            hit_distance: None,
            reference: None,
        }
    }

    /// Combined radiance: the sum of the two, where there are two.
    pub fn combined_radiance(&self) -> Vec<[f32; 3]> {
        let Some(specular) = &self.specular else {
            return self.radiance.clone();
        };
        let sum = |(rest, specular): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| rest[c] + specular[c]);
        self.radiance.iter().zip(specular).map(sum).collect()
    }

    /// A reflectance without what is reflected is a mistake: most likely the other channel has another name.
    fn check_split(&self, path: &Path) -> Result<(), CaptureError> {
        match (&self.specular_albedo, &self.specular) {
            (Some(_), None) => Err(CaptureError::Alone {
                path: path.to_owned(),
                image: "specular_albedo",
                needed: "specular",
            }),
            _ => Ok(()),
        }
    }

    /// The converged image, where the frame has one.
    pub fn reference_image(&self) -> Option<ImageRgb> {
        let pixels = self.reference.clone()?;
        Some(ImageRgb { width: self.width, height: self.height, pixels })
    }
}
