//! Counts how well inputs agree with each other, for an [`InputCheck`](crate::InputCheck). See `shaders/check.wgsl`.

use crate::gpu::{Compiler, DECODING, Kernel, KernelDescriptor, Kind, Recorder, ViewUniforms};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::{BindingResource, Buffer, TextureFormat, TextureView};

/// What counts.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "check",
    source: include_str!("../../shaders/check.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("radiance", Kind::Texture),
        ("albedo", Kind::Texture),
        ("normal_roughness", Kind::Texture),
        ("roughness", Kind::Texture),
        ("depth", Kind::Texture),
        ("motion", Kind::Texture),
        ("surface_id", Kind::TextureUint),
        ("emission", Kind::Texture),
        ("sample_count", Kind::TextureUint),
        ("hit_distance", Kind::Texture),
        ("previous_guide", Kind::TextureUint),
        ("previous_motion", Kind::TextureUint),
        ("guide", Kind::Storage(TextureFormat::Rg32Uint)),
        ("kept_motion", Kind::Storage(TextureFormat::Rg32Uint)),
        ("suspects", Kind::Frame),
        ("statistics", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// WGSL `Suspects`.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "documented once, in check.wgsl")]
pub struct SuspectUniforms {
    pub inverse_current: ViewUniforms,
    pub inverse_previous: ViewUniforms,
    pub turned_current: ViewUniforms,
    pub turned_previous: ViewUniforms,
    pub before: ViewUniforms,
    pub inverse_eye_delta: Vec3,
    pub is_before_known: u32,
    pub turned_eye_delta: Vec3,
    pub pad_0: u32,
    pub before_eye_delta: Vec3,
    pub pad_1: u32,
}

/// What the pass reads and writes; named as in the WGSL. `statistics` is 0 before it.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct CheckViews<'a> {
    pub radiance: &'a TextureView,
    pub albedo: &'a TextureView,
    pub normal_roughness: &'a TextureView,
    pub roughness: &'a TextureView,
    pub depth: &'a TextureView,
    pub motion: &'a TextureView,
    pub surface_id: &'a TextureView,
    pub emission: &'a TextureView,
    pub sample_count: &'a TextureView,
    pub hit_distance: &'a TextureView,
    pub previous_guide: &'a TextureView,
    pub previous_motion: &'a TextureView,
    pub guide: &'a TextureView,
    pub kept_motion: &'a TextureView,
    pub suspects: &'a Buffer,
    pub statistics: &'a Buffer,
}

/// The pass.
#[derive(Debug)]
pub struct Check(Kernel);

impl Check {
    /// Compiles the pass, for any conventions.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::with(compiler, &DESCRIPTOR, DECODING))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &CheckViews<'_>, extent: [u32; 2]) {
        let CheckViews { radiance, albedo, normal_roughness, roughness, depth, motion, .. } = *views;
        let CheckViews { surface_id, emission, sample_count, hit_distance, .. } = *views;
        let CheckViews { previous_guide, previous_motion, guide, kept_motion, suspects, statistics, .. } =
            *views;
        let images = [
            radiance,
            albedo,
            normal_roughness,
            roughness,
            depth,
            motion,
            surface_id,
            emission,
            sample_count,
            hit_distance,
            previous_guide,
            previous_motion,
            guide,
            kept_motion,
        ];
        let mut resources: Vec<_> = images.into_iter().map(BindingResource::TextureView).collect();
        resources.extend([suspects.as_entire_binding(), statistics.as_entire_binding()]);
        self.0.record(recorder, &resources, extent);
    }
}
