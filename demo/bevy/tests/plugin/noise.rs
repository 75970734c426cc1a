//! Makes what a camera sees noisy, as a ray-traced effect would.

use bevy::core_pipeline::core_3d::main_opaque_pass_3d;
use bevy::core_pipeline::schedule::Core3d;
use bevy::diagnostic::FrameCount;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::{ExtractComponent, ExtractComponentPlugin};
use bevy::render::renderer::{RenderContext, RenderDevice, ViewQuery};
use bevy::render::view::ViewTarget;
use quell_bevy::QuellSystems;
use quell_bevy::quell::wgpu::{self, util::DeviceExt};

/// For cameras whose view target is a storage texture, as quell makes it.
#[derive(Component, ExtractComponent, Clone)]
#[extract_app(RenderApp)]
pub struct Noise;

pub struct NoisePlugin;

impl Plugin for NoisePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ExtractComponentPlugin::<Noise>::default());
        app.sub_app_mut(RenderApp)
            .add_systems(Core3d, noise.after(main_opaque_pass_3d).before(QuellSystems::Denoise));
    }
}

fn noise(
    view: ViewQuery<&ViewTarget, With<Noise>>,
    frame: Res<FrameCount>,
    device: Res<RenderDevice>,
    mut pipeline: Local<Option<wgpu::ComputePipeline>>,
    mut ctx: RenderContext,
) {
    let device = device.wgpu_device();
    let pipeline = pipeline.get_or_insert_with(|| {
        let module = device.create_shader_module(wgpu::include_wgsl!("noise.wgsl"));
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("noise"),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
    });
    let seed = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("noise seed"),
        contents: &[frame.0, 0, 0, 0].map(u32::to_ne_bytes).concat(),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let images = view.into_inner().post_process_write();
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("noise"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            entry(0, seed.as_entire_binding()),
            entry(1, wgpu::BindingResource::TextureView(images.source)),
            entry(2, wgpu::BindingResource::TextureView(images.destination)),
        ],
    });
    let (width, height) = (images.source_texture.width(), images.source_texture.height());
    let mut pass = ctx.command_encoder().begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &bind_group, &[]);
    pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
}
