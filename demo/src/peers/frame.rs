//! What all peers are told of a frame, and the uniform that their shaders read it from.

use crate::gbuffer::GBuffer;
use crate::gpu::Gpu;
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Mat4, Vec3};

/// What a peer needs besides the images.
#[derive(Debug, Clone, Copy)]
pub struct PeerFrame {
    pub camera: quell::Camera,
    /// Drop history.
    pub restart: bool,
    /// View depth at and beyond which a pixel is a miss.
    pub far: f32,
    /// Frames that history may count for; at least 1. Where a peer's paper has its own limit, the shorter one holds.
    pub max_history: f32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct FrameParams {
    size: [u32; 2],
    restart: u32,
    has_motion_z: u32,
    prev_depth_per_depth: [f32; 4],
    prev_depth_constant: [f32; 4],
    far: f32,
    max_history: f32,
    pad: [u32; 2],
}

/// The uniform `frame` of the shaders, and the camera that it needs from the frame before.
#[derive(Debug)]
pub(super) struct FrameUniform {
    buffer: wgpu::Buffer,
    /// View from world of the frame in history; none before the first.
    previous_view: Option<Mat4>,
}

impl FrameUniform {
    pub fn new(device: &wgpu::Device) -> Self {
        Self { buffer: uniform(device, "peer frame", size_of::<FrameParams>()), previous_view: None }
    }

    /// Writes what this frame is, through the queue. This frame's camera is the next one's previous.
    pub fn update(&mut self, gpu: &Gpu, gbuffer: &GBuffer, frame: &PeerFrame) {
        let previous_view = self.previous_view.filter(|_| !frame.restart);
        let (per_depth, constant) = previous_depth(&frame.camera, previous_view.unwrap_or_default());
        let params = FrameParams {
            size: [gbuffer.width, gbuffer.height],
            restart: u32::from(previous_view.is_none()),
            has_motion_z: u32::from(gbuffer.motion.texture().format().components() > 2),
            prev_depth_per_depth: per_depth.extend(0.0).to_array(),
            prev_depth_constant: constant.extend(0.0).to_array(),
            far: frame.far,
            max_history: frame.max_history.max(1.0),
            pad: [0; 2],
        };
        gpu.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&params));
        self.previous_view = Some(frame.camera.view_from_world);
    }

    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        self.buffer.as_entire_binding()
    }
}

pub(super) fn uniform(device: &wgpu::Device, label: &str, size: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// View-space position as a function of depth and NDC position: `(depth * per_depth + constant) * (x, y, 1)`, for
/// perspective and orthographic cameras.
pub(super) fn position_in_view(camera: &quell::Camera) -> (Mat3, Mat3) {
    let p = camera.clip_from_view;
    let perspective = p.w_axis.w == 0.0;
    let x = Vec3::new(1.0, 0.0, if perspective { p.z_axis.x } else { -p.w_axis.x }) / p.x_axis.x;
    let y = Vec3::new(0.0, 1.0, if perspective { p.z_axis.y } else { -p.w_axis.y }) / p.y_axis.y;
    let rows = |x, y, z| Mat3::from_cols(x, y, z).transpose();
    // Depth is -z.
    if perspective {
        (rows(x, y, -Vec3::Z), Mat3::ZERO)
    } else {
        (rows(Vec3::ZERO, Vec3::ZERO, -Vec3::Z), rows(x, y, Vec3::ZERO))
    }
}

/// View depth in the previous frame of a static point, as a function of its depth and NDC position in this one:
/// `depth * per_depth . (x, y, 1) + constant . (x, y, 1)`.
fn previous_depth(camera: &quell::Camera, previous_view: Mat4) -> (Vec3, Vec3) {
    let (per_depth, constant) = position_in_view(camera);
    // The third row of previous view from current view gives z, which is -depth.
    let row = -(previous_view * camera.view_from_world.inverse()).row(2);
    let toward = row.truncate();
    (per_depth.transpose() * toward, constant.transpose() * toward + row.w * Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::shaders;
    use glam::Vec2;
    use glam::camera::rh::{proj::directx, view::look_at_mat4};

    fn check_positions(projection: Mat4) {
        let view = look_at_mat4(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y);
        let previous = look_at_mat4(Vec3::new(1.2, 1.9, 3.4), Vec3::X, Vec3::Y);
        let camera =
            quell::Camera { view_from_world: view, clip_from_view: projection, jitter_px: Vec2::ZERO };
        let (per_depth, constant) = previous_depth(&camera, previous);
        let (position_per_depth, position_constant) = position_in_view(&camera);
        for point in [Vec3::new(0.1, -0.4, 0.2), Vec3::new(-1.0, 0.3, -2.0)] {
            let depth = -view.transform_point3(point).z;
            let ndc = (projection * view).project_point3(point).truncate().extend(1.0);
            let expected = -previous.transform_point3(point).z;
            let found = depth * per_depth.dot(ndc) + constant.dot(ndc);
            assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
            let found = (depth * position_per_depth + position_constant) * ndc;
            assert!(found.distance(view.transform_point3(point)) < 1e-4, "{found}");
        }
    }

    #[test]
    fn positions_and_previous_depth_of_static_points() {
        check_positions(directx::perspective(1.0, 1.6, 0.1, 100.0));
        check_positions(directx::perspective_infinite_reverse(0.7, 0.8, 0.1));
        check_positions(directx::orthographic(-3.0, 2.0, -1.0, 4.0, 0.1, 50.0));
    }

    #[test]
    fn the_parameters_are_laid_out_as_in_the_shader() {
        use std::mem::offset_of;
        let module = crate::shader_check::validated(&shaders::source("accumulate"));
        let fields = [
            ("size", offset_of!(FrameParams, size)),
            ("restart", offset_of!(FrameParams, restart)),
            ("has_motion_z", offset_of!(FrameParams, has_motion_z)),
            ("prev_depth_per_depth", offset_of!(FrameParams, prev_depth_per_depth)),
            ("prev_depth_constant", offset_of!(FrameParams, prev_depth_constant)),
            ("far", offset_of!(FrameParams, far)),
            ("max_history", offset_of!(FrameParams, max_history)),
            ("pad", offset_of!(FrameParams, pad)),
        ];
        crate::shader_check::assert_layout(&module, "Frame", &fields, size_of::<FrameParams>());
    }
}
