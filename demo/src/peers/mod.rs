//! Other methods, to compare the denoiser with.

mod accumulate;

pub use accumulate::{Accumulate, AccumulateFrame};
