//! A bevy app without a window, that is stepped by hand and whose images can be read.

use crate::picture::Picture;
use bevy::app::PluginsState;
use bevy::asset::RenderAssetUsages;
use bevy::image::ImageSampler;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{
    Extent3d, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::texture::GpuImage;
use bevy::render::{RenderApp, RenderPlugin};
use bevy::window::{ExitCondition, WindowPlugin};
use half::f16;
use quell_bevy::quell::wgpu;

/// An app that draws one frame in each [`App::update`], before it returns. Begun by [`begin`].
pub fn app() -> App {
    let mut app = App::new();
    let plugins = DefaultPlugins
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
        .disable::<PipelinedRenderingPlugin>();
    app.add_plugins(plugins);
    app
}

/// What a runner does before the first update.
pub fn begin(app: &mut App) {
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
}

/// An image that cameras draw to and shaders write, of linear half floats.
pub fn image(app: &mut App, size: [u32; 2]) -> Handle<Image> {
    image_of(app, size, TextureFormat::Rgba16Float, TextureUsages::STORAGE_BINDING)
}

/// With `usage` besides what all such images have.
pub fn image_of(
    app: &mut App,
    [width, height]: [u32; 2],
    format: TextureFormat,
    usage: TextureUsages,
) -> Handle<Image> {
    let image = Image {
        data: None,
        texture_descriptor: TextureDescriptor {
            label: None,
            size: Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: usage
                | TextureUsages::RENDER_ATTACHMENT
                | TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_SRC
                | TextureUsages::COPY_DST,
            view_formats: &[],
        },
        sampler: ImageSampler::nearest(),
        asset_usage: RenderAssetUsages::RENDER_WORLD,
        ..default()
    };
    app.world_mut().resource_mut::<Assets<Image>>().add(image)
}

/// What an image holds after the last update.
pub fn read(app: &App, handle: &Handle<Image>) -> Result<Picture> {
    let world = app.sub_app(RenderApp).world();
    let image =
        world.resource::<RenderAssets<GpuImage>>().get(handle).context("an image is not on the GPU")?;
    let (device, queue) = (world.resource::<RenderDevice>().wgpu_device(), world.resource::<RenderQueue>());
    let size = image.texture.size();
    let row = (8 * size.width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read"),
        size: u64::from(row * size.height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(image.texture.as_image_copy(), target, size);
    queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        let _ = sender.send(result);
    });
    device.poll(wgpu::PollType::wait_indefinitely()).context("waiting for the GPU")?;
    receiver.recv().context("the GPU dropped a read-back")??;
    let bytes = buffer.slice(..).get_mapped_range()?;
    let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
    let texel = |bytes: &[u8]| [0, 2, 4].map(|i| half(&bytes[i..]));
    let rows = bytes.chunks_exact(row as usize).map(|padded| &padded[..8 * size.width as usize]);
    let pixels = rows.flat_map(|row| row.chunks_exact(8).map(texel)).collect();
    Ok(Picture { width: size.width, height: size.height, pixels })
}

/// Fails where a frame went wrong: bevy asks to exit then.
pub fn update(app: &mut App) -> Result<()> {
    app.update();
    if app.should_exit().is_some() {
        return Err("bevy stopped; its log says why".into());
    }
    Ok(())
}
