//! What finds the rate; dispatched within the pass [`sample_map`](super::sample_map). See `shaders/sample_rate.wgsl`.

use crate::gpu::{KernelDescriptor, Kind};

/// What finds the rate.
pub const DESCRIPTOR: KernelDescriptor = KernelDescriptor {
    name: "sample_rate",
    source: include_str!("../../shaders/sample_rate.wgsl"),
    bindings: &[("frame", Kind::Frame), ("sample_histogram", Kind::BufferMut)],
    workgroup: [64, 1],
    covers: [1, 1],
};
