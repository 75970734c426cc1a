//! Looks at every pixel that was written, on the GPU: reading all of them back would take most of the time.

use crate::gpu::{blank, download_words, gpu, upload_words};
use crate::pool::SIZE;
use quell::Viewport;
use rand::{Rng, rngs::StdRng};

const SHADER: &str = "
    struct Part { origin: vec2<u32>, size: vec2<u32> }
    @group(0) @binding(0) var<uniform> part: Part;
    @group(0) @binding(1) var output: texture_2d<f32>;
    @group(0) @binding(2) var<storage, read_write> broken: atomic<u32>;

    @compute @workgroup_size(8, 8)
    fn look(@builtin(global_invocation_id) id: vec3<u32>) {
        if all(id.xy < part.size) {
            let texel = textureLoad(output, part.origin + id.xy, 0);
            let bits = bitcast<vec4<u32>>(texel);
            let is_finite = all((bits & vec4(0x7f800000u)) != vec4(0x7f800000u));
            if !is_finite || any(texel.rgb < vec3(0.0)) || texel.a != 1.0 {
                atomicAdd(&broken, 1u);
            }
        }
    }";

pub struct Judge {
    pipeline: wgpu::ComputePipeline,
    broken: wgpu::Buffer,
    outputs: [wgpu::TextureView; 2],
}

impl Judge {
    pub fn new() -> Self {
        let device = &gpu().device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let outputs = [0; 2].map(|_| blank(SIZE, wgpu::TextureFormat::Rgba16Float));
        Self { pipeline, broken: upload_words(&[0]), outputs }
    }

    /// An image to denoise into.
    pub fn output(&self, random: &mut StdRng) -> wgpu::TextureView {
        self.outputs[random.random_range(0..2)].clone()
    }

    /// Counts pixels that are not finite, negative, or not opaque.
    pub fn look_at(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        output: &wgpu::TextureView,
        Viewport { origin, size }: Viewport,
    ) {
        use wgpu::util::DeviceExt;
        let device = &gpu().device;
        let part = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(&[origin, size]),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let resources = [
            part.as_entire_binding(),
            wgpu::BindingResource::TextureView(output),
            self.broken.as_entire_binding(),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(size[0].div_ceil(8), size[1].div_ceil(8), 1);
    }

    /// How many pixels were broken so far.
    pub fn broken(&self) -> u32 {
        download_words(&self.broken)[0]
    }
}

#[test]
fn broken_pixels_are_seen() {
    use half::f16;
    let judge = Judge::new();
    let mut texels = vec![[f16::from_f32(1.0); 4]; (SIZE[0] * SIZE[1]) as usize];
    let part = Viewport { origin: [3, 2], size: [20, 10] };
    let at = |x: u32, y: u32| (y * SIZE[0] + x) as usize;
    texels[at(5, 5)][0] = f16::NAN;
    texels[at(3, 2)][1] = f16::INFINITY;
    texels[at(22, 11)][2] = f16::from_f32(-0.5);
    texels[at(9, 9)][3] = f16::from_f32(0.0);
    texels[at(23, 11)][0] = f16::NAN; // outside
    let image = crate::gpu::upload(SIZE, wgpu::TextureFormat::Rgba16Float, &texels);
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    judge.look_at(&mut encoder, &image, part);
    gpu().queue.submit([encoder.finish()]);
    assert_eq!(judge.broken(), 4);
}
