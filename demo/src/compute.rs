//! Compute passes over images: a pipeline from joined WGSL files, its bindings, its dispatch.

use std::borrow::Cow;

/// Texts of WGSL files under `demo/shaders/`, by their paths without the ending.
macro_rules! wgsl_files {
    ($folder:literal, $($name:literal),* $(,)?) => {
        [$((
            $name,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $folder, $name, ".wgsl")),
        )),*]
    };
}
pub(crate) use wgsl_files;

/// A pass's WGSL with `include/<name>` in the place of every line `//!include <name>`; none where one is missing.
pub fn join_wgsl(text: &str, includes: &[(&str, &str)]) -> Option<String> {
    let mut joined = String::new();
    for line in text.lines() {
        let part: Cow<str> = match line.strip_prefix("//!include ") {
            Some(name) => {
                let file = format!("include/{}", name.trim());
                includes.iter().find(|(name, _)| *name == file)?.1.into()
            }
            None => line.into(),
        };
        joined.push_str(&part);
        joined.push('\n');
    }
    Some(joined)
}

/// What a shader reads or writes in one place of a bind group.
#[derive(Debug, Clone, Copy)]
pub enum Binding {
    /// A float texture that is only loaded from.
    Texels,
    /// A texture of unsigned integers.
    Integers,
    ImageArray,
    Sampler,
    Uniform,
    Buffer,
    BufferMut,
    Store(wgpu::TextureFormat),
}

/// A pipeline and the layout of the last of its bind groups, which is the pass's own.
#[derive(Debug)]
pub struct Pass {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    /// Edge in pixels of the square that a workgroup works on.
    tile: u32,
}

/// What a pass is made from.
#[derive(Debug)]
pub struct PassDescriptor<'a> {
    /// Label and entry point.
    pub name: &'static str,
    pub source: String,
    /// Layouts of the bind groups before the pass's own.
    pub shared: &'a [&'a wgpu::BindGroupLayout],
    pub bindings: &'a [Binding],
    /// Values of `override`s.
    pub constants: &'a [(&'a str, f64)],
    /// Edge in pixels of the square that a workgroup works on.
    pub tile: u32,
}

impl Pass {
    pub fn new(device: &wgpu::Device, descriptor: PassDescriptor<'_>) -> Self {
        let PassDescriptor { name, source, shared, bindings, constants, tile } = descriptor;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let own = layout(device, name, bindings);
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
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        });
        Self { name, pipeline, layout: own, tile }
    }

    /// The pass's own bind group.
    pub fn bind(&self, device: &wgpu::Device, resources: &[wgpu::BindingResource<'_>]) -> wgpu::BindGroup {
        bind(device, self.name, &self.layout, resources)
    }

    /// Records the pass with its own bind group alone.
    pub fn run(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        resources: &[wgpu::BindingResource<'_>],
        size: [u32; 2],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        self.dispatch(encoder, &[&self.bind(device, resources)], size, timestamp_writes);
    }

    /// Records the pass over `width` x `height` pixels.
    pub fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: &[&wgpu::BindGroup],
        [width, height]: [u32; 2],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = self.begin(encoder, groups, timestamp_writes);
        pass.dispatch_workgroups(width.div_ceil(self.tile), height.div_ceil(self.tile), 1);
    }

    /// As [`Self::dispatch`], with the number of workgroups at the start of a buffer.
    pub fn dispatch_indirect(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: &[&wgpu::BindGroup],
        workgroups: &wgpu::Buffer,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        self.begin(encoder, groups, timestamp_writes).dispatch_workgroups_indirect(workgroups, 0);
    }

    fn begin<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        groups: &[&wgpu::BindGroup],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) -> wgpu::ComputePass<'a> {
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(self.name), timestamp_writes });
        pass.set_pipeline(&self.pipeline);
        for (i, group) in groups.iter().enumerate() {
            pass.set_bind_group(i as u32, *group, &[]);
        }
        pass
    }
}

/// Layout of a bind group whose bindings are numbered from 0.
pub fn layout(device: &wgpu::Device, label: &str, bindings: &[Binding]) -> wgpu::BindGroupLayout {
    let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
        sample_type,
        view_dimension,
        multisampled: false,
    };
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let float = |filterable| wgpu::TextureSampleType::Float { filterable };
    let entry = |(i, binding): (usize, &Binding)| wgpu::BindGroupLayoutEntry {
        binding: i as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: match *binding {
            Binding::Texels => texture(float(false), wgpu::TextureViewDimension::D2),
            Binding::Integers => texture(wgpu::TextureSampleType::Uint, wgpu::TextureViewDimension::D2),
            Binding::ImageArray => texture(float(true), wgpu::TextureViewDimension::D2Array),
            Binding::Sampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            Binding::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            Binding::Buffer => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            Binding::BufferMut => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
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

/// A bind group of resources in the order of their bindings.
pub fn bind(
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

/// Pass `index` of those that `timestamps` are for.
pub fn timestamp_writes(
    timestamps: Option<quell::Timestamps<'_>>,
    index: u32,
) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
    timestamps.map(|t| wgpu::ComputePassTimestampWrites {
        query_set: t.query_set,
        beginning_of_pass_write_index: Some(t.first_query + 2 * index),
        end_of_pass_write_index: Some(t.first_query + 2 * index + 1),
    })
}
