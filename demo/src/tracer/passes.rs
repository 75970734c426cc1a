//! Pipelines of the tracer's passes and their bindings.

use super::images::ImageArray;
use super::shaders;
use crate::compute::{Binding, Pass, PassDescriptor, bind, layout};
use crate::gbuffer::GBuffer;
use crate::gpu::Gpu;
use anyhow::{Context, Result};
use wgpu::TextureFormat::{R32Float, R32Uint, Rgba16Float, Rgba32Float};

/// Everything in bind group 0.
#[derive(Debug)]
pub(super) struct SceneViews {
    pub nodes: wgpu::TextureView,
    pub triangles: wgpu::TextureView,
    pub corners: wgpu::TextureView,
    pub materials: wgpu::TextureView,
    pub images: ImageArray,
    pub frame_data: wgpu::TextureView,
}

/// What one frame is traced with and into.
pub(super) struct Target<'a> {
    pub uniform: &'a wgpu::Buffer,
    pub hits: &'a wgpu::TextureView,
    pub out: &'a GBuffer,
}

#[derive(Debug)]
pub(super) struct Passes {
    scene_layout: wgpu::BindGroupLayout,
    frame_layout: wgpu::BindGroupLayout,
    visibility: Pass,
    surface: Pass,
    trace: Pass,
    accumulate: Pass,
}

/// `@workgroup_size` of every pass, in both directions.
const WORKGROUP: u32 = 8;

impl Passes {
    pub fn new(device: &wgpu::Device) -> Result<Self> {
        use Binding::{ImageArray, Sampler, Store, Texels, Uniform};
        let scene_layout = layout(
            device,
            "scene",
            &[Texels, Texels, Texels, Texels, ImageArray, ImageArray, Sampler, Texels],
        );
        let frame_layout = layout(device, "frame", &[Uniform]);
        let pass = |name, bindings: &[Binding]| -> Result<Pass> {
            let source = shaders::source(name).with_context(|| format!("shader {name} lacks an include"))?;
            // Averaging needs neither scene nor frame.
            let shared: &[_] = if name == "accumulate" { &[] } else { &[&scene_layout, &frame_layout] };
            let descriptor =
                PassDescriptor { name, source, shared, bindings, constants: &[], tile: WORKGROUP };
            Ok(Pass::new(device, descriptor))
        };
        Ok(Self {
            visibility: pass(
                "visibility",
                &[Store(Rgba32Float), Store(R32Float), Store(Rgba16Float), Store(R32Uint)],
            )?,
            surface: pass("surface", &[Texels, Store(Rgba16Float), Store(Rgba16Float), Store(Rgba16Float)])?,
            trace: pass("trace", &[Texels, Store(Rgba32Float), Store(R32Uint)])?,
            accumulate: pass("accumulate", &[Texels, Texels, Store(Rgba32Float), Uniform])?,
            scene_layout,
            frame_layout,
        })
    }

    pub fn bind_scene(&self, device: &wgpu::Device, views: &SceneViews) -> wgpu::BindGroup {
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("images"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let view = wgpu::BindingResource::TextureView;
        let resources = [
            view(&views.nodes),
            view(&views.triangles),
            view(&views.corners),
            view(&views.materials),
            view(&views.images.color),
            view(&views.images.data),
            wgpu::BindingResource::Sampler(&sampler),
            view(&views.frame_data),
        ];
        bind(device, "scene", &self.scene_layout, &resources)
    }

    /// Records the passes of a frame.
    pub fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        scene: &wgpu::BindGroup,
        target: &Target<'_>,
        timestamps: Option<quell::Timestamps<'_>>,
    ) {
        let Target { uniform, hits, out } = *target;
        let frame = bind(&gpu.device, "frame", &self.frame_layout, &[uniform.as_entire_binding()]);
        let frames = [
            (&self.visibility, vec![hits, &out.depth, &out.motion, &out.surface_id]),
            (&self.surface, vec![hits, &out.albedo, &out.normal_roughness, &out.emission]),
            (&self.trace, vec![hits, &out.radiance, &out.sample_count]),
        ];
        let last = frames.len() - 1;
        for (i, (pass, views)) in frames.into_iter().enumerate() {
            let resources: Vec<_> = views.into_iter().map(wgpu::BindingResource::TextureView).collect();
            let images = pass.bind(&gpu.device, &resources);
            let times = timestamps.map(|t| wgpu::ComputePassTimestampWrites {
                query_set: t.query_set,
                beginning_of_pass_write_index: (i == 0).then_some(t.first_query),
                end_of_pass_write_index: (i == last).then_some(t.first_query + 1),
            });
            // A pass in the middle has nothing to write, which is not allowed as timestamp writes.
            let times = times.filter(|_| i == 0 || i == last);
            pass.dispatch(encoder, &[scene, &frame, &images], [out.width, out.height], times);
        }
    }

    /// Records the mean of what `prev_mean` holds and of `spp` more samples, or of these alone.
    pub fn accumulate(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        radiance: &wgpu::TextureView,
        [prev_mean, mean]: [&wgpu::TextureView; 2],
        parameters: &wgpu::Buffer,
    ) {
        let view = wgpu::BindingResource::TextureView;
        let resources = [view(radiance), view(prev_mean), view(mean), parameters.as_entire_binding()];
        let images = self.accumulate.bind(&gpu.device, &resources);
        let size = mean.texture().size();
        self.accumulate.dispatch(encoder, &[&images], [size.width, size.height], None);
    }
}
