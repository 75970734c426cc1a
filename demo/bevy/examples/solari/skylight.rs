//! A noisy effect of one's own: skylight by rays through the depth buffer, written to an image. See `skylight.wgsl`.

use bevy::core_pipeline::core_3d::main_opaque_pass_3d;
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::core_pipeline::schedule::Core3d;
use bevy::diagnostic::FrameCount;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_component::{ExtractComponent, ExtractComponentPlugin};
use bevy::render::render_asset::RenderAssets;
use bevy::render::renderer::{RenderContext, RenderDevice, ViewQuery};
use bevy::render::texture::GpuImage;
use bevy::render::view::ExtractedView;
use quell_bevy::QuellSystems;
use quell_bevy::quell::wgpu::{self, util::DeviceExt};

/// Lights what the camera sees, into an image of its size. The camera needs the depth and the deferred prepass.
#[derive(Component, ExtractComponent, Clone)]
#[extract_app(RenderApp)]
pub struct Skylight {
    pub image: Handle<Image>,
    pub samples: u32,
}

pub struct SkylightPlugin;

impl Plugin for SkylightPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ExtractComponentPlugin::<Skylight>::default());
        app.sub_app_mut(RenderApp)
            .add_systems(Core3d, skylight.after(main_opaque_pass_3d).before(QuellSystems::Denoise));
    }
}

fn skylight(
    view: ViewQuery<(&Skylight, &ExtractedView, &ViewPrepassTextures)>,
    images: Res<RenderAssets<GpuImage>>,
    frame: Res<FrameCount>,
    device: Res<RenderDevice>,
    mut pipeline: Local<Option<wgpu::ComputePipeline>>,
    mut ctx: RenderContext,
) {
    let (effect, view, prepass) = view.into_inner();
    let (Some(gbuffer), Some(depth), Some(light)) =
        (prepass.deferred_view(), prepass.depth_only_view(), images.get(&effect.image))
    else {
        return;
    };
    let device = device.wgpu_device();
    let pipeline = pipeline.get_or_insert_with(|| compile(device));
    let clip_from_world = view.clip_from_view * view.world_from_view.to_matrix().inverse();
    let matrices =
        [clip_from_world, clip_from_world.inverse()].map(|matrix| matrix.to_cols_array().map(f32::to_bits));
    let words = [light.texture.width(), light.texture.height(), effect.samples, frame.0];
    let bytes: Vec<u8> = matrices.concat().into_iter().chain(words).flat_map(u32::to_ne_bytes).collect();
    let uniforms = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("skylight frame"),
        contents: &bytes,
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    let image = |view| wgpu::BindingResource::TextureView(view);
    let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("skylight"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            entry(0, uniforms.as_entire_binding()),
            entry(1, image(gbuffer)),
            entry(2, image(depth)),
            entry(3, image(&light.texture_view)),
        ],
    });
    let mut pass = ctx.command_encoder().begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &bind_group, &[]);
    pass.dispatch_workgroups(light.texture.width().div_ceil(8), light.texture.height().div_ceil(8), 1);
}

fn compile(device: &wgpu::Device) -> wgpu::ComputePipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("skylight.wgsl"));
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("skylight"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}
