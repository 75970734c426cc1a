//! A path tracer in compute shaders: what the denoiser is fed with, and the converged truth it is measured by.
//!
//! A frame is four passes: `visibility` finds what each pixel sees and how it moved, `surface` writes how that
//! looks, `plan` lists the pixels that get samples, `trace` follows paths from there. A G-buffer with split images also gets
//! `lobes`, and `trace_split` in the place of `trace`: the same paths, split by the lobe of the first hit. All samples of a pixel
//! share one primary hit at the pixel's centre (plus the camera's jitter), in frames and references alike, so that a reference is
//! what a frame converges to.

mod frame_data;
mod geometry;
mod images;
mod passes;
mod reference;
pub mod shaders;

pub use reference::ReferenceImage;

use crate::gbuffer::GBuffer;
use crate::gpu::Gpu;
use crate::scene::{CameraPose, Scene};
use anyhow::{Result, ensure};
use frame_data::FrameSource;
use geometry::Geometry;
use glam::{Vec2, Vec4};
use images::ImageArray;
use passes::{Passes, Target};
use std::sync::Mutex;
use wgpu::util::DeviceExt;

/// How light is found. All converge to the same image, but for lights without extent, which only sampling finds,
/// and the sky, which only the BSDF finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Strategy {
    /// Both ways, weighted by the power heuristic.
    #[default]
    Mis,
    /// Emitters and the sun by sampling them.
    LightsOnly,
    /// Emitters and the sun where the BSDF's samples hit them.
    BsdfOnly,
}

/// Which pixels get the samples. Those that get none cost nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// All pixels alike; fewer than one sample a pixel are spread evenly over neighbours and frames
    #[default]
    Uniform,
    /// Every other pixel in turn, twice as many
    Checkerboard,
    /// Where the denoiser expects them to help most
    // Takes `GBuffer::sample_map` as it is, whatever `TraceSettings::spp` says.
    Adaptive,
}

impl Sampling {
    /// As on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::Checkerboard => "checkerboard",
            Self::Adaptive => "adaptive",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceSettings {
    /// Samples per pixel, in the mean; above 0. The sky gets one at least.
    pub spp: f32,
    pub sampling: Sampling,
    /// Another seed is another, independent run.
    pub seed: u32,
    /// Index of the frame; each has its own random numbers.
    pub frame: u32,
    /// Reflections on a path; 0 shows emission only. More is slower and brighter in corners.
    pub max_bounces: u32,
    pub strategy: Strategy,
}

impl Default for TraceSettings {
    fn default() -> Self {
        Self {
            spp: 1.0,
            sampling: Sampling::default(),
            seed: 0,
            frame: 0,
            max_bounces: 5,
            strategy: Strategy::Mis,
        }
    }
}

/// What a frame shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameView {
    /// Perspective.
    pub camera: quell::Camera,
    pub time_s: f32,
    /// Camera and time of the frame before, for motion vectors. `None`: nothing moved.
    pub previous: Option<(quell::Camera, f32)>,
}

/// A scene on the GPU, and the passes that trace it.
#[derive(Debug)]
pub struct Tracer {
    source: FrameSource,
    scene_bindings: wgpu::BindGroup,
    frame_texture: wgpu::Texture,
    passes: Passes,
    /// Images between passes, of the size that was last asked for.
    scratch: Mutex<Option<Scratch>>,
}

#[derive(Debug, Clone)]
struct Scratch {
    hits: wgpu::TextureView,
    listed: wgpu::Buffer,
    work: wgpu::Buffer,
    /// What a reference traces into and throws away.
    images: Option<std::sync::Arc<GBuffer>>,
    size: [u32; 2],
}

/// Texels in a row of scene data (`SCENE_WIDTH_LOG2` of the shaders) and of frame data.
const SCENE_WIDTH: u32 = 1 << 12;
const FRAME_WIDTH: u32 = 1 << 8;

impl Tracer {
    /// Builds the BVHs and uploads the scene; takes up to seconds for large ones.
    ///
    /// # Errors
    /// Where the scene is larger than textures of WebGPU's default limits can hold, or has no geometry.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        let mut geometry = Geometry::new(scene)?;
        ensure!(!geometry.placed.is_empty(), "scene {} has no triangles", scene.name);
        let source = FrameSource::new(scene, &mut geometry);
        let device = &gpu.device;
        let texels = |label, texels: &[Vec4]| scene_texture(gpu, label, texels);
        let frame_rows = (source.texel_count() as u32).div_ceil(FRAME_WIDTH);
        ensure!(
            frame_rows <= device.limits().max_texture_dimension_2d,
            "the scene has too many emissive triangles"
        );
        let frame_texture = device.create_texture(&texture_descriptor("frame_data", FRAME_WIDTH, frame_rows));
        let views = passes::SceneViews {
            nodes: texels("nodes", &geometry.nodes)?,
            triangles: texels("triangles", &geometry.triangles)?,
            corners: texels("corners", &geometry.corners)?,
            materials: texels("materials", &material_texels(scene))?,
            images: ImageArray::new(gpu, scene)?,
            frame_data: frame_texture.create_view(&Default::default()),
        };
        let passes = Passes::new(device)?;
        let scene_bindings = passes.bind_scene(device, &views);
        Ok(Self { source, scene_bindings, frame_texture, passes, scratch: Mutex::new(None) })
    }

    /// Traces one frame into all images of `out`. Records into `encoder`; never submits.
    pub fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &FrameView,
        settings: &TraceSettings,
        out: &GBuffer,
    ) {
        self.encode_timed(gpu, encoder, view, settings, out, None);
    }

    /// As [`Self::encode`]; writes the time before and after to `timestamps.first_query` and the query after it.
    pub fn encode_timed(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &FrameView,
        settings: &TraceSettings,
        out: &GBuffer,
        timestamps: Option<quell::Timestamps<'_>>,
    ) {
        let size = [out.width, out.height];
        let (uniform, texels) = self.source.frame(view, settings, size);
        self.upload(gpu, encoder, texels);
        let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("frame"),
            contents: bytemuck::bytes_of(&uniform),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let scratch = self.scratch(gpu, size, false);
        let Scratch { hits, listed, work, .. } = &scratch;
        let target = Target { uniform: &uniform, hits, listed, work, out };
        self.passes.encode(gpu, encoder, &self.scene_bindings, &target, timestamps);
    }

    /// Adds `settings.spp` samples per pixel, a whole number, to a reference. Each call needs its own `settings.frame`. Keep the
    /// samples of one submit few: drivers end dispatches that take seconds.
    pub fn accumulate_reference(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &FrameView,
        settings: &TraceSettings,
        accumulation: &ReferenceImage,
    ) {
        let scratch = self.scratch(gpu, accumulation.size(), true);
        if let Some(images) = &scratch.images {
            self.encode(gpu, encoder, view, settings, images);
            accumulation.add(gpu, encoder, &self.passes, &images.radiance, settings.spp as u32);
        }
    }

    /// Copies from a buffer of its own, so that several frames may be recorded before one submit.
    fn upload(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, mut texels: Vec<Vec4>) {
        let extent = self.frame_texture.size();
        texels.resize((extent.width * extent.height) as usize, Vec4::ZERO);
        let buffer = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("frame_data"),
            contents: bytemuck::cast_slice(&texels),
            usage: wgpu::BufferUsages::COPY_SRC,
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(FRAME_WIDTH * 16),
            rows_per_image: None,
        };
        let source = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_buffer_to_texture(source, self.frame_texture.as_image_copy(), extent);
    }

    fn scratch(&self, gpu: &Gpu, size: [u32; 2], with_images: bool) -> Scratch {
        let mut cached = self.scratch.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut scratch = cached.take().filter(|s| s.size == size).unwrap_or_else(|| {
            let mut descriptor = texture_descriptor("hits", size[0], size[1]);
            descriptor.usage |= wgpu::TextureUsages::STORAGE_BINDING;
            let hits = gpu.device.create_texture(&descriptor).create_view(&Default::default());
            let buffer = |label, words: u32, usage| {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: 4 * u64::from(words),
                    usage: wgpu::BufferUsages::STORAGE | usage,
                    mapped_at_creation: false,
                })
            };
            let arguments = wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST;
            Scratch {
                hits,
                listed: buffer("listed", size[0] * size[1], wgpu::BufferUsages::empty()),
                work: buffer("work", 4, arguments),
                images: None,
                size,
            }
        });
        if with_images && scratch.images.is_none() {
            scratch.images = Some(GBuffer::new(&gpu.device, size[0], size[1]).into());
        }
        *cached = Some(scratch.clone());
        scratch
    }
}

/// The camera at `pose`: unjittered, reversed depth to an infinite far plane.
pub fn camera_of(pose: &CameraPose, width: u32, height: u32) -> quell::Camera {
    let forward = (pose.target - pose.eye).normalize_or(glam::Vec3::NEG_Z);
    // Looking along `up` leaves the roll open; any will do.
    let up = if forward.cross(pose.up).length_squared() > 1e-8 {
        pose.up
    } else {
        forward.any_orthonormal_vector()
    };
    let aspect = width as f32 / height.max(1) as f32;
    quell::Camera {
        view_from_world: glam::camera::rh::view::look_to_mat4(pose.eye, forward, up),
        clip_from_view: glam::camera::rh::proj::directx::perspective_infinite_reverse(
            pose.vertical_fov,
            aspect,
            0.01,
        ),
        jitter_px: Vec2::ZERO,
    }
}

/// `MATERIAL_TEXELS` of the shaders for each material.
fn material_texels(scene: &Scene) -> Vec<Vec4> {
    let mut texels = Vec::new();
    for m in &scene.materials {
        let slots =
            [m.base_color_texture, m.metallic_roughness_texture, m.normal_texture, m.emissive_texture];
        let [r, g, b] = m.emissive;
        texels.push(m.base_color.into());
        texels.push(Vec4::new(m.metallic, m.roughness, m.alpha_cutoff.unwrap_or(-1.0), m.specular));
        texels.push(Vec4::new(r, g, b, if m.double_sided { 1.0 } else { 0.0 }));
        texels.push(Vec4::from(slots.map(|slot| slot.map_or(-1.0, |texture| texture.image as f32))));
        texels.push(Vec4::new(m.normal_scale, 0.0, 0.0, 0.0));
        for slot in slots {
            let [x, y] = slot.map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], |texture| texture.matrix());
            texels.extend([x, y].map(|row| glam::Vec3::from(row).extend(0.0)));
        }
    }
    texels
}

fn texture_descriptor(label: &'static str, width: u32, height: u32) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    }
}

fn scene_texture(gpu: &Gpu, label: &'static str, texels: &[Vec4]) -> Result<wgpu::TextureView> {
    let rows = (texels.len() as u32).div_ceil(SCENE_WIDTH).max(1);
    let limit = gpu.device.limits().max_texture_dimension_2d;
    ensure!(rows <= limit, "the scene's {label} need {rows} texture rows, at most {limit} are possible");
    let texture = gpu.device.create_texture(&texture_descriptor(label, SCENE_WIDTH, rows));
    let mut padded = texels.to_vec();
    padded.resize((rows * SCENE_WIDTH) as usize, Vec4::ZERO);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(SCENE_WIDTH * 16),
        rows_per_image: None,
    };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&padded), layout, texture.size());
    Ok(texture.create_view(&Default::default()))
}
