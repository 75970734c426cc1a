//! What real denoisers hold, at the sizes that the budget names.

use quell::{Camera, Denoiser, DenoiserDescriptor, FrameInputs, Pipelines, RequiredInputs, Settings};
use std::collections::BTreeMap;
use std::sync::Arc;
use wgpu::TextureFormat;

pub const SIZES: [[u32; 2]; 2] = [[1920, 1080], [2560, 1440]];

/// What a denoiser holds.
pub struct Held {
    /// Bytes by resource, once a frame's specular radiance came apart.
    pub all: Vec<(&'static str, u64)>,
    /// Names of those that are there from the beginning.
    combined: Vec<&'static str>,
}

impl Held {
    /// Bytes while there is one signal.
    pub fn without_split(&self) -> u64 {
        self.all.iter().filter(|(name, _)| self.combined.contains(name)).map(|(_, bytes)| bytes).sum()
    }
}

/// At each of [`SIZES`].
pub fn held() -> [Held; 2] {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| adapter.get_info().device_type != wgpu::DeviceType::Cpu);
    let adapter =
        adapters.first().expect("no adapter: `apt-get install mesa-vulkan-drivers` gives one on the CPU");
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
    let pipelines = Arc::new(Pipelines::new(&device).unwrap());
    SIZES.map(|[width, height]| {
        let descriptor = DenoiserDescriptor::new(width, height);
        let mut denoiser = Denoiser::with_pipelines(&device, &descriptor, pipelines.clone()).unwrap();
        let combined = denoiser.memory().allocations().map(|resource| resource.name).collect();
        record_split(&mut denoiser, &device, &queue);
        let all = denoiser.memory().allocations().map(|resource| (resource.name, resource.bytes)).collect();
        Held { all, combined }
    })
}

/// A frame that is never submitted.
fn record_split(denoiser: &mut Denoiser, device: &wgpu::Device, queue: &wgpu::Queue) {
    let size = denoiser.size();
    let image = |format| quell::gpu::image(device, "cost", size, format);
    let [radiance, depth] = [TextureFormat::Rgba16Float, TextureFormat::R32Float].map(image);
    let [specular, output] = [TextureFormat::Rgba16Float; 2].map(image);
    let clip_from_view = glam::camera::rh::proj::directx::perspective(1.0, 1.5, 0.1, 100.0);
    let inputs = FrameInputs::new(RequiredInputs {
        radiance: &radiance,
        albedo: &radiance,
        normal_roughness: &radiance,
        depth: &depth,
        motion: &radiance,
        output: &output,
        camera: Camera::new(glam::Mat4::IDENTITY, clip_from_view),
    })
    .with_specular(&specular);
    let mut encoder = device.create_command_encoder(&Default::default());
    denoiser.encode(device, queue, &mut encoder, &inputs, &Settings::default()).unwrap();
}

/// Bytes per pixel by resource.
pub fn per_pixel(held: &[(&'static str, u64)], [width, height]: [u32; 2]) -> BTreeMap<&'static str, f64> {
    let pixels = f64::from(width) * f64::from(height);
    held.iter().map(|&(name, bytes)| (name, bytes as f64 / pixels)).collect()
}
