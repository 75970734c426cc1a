//! What spends the budget of models on a level; dispatched within the pass [`fit`](super::fit) under a budget. See
//! `shaders/choose.wgsl`.

use crate::gpu::{KernelDescriptor, Kind};

/// What lists the centres that gain most and keeps models elsewhere.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "choose",
    source: include_str!("../../shaders/choose.wgsl"),
    bindings: &[
        ("frame", Kind::Frame),
        ("level", Kind::Uniform),
        ("kept", Kind::Buffer),
        ("histogram", Kind::Buffer),
        ("centre_list", Kind::BufferMut),
        ("levels", Kind::BufferMut),
        ("windows", Kind::BufferMut),
        ("coverage", Kind::BufferMut),
    ],
    workgroup: [8, 8],
    covers: [8, 8],
};
