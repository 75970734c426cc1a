//! The walkthrough demo of quell: scenes, a path tracer, captures, a window.

pub mod bench;
pub mod capture;
pub mod check;
pub mod cli;
pub mod compute;
pub mod contact_sheet;
pub mod correlation;
pub mod gbuffer;
pub mod gpu;
pub mod gpu_timer;
pub mod halton;
pub mod html;
pub mod image;
pub mod input_file;
pub mod method;
pub mod metrics;
pub mod peers;
pub mod plot;
pub mod quality;
pub mod record;
pub mod render;
pub mod replay;
pub mod report;
pub mod sampling;
pub mod scene;
pub mod settings_args;
#[cfg(test)]
mod shader_check;
pub mod split_args;
pub mod still;
pub mod study;
pub mod table;
pub mod tracer;
pub mod walk;
pub mod walkthrough;
pub mod window;
