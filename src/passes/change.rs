//! Sums moments of what this frame's samples differ by from the history. See `shaders/change.wgsl`.

use crate::gpu::{Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::{BindingResource, Buffer, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "change",
    source: include_str!("../../shaders/change.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("signal", Kind::Texture),
        ("guide", Kind::TextureUint),
        ("reprojected", Kind::Texture),
        ("reprojected_noise", Kind::Texture),
        ("tile_means", Kind::BufferMut),
        ("tile_squares_low", Kind::BufferMut),
        ("tile_squares_high", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL. The tiles are regions.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct ChangeViews<'a> {
    pub signal: &'a TextureView,
    pub guide: &'a TextureView,
    pub reprojected: &'a TextureView,
    pub reprojected_noise: &'a TextureView,
    pub tile_means: &'a Buffer,
    pub tile_squares_low: &'a Buffer,
    pub tile_squares_high: &'a Buffer,
}

/// The pass.
#[derive(Debug)]
pub struct Change(Kernel);

impl Change {
    /// Compiles the pass.
    pub fn new(device: &wgpu::Device) -> Self {
        Self(Kernel::new(device, &DESCRIPTOR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &ChangeViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.signal),
            BindingResource::TextureView(views.guide),
            BindingResource::TextureView(views.reprojected),
            BindingResource::TextureView(views.reprojected_noise),
            views.tile_means.as_entire_binding(),
            views.tile_squares_low.as_entire_binding(),
            views.tile_squares_high.as_entire_binding(),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
