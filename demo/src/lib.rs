//! The walkthrough demo of quell: scenes, a path tracer, captures, a window.

pub mod gbuffer;
pub mod gpu;
pub mod scene;
pub mod tracer;
