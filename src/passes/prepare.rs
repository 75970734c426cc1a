//! Repairs the inputs and packs them. See `shaders/prepare.wgsl`.

use crate::gpu::{Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::{BindingResource, TextureFormat, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "prepare",
    source: include_str!("../../shaders/prepare.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("radiance", Kind::Texture),
        ("albedo", Kind::Texture),
        ("normal_roughness", Kind::Texture),
        ("depth", Kind::Texture),
        ("surface_id", Kind::TextureUint),
        ("emission", Kind::Texture),
        ("sample_count", Kind::TextureUint),
        ("signal", Kind::Storage(TextureFormat::Rgba16Float)),
        ("guide", Kind::Storage(TextureFormat::Rgba32Uint)),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct PrepareViews<'a> {
    pub radiance: &'a TextureView,
    pub albedo: &'a TextureView,
    pub normal_roughness: &'a TextureView,
    pub depth: &'a TextureView,
    pub surface_id: &'a TextureView,
    pub emission: &'a TextureView,
    pub sample_count: &'a TextureView,
    pub signal: &'a TextureView,
    pub guide: &'a TextureView,
}

/// The pass.
#[derive(Debug)]
pub struct Prepare(Kernel);

impl Prepare {
    /// Compiles the pass.
    pub fn new(device: &wgpu::Device) -> Self {
        Self(Kernel::new(device, &DESCRIPTOR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &PrepareViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.radiance),
            BindingResource::TextureView(views.albedo),
            BindingResource::TextureView(views.normal_roughness),
            BindingResource::TextureView(views.depth),
            BindingResource::TextureView(views.surface_id),
            BindingResource::TextureView(views.emission),
            BindingResource::TextureView(views.sample_count),
            BindingResource::TextureView(views.signal),
            BindingResource::TextureView(views.guide),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
