//! The library's test suite: one binary, on the CPU adapter where there is one.

mod gpu;
mod layout;
mod shaders;
