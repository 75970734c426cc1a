//! Frames of any size through a method.
#![allow(dead_code, reason = "each test binary uses its part")]

use crate::synthetic::{FAR, info};
use glam::camera::rh::proj::directx;
use glam::{Mat4, Vec2, Vec3};
use quell::Settings;
use quell_demo::capture::{Frame, FrameInfo, gbuffer_for, upload};
use quell_demo::gpu::Gpu;
use quell_demo::image::ImageRgb;
use quell_demo::method::{Method, MethodFrame, MethodRunner};

pub fn gpu() -> Gpu {
    Gpu::new().expect("tests need a Vulkan driver; Mesa's works without a GPU (mesa-vulkan-drivers)")
}

/// How a sequence is denoised.
pub struct Sequence<'a> {
    pub gpu: &'a Gpu,
    pub method: Method,
    /// Frames that are cuts.
    pub restarts: Vec<usize>,
    pub max_history: f32,
}

impl<'a> Sequence<'a> {
    pub fn of(gpu: &'a Gpu, method: Method) -> Self {
        Self { gpu, method, restarts: vec![0], max_history: 32.0 }
    }

    /// Every frame's output.
    pub fn run(&self, frames: &[Frame]) -> Vec<ImageRgb> {
        let Self { gpu, method, .. } = *self;
        let Frame { width, height, .. } = frames[0];
        let mut runner = MethodRunner::new(gpu, method, width, height).unwrap();
        let settings = Settings::default().with_far(FAR).with_max_history(self.max_history);
        let mut gbuffer = gbuffer_for(&gpu.device, &frames[0]);
        let output = |(i, frame): (usize, &Frame)| {
            upload(&gpu.device, &gpu.queue, frame, &mut gbuffer);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let restart = self.restarts.contains(&i);
            let inputs = MethodFrame::new(&gbuffer, view(frame).camera(), restart, &settings);
            let view = runner.encode(gpu, &mut encoder, &inputs).unwrap();
            gpu.queue.submit([encoder.finish()]);
            ImageRgb::read_back(gpu, view.texture()).unwrap()
        };
        frames.iter().enumerate().map(output).collect()
    }
}

/// A still camera that looks along -z.
fn view(frame: &Frame) -> FrameInfo {
    let aspect = frame.width as f32 / frame.height as f32;
    FrameInfo {
        view: Mat4::from_translation(Vec3::new(-3.0, 1.0, 0.5)),
        projection: directx::perspective(1.0, aspect, 0.1, FAR),
        jitter_px: Vec2::ZERO,
        ..info()
    }
}

/// World-space position of what a pixel shows.
pub fn position(frame: &Frame, i: usize) -> [f32; 3] {
    let FrameInfo { view, projection, .. } = view(frame);
    let (x, y) = ((i as u32 % frame.width) as f32 + 0.5, (i as u32 / frame.width) as f32 + 0.5);
    let ndc = Vec2::new(x / frame.width as f32 * 2.0 - 1.0, 1.0 - y / frame.height as f32 * 2.0);
    let depth = frame.depth[i];
    let in_view = Vec3::new(ndc.x / projection.x_axis.x, ndc.y / projection.y_axis.y, -1.0) * depth;
    view.inverse().transform_point3(in_view).to_array()
}

/// A still grey wall that faces the camera, black and with one sample a pixel.
pub fn wall(width: u32, height: u32) -> Frame {
    let mut frame = Frame::new(width, height);
    let pixels = (width * height) as usize;
    frame.albedo = vec![[0.5; 3]; pixels];
    frame.normal = vec![[0.0, 0.0, 1.0]; pixels];
    frame.depth = vec![4.0; pixels];
    frame.motion_depth = Some(vec![0.0; pixels]);
    frame.surface_id = Some(vec![7; pixels]);
    frame.emission = Some(vec![[0.0; 3]; pixels]);
    frame.samples = Some(vec![1; pixels]);
    frame
}

/// Root of the mean squared difference from `truth`.
pub fn rms(image: &ImageRgb, truth: impl Fn(usize) -> [f32; 3]) -> f32 {
    let square = |(i, rgb): (usize, &[f32; 3])| {
        let truth = truth(i);
        (0..3).map(|c| (rgb[c] - truth[c]).powi(2)).sum::<f32>()
    };
    let sum: f32 = image.pixels.iter().enumerate().map(square).sum();
    (sum / (3 * image.pixels.len()) as f32).sqrt()
}
