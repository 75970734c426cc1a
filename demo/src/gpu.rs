//! The device that the demo runs on, and reading images back from it.

use anyhow::{Context, Result, bail};

/// Adapter, device and queue.
#[derive(Debug, Clone)]
pub struct Gpu {
    pub instance: wgpu::Instance,
    pub adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

const NO_ADAPTER: &str = "no GPU adapter found. Install a Vulkan driver; without a GPU, Mesa's CPU driver works: \
                          `apt-get install mesa-vulkan-drivers`";

impl Gpu {
    /// Opens the best adapter, or the first whose name contains `QUELL_ADAPTER` (case-insensitive) where that is
    /// set. Timestamp queries are enabled where the adapter has them; limits are WebGPU's defaults.
    pub fn new() -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        Self::on(instance, None)
    }

    /// As [`Gpu::new`], on an adapter that can present to `surface`.
    pub fn on(instance: wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<Self> {
        let adapter = match std::env::var("QUELL_ADAPTER") {
            Ok(wanted) => find_adapter(&instance, &wanted)?,
            Err(_) => pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                compatible_surface: surface,
                ..Default::default()
            }))
            .context(NO_ADAPTER)?,
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("quell-demo"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: wgpu::Limits::default(),
            ..Default::default()
        }))
        .with_context(|| format!("adapter {} gave no device", adapter.get_info().name))?;
        Ok(Self { instance, adapter, device, queue })
    }

    /// Adapter name, driver and backend on one line, for reports.
    pub fn description(&self) -> String {
        let info = self.adapter.get_info();
        format!("{} ({} {}, {})", info.name, info.driver, info.driver_info, info.backend)
    }

    /// Reads mip level 0 of a 2D texture back, rows tightly packed. Waits for the GPU.
    pub fn read_texture(&self, texture: &wgpu::Texture) -> Result<Vec<u8>> {
        let texel = texture.format().block_copy_size(None).context("texture format has no texel size")?;
        let (width, height) = (texture.width(), texture.height());
        let packed_row = width * texel;
        let padded_row = packed_row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read_texture"),
            size: u64::from(padded_row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            let _ = sender.send(result);
        });
        self.device.poll(wgpu::PollType::wait_indefinitely()).context("waiting for the GPU")?;
        receiver.recv().context("the GPU dropped a read-back")??;
        let mapped = buffer.slice(..).get_mapped_range()?;
        let rows = mapped.chunks_exact(padded_row as usize);
        Ok(rows.flat_map(|row| &row[..packed_row as usize]).copied().collect())
    }
}

fn find_adapter(instance: &wgpu::Instance, wanted: &str) -> Result<wgpu::Adapter> {
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
    let matches =
        |adapter: &wgpu::Adapter| adapter.get_info().name.to_lowercase().contains(&wanted.to_lowercase());
    match adapters.into_iter().find(matches) {
        Some(adapter) => Ok(adapter),
        None if names.is_empty() => bail!(NO_ADAPTER),
        None => bail!("QUELL_ADAPTER={wanted}: no such adapter; found {}", names.join(", ")),
    }
}
