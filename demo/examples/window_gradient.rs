//! The window with a source that needs no tracer: a gradient that moves. For work on the window alone.
//!
//! `cargo run -p quell-demo --example window_gradient [frames]`

use glam::Vec3;
use glam::camera::rh::view::look_at_mat4;
use quell_demo::gpu::Gpu;
use quell_demo::gpu_timer::GpuTimer;
use quell_demo::image::{half_from_f32, write_texture};
use quell_demo::window::{
    FrameImages, FrameRequest, FrameSource, ViewMode, ViewState, WindowError, WindowOptions, run,
};

const SIZE: [u32; 2] = [192, 108];

struct Gradient {
    noisy: wgpu::TextureView,
    clean: wgpu::TextureView,
    time_s: f32,
    seed: u32,
}

impl Gradient {
    fn write(&mut self, gpu: &Gpu, view: &wgpu::TextureView, noise: f32) {
        let mut texels = Vec::new();
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                self.seed = self.seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                let random = (self.seed >> 8) as f32 / (1 << 24) as f32;
                let factor = 1.0 + noise * (2.0 * random - 1.0);
                let (u, v) = (x as f32 / SIZE[0] as f32, y as f32 / SIZE[1] as f32);
                let wave = 0.5 + 0.5 * (12.0 * u + 3.0 * self.time_s).sin();
                texels.push([u * 2.0 * factor, wave * factor, v * factor, 1.0].map(half_from_f32));
            }
        }
        write_texture(&gpu.queue, view.texture(), &texels);
    }
}

impl FrameSource for Gradient {
    fn frame(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &FrameRequest<'_>,
        timer: &mut GpuTimer,
    ) -> anyhow::Result<FrameImages> {
        self.time_s += request.time_step_s;
        let (noisy, clean) = (self.noisy.clone(), self.clean.clone());
        self.write(gpu, &noisy, 1.0);
        self.write(gpu, &clean, 0.0);
        // An empty pass, so that the panel has a time to show.
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("nothing"),
            timestamp_writes: timer.reserve_pass("nothing"),
        });
        Ok(FrameImages {
            noisy: Some(noisy),
            rival: None,
            denoised: clean,
            reference: None,
            debug: None,
            view_from_world: request
                .free_view
                .unwrap_or_else(|| look_at_mat4(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, Vec3::Y)),
            status: format!("time {:.2} s, area {:?}", self.time_s, request.area),
        })
    }
}

fn main() -> anyhow::Result<()> {
    let max_frames = std::env::args().nth(1).map(|frames| frames.parse()).transpose()?;
    let view = ViewState { mode: ViewMode::Split, ..ViewState::default() };
    let options = WindowOptions { max_frames, view, ..WindowOptions::default() };
    let source = |gpu: &Gpu| {
        let image = || {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("gradient"),
                size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba16Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        Ok(Gradient { noisy: image(), clean: image(), time_s: 0.0, seed: 1 })
    };
    match run(options, source) {
        Err(error @ WindowError::NoDisplay(_)) => println!("{error}"),
        result => result?,
    }
    Ok(())
}
