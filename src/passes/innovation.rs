//! Predicts the change of the light. See `shaders/innovation.wgsl`.

use crate::gpu::{Compiler, Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::Buffer;

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "innovation",
    source: include_str!("../../shaders/innovation.wgsl"),
    bindings: &[("frame", Kind::Frame), ("moments", Kind::Buffer), ("innovations", Kind::BufferMut)],
    workgroup: [32, 1],
    covers: [1, 1],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct InnovationViews<'a> {
    pub moments: &'a Buffer,
    pub innovations: &'a Buffer,
}

/// The pass.
#[derive(Debug, Clone)]
pub struct Innovation(Kernel);

impl Innovation {
    /// Compiles the pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>) -> Self {
        Self(Kernel::new(compiler, &DESCRIPTOR))
    }

    /// Records the pass over `extent` centres.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &InnovationViews<'_>, extent: [u32; 2]) {
        let resources = [views.moments.as_entire_binding(), views.innovations.as_entire_binding()];
        self.0.record(recorder, &resources, extent);
    }
}
