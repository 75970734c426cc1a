//! The only place that spells wgpu descriptors: pipelines, bindings, uniforms, textures, shader includes.

mod failure;
mod kernel;
mod resources;
mod shader;
mod uniforms;

pub use failure::{catch, check_alive, uniform_buffer};
pub use kernel::{
    Binding, Compiler, Constants, DECODING, Kernel, KernelDescriptor, Kind, REFLECTIONS, Recorder, SPECULAR,
};
pub use resources::{buffer, image, words};
pub use shader::assemble;
pub use uniforms::{FrameUniforms, LevelUniforms, ViewUniforms, flags};
