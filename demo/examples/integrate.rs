//! The smallest integration of quell: a raster G-buffer, one noisy ray-traced effect, quell, tonemapping. Needs no window.
//!
//! `cargo run -p quell-demo --example integrate [-- --out DIR --frames N --size WxH]`; wgpu's `WGPU_ADAPTER_NAME` picks the GPU.
//!
//! [`Denoiser::new`] in `main` and [`denoise`] are all of quell. The rest is a renderer, whose shaders are in `boxes.wgsl`.

use anyhow::{Context, Result};
use clap::Parser;
use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Quat, Vec3};
use image::RgbaImage;
use quell::{Camera, Denoiser, DenoiserDescriptor, FrameInputs, RequiredInputs, Settings};
use std::path::PathBuf;
use wgpu::util::{BufferInitDescriptor, DeviceExt, DownloadBuffer, initialize_adapter_from_env_or_default};
use wgpu::{
    BindingResource as Resource, BufferUsages, Color, CommandEncoder as Encoder, ComputePipeline, LoadOp,
    Operations, RenderPassColorAttachment, StoreOp, TextureFormat as Format, TextureUsages as Usages,
    TextureView as View,
};

#[derive(Parser)]
struct Args {
    #[arg(long, default_value = "out/integrate")]
    out: PathBuf,
    #[arg(long, default_value = "32", value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    #[arg(long, default_value = "640x360", value_delimiter = 'x')]
    size: Vec<u32>,
}

fn main() -> Result<()> {
    let Args { out, frames, size } = Args::parse();
    let size: [u32; 2] =
        size.try_into().ok().context("`--size` takes a width and a height, as in 640x360")?;
    std::fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    let renderer = Renderer::new()?;
    let mut denoiser = Denoiser::new(&renderer.device, &DenoiserDescriptor::new(size[0], size[1]))?;
    let images = Images::new(&renderer, size);
    for i in 0..frames {
        let (frame, camera) = Frame::new(i, size);
        let mut encoder = renderer.device.create_command_encoder(&Default::default());
        renderer.draw(&mut encoder, &frame, images.gbuffer(), &images.depth_buffer);
        renderer.trace(&mut encoder, &frame, &images.gbuffer()[..3], &images.noisy);
        denoise(&renderer, &mut encoder, &mut denoiser, &images, camera)?;
        renderer.queue.submit([encoder.finish()]);
    }

    // The last frame again with many samples, to see what it was good for.
    let reference = renderer.image(size, Format::Rgba16Float, Usages::STORAGE_BINDING);
    let frame = Frame { samples: 512, ..Frame::new(frames - 1, size).0 };
    let mut encoder = renderer.device.create_command_encoder(&Default::default());
    renderer.trace(&mut encoder, &frame, &images.gbuffer()[..3], &reference);
    renderer.queue.submit([encoder.finish()]);
    let reference = renderer.picture(&frame, &reference)?;
    reference.save(out.join("reference.png"))?;
    for (name, radiance) in [("noisy", &images.noisy), ("denoised", &images.denoised)] {
        let picture = renderer.picture(&frame, radiance)?;
        picture.save(out.join(name).with_extension("png"))?;
        println!("{name}: {:.2} dB", psnr_db(&picture, &reference));
    }
    Ok(())
}

/// What quell needs per frame: after the pass that writes `noisy`, before the one that shows `denoised`.
fn denoise(
    renderer: &Renderer,
    encoder: &mut Encoder,
    denoiser: &mut Denoiser,
    images: &Images,
    camera: Camera,
) -> Result<()> {
    let inputs = FrameInputs::new(RequiredInputs {
        radiance: &images.noisy,
        albedo: &images.albedo,
        normal_roughness: &images.normal_roughness,
        depth: &images.depth,
        motion: &images.motion,
        output: &images.denoised,
        camera,
    });
    denoiser.encode(&renderer.device, &renderer.queue, encoder, &inputs, &Settings::default())?;
    Ok(())
}

pub struct Images {
    /// Linear reflectance; 1 where nothing is.
    pub albedo: View,
    /// World-space normal, and roughness in w.
    pub normal_roughness: View,
    /// Linear view depth; 0 where nothing is.
    pub depth: View,
    /// Where the surface was in the previous frame minus where it is, in UV.
    pub motion: View,
    pub depth_buffer: View,
    /// Scene-linear radiance of one sample a pixel.
    pub noisy: View,
    pub denoised: View,
}

pub const GBUFFER: [Format; 4] =
    [Format::Rgba8Unorm, Format::Rgba16Float, Format::R32Float, Format::Rg16Float];

impl Images {
    pub fn new(renderer: &Renderer, size: [u32; 2]) -> Self {
        let target = |format| renderer.image(size, format, Usages::RENDER_ATTACHMENT);
        let stored = || renderer.image(size, Format::Rgba16Float, Usages::STORAGE_BINDING);
        let [albedo, normal_roughness, depth, motion] = GBUFFER.map(target);
        let depth_buffer = target(Format::Depth32Float);
        Self { albedo, normal_roughness, depth, motion, depth_buffer, noisy: stored(), denoised: stored() }
    }

    pub fn gbuffer(&self) -> [&View; 4] {
        [&self.albedo, &self.normal_roughness, &self.depth, &self.motion]
    }
}

/// `Frame` of the shader.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Frame {
    pub view_from_world: Mat4,
    pub clip_from_world: Mat4,
    pub prev_clip_from_world: Mat4,
    pub world_from_clip: Mat4,
    pub eye: Vec3,
    pub seed: u32,
    pub size: [u32; 2],
    pub time: f32,
    pub samples: u32,
}

impl Frame {
    /// The camera goes round the boxes.
    pub fn new(i: u32, size: [u32; 2]) -> (Self, Camera) {
        let clip_from_view = perspective(0.7, size[0] as f32 / size[1] as f32, 0.1, 100.0);
        let eye = |i: u32| Quat::from_rotation_y(0.3 + 0.012 * i as f32) * Vec3::new(0.0, 2.2, 5.4);
        let view = |i: u32| look_at_mat4(eye(i), 0.75 * Vec3::Y, Vec3::Y);
        let clip_from_world = clip_from_view * view(i);
        let frame = Self {
            view_from_world: view(i),
            clip_from_world,
            prev_clip_from_world: clip_from_view * view(i.saturating_sub(1)),
            world_from_clip: clip_from_world.inverse(),
            eye: eye(i),
            seed: i,
            size,
            time: i as f32,
            samples: 1,
        };
        (frame, Camera::new(view(i), clip_from_view))
    }
}

pub struct Renderer {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    gbuffer: wgpu::RenderPipeline,
    trace: ComputePipeline,
    tonemap: ComputePipeline,
}

impl Renderer {
    pub fn new() -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(initialize_adapter_from_env_or_default(&instance, None))
            .context("no adapter; without a GPU, Mesa's llvmpipe is one")?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_features: adapter.features() & quell::OPTIONAL_FEATURES,
            ..Default::default()
        }))?;
        let module = &device.create_shader_module(wgpu::include_wgsl!("boxes.wgsl"));
        let compute = |name| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let [trace, tonemap] = ["trace", "tonemap"].map(compute);
        let gbuffer = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("gbuffer"),
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("cube"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: Format::Depth32Float,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("gbuffer"),
                compilation_options: Default::default(),
                targets: &GBUFFER.map(|format| Some(format.into())),
            }),
            multiview_mask: None,
            cache: None,
        });
        Ok(Self { device, queue, gbuffer, trace, tonemap })
    }

    pub fn image(&self, [width, height]: [u32; 2], format: Format, usage: Usages) -> View {
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | Usages::TEXTURE_BINDING,
            view_formats: &[],
        });
        texture.create_view(&Default::default())
    }

    pub fn draw(&self, encoder: &mut Encoder, frame: &Frame, gbuffer: [&View; 4], depth: &View) {
        let target = |view, clear| {
            let ops = Operations { load: LoadOp::Clear(clear), store: StoreOp::Store };
            Some(RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        let clear = [Color::WHITE, Color::TRANSPARENT, Color::TRANSPARENT, Color::TRANSPARENT];
        let depth_ops = Operations { load: LoadOp::Clear(1.0), store: StoreOp::Discard };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("gbuffer"),
            color_attachments: &[0, 1, 2, 3].map(|i| target(gbuffer[i], clear[i])),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(depth_ops),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_viewport(0.0, 0.0, frame.size[0] as f32, frame.size[1] as f32, 0.0, 1.0);
        pass.set_pipeline(&self.gbuffer);
        pass.set_bind_group(0, &self.bind(self.gbuffer.get_bind_group_layout(0), frame, &[]), &[]);
        pass.draw(0..36, 0..6);
    }

    /// From albedo, normals and depth.
    pub fn trace(&self, encoder: &mut Encoder, frame: &Frame, surface: &[&View], radiance: &View) {
        let views = surface.iter().chain([&radiance]).map(|view| Resource::TextureView(view));
        self.compute(encoder, &self.trace, frame, &views.collect::<Vec<_>>());
    }

    fn compute(&self, encoder: &mut Encoder, pipeline: &ComputePipeline, frame: &Frame, rest: &[Resource]) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.bind(pipeline.get_bind_group_layout(0), frame, rest), &[]);
        pass.dispatch_workgroups(frame.size[0].div_ceil(8), frame.size[1].div_ceil(8), 1);
    }

    pub fn bind(&self, layout: wgpu::BindGroupLayout, frame: &Frame, rest: &[Resource]) -> wgpu::BindGroup {
        let (contents, usage) = (bytemuck::bytes_of(frame), BufferUsages::UNIFORM);
        let frame = self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage });
        let resources = [frame.as_entire_binding()].into_iter().chain(rest.iter().cloned());
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
        self.device.create_bind_group(&descriptor)
    }

    /// Tonemapped radiance. Waits for the GPU.
    pub fn picture(&self, frame: &Frame, radiance: &View) -> Result<RgbaImage> {
        let [width, height] = frame.size;
        let texels = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * u64::from(width) * u64::from(height),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let rest = [Resource::TextureView(radiance), texels.as_entire_binding()];
        self.compute(&mut encoder, &self.tonemap, frame, &rest);
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        DownloadBuffer::read_buffer(&self.device, &self.queue, &texels.slice(..), move |bytes| {
            let _ = sender.send(bytes);
        });
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        RgbaImage::from_raw(width, height, receiver.recv()??.to_vec()).context("the picture came in part")
    }
}

/// Over what is shown; a quarter of it is alpha, which is equal.
pub fn psnr_db(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let sum: f64 = a.iter().zip(b.iter()).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
    10.0 * (255.0 * 255.0 * 0.75 * a.len() as f64 / sum).log10()
}
