//! Predicts every pixel by the models, mixes prediction and temporal mean, and makes radiance of it. See `shaders/compose.wgsl`.

use crate::gpu::{Compiler, Kernel, KernelDescriptor, Kind, Recorder, SPECULAR};
use crate::layout::TILE;
use wgpu::{BindingResource, Buffer, TextureFormat, TextureView};

/// Pixels on a side of a workgroup.
const GROUP: u32 = 16;

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "compose",
    source: include_str!("../../shaders/compose.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("guide", Kind::TextureUint),
        ("models", Kind::Buffer),
        ("windows", Kind::Buffer),
        ("history", Kind::Texture),
        ("noise", Kind::TextureUint),
        ("albedo", Kind::Texture),
        ("emission", Kind::Texture),
        ("rest", Kind::Texture),
        ("output", Kind::Storage(TextureFormat::Rgba16Float)),
        ("error", Kind::Storage(TextureFormat::R32Uint)),
        ("prediction", Kind::Storage(TextureFormat::Rg32Uint)),
        ("mix_weight", Kind::Storage(TextureFormat::R32Uint)),
    ],
    workgroup: [GROUP, GROUP],
    covers: [GROUP, GROUP],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct ComposeViews<'a> {
    pub guide: &'a TextureView,
    pub models: &'a Buffer,
    pub windows: &'a Buffer,
    pub history: &'a TextureView,
    pub noise: &'a TextureView,
    pub albedo: &'a TextureView,
    pub emission: &'a TextureView,
    pub rest: &'a TextureView,
    pub output: &'a TextureView,
    pub error: &'a TextureView,
    pub prediction: &'a TextureView,
    pub mix_weight: &'a TextureView,
}

/// The pass.
#[derive(Debug, Clone)]
pub struct Compose(Kernel);

impl Compose {
    /// Compiles the pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::new(compiler, &DESCRIPTOR))
    }

    /// Compiles the pass for the specular signal.
    pub fn specular<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::with(compiler, &DESCRIPTOR, SPECULAR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &ComposeViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.guide),
            views.models.as_entire_binding(),
            views.windows.as_entire_binding(),
            BindingResource::TextureView(views.history),
            BindingResource::TextureView(views.noise),
            BindingResource::TextureView(views.albedo),
            BindingResource::TextureView(views.emission),
            BindingResource::TextureView(views.rest),
            BindingResource::TextureView(views.output),
            BindingResource::TextureView(views.error),
            BindingResource::TextureView(views.prediction),
            BindingResource::TextureView(views.mix_weight),
        ];
        // The workgroups' grid begins up to a tile outside.
        self.0.record(recorder, &resources, extent.map(|side| side + TILE));
    }
}
