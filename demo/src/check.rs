//! Checking the inputs in a capture.

use crate::capture::{CaptureReader, gbuffer_for, upload};
use crate::gbuffer::GBuffer;
use crate::gpu::Gpu;
use anyhow::{Context, Result};
use clap::Args;
use quell::{
    Camera, Conventions, DenoiserDescriptor, Finding, FrameInputs, HistoryMode, InputCheck, MotionUnit,
    RequiredInputs, Settings, Untold,
};
use std::fmt::Write;
use std::path::PathBuf;

/// `quell-demo check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Folder of the capture (with capture.json in it)
    #[arg(value_name = "DIR")]
    pub capture: PathBuf,
    /// Also print the numbers behind it
    #[arg(long)]
    pub numbers: bool,
}

/// What a check came to.
#[derive(Debug)]
pub struct Checked {
    pub findings: Vec<Finding>,
    pub untold: Vec<Untold>,
    pub frames: usize,
    /// The numbers behind it, where wanted.
    pub numbers: Option<String>,
}

impl Checked {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for finding in &self.findings {
            let _ = writeln!(text, "{finding}");
        }
        if self.findings.is_empty() {
            let _ = writeln!(text, "nothing looks wrong in {} frames", self.frames);
        }
        if !self.untold.is_empty() {
            text += "could not be told:\n";
        }
        for untold in &self.untold {
            let _ = writeln!(text, "- {untold}");
        }
        text + self.numbers.as_deref().unwrap_or_default()
    }
}

/// Checks the inputs of all frames of a capture.
pub fn check(args: &CheckArgs) -> Result<Checked> {
    let capture = CaptureReader::open(&args.capture)?;
    let gpu = Gpu::new()?;
    let header = *capture.header();
    let descriptor = DenoiserDescriptor::new(header.width, header.height);
    let mut check = InputCheck::new(&gpu.device, &descriptor).context("cannot create the check")?;
    let mut gbuffer = None;
    for i in 0..capture.len() {
        let frame = capture.read(i)?;
        let info = capture.info(i);
        let gbuffer = gbuffer.get_or_insert_with(|| gbuffer_for(&gpu.device, &frame));
        upload(&gpu.device, &gpu.queue, &frame, gbuffer);
        let history = if info.restart { HistoryMode::Restart } else { HistoryMode::Continue };
        let given = Given {
            has_ids: frame.surface_id.is_some(),
            has_emission: frame.emission.is_some(),
            far: header.far,
            camera: info.camera(),
            history,
            conventions: conventions(),
        };
        check_frame(&gpu, &mut check, gbuffer, &given).with_context(|| format!("frame {i}"))?;
    }
    Ok(Checked {
        findings: check.findings(),
        untold: check.untold(),
        frames: capture.len(),
        numbers: args.numbers.then(|| check.evidence().to_string()),
    })
}

/// What of a frame is not in its images.
#[derive(Debug, Clone, Copy)]
pub struct Given {
    pub has_ids: bool,
    pub has_emission: bool,
    pub far: f32,
    pub camera: Camera,
    pub history: HistoryMode,
    /// What the numbers mean; [`conventions()`] of captures and of the tracer.
    pub conventions: Conventions,
}

/// What the numbers in captures, and in the tracer's images, mean.
pub fn conventions() -> Conventions {
    Conventions::default().with_motion_unit(MotionUnit::Pixels)
}

/// Checks one frame as quell would be given it, and waits for the result.
pub fn check_frame(gpu: &Gpu, check: &mut InputCheck, gbuffer: &GBuffer, given: &Given) -> Result<()> {
    let lobes = gbuffer.lobes.as_ref();
    let output = crate::method::output_image(&gpu.device, gbuffer.width, gbuffer.height);
    let inputs = FrameInputs::new(RequiredInputs {
        radiance: lobes.map_or(&gbuffer.radiance, |lobes| &lobes.rest),
        albedo: &gbuffer.albedo,
        normal_roughness: &gbuffer.normal_roughness,
        depth: &gbuffer.depth,
        motion: &gbuffer.motion,
        output: &output,
        camera: given.camera,
    })
    .with_history(given.history)
    .with_surface_id(given.has_ids.then_some(&gbuffer.surface_id))
    .with_emission(given.has_emission.then_some(&gbuffer.emission))
    .with_sample_count(&gbuffer.sample_count)
    .with_specular(lobes.map(|lobes| &lobes.specular))
    .with_specular_albedo(lobes.and(gbuffer.specular_albedo.as_ref()))
    .with_hit_distance(gbuffer.hit_distance.as_ref());
    let settings = Settings::default().with_conventions(given.conventions).with_far(given.far);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    check.encode(&gpu.device, &mut encoder, &inputs, &settings)?;
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(())
}
