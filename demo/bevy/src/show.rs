//! The pass that brings the denoised image to the view target. Drawing needs no usage that view targets do not have, and leaves
//! alpha and all outside of the viewport alone, as a storage texture or a swap of bevy's two main textures would not.

use quell::Viewport;
use quell::wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindingResource, ColorTargetState, ColorWrites, CommandEncoder,
    Device, FragmentState, LoadOp, Operations, RenderPassColorAttachment, RenderPassDescriptor,
    RenderPipeline, RenderPipelineDescriptor, StoreOp, TextureFormat, TextureView, VertexState, include_wgsl,
};

/// The compiled pass.
#[derive(Debug)]
pub struct Show(RenderPipeline);

impl Show {
    pub fn new(device: &Device) -> Self {
        let module = device.create_shader_module(include_wgsl!("show.wgsl"));
        let format = TextureFormat::Rgba16Float;
        Self(device.create_render_pipeline(&RenderPipelineDescriptor {
            label: Some("quell bevy show"),
            layout: None,
            vertex: VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(ColorTargetState { format, blend: None, write_mask: ColorWrites::COLOR })],
            }),
            multiview_mask: None,
            cache: None,
        }))
    }

    /// Records the pass. `target` is `Rgba16Float`, has the size of `denoised`, and was cleared before.
    pub fn record(
        &self,
        device: &Device,
        encoder: &mut CommandEncoder,
        denoised: &TextureView,
        target: &TextureView,
        viewport: Viewport,
    ) {
        let bind_group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("quell bevy show"),
            layout: &self.0.get_bind_group_layout(0),
            entries: &[BindGroupEntry { binding: 0, resource: BindingResource::TextureView(denoised) }],
        });
        let attachment = RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load: LoadOp::Load, store: StoreOp::Store },
        };
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("quell bevy show"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        pass.set_pipeline(&self.0);
        pass.set_bind_group(0, &bind_group, &[]);
        let Viewport { origin: [x, y], size: [width, height] } = viewport;
        pass.set_scissor_rect(x, y, width, height);
        pass.draw(0..3, 0..1);
    }
}
