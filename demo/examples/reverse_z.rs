//! An engine whose images mean something else than quell's own: reverse-Z depth buffer without a far plane, motion in pixels that
//! comes from the previous frame and has the jitter in it, octahedral normals in view space, roughness apart; no surface ids.
//!
//! `cargo run -p quell-demo --example reverse_z [-- --out DIR --frames N --size WxH] [--mistake WHICH]`
//!
//! It proves that [`conventions`] say so: the same frames in quell's own conventions must come out the same. `--mistake` leaves
//! one of them at its default, to show what that looks like; it then fails.

#[allow(dead_code, reason = "of the first example only its renderer is used")]
#[path = "integrate.rs"]
mod integrate;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use glam::camera::rh::proj::directx::perspective_infinite_reverse;
use glam::{Mat4, Vec2};
use integrate::{Frame, Images, Renderer, psnr_db};
use quell::{
    Camera, Conventions, Denoiser, DenoiserDescriptor, DepthEncoding, FrameInputs, MotionDirection,
    MotionUnit, NormalEncoding, NormalSpace, RequiredInputs, Settings,
};
use std::path::PathBuf;
use wgpu::{
    Color, LoadOp, Operations, StoreOp, TextureFormat as Format, TextureUsages as Usages, TextureView,
};

/// How alike both outputs must be, as shown in 8 bits. They are 72 to 74 dB: numbers are rounded otherwise. The least of the
/// mistakes makes 65 of it.
const ALIKE_DB: f64 = 68.0;

#[derive(Parser)]
struct Args {
    #[arg(long, default_value = "out/reverse_z")]
    out: PathBuf,
    #[arg(long, default_value = "32", value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    #[arg(long, default_value = "640x360", value_delimiter = 'x')]
    size: Vec<u32>,
    /// What to tell quell wrong.
    #[arg(long)]
    mistake: Option<Mistake>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Mistake {
    Depth,
    MotionUnit,
    MotionDirection,
    MotionJitter,
    NormalEncoding,
    NormalSpace,
}

fn main() -> Result<()> {
    let Args { out, frames, size, mistake } = Args::parse();
    let size: [u32; 2] =
        size.try_into().ok().context("`--size` takes a width and a height, as in 640x360")?;
    std::fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    let renderer = Renderer::new()?;
    let Renderer { device, queue, .. } = &renderer;
    let descriptor = DenoiserDescriptor::new(size[0], size[1]);
    let mut own_denoiser = Denoiser::new(device, &descriptor)?;
    let mut denoiser = Denoiser::with_pipelines(device, &descriptor, own_denoiser.pipelines())?;
    let own_images = Images::new(&renderer, size);
    let engine = Engine::new(&renderer, size);
    let settings = Settings::default().with_conventions(conventions(mistake));

    for i in 0..frames {
        let [own, other] = views(i, size);
        let mut encoder = device.create_command_encoder(&Default::default());
        renderer.draw(&mut encoder, &own.frame, own_images.gbuffer(), &own_images.depth_buffer);
        renderer.trace(&mut encoder, &own.frame, &own_images.gbuffer()[..3], &own_images.noisy);
        engine.draw(&renderer, &mut encoder, &other.frame);

        let own_inputs = RequiredInputs {
            radiance: &own_images.noisy,
            albedo: &own_images.albedo,
            normal_roughness: &own_images.normal_roughness,
            depth: &own_images.depth,
            motion: &own_images.motion,
            output: &own_images.denoised,
            camera: own.camera,
        };
        let inputs = RequiredInputs {
            normal_roughness: &engine.normal,
            depth: &engine.depth_buffer,
            motion: &engine.motion,
            output: &engine.denoised,
            camera: other.camera,
            ..own_inputs
        };
        let own_inputs = FrameInputs::new(own_inputs);
        own_denoiser.encode(device, queue, &mut encoder, &own_inputs, &Settings::default())?;
        let inputs = FrameInputs::new(inputs).with_roughness(&engine.roughness);
        denoiser.encode(device, queue, &mut encoder, &inputs, &settings)?;
        queue.submit([encoder.finish()]);
    }

    let [view, _] = views(frames - 1, size);
    let own = renderer.picture(&view.frame, &own_images.denoised)?;
    let other = renderer.picture(&view.frame, &engine.denoised)?;
    let noisy = renderer.picture(&view.frame, &own_images.noisy)?;
    for (name, picture) in [("own_conventions", &own), ("denoised", &other), ("noisy", &noisy)] {
        picture.save(out.join(name).with_extension("png"))?;
    }
    let alike_db = psnr_db(&other, &own);
    println!("noisy, against quell's own conventions: {:.2} dB", psnr_db(&noisy, &own));
    println!("this engine's, against quell's own conventions: {alike_db:.2} dB");
    ensure!(
        alike_db > ALIKE_DB,
        "{alike_db:.2} dB, expected more than {ALIKE_DB}: a convention is told wrong"
    );
    Ok(())
}

/// All that quell must be told of this engine. Reverse-Z it sees from the camera's projection.
fn conventions(mistake: Option<Mistake>) -> Conventions {
    let right = Conventions::default()
        .with_depth(DepthEncoding::Hardware)
        .with_motion_unit(MotionUnit::Pixels)
        .with_motion_direction(MotionDirection::FromPrevious)
        .with_motion_is_jittered(true)
        .with_normal_encoding(NormalEncoding::Octahedral)
        .with_normal_space(NormalSpace::View);
    match mistake {
        None => right,
        Some(Mistake::Depth) => right.with_depth(DepthEncoding::Linear),
        Some(Mistake::MotionUnit) => right.with_motion_unit(MotionUnit::Uv),
        Some(Mistake::MotionDirection) => right.with_motion_direction(MotionDirection::ToPrevious),
        Some(Mistake::MotionJitter) => right.with_motion_is_jittered(false),
        Some(Mistake::NormalEncoding) => right.with_normal_encoding(NormalEncoding::Signed),
        Some(Mistake::NormalSpace) => right.with_normal_space(NormalSpace::World),
    }
}

/// What a frame is drawn with, and the camera that quell gets for it.
struct View {
    frame: Frame,
    camera: Camera,
}

/// Frame `i` with jitter: for quell's own conventions, and for this engine.
fn views(i: u32, size: [u32; 2]) -> [View; 2] {
    let previous = i.saturating_sub(1);
    let [(frame, camera), (_, prev_camera)] = [i, previous].map(|i| Frame::new(i, size));
    let [jitter_px, prev_jitter_px] = [i, previous].map(jitter_px);
    let [view, prev_view] = [camera, prev_camera].map(|camera| camera.view_from_world);

    // The same jitter in both matrices leaves none in their difference.
    let own_clip_from_view = jittered(camera.clip_from_view, jitter_px, size);
    let own = Frame {
        clip_from_world: own_clip_from_view * view,
        prev_clip_from_world: own_clip_from_view * prev_view,
        world_from_clip: (own_clip_from_view * view).inverse(),
        ..frame
    };
    let clip_from_view = perspective_infinite_reverse(0.7, size[0] as f32 / size[1] as f32, 0.1);
    let other = Frame {
        clip_from_world: jittered(clip_from_view, jitter_px, size) * view,
        prev_clip_from_world: jittered(clip_from_view, prev_jitter_px, size) * prev_view,
        ..frame
    };
    // quell gets the matrices without the jitter.
    let camera = camera.with_jitter(jitter_px);
    [View { frame: own, camera }, View { frame: other, camera: Camera { clip_from_view, ..camera } }]
}

/// Where samples lie relative to pixel centres; +x right, +y down. Roberts' sequence, which is even over any number of frames.
fn jitter_px(i: u32) -> Vec2 {
    (Vec2::new(0.754_877_7, 0.569_840_3) * i as f32).fract() - 0.5
}

/// Samples that lie further right show what is further right, so the image moves left.
fn jittered(clip_from_view: Mat4, jitter_px: Vec2, size: [u32; 2]) -> Mat4 {
    let ndc = Vec2::new(-2.0, 2.0) * jitter_px / Vec2::new(size[0] as f32, size[1] as f32);
    Mat4::from_translation(ndc.extend(0.0)) * clip_from_view
}

/// The part of the engine that differs: another G-buffer.
struct Engine {
    pipeline: wgpu::RenderPipeline,
    /// `Rg16Float`, octahedral, in view space.
    normal: TextureView,
    /// `R8Unorm`.
    roughness: TextureView,
    /// `Rg16Float`, in pixels, from where the surface was.
    motion: TextureView,
    /// `Depth32Float`, 1 at the near plane and 0 at infinity.
    depth_buffer: TextureView,
    denoised: TextureView,
}

const TARGETS: [Format; 3] = [Format::Rg16Float, Format::R8Unorm, Format::Rg16Float];

impl Engine {
    fn new(renderer: &Renderer, size: [u32; 2]) -> Self {
        let device = &renderer.device;
        let shader = concat!(include_str!("boxes.wgsl"), include_str!("reverse_z.wgsl"));
        let module = &device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("reverse_z"),
            source: wgpu::ShaderSource::Wgsl(shader.into()),
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("other_gbuffer"),
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
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("other_gbuffer"),
                compilation_options: Default::default(),
                targets: &TARGETS.map(|format| Some(format.into())),
            }),
            multiview_mask: None,
            cache: None,
        });
        let target = |format| renderer.image(size, format, Usages::RENDER_ATTACHMENT);
        let [normal, roughness, motion] = TARGETS.map(target);
        let denoised = renderer.image(size, Format::Rgba16Float, Usages::STORAGE_BINDING);
        let depth_buffer = target(Format::Depth32Float);
        Self { pipeline, normal, roughness, motion, depth_buffer, denoised }
    }

    fn draw(&self, renderer: &Renderer, encoder: &mut wgpu::CommandEncoder, frame: &Frame) {
        let target = |view| {
            let ops = Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        // Infinity is 0, which quell takes for a miss.
        let depth_ops = Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("other_gbuffer"),
            color_attachments: &[&self.normal, &self.roughness, &self.motion].map(target),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_buffer,
                depth_ops: Some(depth_ops),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        let bindings = renderer.bind(self.pipeline.get_bind_group_layout(0), frame, &[]);
        pass.set_bind_group(0, &bindings, &[]);
        pass.draw(0..36, 0..6);
    }
}
