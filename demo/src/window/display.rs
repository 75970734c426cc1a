//! The pass that draws images into the window.

use bytemuck::{Pod, Zeroable};

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Params {
    size: [f32; 2],
    scale: f32,
    split: f32,
    exposure: f32,
    tonemap: u32,
    encode_srgb: u32,
    line_width: f32,
}

/// What is drawn.
#[derive(Debug)]
pub struct Shown<'a> {
    pub left: &'a wgpu::TextureView,
    /// The other image and where it begins, as a part of the width. Of the same size.
    pub right: Option<(&'a wgpu::TextureView, f32)>,
    /// Factor on radiance.
    pub exposure: f32,
    /// Radiance is tonemapped; colours are shown as they are.
    pub tonemap: bool,
}

/// Fullscreen triangle into a letterboxed rectangle.
#[derive(Debug)]
pub struct DisplayPass {
    pipeline: wgpu::RenderPipeline,
    params: wgpu::Buffer,
    encode_srgb: bool,
}

impl DisplayPass {
    pub fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Self {
        let shader = device.create_shader_module(wgpu::include_wgsl!("../../shaders/display.wgsl"));
        let texture = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let uniform = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("display"),
            entries: &[uniform, texture(1), texture(2)],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("display"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("display"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(target.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let params = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("display params"),
            size: size_of::<Params>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { pipeline, params, encode_srgb: !target.is_srgb() }
    }

    /// Clears `target` and draws into the part of `area` (left, top, width, height, in pixels) that keeps the image's
    /// proportions. Once per submission: the parameters are written through the queue.
    pub fn draw(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        area: [f32; 4],
        shown: Option<&Shown<'_>>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("display"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        let Some(shown) = shown else {
            return;
        };
        let image = shown.left.texture();
        let size = [image.width() as f32, image.height() as f32];
        let [left, top, width, height] = letterbox(size, area);
        if width < 1.0 || height < 1.0 {
            return;
        }
        let (right, split) = shown.right.unwrap_or((shown.left, 2.0));
        let params = Params {
            size,
            scale: width / size[0],
            split,
            exposure: shown.exposure,
            tonemap: u32::from(shown.tonemap),
            encode_srgb: u32::from(self.encode_srgb),
            line_width: 2.0 / width,
        };
        queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("display"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.params.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(shown.left) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(right) },
            ],
        });
        pass.set_viewport(left, top, width, height, 0.0, 1.0);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// The largest rectangle with an image's proportions in the middle of an area, both as left, top, width, height.
pub fn letterbox([image_width, image_height]: [f32; 2], [left, top, width, height]: [f32; 4]) -> [f32; 4] {
    let scale = (width / image_width).min(height / image_height).max(0.0);
    let (w, h) = ((image_width * scale).floor().min(width), (image_height * scale).floor().min(height));
    [left + ((width - w) * 0.5).floor(), top + ((height - h) * 0.5).floor(), w, h]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Gpu;
    use crate::image::{ImageRgb, display_from_linear, write_texture};

    #[test]
    fn images_keep_their_proportions() {
        assert_eq!(letterbox([4.0, 2.0], [10.0, 0.0, 100.0, 100.0]), [10.0, 25.0, 100.0, 50.0]);
        assert_eq!(letterbox([2.0, 4.0], [0.0, 0.0, 100.0, 50.0]), [37.0, 0.0, 25.0, 50.0]);
        assert_eq!(letterbox([4.0, 2.0], [0.0, 0.0, 0.0, 100.0])[2..], [0.0, 0.0]);
    }

    /// The window shows what the metrics measure: the shader's transform is the one on the CPU.
    #[test]
    fn the_shader_shows_what_png_files_show() {
        let gpu = Gpu::new().expect("tests need a Vulkan driver");
        let texture = |format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: 8, height: 4, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let input = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let image = texture(wgpu::TextureFormat::Rgba32Float, input);
        let mut source = ImageRgb::from_fn(8, 4, |x, y| [x as f32 * 0.2, y as f32, 1e-3 * x as f32]);
        source.pixels[3] = [f32::NAN, 0.0, 0.0];
        let texels: Vec<[f32; 4]> = source.pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        write_texture(&gpu.queue, &image, &texels);
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let output = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = texture(format, output);
        let view = image.create_view(&Default::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        DisplayPass::new(&gpu.device, format).draw(
            &gpu.device,
            &gpu.queue,
            &mut encoder,
            &target.create_view(&Default::default()),
            [0.0, 0.0, 8.0, 4.0],
            Some(&Shown { left: &view, right: None, exposure: 2.0, tonemap: true }),
        );
        gpu.queue.submit([encoder.finish()]);
        let shown = gpu.read_texture(&target).unwrap();
        for (i, (texel, pixel)) in shown.chunks_exact(4).zip(&source.pixels).enumerate() {
            if i == 3 {
                assert_eq!(texel[..3], [255, 0, 255], "invalid pixels are magenta");
                continue;
            }
            for c in 0..3 {
                let expected = display_from_linear(2.0 * pixel[c]) * 255.0;
                assert!((f32::from(texel[c]) - expected).abs() <= 1.0, "{texel:?} for {pixel:?}");
            }
        }
    }

    #[test]
    fn the_parameters_are_laid_out_as_in_the_shader() {
        use std::mem::offset_of;
        let module = crate::shader_check::validated(include_str!("../../shaders/display.wgsl"));
        let fields = [
            ("size", offset_of!(Params, size)),
            ("scale", offset_of!(Params, scale)),
            ("split", offset_of!(Params, split)),
            ("exposure", offset_of!(Params, exposure)),
            ("tonemap", offset_of!(Params, tonemap)),
            ("encode_srgb", offset_of!(Params, encode_srgb)),
            ("line_width", offset_of!(Params, line_width)),
        ];
        crate::shader_check::assert_layout(&module, "Params", &fields, size_of::<Params>());
    }
}
