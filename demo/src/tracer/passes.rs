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
    pub listed: &'a wgpu::Buffer,
    pub work: &'a wgpu::Buffer,
    pub out: &'a GBuffer,
}

#[derive(Debug)]
pub(super) struct Passes {
    scene_layout: wgpu::BindGroupLayout,
    frame_layout: wgpu::BindGroupLayout,
    visibility: Pass,
    surface: Pass,
    plan: Pass,
    trace: Pass,
    lobes: Pass,
    trace_split: Pass,
    accumulate: Pass,
}

/// `@workgroup_size` of every pass, in both directions.
const WORKGROUP: u32 = 8;

impl Passes {
    pub fn new(device: &wgpu::Device) -> Result<Self> {
        use Binding::{Buffer, BufferMut, ImageArray, Integers, Sampler, Store, Texels, Uniform};
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
        let trace = [Texels, Store(Rgba32Float), Integers, Buffer, Buffer];
        let lobes = [Store(Rgba32Float), Store(Rgba32Float), Store(R32Float)];
        let trace_split: Vec<_> = trace.into_iter().chain(lobes).collect();
        Ok(Self {
            visibility: pass(
                "visibility",
                &[Store(Rgba32Float), Store(R32Float), Store(Rgba16Float), Store(R32Uint)],
            )?,
            surface: pass("surface", &[Texels, Store(Rgba16Float), Store(Rgba16Float), Store(Rgba16Float)])?,
            plan: pass(
                "plan",
                &[Texels, Integers, Store(Rgba32Float), Store(R32Uint), BufferMut, BufferMut],
            )?,
            trace: pass("trace", &trace)?,
            lobes: pass(
                "lobes",
                &[Texels, Store(Rgba16Float), Store(Rgba32Float), Store(Rgba32Float), Store(R32Float)],
            )?,
            trace_split: pass("trace_split", &trace_split)?,
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
        let Target { uniform, hits, listed, work, out } = *target;
        encoder.clear_buffer(work, 0, None);
        let frame = bind(&gpu.device, "frame", &self.frame_layout, &[uniform.as_entire_binding()]);
        let image = wgpu::BindingResource::TextureView;
        let (list, counts) = (listed.as_entire_binding(), work.as_entire_binding());
        let visibility = [hits, &out.depth, &out.motion, &out.surface_id].map(image);
        let surface = [hits, &out.albedo, &out.normal_roughness, &out.emission].map(image);
        let [hits, radiance, sample_count] = [hits, &out.radiance, &out.sample_count].map(image);
        let plan = [
            hits.clone(),
            image(&out.sample_map),
            radiance.clone(),
            sample_count.clone(),
            list.clone(),
            counts.clone(),
        ];
        let mut trace = vec![hits.clone(), radiance, sample_count, list, counts];
        let [begin, end] = [true, false].map(|is_begin| {
            timestamps.map(|t| wgpu::ComputePassTimestampWrites {
                query_set: t.query_set,
                beginning_of_pass_write_index: is_begin.then_some(t.first_query),
                end_of_pass_write_index: (!is_begin).then_some(t.first_query + 1),
            })
        });
        let size = [out.width, out.height];
        let mut run = |pass: &Pass, resources: &[wgpu::BindingResource<'_>], times| {
            let own = pass.bind(&gpu.device, resources);
            pass.dispatch(encoder, &[scene, &frame, &own], size, times);
        };
        run(&self.visibility, &visibility, begin);
        run(&self.surface, &surface, None);
        run(&self.plan, &plan, None);
        let mut tracing = &self.trace;
        if let (Some(lobes), Some(albedo), Some(distance)) =
            (&out.lobes, &out.specular_albedo, &out.hit_distance)
        {
            let split = [&lobes.rest, &lobes.specular, distance].map(image);
            run(&self.lobes, &[&[hits, image(albedo)], &split[..]].concat(), None);
            trace.extend(split);
            tracing = &self.trace_split;
        }
        let own = tracing.bind(&gpu.device, &trace);
        tracing.dispatch_indirect(encoder, &[scene, &frame, &own], work, end);
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
