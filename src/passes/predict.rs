//! Predicts every pixel from the models that cover it. See `shaders/predict.wgsl`.

use crate::gpu::{Compiler, Kernel, KernelDescriptor, Kind, Recorder, SPECULAR};
use wgpu::{BindingResource, Buffer, TextureFormat, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "predict",
    source: include_str!("../../shaders/predict.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("guide", Kind::TextureUint),
        ("models", Kind::Buffer),
        ("windows", Kind::Buffer),
        ("prediction", Kind::Storage(TextureFormat::Rg32Uint)),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct PredictViews<'a> {
    pub guide: &'a TextureView,
    pub models: &'a Buffer,
    pub windows: &'a Buffer,
    pub prediction: &'a TextureView,
}

/// The pass.
#[derive(Debug, Clone)]
pub struct Predict(Kernel);

impl Predict {
    /// Compiles the pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::new(compiler, &DESCRIPTOR))
    }

    /// Compiles the pass for the specular signal.
    pub fn specular<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::with(compiler, &DESCRIPTOR, SPECULAR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &PredictViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.guide),
            views.models.as_entire_binding(),
            views.windows.as_entire_binding(),
            BindingResource::TextureView(views.prediction),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
