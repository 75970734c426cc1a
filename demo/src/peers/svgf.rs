//! SVGF: Schied et al., "Spatiotemporal Variance-Guided Filtering: Real-Time Reconstruction for Path-Traced Global
//! Illumination" (HPG 2017).
//!
//! On illumination without albedo (section 3): temporal accumulation of colour and moments (4.1), variance (4.2), and
//! five levels of an edge-avoiding wavelet filter (4.3, 4.4), of which the first one's result is the colour history of
//! the next frame.
//!
//! Beyond the paper: surface ids stop the filter as they stop reprojection, and a pixel without a sample takes its
//! colour from its neighbours.

use super::frame::{FrameUniform, PeerFrame};
use super::{allocations, shaders, views};
use crate::compute::{Binding, Pass, timestamp_writes};
use crate::gbuffer::{GBuffer, image};
use crate::gpu::Gpu;
use quell::{Allocation, Timestamps};
use wgpu::TextureFormat::{Rg32Uint, Rgba16Float};

/// Section 4.3: levels of the wavelet filter.
const LEVELS: usize = 5;

/// What is known of a pixel over time besides its colour.
#[derive(Debug)]
struct History {
    /// Moments of luminance, slope of depth, length of history.
    state: wgpu::TextureView,
    surface: wgpu::TextureView,
}

/// Pipelines and history.
#[derive(Debug)]
pub struct Svgf {
    temporal: Pass,
    variance: Pass,
    /// The levels before the last, which [`compose`](Self::compose) is.
    atrous: [Pass; LEVELS - 1],
    compose: Pass,
    frame: FrameUniform,
    /// `[parity]` is written this frame, the other one read.
    history: [History; 2],
    parity: usize,
    /// Filtered by the first level: the colour of the next frame's history.
    color_history: wgpu::TextureView,
    /// Where the other steps' results go, in turn.
    scratch: [wgpu::TextureView; 2],
    output: wgpu::TextureView,
}

impl Svgf {
    pub const PASSES: [&str; 2 + LEVELS] = [
        "svgf temporal",
        "svgf variance",
        "svgf a-trous 1",
        "svgf a-trous 2",
        "svgf a-trous 3",
        "svgf a-trous 4",
        "svgf a-trous 5",
    ];

    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        use Binding::{Integers, Store, Texels, Uniform};
        let image = |label, format| image(device, label, [width, height], format);
        let history =
            || History { state: image("svgf state", Rg32Uint), surface: image("svgf surface", Rg32Uint) };
        let temporal = [
            Uniform,
            Texels,   // radiance
            Texels,   // albedo
            Texels,   // normal_roughness
            Texels,   // depth
            Texels,   // motion
            Integers, // surface_id
            Texels,   // emission
            Integers, // sample_count
            Texels,   // prev_color
            Integers, // prev_state
            Integers, // prev_surface
            Store(Rgba16Float),
            Store(Rg32Uint),
            Store(Rg32Uint),
        ];
        // Colour, state, surface.
        let spatial = [Uniform, Texels, Integers, Integers, Store(Rgba16Float)];
        let compose = [Uniform, Texels, Integers, Integers, Texels, Texels, Texels, Store(Rgba16Float)];
        let step = |level: usize| [("STEP", f64::from(1 << level))];
        Self {
            temporal: shaders::pass(device, "svgf_temporal", &temporal, &[]),
            variance: shaders::pass(device, "svgf_variance", &spatial, &[]),
            atrous: std::array::from_fn(|level| shaders::pass(device, "svgf_atrous", &spatial, &step(level))),
            compose: shaders::pass(device, "svgf_compose", &compose, &step(LEVELS - 1)),
            frame: FrameUniform::new(device),
            history: [history(), history()],
            parity: 0,
            color_history: image("svgf color history", Rgba16Float),
            scratch: [image("svgf scratch", Rgba16Float), image("svgf scratch", Rgba16Float)],
            output: image("svgf output", Rgba16Float),
        }
    }

    /// What it holds on the GPU besides its inputs and output.
    pub fn memory(&self) -> Vec<Allocation> {
        let History { state, surface } = &self.history[0];
        allocations(&[
            ("state", state, 2),
            ("surface", surface, 2),
            ("color history", &self.color_history, 1),
            ("scratch", &self.scratch[0], 2),
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
        self.parity ^= 1;
        let History { state, surface } = &self.history[self.parity];
        let previous = &self.history[self.parity ^ 1];
        let [a, b] = &self.scratch;
        let mut index = 0;
        let mut run = |pass: &Pass, images: &[&wgpu::TextureView]| {
            let resources = views(self.frame.binding(), images);
            let size = [gbuffer.width, gbuffer.height];
            pass.run(&gpu.device, encoder, &resources, size, timestamp_writes(timestamps, index));
            index += 1;
        };
        run(
            &self.temporal,
            &[
                &gbuffer.radiance,
                &gbuffer.albedo,
                &gbuffer.normal_roughness,
                &gbuffer.depth,
                &gbuffer.motion,
                &gbuffer.surface_id,
                &gbuffer.emission,
                &gbuffer.sample_count,
                &self.color_history,
                &previous.state,
                &previous.surface,
                a,
                state,
                surface,
            ],
        );
        run(&self.variance, &[a, state, surface, b]);
        // The first level's result is kept; those after it alternate.
        let [first, second, third, fourth] = &self.atrous;
        run(first, &[b, state, surface, &self.color_history]);
        run(second, &[&self.color_history, state, surface, a]);
        run(third, &[a, state, surface, b]);
        run(fourth, &[b, state, surface, a]);
        run(
            &self.compose,
            &[a, state, surface, &gbuffer.radiance, &gbuffer.albedo, &gbuffer.emission, &self.output],
        );
    }
}
