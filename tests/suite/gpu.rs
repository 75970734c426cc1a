//! The device that tests run on, and moving images and buffers to and from it.

use std::sync::OnceLock;
use wgpu::util::DeviceExt;

pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

/// WebGPU's default limits and no optional feature, on the CPU adapter first: it is the same everywhere.
pub fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = adapter(&instance);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("quell tests"),
            required_features: wgpu::Features::empty(),
            required_limits: wgpu::Limits::default(),
            ..Default::default()
        }))
        .unwrap();
        Gpu { device, queue }
    })
}

/// That of the CPU first.
pub fn adapter(instance: &wgpu::Instance) -> wgpu::Adapter {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| adapter.get_info().device_type != wgpu::DeviceType::Cpu);
    let first = adapters.into_iter().next();
    first.expect("no adapter: `apt-get install mesa-vulkan-drivers` gives one on the CPU")
}

/// An image of `size` with the given texels, readable, writable and copyable.
pub fn upload<T: bytemuck::Pod>(
    size: [u32; 2],
    format: wgpu::TextureFormat,
    texels: &[T],
) -> wgpu::TextureView {
    let gpu = gpu();
    let [width, height] = size;
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    let texel = format.block_copy_size(None).unwrap();
    assert_eq!(bytes.len() as u32, width * height * texel, "{format:?} {width}x{height}");
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &descriptor(size, format),
        wgpu::util::TextureDataOrder::LayerMajor,
        bytes,
    );
    texture.create_view(&Default::default())
}

/// A buffer of depth, which only drawing can fill.
pub fn depth_buffer(size: [u32; 2], format: wgpu::TextureFormat, texels: &[f32]) -> wgpu::TextureView {
    const SHADER: &str = "
        @group(0) @binding(0) var texels: texture_2d<f32>;
        @vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
            return vec4(4.0 * f32(i % 2u) - 1.0, 4.0 * f32(i / 2u) - 1.0, 0.0, 1.0);
        }
        @fragment fn depth(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 {
            return textureLoad(texels, vec2<u32>(at.xy), 0).x;
        }";
    let Gpu { device, queue } = gpu();
    let source = upload(size, wgpu::TextureFormat::R32Float, texels);
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
    let depth = device
        .create_texture(&wgpu::TextureDescriptor { usage, ..descriptor(size, format) })
        .create_view(&Default::default());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }],
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(&layout)],
        ..Default::default()
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::TextureView(&source),
        }],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);
    queue.submit([encoder.finish()]);
    depth
}

/// An image of zeros.
pub fn blank(size: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureView {
    gpu().device.create_texture(&descriptor(size, format)).create_view(&Default::default())
}

fn descriptor([width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureDescriptor<'static> {
    use wgpu::TextureUsages as Usage;
    let storable = matches!(
        format,
        wgpu::TextureFormat::Rgba16Float
            | wgpu::TextureFormat::Rgba32Float
            | wgpu::TextureFormat::R32Uint
            | wgpu::TextureFormat::Rg32Uint
    );
    let stored = if storable { Usage::STORAGE_BINDING } else { Usage::empty() };
    wgpu::TextureDescriptor {
        label: Some("test"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: Usage::TEXTURE_BINDING | Usage::COPY_SRC | Usage::COPY_DST | stored,
        view_formats: &[],
    }
}

/// Texels of an image, row by row.
pub fn download<T: bytemuck::Pod>(view: &wgpu::TextureView) -> Vec<T> {
    let gpu = gpu();
    let texture = view.texture();
    let row = texture.width() * texture.format().block_copy_size(None).unwrap();
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = readable(u64::from(padded * texture.height()));
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = map(&buffer);
    let packed: Vec<u8> =
        bytes.chunks_exact(padded as usize).flat_map(|padded| &padded[..row as usize]).copied().collect();
    bytemuck::pod_collect_to_vec(&packed)
}

/// Contents of a storage buffer.
pub fn download_buffer(source: &wgpu::Buffer) -> Vec<f32> {
    bytemuck::cast_vec(download_words(source))
}

/// As [`download_buffer`], of unsigned numbers.
pub fn download_words(source: &wgpu::Buffer) -> Vec<u32> {
    let gpu = gpu();
    let buffer = readable(source.size());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(source, 0, &buffer, 0, source.size());
    gpu.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&map(&buffer))
}

fn readable(size: u64) -> wgpu::Buffer {
    gpu().device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("test read-back"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

fn map(buffer: &wgpu::Buffer) -> Vec<u8> {
    buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.unwrap());
    gpu().device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    buffer.slice(..).get_mapped_range().unwrap().to_vec()
}

/// A storage buffer with the given contents.
pub fn upload_buffer(contents: &[f32]) -> wgpu::Buffer {
    upload_words(bytemuck::cast_slice(contents))
}

/// As [`upload_buffer`], of unsigned numbers. Also serves as the arguments of an indirect dispatch.
pub fn upload_words(contents: &[u32]) -> wgpu::Buffer {
    gpu().device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("test"),
        contents: bytemuck::cast_slice(contents),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::INDIRECT,
    })
}
