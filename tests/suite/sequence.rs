//! A small analytic scene with known truth: two walls, a floor with a sharp shadow, sky above; a camera that may move.

use crate::gpu::{blank, download, gpu, upload};
use glam::{Vec2, Vec3, camera::rh};
use quell::{Camera, Denoiser, DenoiserDescriptor, FrameInputs, HistoryMode, RequiredInputs, Settings};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

/// One frame on the CPU. `truth` is what radiance converges to.
#[derive(Clone)]
pub struct Frame {
    pub size: [u32; 2],
    pub camera: Camera,
    pub radiance: Vec<[f32; 4]>,
    pub albedo: Vec<[f32; 4]>,
    pub normal: Vec<[f32; 4]>,
    pub depth: Vec<f32>,
    pub motion: Vec<[f32; 2]>,
    pub id: Vec<u32>,
    pub samples: Vec<u32>,
    /// Empty where the scene has no mirrors; see [`mirrored`](crate::mirror::mirrored).
    pub specular: Vec<[f32; 4]>,
    /// As `specular`.
    pub hit_distance: Vec<f32>,
    pub truth: Vec<[f32; 3]>,
    /// As `specular`: what of the truth is reflected.
    pub mirror_truth: Vec<[f32; 3]>,
}

/// A frame's images on the GPU.
pub struct Images {
    pub radiance: wgpu::TextureView,
    pub albedo: wgpu::TextureView,
    pub normal: wgpu::TextureView,
    pub depth: wgpu::TextureView,
    pub motion: wgpu::TextureView,
    pub id: wgpu::TextureView,
    pub samples: wgpu::TextureView,
    pub specular: Option<wgpu::TextureView>,
    pub hit_distance: Option<wgpu::TextureView>,
    pub output: wgpu::TextureView,
}

impl Frame {
    pub fn upload(&self) -> Images {
        let half = |texels: &[[f32; 4]]| -> Vec<[half::f16; 4]> {
            texels.iter().map(|t| t.map(half::f16::from_f32)).collect()
        };
        Images {
            radiance: upload(self.size, Format::Rgba32Float, &self.radiance),
            albedo: upload(self.size, Format::Rgba16Float, &half(&self.albedo)),
            normal: upload(self.size, Format::Rgba16Float, &half(&self.normal)),
            depth: upload(self.size, Format::R32Float, &self.depth),
            motion: upload(self.size, Format::Rg32Float, &self.motion),
            id: upload(self.size, Format::R32Uint, &self.id),
            samples: upload(self.size, Format::R32Uint, &self.samples),
            specular: given(&self.specular).map(|texels| upload(self.size, Format::Rgba32Float, texels)),
            hit_distance: given(&self.hit_distance).map(|texels| upload(self.size, Format::R32Float, texels)),
            output: blank(self.size, Format::Rgba16Float),
        }
    }
}

impl Images {
    pub fn inputs(&self, camera: Camera, history: HistoryMode) -> FrameInputs<'_> {
        FrameInputs::new(RequiredInputs {
            radiance: &self.radiance,
            albedo: &self.albedo,
            normal_roughness: &self.normal,
            depth: &self.depth,
            motion: &self.motion,
            output: &self.output,
            camera,
        })
        .with_history(history)
        .with_surface_id(&self.id)
        .with_sample_count(&self.samples)
        .with_specular(self.specular.as_ref())
        .with_hit_distance(self.hit_distance.as_ref())
    }
}

/// Changes what a constructor has set.
pub fn with<'a>(mut inputs: FrameInputs<'a>, change: impl FnOnce(&mut FrameInputs<'a>)) -> FrameInputs<'a> {
    change(&mut inputs);
    inputs
}

fn given<T>(texels: &[T]) -> Option<&[T]> {
    (!texels.is_empty()).then_some(texels)
}

/// Denoises one frame and reads the output back.
pub fn denoise(denoiser: &mut Denoiser, frame: &Frame, settings: &Settings) -> Vec<[f32; 3]> {
    let images = frame.upload();
    let inputs = images.inputs(frame.camera, HistoryMode::Continue);
    submit(denoiser, &inputs, settings);
    read_output(&images.output)
}

pub fn submit(denoiser: &mut Denoiser, inputs: &FrameInputs<'_>, settings: &Settings) {
    let gpu = gpu();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    denoiser.encode(&gpu.device, &gpu.queue, &mut encoder, inputs, settings).unwrap();
    gpu.queue.submit([encoder.finish()]);
}

pub fn read_output(output: &wgpu::TextureView) -> Vec<[f32; 3]> {
    download::<[half::f16; 4]>(output).iter().map(|t| [t[0], t[1], t[2]].map(f32::from)).collect()
}

pub fn denoiser(size: [u32; 2]) -> Denoiser {
    let [width, height] = size;
    Denoiser::new(&gpu().device, &DenoiserDescriptor::new(width, height)).unwrap()
}

/// Peak signal-to-noise ratio of images tonemapped by x / (1 + x), in dB.
pub fn psnr(image: &[[f32; 3]], truth: &[[f32; 3]]) -> f64 {
    assert_eq!(image.len(), truth.len());
    let tonemap = |x: f32| f64::from(x) / (1.0 + f64::from(x));
    let squares = image.iter().flatten().zip(truth.iter().flatten()).map(|(&a, &b)| {
        assert!(a.is_finite() && b.is_finite(), "not finite: {a} against {b}");
        (tonemap(a) - tonemap(b)).powi(2)
    });
    -10.0 * (squares.sum::<f64>() / (3 * image.len()) as f64).log10()
}

/// Looking into the room from `eye`, straight ahead.
pub fn camera(eye: Vec3, [width, height]: [u32; 2]) -> Camera {
    Camera {
        view_from_world: rh::view::look_to_mat4(eye, Vec3::new(-0.15, -0.1, -1.0).normalize(), Vec3::Y),
        clip_from_view: rh::proj::directx::perspective(1.0, width as f32 / height as f32, 0.1, 100.0),
        jitter_px: Vec2::ZERO,
    }
}

/// What is lit how much, as factors of how it is lit by day.
#[derive(Debug, Clone, Copy)]
pub struct Light {
    pub lamp: f32,
    pub sun: f32,
}

impl Light {
    pub const ON: Self = Self::all(1.0);

    pub const fn all(level: f32) -> Self {
        Self { lamp: level, sun: level }
    }
}

/// A frame at `eye`, with motion from `previous`; noise from `seed`, one sample a pixel.
pub fn frame(size: [u32; 2], eye: Vec3, previous: Vec3, seed: u64) -> Frame {
    shot(size, [eye, previous], seed, Vec2::ZERO, Light::ON)
}

/// As [`frame`], with samples off the pixels' centres.
pub fn jittered_frame(size: [u32; 2], eye: Vec3, previous: Vec3, seed: u64, jitter_px: Vec2) -> Frame {
    shot(size, [eye, previous], seed, jitter_px, Light::ON)
}

/// As [`frame`], in another light. The sky keeps its own.
pub fn lit_frame(size: [u32; 2], eye: Vec3, previous: Vec3, seed: u64, light: Light) -> Frame {
    shot(size, [eye, previous], seed, Vec2::ZERO, light)
}

fn shot(size: [u32; 2], [eye, previous]: [Vec3; 2], seed: u64, jitter_px: Vec2, light: Light) -> Frame {
    let mut random = StdRng::seed_from_u64(seed);
    let camera_now = Camera { jitter_px, ..camera(eye, size) };
    let clip_before = camera(previous, size);
    let clip_before = clip_before.clip_from_view * clip_before.view_from_world;
    let [width, height] = size;
    let mut frame = Frame {
        size,
        camera: camera_now,
        radiance: vec![],
        albedo: vec![],
        normal: vec![],
        depth: vec![],
        motion: vec![],
        id: vec![],
        samples: vec![1; (width * height) as usize],
        specular: vec![],
        hit_distance: vec![],
        truth: vec![],
        mirror_truth: vec![],
    };
    let world_from_clip = (camera_now.clip_from_view * camera_now.view_from_world).inverse();
    for y in 0..height {
        for x in 0..width {
            let sampled = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) + jitter_px;
            let uv = sampled / Vec2::new(width as f32, height as f32);
            let far = world_from_clip.project_point3(Vec3::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.5));
            let hit = intersect(eye, (far - eye).normalize());
            let shade = hit.map_or(Shade::SKY, |(position, surface)| shade(position, surface, light));
            let position = hit.map_or(far, |(position, _)| position);
            let before = clip_before.project_point3(position);
            let uv_before = Vec2::new(0.5 + 0.5 * before.x, 0.5 - 0.5 * before.y);
            let view_z = camera_now.view_from_world.transform_point3(position).z;
            let radiance = shade.albedo * shade.irradiance;
            // One sample sees the light with chance 0.4: unbiased, and as noisy as path tracing.
            let seen = if random.random_bool(0.4) { 2.5 } else { 0.0 };
            let noisy = if hit.is_some() { radiance * seen } else { radiance };
            frame.radiance.push(noisy.extend(1.0).to_array());
            frame.albedo.push(shade.albedo.extend(1.0).to_array());
            frame.normal.push(shade.normal.extend(1.0).to_array());
            frame.depth.push(if hit.is_some() { -view_z } else { f32::INFINITY });
            frame.motion.push((uv_before - uv).to_array());
            frame.id.push(shade.id);
            frame.truth.push(radiance.to_array());
        }
    }
    frame
}

struct Shade {
    albedo: Vec3,
    irradiance: Vec3,
    normal: Vec3,
    id: u32,
}

impl Shade {
    const SKY: Self =
        Self { albedo: Vec3::ONE, irradiance: Vec3::new(0.3, 0.5, 0.8), normal: Vec3::ZERO, id: 0 };
}

/// Normal and distance of each plane: floor, back wall, left wall.
const PLANES: [(Vec3, f32); 3] = [(Vec3::Y, 0.0), (Vec3::Z, -6.0), (Vec3::X, -3.0)];
const WALL_HEIGHT: f32 = 3.0;

fn intersect(eye: Vec3, direction: Vec3) -> Option<(Vec3, usize)> {
    let hits = PLANES.iter().enumerate().filter_map(|(surface, &(normal, distance))| {
        let t = (distance - normal.dot(eye)) / normal.dot(direction);
        let position = eye + t * direction;
        (t > 0.0 && position.y < WALL_HEIGHT).then_some((t, position, surface))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, position, surface)| (position, surface))
}

fn shade(p: Vec3, surface: usize, light: Light) -> Shade {
    let cell = (p * 2.0 + 0.25).floor();
    let checker = (cell.x + cell.y + cell.z).rem_euclid(2.0);
    let lamp = Vec3::new(0.5, 2.5, -3.0) - p;
    let lit = 2.0 * lamp.normalize().dot(PLANES[surface].0).max(0.0) / (0.5 + lamp.length_squared());
    let sun = if surface == 0 && p.x + 0.5 * p.z > -1.5 { 0.8 } else { 0.0 };
    Shade {
        albedo: Vec3::new(0.7, 0.6, 0.5) * (0.35 + 0.65 * checker),
        irradiance: Vec3::new(1.0, 0.9, 0.7) * (lit + 0.1) * light.lamp
            + Vec3::new(1.0, 0.95, 0.9) * sun * light.sun,
        normal: PLANES[surface].0,
        id: surface as u32 + 1,
    }
}

/// What is seen from a point by day, and how far away.
pub fn radiance_along(from: Vec3, direction: Vec3) -> (Vec3, f32) {
    let hit = intersect(from, direction);
    let shade = hit.map_or(Shade::SKY, |(position, surface)| shade(position, surface, Light::ON));
    (shade.albedo * shade.irradiance, hit.map_or(f32::INFINITY, |(position, _)| (position - from).length()))
}

/// A walk of `count` frames with `step` of movement each.
pub fn walk(size: [u32; 2], count: u32, step: Vec3, seed: u64) -> impl Iterator<Item = Frame> {
    lit_walk(size, count, step, seed, |_| Light::ON)
}

/// As [`walk`], in a light that changes from frame to frame.
pub fn lit_walk(
    size: [u32; 2],
    count: u32,
    step: Vec3,
    seed: u64,
    light: impl Fn(u32) -> Light,
) -> impl Iterator<Item = Frame> {
    let start = Vec3::new(0.0, 1.4, 1.0);
    (0..count).map(move |i| {
        let at = |i: u32| start + step * i as f32;
        let seed = seed.wrapping_mul(1_000_003) + u64::from(i);
        lit_frame(size, at(i), at(i.saturating_sub(1)), seed, light(i))
    })
}
