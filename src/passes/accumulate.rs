//! Joins this frame's samples to the history. See `shaders/accumulate.wgsl`.

use crate::gpu::{Compiler, Kernel, KernelDescriptor, Kind, Recorder, SPECULAR};
use wgpu::{BindingResource, Buffer, TextureFormat, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "accumulate",
    source: include_str!("../../shaders/accumulate.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("signal", Kind::TextureUint),
        ("guide", Kind::TextureUint),
        ("sample_count", Kind::TextureUint),
        ("reprojected", Kind::TextureUint),
        ("reprojected_noise", Kind::TextureUint),
        ("innovations", Kind::Buffer),
        ("history", Kind::Storage(TextureFormat::Rgba16Float)),
        ("noise", Kind::Storage(TextureFormat::R32Uint)),
        ("moments", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct AccumulateViews<'a> {
    pub signal: &'a TextureView,
    pub guide: &'a TextureView,
    pub sample_count: &'a TextureView,
    pub reprojected: &'a TextureView,
    pub reprojected_noise: &'a TextureView,
    pub innovations: &'a Buffer,
    pub history: &'a TextureView,
    pub noise: &'a TextureView,
    pub moments: &'a Buffer,
}

/// The pass.
#[derive(Debug, Clone)]
pub struct Accumulate(Kernel);

impl Accumulate {
    /// Compiles the pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::new(compiler, &DESCRIPTOR))
    }

    /// Compiles the pass for the specular signal.
    pub fn specular<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::with(compiler, &DESCRIPTOR, SPECULAR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &AccumulateViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.signal),
            BindingResource::TextureView(views.guide),
            BindingResource::TextureView(views.sample_count),
            BindingResource::TextureView(views.reprojected),
            BindingResource::TextureView(views.reprojected_noise),
            views.innovations.as_entire_binding(),
            BindingResource::TextureView(views.history),
            BindingResource::TextureView(views.noise),
            views.moments.as_entire_binding(),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
