//! The pass that turns bevy's deferred G-buffer into images that quell reads. Needs no bevy, so that quell's own tests can run it.

use quell::Viewport;
use quell::wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferDescriptor, BufferUsages,
    CommandEncoder, ComputePassDescriptor, ComputePipeline, ComputePipelineDescriptor, Device, Extent3d,
    Queue, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView, include_wgsl,
};

/// Pixels that a workgroup of `decode.wgsl` decodes, in x and y.
const GROUP: u32 = 8;

/// The compiled pass.
#[derive(Debug)]
pub struct Decoder(ComputePipeline);

/// What a view's G-buffer holds, as quell reads it.
#[derive(Debug)]
pub struct Decoded {
    /// Base colour, linear: what quell calls albedo.
    pub albedo: TextureView,
    /// World normal and linear roughness.
    pub normal_roughness: TextureView,
    /// Linear view depth; 0 where there is no surface or where it was drawn forward.
    pub depth: TextureView,
    /// Emission as it is in the radiance.
    pub emission: TextureView,
    uniforms: Buffer,
}

/// What a frame's G-buffer is to be read with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecodeFrame {
    /// Column-major, unjittered.
    pub clip_from_view: [f32; 16],
    /// The part of the images that is the view.
    pub viewport: Viewport,
    /// What emission is multiplied by; 0 where the radiance has none.
    pub emission_scale: f32,
    /// Whether the radiance was multiplied by the base colour.
    pub has_albedo: bool,
}

impl Decoded {
    /// Images of this size: that of the G-buffer.
    pub fn new(device: &Device, size: [u32; 2]) -> Self {
        let image = |label, format| image(device, label, size, format);
        Self {
            albedo: image("quell bevy albedo", TextureFormat::Rgba8Unorm),
            normal_roughness: image("quell bevy normal roughness", TextureFormat::Rgba16Float),
            depth: image("quell bevy depth", TextureFormat::R32Float),
            emission: image("quell bevy emission", TextureFormat::Rgba16Float),
            uniforms: device.create_buffer(&BufferDescriptor {
                label: Some("quell bevy decode frame"),
                size: size_of::<[u32; 12]>() as u64,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }

    /// Of the images, in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.albedo.texture().width(), self.albedo.texture().height()]
    }
}

/// An image that one pass writes and another one reads.
pub fn image(device: &Device, label: &str, [width, height]: [u32; 2], format: TextureFormat) -> TextureView {
    let texture = device.create_texture(&TextureDescriptor {
        label: Some(label),
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

impl Decoder {
    pub fn new(device: &Device) -> Self {
        let module = device.create_shader_module(include_wgsl!("decode.wgsl"));
        Self(device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some("quell bevy decode"),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        }))
    }

    /// Records the pass. `gbuffer` is `Rgba32Uint`, `depth` a view of reverse-Z depth alone; `decoded` has their size.
    pub fn record(
        &self,
        (device, queue): (&Device, &Queue),
        encoder: &mut CommandEncoder,
        [gbuffer, depth]: [&TextureView; 2],
        frame: &DecodeFrame,
        decoded: &Decoded,
    ) {
        queue.write_buffer(&decoded.uniforms, 0, &frame.to_bytes());
        let views =
            [gbuffer, depth, &decoded.albedo, &decoded.normal_roughness, &decoded.depth, &decoded.emission];
        let uniforms = [decoded.uniforms.as_entire_binding()];
        let resources = uniforms.into_iter().chain(views.into_iter().map(BindingResource::TextureView));
        let entries: Vec<_> =
            (0..).zip(resources).map(|(binding, resource)| BindGroupEntry { binding, resource }).collect();
        let bind_group = device.create_bind_group(&BindGroupDescriptor {
            label: Some("quell bevy decode"),
            layout: &self.0.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("quell bevy decode"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.0);
        pass.set_bind_group(0, &bind_group, &[]);
        let [x, y] = frame.viewport.size.map(|pixels| pixels.div_ceil(GROUP));
        pass.dispatch_workgroups(x, y, 1);
    }
}

impl DecodeFrame {
    /// As `Frame` in `decode.wgsl`.
    fn to_bytes(self) -> Vec<u8> {
        let clip = self.clip_from_view;
        let (z, w) = (2, 3);
        let depth_rows = [clip[4 * z + z], clip[4 * w + z], clip[4 * z + w], clip[4 * w + w]];
        let Viewport { origin: [x, y], size: [width, height] } = self.viewport;
        let words = [x, y, width, height, self.emission_scale.to_bits(), self.has_albedo.into()];
        let words = depth_rows.map(f32::to_bits).into_iter().chain(words).chain([0; 2]);
        words.flat_map(u32::to_ne_bytes).collect()
    }
}
