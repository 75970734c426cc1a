//! Shares out the samples of the next frame. See `shaders/sample_gains.wgsl`, `shaders/sample_rate.wgsl` and
//! `shaders/sample_map.wgsl`.

use super::{sample_gains, sample_rate};
use crate::gpu::{Compiler, Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::{BindingResource, Buffer, TextureFormat, TextureView};

/// What shares out the samples.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "sample_map",
    source: include_str!("../../shaders/sample_map.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("guide", Kind::TextureUint),
        ("motion", Kind::Texture),
        ("history", Kind::Texture),
        ("error", Kind::TextureUint),
        ("sample_histogram", Kind::Buffer),
        ("samples", Kind::Storage(TextureFormat::R32Uint)),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL. `sample_histogram` is 0 before it.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct SampleMapViews<'a> {
    pub guide: &'a TextureView,
    pub motion: &'a TextureView,
    pub history: &'a TextureView,
    pub error: &'a TextureView,
    pub sample_histogram: &'a Buffer,
    pub samples: &'a TextureView,
}

/// The pass: counts gains, finds what they are worth, writes the map.
#[derive(Debug)]
pub struct SampleMap {
    count: Kernel,
    rate: Kernel,
    share: Kernel,
}

impl SampleMap {
    /// Compiles the pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        let compiler = compiler.into();
        Self {
            count: Kernel::new(compiler, &sample_gains::DESCRIPTOR),
            rate: Kernel::new(compiler, &sample_rate::DESCRIPTOR),
            share: Kernel::new(compiler, &DESCRIPTOR),
        }
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &SampleMapViews<'_>, extent: [u32; 2]) {
        let SampleMapViews { guide, motion, history, error, samples, .. } = *views;
        let [guide, motion, history, error, samples] =
            [guide, motion, history, error, samples].map(BindingResource::TextureView);
        let histogram = views.sample_histogram.as_entire_binding();
        let mut resources = vec![guide, motion, history, error, histogram.clone()];
        let count = self.count.bind(recorder, &resources);
        let rate = self.rate.bind(recorder, &[histogram]);
        resources.push(samples);
        let share = self.share.bind(recorder, &resources);
        recorder.pass(DESCRIPTOR.name, |pass| {
            self.count.dispatch(pass, &count, extent);
            self.rate.dispatch(pass, &rate, [1, 1]);
            self.share.dispatch(pass, &share, extent);
        });
    }
}
