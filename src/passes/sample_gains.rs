//! What counts the gains; dispatched within the pass [`sample_map`](super::sample_map). See `shaders/sample_gains.wgsl`.

use crate::gpu::{KernelDescriptor, Kind};

/// What counts the gains.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "sample_gains",
    source: include_str!("../../shaders/sample_gains.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("guide", Kind::TextureUint),
        ("motion", Kind::Texture),
        ("history", Kind::Texture),
        ("error", Kind::TextureUint),
        ("sample_histogram", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};
