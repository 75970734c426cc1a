//! Sums the moments of each tile. See `shaders/moments.wgsl`.

use crate::gpu::{Kernel, KernelDescriptor, Kind, Recorder};
use wgpu::{BindingResource, Buffer, TextureView};

/// What the pass is made of.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "moments",
    source: include_str!("../../shaders/moments.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("guide", Kind::TextureUint),
        ("history", Kind::Texture),
        ("noise", Kind::Texture),
        ("tile_means", Kind::BufferMut),
        ("tile_squares_low", Kind::BufferMut),
        ("tile_squares_high", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};

/// What the pass reads and writes; named as in the WGSL.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "documented once, at the head of the WGSL")]
pub struct MomentsViews<'a> {
    pub guide: &'a TextureView,
    pub history: &'a TextureView,
    pub noise: &'a TextureView,
    pub tile_means: &'a Buffer,
    pub tile_squares_low: &'a Buffer,
    pub tile_squares_high: &'a Buffer,
}

/// The pass.
#[derive(Debug)]
pub struct Moments(Kernel);

impl Moments {
    /// Compiles the pass.
    pub fn new(device: &wgpu::Device) -> Self {
        Self(Kernel::new(device, &DESCRIPTOR))
    }

    /// Records the pass over `extent` pixels.
    pub fn record(&self, recorder: &mut Recorder<'_>, views: &MomentsViews<'_>, extent: [u32; 2]) {
        let resources = [
            BindingResource::TextureView(views.guide),
            BindingResource::TextureView(views.history),
            BindingResource::TextureView(views.noise),
            views.tile_means.as_entire_binding(),
            views.tile_squares_low.as_entire_binding(),
            views.tile_squares_high.as_entire_binding(),
        ];
        self.0.record(recorder, &resources, extent);
    }
}
