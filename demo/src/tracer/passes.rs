//! Pipelines of the tracer's passes and their bindings.

use super::images::ImageArray;
use super::shaders;
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

/// A pipeline and the layout of the last of its bind groups, which holds its images.
#[derive(Debug)]
struct Pass {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

#[derive(Clone, Copy)]
enum Binding {
    /// A float texture that is only loaded from.
    Texels,
    ImageArray,
    Sampler,
    Uniform,
    Store(wgpu::TextureFormat),
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
        let pass = |name, bindings: &[Binding]| {
            Pass::new(device, name, &[&scene_layout, &frame_layout], layout(device, name, bindings))
        };
        Ok(Self {
            visibility: pass(
                "visibility",
                &[Store(Rgba32Float), Store(R32Float), Store(Rgba16Float), Store(R32Uint)],
            )?,
            surface: pass("surface", &[Texels, Store(Rgba16Float), Store(Rgba16Float), Store(Rgba16Float)])?,
            trace: pass("trace", &[Texels, Store(Rgba32Float), Store(R32Uint)])?,
            accumulate: Pass::new(
                device,
                "accumulate",
                &[],
                layout(device, "accumulate", &[Texels, Texels, Store(Rgba32Float), Uniform]),
            )?,
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
            let images = bind(&gpu.device, pass.name, &pass.layout, &resources);
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
        let images = bind(&gpu.device, "accumulate", &self.accumulate.layout, &resources);
        let size = mean.texture().size();
        self.accumulate.dispatch(encoder, &[&images], [size.width, size.height], None);
    }
}

impl Pass {
    fn new(
        device: &wgpu::Device,
        name: &'static str,
        shared: &[&wgpu::BindGroupLayout],
        own: wgpu::BindGroupLayout,
    ) -> Result<Self> {
        let source = shaders::source(name).with_context(|| format!("shader {name} lacks an include"))?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layouts: Vec<_> = shared.iter().copied().chain([&own]).map(Some).collect();
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(name),
            compilation_options: Default::default(),
            cache: None,
        });
        Ok(Self { name, pipeline, layout: own })
    }

    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: &[&wgpu::BindGroup],
        [width, height]: [u32; 2],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(self.name), timestamp_writes });
        pass.set_pipeline(&self.pipeline);
        for (i, group) in groups.iter().enumerate() {
            pass.set_bind_group(i as u32, *group, &[]);
        }
        pass.dispatch_workgroups(width.div_ceil(WORKGROUP), height.div_ceil(WORKGROUP), 1);
    }
}

fn layout(device: &wgpu::Device, label: &str, bindings: &[Binding]) -> wgpu::BindGroupLayout {
    let entry = |(i, binding): (usize, &Binding)| wgpu::BindGroupLayoutEntry {
        binding: i as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: match *binding {
            Binding::Texels => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            Binding::ImageArray => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: true },
                view_dimension: wgpu::TextureViewDimension::D2Array,
                multisampled: false,
            },
            Binding::Sampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            Binding::Uniform => wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            Binding::Store(format) => wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format,
                view_dimension: wgpu::TextureViewDimension::D2,
            },
        },
        count: None,
    };
    let entries: Vec<_> = bindings.iter().enumerate().map(entry).collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

fn bind(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
