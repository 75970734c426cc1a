//! The library's test suite: one binary, on the CPU adapter where there is one.

mod api;
mod bevy;
mod budget;
mod check;
mod conventions;
mod edge_cases;
mod gpu;
mod layout;
mod light;
mod mirror;
mod quality;
mod sample_map;
mod sequence;
mod shaders;
mod split;
mod statistics;
mod twins;
mod viewport;
