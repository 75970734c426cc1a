//! quell as one node of a small render graph: G-buffer, effect, quell, glow, tonemapping, for two views of one scene, in one
//! window that is resized; the right view has a resolution that changes in every frame.
//!
//! `cargo run -p quell-demo --example render_graph [-- --out DIR --frames N --size WxH]`
//!
//! `graph.rs` orders the nodes and knows how long textures live, `pool.rs` recycles them, `nodes.rs` are the nodes with quell's
//! among them, `profiler.rs` times its passes. The renderer is that of `integrate.rs`.

mod graph;
#[allow(dead_code, reason = "of the first example only its renderer is used")]
#[path = "../integrate.rs"]
mod integrate;
mod nodes;
mod pool;
mod profiler;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use integrate::{Frame, Renderer, psnr_db};
use nodes::{Post, SCREEN, Shot, View};
use pool::Pool;
use profiler::Profiler;
use quell::{Denoiser, DenoiserDescriptor};
use std::path::PathBuf;
use wgpu::util::DownloadBuffer;
use wgpu::{TextureUsages as Usages, TextureView};

#[derive(Parser)]
struct Args {
    #[arg(long, default_value = "out/render_graph")]
    out: PathBuf,
    #[arg(long, default_value = "32", value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Of the window, once it was resized.
    #[arg(long, default_value = "640x360", value_delimiter = 'x')]
    size: Vec<u32>,
}

fn main() -> Result<()> {
    let Args { out, frames, size } = Args::parse();
    let size: [u32; 2] =
        size.try_into().ok().context("`--size` takes a width and a height, as in 640x360")?;
    ensure!(size[0] >= 16 && size[1] >= 16, "`--size`: both views need some pixels");
    std::fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    let mut window = Window::new(size.map(|side| side * 3 / 4))?;
    for i in 0..frames {
        if i == frames / 2 {
            window.resize(size)?;
            println!("frame {i}: the window is resized to {}x{}", size[0], size[1]);
        }
        let profiler = Profiler::new(&window.renderer.device);
        window.draw(i, &Draw { samples: 1, denoise: true, profiler: Some(&profiler) })?;
        if i + 1 == frames {
            println!("quell's passes in the left view, as recorded on the CPU and run on the GPU:");
            for scope in profiler.read(&window.renderer.device, &window.renderer.queue)? {
                let run = scope.gpu_ms.map_or("no timestamps".into(), |ms| format!("{ms:.3} ms"));
                println!("  {}: {:.3} ms, {run}", scope.name, scope.recording.as_secs_f64() * 1e3);
            }
        }
    }
    let denoised = window.picture()?;
    // Without quell, and with so many samples that it is not needed. Its node is no longer recorded then.
    window.draw(frames - 1, &Draw { samples: 1, denoise: false, profiler: None })?;
    let noisy = window.picture()?;
    window.draw(frames - 1, &Draw { samples: 512, denoise: false, profiler: None })?;
    let reference = window.picture()?;
    for (name, picture) in [("denoised", &denoised), ("noisy", &noisy), ("reference", &reference)] {
        picture.save(out.join(name).with_extension("png"))?;
    }
    println!("noisy: {:.2} dB", psnr_db(&noisy, &reference));
    println!("denoised: {:.2} dB", psnr_db(&denoised, &reference));
    Ok(())
}

/// What may differ between frames.
struct Draw<'a> {
    samples: u32,
    denoise: bool,
    /// Of the left view's denoiser.
    profiler: Option<&'a Profiler>,
}

struct Window {
    renderer: Renderer,
    post: Post,
    pool: Pool<TextureView>,
    screen: TextureView,
    /// Left and right.
    views: [View; 2],
    /// What was last said of the graph.
    said: String,
}

impl Window {
    fn new(size: [u32; 2]) -> Result<Self> {
        let renderer = Renderer::new()?;
        let left = Denoiser::new(&renderer.device, &half(size))?;
        let right = Denoiser::with_pipelines(&renderer.device, &half(size), left.pipelines())?;
        Ok(Self {
            post: Post::new(&renderer.device),
            pool: Pool::default(),
            screen: screen(&renderer, size),
            views: [left, right].map(|denoiser| View { denoiser, denoised: None }),
            said: String::new(),
            renderer,
        })
    }

    /// The pool needs no word of it: nobody asks for textures of the old size any more.
    fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        for view in &mut self.views {
            view.denoiser.resize(&self.renderer.device, &half(size))?;
        }
        self.screen = screen(&self.renderer, size);
        Ok(())
    }

    fn draw(&mut self, index: u32, draw: &Draw<'_>) -> Result<()> {
        let Self { renderer, post, pool, screen, views, said } = self;
        let mut encoder = renderer.device.create_command_encoder(&Default::default());
        for (side, view) in views.iter_mut().enumerate() {
            let size = view.denoiser.size();
            // The right view looks from the other side, in 60 to 100 % of the resolution.
            let (frame, camera) = Frame::new(index + [0, 260][side], size);
            let scale = [1.0, 0.8 + 0.2 * (0.5 * index as f32).cos()][side];
            let frame = Frame {
                size: size.map(|pixels| ((pixels as f32 * scale) as u32).max(1)),
                time: index as f32,
                samples: draw.samples,
                ..frame
            };
            let [width, height] = size.map(|pixels| pixels as f32);
            let place = [side as f32 * (width + GAP as f32), 0.0, width, height];
            let profiler = draw.profiler.filter(|_| side == 0).map(|profiler| profiler as _);
            let shot = Shot { index, frame, camera, place, denoise: draw.denoise, profiler };
            let graph = view.graph(renderer, post, screen, &shot);
            let plan = graph.compile()?;
            let order = graph.order(&plan).join(" > ");
            let say = format!("{order}; culled: {:?}", graph.culled(&plan));
            graph.record(plan, size, pool, &renderer.device, &mut encoder)?;
            if *said != say {
                println!("frame {index}: {say}");
                *said = say;
            }
        }
        renderer.queue.submit([encoder.finish()]);
        let counts = pool.end_frame();
        if index == 0 || counts.created + counts.dropped > 0 {
            let pool::Counts { created, recycled, dropped, held } = counts;
            println!(
                "frame {index}: {created} textures created, {recycled} recycled, {dropped} dropped, {held} held"
            );
        }
        Ok(())
    }

    /// What is on the screen. Waits for the GPU.
    fn picture(&self) -> Result<image::RgbaImage> {
        let Renderer { device, queue, .. } = &self.renderer;
        let texture = self.screen.texture();
        let row = (4 * texture.width()).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row) * u64::from(texture.height()),
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let copy = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, texture.size());
        queue.submit([encoder.finish()]);
        let padded = image::RgbaImage::from_raw(row / 4, texture.height(), download(device, queue, &buffer)?);
        let padded = padded.context("the picture came in part")?;
        let mut picture =
            image::imageops::crop_imm(&padded, 0, 0, texture.width(), texture.height()).to_image();
        // Between the views nothing was drawn.
        picture.pixels_mut().for_each(|pixel| pixel.0[3] = 255);
        Ok(picture)
    }
}

/// Between the views, in pixels.
const GAP: u32 = 4;

/// One view's half of a window.
fn half([width, height]: [u32; 2]) -> DenoiserDescriptor {
    DenoiserDescriptor::new(width.saturating_sub(GAP) / 2, height)
}

fn screen(renderer: &Renderer, size: [u32; 2]) -> TextureView {
    renderer.image(size, SCREEN, Usages::RENDER_ATTACHMENT | Usages::COPY_SRC)
}

/// Waits for the GPU.
fn download(device: &wgpu::Device, queue: &wgpu::Queue, buffer: &wgpu::Buffer) -> Result<Vec<u8>> {
    let (sender, receiver) = std::sync::mpsc::channel();
    DownloadBuffer::read_buffer(device, queue, &buffer.slice(..), move |bytes| {
        let _ = sender.send(bytes);
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(receiver.recv()??.to_vec())
}
