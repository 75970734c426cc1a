//! Shows one of the frame's inner images. See `shaders/debug_view.wgsl`.

use crate::gpu::{Compiler, Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::{BindingResource, Buffer, TextureFormat, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "debug_view",
    source: include_str!("../../shaders/debug_view.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("guide", Kind::TextureUint),
        ("motion", Kind::Texture),
        ("prediction", Kind::TextureUint),
        ("history", Kind::Texture),
        ("noise", Kind::TextureUint),
        ("mix_weight", Kind::TextureUint),
        ("error", Kind::TextureUint),
        ("models", Kind::Buffer),
        ("windows", Kind::Buffer),
        ("debug", Kind::Storage(TextureFormat::Rgba16Float)),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct DebugViewViews<'a> {
    pub guide: &'a TextureView,
    pub motion: &'a TextureView,
    pub prediction: &'a TextureView,
    pub history: &'a TextureView,
    pub noise: &'a TextureView,
    pub mix_weight: &'a TextureView,
    pub error: &'a TextureView,
    pub models: &'a Buffer,
    pub windows: &'a Buffer,
    pub debug: &'a TextureView,
}

/// The pass.
#[derive(Debug)]
pub struct DebugView(Kernel);

impl DebugView {
    /// Compiles the pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::new(compiler, &DESCRIPTOR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &DebugViewViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.guide),
            BindingResource::TextureView(views.motion),
            BindingResource::TextureView(views.prediction),
            BindingResource::TextureView(views.history),
            BindingResource::TextureView(views.noise),
            BindingResource::TextureView(views.mix_weight),
            BindingResource::TextureView(views.error),
            views.models.as_entire_binding(),
            views.windows.as_entire_binding(),
            BindingResource::TextureView(views.debug),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
