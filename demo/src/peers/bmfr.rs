//! BMFR: Koskela et al., "Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction" (ACM
//! Transactions on Graphics, 2019).
//!
//! Four passes on illumination without albedo: accumulation of the noisy input, a least-squares fit by ten features in
//! each block of 32x32 pixels, accumulation of the fit, and temporal antialiasing of the composed image.
//!
//! Beyond the paper: surface ids stop reprojection, and a pixel without a sample takes its colour from the fit.

use super::frame::{FrameUniform, PeerFrame, position_in_view, uniform};
use super::{allocations, shaders, views};
use crate::compute::{Binding, Pass, timestamp_writes};
use crate::gbuffer::{GBuffer, image};
use crate::gpu::Gpu;
use crate::halton;
use bytemuck::{Pod, Zeroable};
use glam::Mat3;
use quell::{Allocation, Timestamps};
use wgpu::TextureFormat::{Rg32Uint, Rgba16Float};

/// Edge of a block in pixels.
const BLOCK: u32 = 32;
/// Frames after which the blocks lie where they lay.
const OFFSETS: u32 = 16;

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct BlockParams {
    position_per_depth: [[f32; 4]; 3],
    position_constant: [[f32; 4]; 3],
    origin: [i32; 2],
    pad: [u32; 2],
}

/// What a frame leaves for the next one.
#[derive(Debug)]
struct History {
    /// Mean of the noisy signal, and its count.
    mean: wgpu::TextureView,
    surface: wgpu::TextureView,
    /// Mean of the fitted signal.
    accumulated: wgpu::TextureView,
    /// The output.
    antialiased: wgpu::TextureView,
}

/// Pipelines and history.
#[derive(Debug)]
pub struct Bmfr {
    accumulate: Pass,
    fit: Pass,
    blend: Pass,
    taa: Pass,
    frame: FrameUniform,
    blocks: wgpu::Buffer,
    /// `[parity]` is written this frame, the other one read.
    history: [History; 2],
    parity: usize,
    /// Frames since the last cut, for the blocks' offsets.
    count: u32,
    /// Where each pixel's history was found.
    taps: wgpu::TextureView,
    fitted: wgpu::TextureView,
    composed: wgpu::TextureView,
    output: wgpu::TextureView,
}

impl Bmfr {
    pub const PASSES: [&str; 4] = ["bmfr accumulate", "bmfr fit", "bmfr blend", "bmfr antialias"];

    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        use Binding::{Integers, Store, Texels, Uniform};
        let image = |label, format| image(device, label, [width, height], format);
        let history = || History {
            mean: image("bmfr mean", Rgba16Float),
            surface: image("bmfr surface", Rg32Uint),
            accumulated: image("bmfr accumulated", Rgba16Float),
            antialiased: image("bmfr antialiased", Rgba16Float),
        };
        let accumulate = [
            Uniform,
            Texels,   // radiance
            Texels,   // albedo
            Texels,   // normal_roughness
            Texels,   // depth
            Texels,   // motion
            Integers, // surface_id
            Texels,   // emission
            Integers, // sample_count
            Texels,   // prev_mean
            Integers, // prev_surface
            Store(Rgba16Float),
            Store(Rg32Uint),
            Store(Rg32Uint),
        ];
        // Blocks, mean, normal_roughness, depth.
        let fit = [Uniform, Uniform, Texels, Texels, Texels, Store(Rgba16Float)];
        let blend = [
            Uniform,
            Texels,   // fitted
            Texels,   // mean
            Integers, // taps
            Texels,   // prev_accumulated
            Texels,   // depth
            Texels,   // radiance
            Texels,   // albedo
            Texels,   // emission
            Store(Rgba16Float),
            Store(Rgba16Float),
        ];
        // Composed, motion, depth, prev_output.
        let taa = [Uniform, Texels, Texels, Texels, Texels, Store(Rgba16Float), Store(Rgba16Float)];
        Self {
            accumulate: shaders::pass(device, "bmfr_accumulate", &accumulate, &[]),
            fit: shaders::block_pass(device, "bmfr_fit", &fit, BLOCK),
            blend: shaders::pass(device, "bmfr_blend", &blend, &[]),
            taa: shaders::pass(device, "bmfr_taa", &taa, &[]),
            frame: FrameUniform::new(device),
            blocks: uniform(device, "bmfr blocks", size_of::<BlockParams>()),
            history: [history(), history()],
            parity: 0,
            count: 0,
            taps: image("bmfr taps", Rg32Uint),
            fitted: image("bmfr fitted", Rgba16Float),
            composed: image("bmfr composed", Rgba16Float),
            output: image("bmfr output", Rgba16Float),
        }
    }

    /// What it holds on the GPU besides its inputs and output.
    pub fn memory(&self) -> Vec<Allocation> {
        let History { mean, surface, accumulated, antialiased } = &self.history[0];
        allocations(&[
            ("mean", mean, 2),
            ("surface", surface, 2),
            ("accumulated", accumulated, 2),
            ("antialiased", antialiased, 2),
            ("taps", &self.taps, 1),
            ("fitted", &self.fitted, 1),
            ("composed", &self.composed, 1),
        ])
    }

    /// The denoised radiance of the last frame that was encoded, `Rgba16Float`.
    pub fn output(&self) -> &wgpu::TextureView {
        &self.output
    }

    /// Records one frame. Submit `encoder` before the next call: the parameters are written through the queue.
    pub fn encode(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: &GBuffer,
        frame: &PeerFrame,
        timestamps: Option<Timestamps<'_>>,
    ) {
        self.frame.update(gpu, gbuffer, frame);
        self.count = if frame.restart { 0 } else { self.count.wrapping_add(1) };
        let origin = block_origin(self.count);
        gpu.queue.write_buffer(&self.blocks, 0, bytemuck::bytes_of(&block_params(&frame.camera, origin)));
        self.parity ^= 1;
        let (history, previous) = (&self.history[self.parity], &self.history[self.parity ^ 1]);
        let size = [gbuffer.width, gbuffer.height];
        // Blocks that begin above and left of the image also reach its other side.
        let covered = [0, 1].map(|axis| size[axis] + origin[axis].unsigned_abs());

        let resources = views(
            self.frame.binding(),
            &[
                &gbuffer.radiance,
                &gbuffer.albedo,
                &gbuffer.normal_roughness,
                &gbuffer.depth,
                &gbuffer.motion,
                &gbuffer.surface_id,
                &gbuffer.emission,
                &gbuffer.sample_count,
                &previous.mean,
                &previous.surface,
                &history.mean,
                &history.surface,
                &self.taps,
            ],
        );
        self.accumulate.run(&gpu.device, encoder, &resources, size, timestamp_writes(timestamps, 0));

        let images = [&history.mean, &gbuffer.normal_roughness, &gbuffer.depth, &self.fitted];
        let mut resources = views(self.frame.binding(), &images);
        resources.insert(1, self.blocks.as_entire_binding());
        self.fit.run(&gpu.device, encoder, &resources, covered, timestamp_writes(timestamps, 1));

        let resources = views(
            self.frame.binding(),
            &[
                &self.fitted,
                &history.mean,
                &self.taps,
                &previous.accumulated,
                &gbuffer.depth,
                &gbuffer.radiance,
                &gbuffer.albedo,
                &gbuffer.emission,
                &history.accumulated,
                &self.composed,
            ],
        );
        self.blend.run(&gpu.device, encoder, &resources, size, timestamp_writes(timestamps, 2));

        let resources = views(
            self.frame.binding(),
            &[
                &self.composed,
                &gbuffer.motion,
                &gbuffer.depth,
                &previous.antialiased,
                &history.antialiased,
                &self.output,
            ],
        );
        self.taa.run(&gpu.device, encoder, &resources, size, timestamp_writes(timestamps, 3));
    }
}

/// Where the first block of a frame begins, so that borders of blocks are elsewhere in every one of 16 frames. The paper
/// has a fixed sequence of pseudorandom offsets; this one is Halton's, in bases 2 and 3, which covers a block evenly.
fn block_origin(frame: u32) -> [i32; 2] {
    (-(halton::point(frame % OFFSETS) * BLOCK as f32).as_ivec2()).to_array()
}

fn block_params(camera: &quell::Camera, origin: [i32; 2]) -> BlockParams {
    let world_from_view = Mat3::from_mat4(camera.view_from_world).inverse();
    let (per_depth, constant) = position_in_view(camera);
    let columns = |m: Mat3| (world_from_view * m).to_cols_array_2d().map(|[x, y, z]| [x, y, z, 0.0]);
    BlockParams {
        position_per_depth: columns(per_depth),
        position_constant: columns(constant),
        origin,
        pad: [0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn blocks_begin_elsewhere_in_every_frame_and_cover_the_image() {
        let origins: Vec<_> = (0..OFFSETS).map(block_origin).collect();
        let distinct: HashSet<_> = origins.iter().collect();
        assert_eq!(distinct.len(), OFFSETS as usize);
        for axis in 0..2 {
            // No border stays, and none is used much more than others.
            let columns: HashSet<_> = origins.iter().map(|origin| origin[axis]).collect();
            assert!(columns.len() >= 14, "{columns:?}");
            assert!(columns.iter().all(|column| (-31..=0).contains(column)));
        }
        assert_eq!(block_origin(OFFSETS), block_origin(0));
    }

    #[test]
    fn the_parameters_are_laid_out_as_in_the_shader() {
        use std::mem::offset_of;
        let module = crate::shader_check::validated(&shaders::source("bmfr_fit"));
        let fields = [
            ("position_per_depth", offset_of!(BlockParams, position_per_depth)),
            ("position_constant", offset_of!(BlockParams, position_constant)),
            ("origin", offset_of!(BlockParams, origin)),
            ("pad", offset_of!(BlockParams, pad)),
        ];
        crate::shader_check::assert_layout(&module, "Blocks", &fields, size_of::<BlockParams>());
    }
}
