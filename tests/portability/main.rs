//! The library elsewhere: its shaders in a browser, and its results on another driver.

mod drivers;
#[allow(dead_code, reason = "the suite uses more of it")]
#[path = "../suite/gpu.rs"]
mod gpu;
#[allow(dead_code, reason = "the suite uses more of it")]
#[path = "../suite/mirror.rs"]
mod mirror;
#[allow(dead_code, reason = "the suite uses more of it")]
#[path = "../suite/sequence.rs"]
mod sequence;
mod shaders;
mod tint;
mod walks;
