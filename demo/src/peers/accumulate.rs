//! Plain temporal accumulation with reprojection: what history alone gives, without a spatial filter.

use crate::gbuffer::{GBuffer, image};
use crate::gpu::Gpu;
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};
use quell::{Allocation, Timestamps};
use wgpu::TextureFormat;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Params {
    size: [u32; 2],
    restart: u32,
    has_motion_z: u32,
    prev_depth_per_depth: [f32; 4],
    prev_depth_constant: [f32; 4],
    far: f32,
    max_history: f32,
    pad: [u32; 2],
}

/// Edge of the shader's square workgroup.
const WORKGROUP: u32 = 8;

/// History ping-pong of one accumulator, and its pipeline.
#[derive(Debug)]
pub struct Accumulate {
    pipeline: wgpu::ComputePipeline,
    params: wgpu::Buffer,
    /// Mean radiance and count, then packed features; `[parity]` is written this frame, the other one read.
    history: [(wgpu::TextureView, wgpu::TextureView); 2],
    output: wgpu::TextureView,
    parity: usize,
    /// View matrix of the frame in history; none before the first.
    previous_view: Option<Mat4>,
}

/// What `Accumulate::encode` needs besides the images.
#[derive(Debug, Clone, Copy)]
pub struct AccumulateFrame {
    pub camera: quell::Camera,
    /// Drop history.
    pub restart: bool,
    /// View depth at and beyond which a pixel is a miss.
    pub far: f32,
    /// Frames that history may count for; at least 1.
    pub max_history: f32,
}

impl Accumulate {
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        let image = |label, format| image(device, label, [width, height], format);
        let history = || {
            (
                image("accumulate mean", TextureFormat::Rgba32Float),
                image("accumulate features", TextureFormat::Rgba32Uint),
            )
        };
        Self {
            pipeline: pipeline(device),
            params: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("accumulate params"),
                size: size_of::<Params>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            history: [history(), history()],
            output: image("accumulate output", TextureFormat::Rgba16Float),
            parity: 0,
            previous_view: None,
        }
    }

    pub const PASSES: [&str; 1] = ["accumulate"];

    /// What it holds on the GPU besides its inputs and output.
    pub fn memory(&self) -> Vec<Allocation> {
        let twice = |name, view| {
            let allocation = Allocation::of_image(name, view);
            Allocation { bytes: 2 * allocation.bytes, ..allocation }
        };
        let (mean, features) = &self.history[0];
        vec![twice("mean", mean), twice("features", features)]
    }

    /// The mean radiance of the last frame that was encoded, `Rgba16Float`.
    pub fn output(&self) -> &wgpu::TextureView {
        &self.output
    }

    /// Records one frame. Submit `encoder` before the next call: the parameters are written through the queue.
    pub fn encode(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: &GBuffer,
        frame: &AccumulateFrame,
        timestamps: Option<Timestamps<'_>>,
    ) {
        let previous_view = self.previous_view.filter(|_| !frame.restart);
        let (per_depth, constant) = previous_depth(&frame.camera, previous_view.unwrap_or_default());
        let params = Params {
            size: [gbuffer.width, gbuffer.height],
            restart: u32::from(previous_view.is_none()),
            has_motion_z: u32::from(gbuffer.motion.texture().format().components() > 2),
            prev_depth_per_depth: per_depth.to_array(),
            prev_depth_constant: constant.to_array(),
            far: frame.far,
            max_history: frame.max_history.max(1.0),
            pad: [0; 2],
        };
        gpu.queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
        self.parity ^= 1;
        let (written, read) = (&self.history[self.parity], &self.history[self.parity ^ 1]);
        let views = [
            &gbuffer.radiance,
            &gbuffer.normal_roughness,
            &gbuffer.depth,
            &gbuffer.motion,
            &gbuffer.surface_id,
            &gbuffer.sample_count,
            &read.0,
            &read.1,
            &written.0,
            &written.1,
            &self.output,
        ];
        let mut entries =
            vec![wgpu::BindGroupEntry { binding: 0, resource: self.params.as_entire_binding() }];
        entries.extend(views.into_iter().zip(1..).map(|(view, binding)| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(view),
        }));
        let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("accumulate"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("accumulate"),
            timestamp_writes: timestamps.map(|t| wgpu::ComputePassTimestampWrites {
                query_set: t.query_set,
                beginning_of_pass_write_index: Some(t.first_query),
                end_of_pass_write_index: Some(t.first_query + 1),
            }),
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.dispatch_workgroups(gbuffer.width.div_ceil(WORKGROUP), gbuffer.height.div_ceil(WORKGROUP), 1);
        self.previous_view = Some(frame.camera.view_from_world);
    }
}

/// View depth in the previous frame of a static point, as a function of its depth and NDC position in this one:
/// `depth * per_depth . (x, y, 1) + constant . (x, y, 1)`, for perspective and orthographic cameras.
fn previous_depth(camera: &quell::Camera, previous_view: Mat4) -> (Vec4, Vec4) {
    let p = camera.clip_from_view;
    // View position = depth * from_depth * (x, y, 1) + from_ndc * (x, y, 1), per component.
    let perspective = p.w_axis.w == 0.0;
    let x = Vec4::new(1.0, 0.0, if perspective { p.z_axis.x } else { -p.w_axis.x }, 0.0) / p.x_axis.x;
    let y = Vec4::new(0.0, 1.0, if perspective { p.z_axis.y } else { -p.w_axis.y }, 0.0) / p.y_axis.y;
    let minus_z = Vec4::new(0.0, 0.0, -1.0, 0.0);
    // Depth is -z; the third row of previous view from current view gives z.
    let row = -(previous_view * camera.view_from_world.inverse()).row(2);
    let origin = Vec4::new(0.0, 0.0, row.w, 0.0);
    if perspective {
        (row.x * x + row.y * y + row.z * minus_z, origin)
    } else {
        (row.z * minus_z, row.x * x + row.y * y + origin)
    }
}

fn pipeline(device: &wgpu::Device) -> wgpu::ComputePipeline {
    use wgpu::TextureSampleType::{Float, Uint};
    let shader = device.create_shader_module(wgpu::include_wgsl!("../../shaders/peers/accumulate.wgsl"));
    let float = Float { filterable: false };
    let read = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let write = |format| wgpu::BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format,
        view_dimension: wgpu::TextureViewDimension::D2,
    };
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let bindings = [
        uniform,
        read(float), // radiance
        read(float), // normal_roughness
        read(float), // depth
        read(float), // motion
        read(Uint),  // surface_id
        read(Uint),  // sample_count
        read(float), // prev_mean
        read(Uint),  // prev_features
        write(TextureFormat::Rgba32Float),
        write(TextureFormat::Rgba32Uint),
        write(TextureFormat::Rgba16Float),
    ];
    let entries: Vec<_> = (0..)
        .zip(bindings)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        })
        .collect();
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("accumulate"),
        entries: &entries,
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("accumulate"),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("accumulate"),
        layout: Some(&layout),
        module: &shader,
        entry_point: Some("accumulate"),
        compilation_options: Default::default(),
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::camera::rh::{proj::directx, view::look_at_mat4};
    use glam::{Vec2, Vec3};

    fn check_previous_depth(projection: Mat4) {
        let view = look_at_mat4(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y);
        let previous = look_at_mat4(Vec3::new(1.2, 1.9, 3.4), Vec3::X, Vec3::Y);
        let camera =
            quell::Camera { view_from_world: view, clip_from_view: projection, jitter_px: Vec2::ZERO };
        let (per_depth, constant) = previous_depth(&camera, previous);
        for point in [Vec3::new(0.1, -0.4, 0.2), Vec3::new(-1.0, 0.3, -2.0)] {
            let depth = -view.transform_point3(point).z;
            let ndc = (projection * view).project_point3(point).truncate().extend(1.0).extend(0.0);
            let expected = -previous.transform_point3(point).z;
            let found = depth * per_depth.dot(ndc) + constant.dot(ndc);
            assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
        }
    }

    #[test]
    fn previous_depth_of_static_points() {
        check_previous_depth(directx::perspective(1.0, 1.6, 0.1, 100.0));
        check_previous_depth(directx::perspective_infinite_reverse(0.7, 0.8, 0.1));
        check_previous_depth(directx::orthographic(-3.0, 2.0, -1.0, 4.0, 0.1, 50.0));
    }

    #[test]
    fn the_parameters_are_laid_out_as_in_the_shader() {
        use std::mem::offset_of;
        let module = crate::shader_check::validated(include_str!("../../shaders/peers/accumulate.wgsl"));
        let fields = [
            ("size", offset_of!(Params, size)),
            ("restart", offset_of!(Params, restart)),
            ("has_motion_z", offset_of!(Params, has_motion_z)),
            ("prev_depth_per_depth", offset_of!(Params, prev_depth_per_depth)),
            ("prev_depth_constant", offset_of!(Params, prev_depth_constant)),
            ("far", offset_of!(Params, far)),
            ("max_history", offset_of!(Params, max_history)),
            ("pad", offset_of!(Params, pad)),
        ];
        crate::shader_check::assert_layout(&module, "Params", &fields, size_of::<Params>());
        assert_eq!(module.entry_points[0].workgroup_size, [WORKGROUP, WORKGROUP, 1]);
    }
}
