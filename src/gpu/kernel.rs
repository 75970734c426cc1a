//! A compute pipeline with its binding table, and recording one dispatch of it.

use super::shader::assemble;
use crate::PassProfiler;
use wgpu::{BindingResource, BindingType, TextureFormat};

/// What a binding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A struct of uniforms; binding 0 is always the frame's.
    Frame,
    /// Four words that differ between dispatches of a frame.
    Uniform,
    /// A float image that is read by `textureLoad`.
    Texture,
    /// An unsigned image that is read by `textureLoad`.
    TextureUint,
    /// An image that is written.
    Storage(TextureFormat),
    /// A buffer that is read.
    Buffer,
    /// A buffer that is written.
    BufferMut,
}

/// A row of a binding table: WGSL name and kind. The row's place is the binding's number in group 0.
pub type Binding = (&'static str, Kind);

/// What a pass is made of.
#[derive(Debug)]
pub struct KernelDescriptor {
    /// Name of pass, WGSL file, entry point, label and profiler scope.
    pub name: &'static str,
    /// The WGSL file.
    pub source: &'static str,
    /// The binding table.
    pub bindings: &'static [Binding],
    /// Workgroup size, as in the WGSL.
    pub workgroup: [u32; 2],
    /// What one workgroup covers of the extent given to `record`.
    pub covers: [u32; 2],
}

/// Names and values of the WGSL's overridable constants (`include/frame.wgsl`).
pub type Constants = [(&'static str, f64)];

/// For the specular signal.
pub const SPECULAR: &Constants = &[("IS_SPECULAR", 1.0)];
/// For radiance in one with hit distances.
pub const REFLECTIONS: &Constants = &[("HAS_REFLECTIONS", 1.0)];

/// For conventions of depth and normals other than quell's own.
pub const DECODING: &Constants = &[("DECODES", 1.0)];

/// A compiled pass.
#[derive(Clone)]
pub struct Kernel {
    descriptor: &'static KernelDescriptor,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl std::fmt::Debug for Kernel {
    /// By name: a denoiser is printed in a line or two.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Kernel({})", self.descriptor.name)
    }
}

/// What all passes of a frame are recorded with.
#[derive(Debug)]
pub struct Recorder<'a> {
    /// Makes bind groups.
    pub device: &'a wgpu::Device,
    /// Receives the passes.
    pub encoder: &'a mut wgpu::CommandEncoder,
    /// The frame's uniforms.
    pub frame: &'a wgpu::Buffer,
    /// What times passes, if something does.
    pub profiler: Option<&'a dyn PassProfiler>,
    /// Whether the passes work on the specular signal.
    pub is_specular: bool,
}

/// What compiles passes.
#[derive(Debug, Clone, Copy)]
pub struct Compiler<'a> {
    /// What they are for.
    pub device: &'a wgpu::Device,
    /// What remembers them from one run of the program to the next.
    pub cache: Option<&'a wgpu::PipelineCache>,
}

impl<'a> From<&'a wgpu::Device> for Compiler<'a> {
    fn from(device: &'a wgpu::Device) -> Self {
        Self { device, cache: None }
    }
}

impl Kernel {
    /// Compiles a pass.
    pub fn new<'a>(compiler: impl Into<Compiler<'a>>, descriptor: &'static KernelDescriptor) -> Self {
        Self::with(compiler, descriptor, &[])
    }

    /// Compiles a pass for other signals, with other values of its overridable constants.
    pub fn with<'a>(
        compiler: impl Into<Compiler<'a>>,
        descriptor: &'static KernelDescriptor,
        constants: &Constants,
    ) -> Self {
        let Compiler { device, cache } = compiler.into();
        let name = Some(descriptor.name);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: name,
            source: wgpu::ShaderSource::Wgsl(assemble(descriptor.source).into()),
        });
        let entries: Vec<_> = (0..).zip(descriptor.bindings).map(|(i, &(_, kind))| entry(i, kind)).collect();
        let layout = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: name, entries: &entries });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: name,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: name,
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: name,
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                // Clearing would be stores that nobody reads: what a pass reads of its workgroup's memory it has written.
                zero_initialize_workgroup_memory: false,
            },
            cache,
        });
        Self { descriptor, layout, pipeline }
    }

    /// Records a compute pass with one dispatch over `extent` (in the units of [`KernelDescriptor::covers`]), with the
    /// resources of all bindings after the frame's uniforms, in the order of the table.
    pub fn record(&self, recorder: &mut Recorder<'_>, resources: &[BindingResource<'_>], extent: [u32; 2]) {
        let group = self.bind(recorder, resources);
        recorder.pass(self.descriptor.name, |pass| self.dispatch(pass, &group, extent));
    }

    /// Binds the frame's uniforms, then `resources` in the order of the table.
    pub fn bind(&self, recorder: &Recorder<'_>, resources: &[BindingResource<'_>]) -> wgpu::BindGroup {
        let frame = recorder.frame.as_entire_binding();
        let entries: Vec<_> = (0..)
            .zip(std::iter::once(frame).chain(resources.iter().cloned()))
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        recorder.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.descriptor.name),
            layout: &self.layout,
            entries: &entries,
        })
    }

    /// One dispatch of a pass that has several.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, group: &wgpu::BindGroup, extent: [u32; 2]) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        let [columns, rows] = self.descriptor.covers;
        pass.dispatch_workgroups(extent[0].div_ceil(columns), extent[1].div_ceil(rows), 1);
    }

    /// As [`Kernel::dispatch`], with the number of workgroups at a place in a buffer that an earlier dispatch wrote.
    pub fn dispatch_indirect(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        group: &wgpu::BindGroup,
        workgroups: &wgpu::Buffer,
        offset: u64,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups_indirect(workgroups, offset);
    }
}

impl Recorder<'_> {
    /// Tells the profiler of a pass that has nothing to do, so that each of a frame's queries is written.
    pub fn skip_pass(&mut self, name: &'static str) {
        if self.profiler.is_some() {
            self.pass(name, |_| {});
        }
    }

    /// A compute pass of a kernel, one of [`PASSES`](crate::PASSES), timed where the caller wants it.
    pub fn pass(&mut self, name: &'static str, record: impl FnOnce(&mut wgpu::ComputePass<'_>)) {
        let place = crate::PASSES.iter().position(|pass| *pass == name);
        let of_signal = place.filter(|&place| self.is_specular && place < crate::SIGNAL_PASSES);
        let label = of_signal.map_or(name, |place| crate::PASSES[place + crate::SIGNAL_PASSES]);
        let times = self.profiler.and_then(|profiler| profiler.begin(label, self.encoder));
        let timestamp_writes = times.as_ref().map(|times| wgpu::ComputePassTimestampWrites {
            query_set: &times.query_set,
            beginning_of_pass_write_index: times.begin,
            end_of_pass_write_index: times.end,
        });
        record(
            &mut self
                .encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(label), timestamp_writes }),
        );
        if let Some(profiler) = self.profiler {
            profiler.end(label, self.encoder);
        }
    }
}

fn entry(binding: u32, kind: Kind) -> wgpu::BindGroupLayoutEntry {
    let texture = |sample_type| BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let buffer = |ty| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let ty = match kind {
        Kind::Frame | Kind::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        Kind::Texture => texture(wgpu::TextureSampleType::Float { filterable: false }),
        Kind::TextureUint => texture(wgpu::TextureSampleType::Uint),
        Kind::Storage(format) => BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension: wgpu::TextureViewDimension::D2,
        },
        Kind::Buffer => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        Kind::BufferMut => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
    };
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}
