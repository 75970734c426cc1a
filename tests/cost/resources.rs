//! What real denoisers hold, at the sizes that the budget names.

use std::collections::BTreeMap;

pub const SIZES: [[u32; 2]; 2] = [[1920, 1080], [2560, 1440]];

/// Bytes by resource, at each of [`SIZES`].
pub fn held() -> [Vec<(&'static str, u64)>; 2] {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| adapter.get_info().device_type != wgpu::DeviceType::Cpu);
    let adapter =
        adapters.first().expect("no adapter: `apt-get install mesa-vulkan-drivers` gives one on the CPU");
    let (device, _) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();
    let pipelines = std::sync::Arc::new(quell::Pipelines::new(&device));
    SIZES.map(|[width, height]| {
        let descriptor = quell::DenoiserDescriptor { width, height };
        let denoiser = quell::Denoiser::with_pipelines(&device, &descriptor, pipelines.clone()).unwrap();
        denoiser.memory().into_iter().map(|resource| (resource.name, resource.bytes)).collect()
    })
}

/// Bytes per pixel by resource.
pub fn per_pixel(held: &[(&'static str, u64)], [width, height]: [u32; 2]) -> BTreeMap<&'static str, f64> {
    let pixels = f64::from(width) * f64::from(height);
    held.iter().map(|&(name, bytes)| (name, bytes as f64 / pixels)).collect()
}
