//! What lists the centres of a level; dispatched within the pass [`fit`](super::fit). See `shaders/centres.wgsl`.

use crate::gpu::{KernelDescriptor, Kind};

/// What lists the centres of a level.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "centres",
    source: include_str!("../../shaders/centres.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("level", Kind::Uniform),
        ("coverage", Kind::Buffer),
        ("moments", Kind::Buffer),
        ("centre_list", Kind::BufferMut),
        ("levels", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};
