//! What every pass knows about the frame: the Rust side of `shaders/include/frame.wgsl`.

use crate::layout::{COVERAGE_ONE, LEVEL_STRIDES, LEVELS, WIDEST_WINDOW_PX};
use crate::{Camera, Centres, Windows};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

/// Bits of [`FrameUniforms::flags`]; named as in the WGSL.
#[expect(missing_docs, reason = "documented once, in include/frame.wgsl")]
pub mod flags {
    pub const HISTORY: u32 = 1;
    pub const SURFACE_ID: u32 = 2;
    pub const EMISSION: u32 = 4;
    pub const SAMPLE_COUNT: u32 = 8;
    pub const MOTION_DEPTH: u32 = 16;
    pub const MIX: u32 = 32;
    pub const RING_ERROR: u32 = 64;
    pub const INNOVATION: u32 = 128;
    pub const DEBUG: u32 = 256;
    pub const ERROR: u32 = 512;
    pub const LIMITED: u32 = 1024;
    pub const SPLIT: u32 = 2048;
    pub const SPECULAR_ALBEDO: u32 = 4096;
    pub const HIT_DISTANCE: u32 = 8192;
    pub const ROUGHNESS: u32 = 16384;
    pub const DEPTH_HARDWARE: u32 = 32768;
    pub const DEPTH_REVERSED: u32 = 65536;
    pub const DEPTH_DISTANCE: u32 = 131_072;
    pub const MOTION_FROM_PREVIOUS: u32 = 262_144;
    pub const NORMAL_UNSIGNED: u32 = 524_288;
    pub const NORMAL_OCTAHEDRAL: u32 = 1_048_576;
    pub const NORMAL_VIEW: u32 = 2_097_152;
    pub const NORMAL_MIRRORED: u32 = 4_194_304;
    pub const NORMAL_ALONE: u32 = 8_388_608;
    pub const BILINEAR: u32 = 16_777_216;
    pub const SPARSE: u32 = 33_554_432;
}

/// WGSL `View`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "documented once, in include/frame.wgsl")]
pub struct ViewUniforms {
    pub view_from_world: Mat4,
    pub scale: [f32; 2],
    pub shift: [f32; 2],
    pub offset: [f32; 2],
    pub jitter: [f32; 2],
    pub perspective: f32,
    pub pad_0: f32,
    pub size: [f32; 2],
}

impl ViewUniforms {
    /// Of a right-handed camera, whose frame has `size` pixels.
    fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let clip = camera.clip_from_view;
        let mut rotation = camera.view_from_world;
        rotation.w_axis = glam::Vec4::W;
        Self {
            size: size.map(|side| side as f32),
            view_from_world: rotation,
            scale: [clip.x_axis.x, clip.y_axis.y],
            shift: [clip.z_axis.x, clip.z_axis.y],
            offset: [clip.w_axis.x, clip.w_axis.y],
            jitter: camera.jitter_px.to_array(),
            perspective: clip.z_axis.w.abs().round(),
            ..Self::zeroed()
        }
    }
}

/// WGSL `Level`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "documented once, in include/frame.wgsl")]
pub struct LevelUniforms {
    pub stride: u32,
    pub covered: u32,
    pub pad_0: u32,
    pub pad_1: u32,
}

impl LevelUniforms {
    fn new(stride: u32, covered: u32) -> Self {
        Self { stride, covered, pad_0: 0, pad_1: 0 }
    }
}

/// WGSL `Frame`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "documented once, in include/frame.wgsl")]
pub struct FrameUniforms {
    pub size: [u32; 2],
    pub tiles: [u32; 2],
    pub motion_scale: [f32; 2],
    pub max_history: f32,
    pub flags: u32,
    pub index: u32,
    pub debug_view: u32,
    pub least_window: u32,
    pub widest_window: u32,
    pub firefly_limit: f32,
    pub far: f32,
    pub sample_budget: f32,
    pub dark_level: f32,
    pub origin: [u32; 2],
    pub motion_offset: [f32; 2],
    pub unprojection: [f32; 4],
    pub levels: [LevelUniforms; LEVELS],
    pub eye_delta: Vec3,
    pub model_limit: u32,
    pub current: ViewUniforms,
    pub previous: ViewUniforms,
}

impl FrameUniforms {
    /// Sets how windows are chosen and centres placed. Call after `size` is set.
    pub fn set_windows(&mut self, windows: Windows, centres: Centres) {
        // A window wider than an eighth of the frame holds more than one linear model can tell.
        let widest = if self.size[0].min(self.size[1]) >= 8 * WIDEST_WINDOW_PX { 3 } else { 2 };
        // The windows of uniform centres reach each other.
        let least = if centres == Centres::Uniform(4) { 3 } else { 1 };
        (self.least_window, self.widest_window) = match windows {
            Windows::RingError | Windows::MallowsCp => (least, widest.max(least)),
            Windows::Fixed(size) => (size.max(least), size.max(least)),
        };
        self.levels = LEVEL_STRIDES.map(|level| match centres {
            // Where the tents of two coarser models meet half-way, they sum to one half.
            Centres::Adaptive => LevelUniforms::new(level, COVERAGE_ONE / 2),
            Centres::Uniform(stride) if stride == level || level == 1 => LevelUniforms::new(level, 1),
            Centres::Uniform(_) => LevelUniforms::zeroed(),
        });
    }

    /// Sets both views, of right-handed cameras, and the eye's movement between them. Call after `size` is set.
    pub fn set_cameras(&mut self, current: &Camera, previous: &Camera, previous_size: [u32; 2]) {
        self.current = ViewUniforms::new(current, self.size);
        self.previous = ViewUniforms::new(previous, previous_size);
        self.eye_delta = eye(current) - eye(previous);
    }
}

/// World position of the camera; exact inverse of a rotation and a translation.
fn eye(camera: &Camera) -> Vec3 {
    let view = camera.view_from_world;
    -(glam::Mat3::from_mat4(view).transpose() * view.w_axis.truncate())
}
