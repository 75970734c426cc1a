//! Fetches each pixel's history. See `shaders/reproject.wgsl`.

use crate::gpu::{Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::{BindingResource, TextureFormat, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "reproject",
    source: include_str!("../../shaders/reproject.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("guide", Kind::TextureUint),
        ("motion", Kind::Texture),
        ("previous_guide", Kind::TextureUint),
        ("previous_history", Kind::Texture),
        ("previous_noise", Kind::Texture),
        ("reprojected", Kind::Storage(TextureFormat::Rgba16Float)),
        ("reprojected_noise", Kind::Storage(TextureFormat::Rgba16Float)),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct ReprojectViews<'a> {
    pub guide: &'a TextureView,
    pub motion: &'a TextureView,
    pub previous_guide: &'a TextureView,
    pub previous_history: &'a TextureView,
    pub previous_noise: &'a TextureView,
    pub reprojected: &'a TextureView,
    pub reprojected_noise: &'a TextureView,
}

/// The pass.
#[derive(Debug)]
pub struct Reproject(Kernel);

impl Reproject {
    /// Compiles the pass.
    pub fn new(device: &wgpu::Device) -> Self {
        Self(Kernel::new(device, &DESCRIPTOR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &ReprojectViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.guide),
            BindingResource::TextureView(views.motion),
            BindingResource::TextureView(views.previous_guide),
            BindingResource::TextureView(views.previous_history),
            BindingResource::TextureView(views.previous_noise),
            BindingResource::TextureView(views.reprojected),
            BindingResource::TextureView(views.reprojected_noise),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
