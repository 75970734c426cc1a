//! The library's test suite: one binary, on the CPU adapter where there is one.

mod edge_cases;
mod gpu;
mod layout;
mod quality;
mod sequence;
mod shaders;
mod twins;
