//! What another model would gain each tile of a level; dispatched within the pass [`fit`](super::fit) under a budget. See
//! `shaders/gains.wgsl`.

use crate::gpu::{KernelDescriptor, Kind};

/// What estimates gains.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "gains",
    source: include_str!("../../shaders/gains.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("level", Kind::Uniform),
        ("coverage", Kind::Buffer),
        ("moments", Kind::Buffer),
        ("models", Kind::BufferMut),
        ("kept", Kind::BufferMut),
        ("histogram", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};
