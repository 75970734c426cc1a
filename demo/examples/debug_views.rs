//! The debug views of one frame of a capture, as pictures, beside its reference where it has one; and what they look like when the caller gets something wrong.
//!
//! `cargo run --release -p quell-demo --example debug_views -- out/capture --frame 15 --out out/views [--wrong motion-direction]`

use anyhow::{Context, Result, ensure};
use clap::{Parser, ValueEnum};
use quell::{
    Conventions, DebugView, Denoiser, DenoiserDescriptor, FrameInputs, HistoryMode, MotionDirection,
    MotionUnit, NormalSpace, Pipelines, RequiredInputs, Settings,
};
use quell_demo::capture::{CaptureReader, gbuffer_for, upload};
use quell_demo::gpu::Gpu;
use quell_demo::image::{ImageRgb, srgb_from_linear, write_png_rgb8};
use quell_demo::method::output_image;
use std::path::PathBuf;
use std::sync::Arc;

/// Write a frame's debug views as pictures
#[derive(Parser)]
struct Args {
    /// Folder of the capture
    capture: PathBuf,
    /// The frame that is shown; history begins with the first
    #[arg(long, default_value_t = 0)]
    frame: usize,
    /// Folder for `output.png`, `reference.png` and a picture per view
    #[arg(long)]
    out: PathBuf,
    /// Only these, e.g. Windows,MixWeight [default: all]
    #[arg(long, value_delimiter = ',')]
    views: Vec<String>,
    /// A mistake to make
    #[arg(long)]
    wrong: Option<Wrong>,
}

impl Args {
    fn views(&self) -> Result<Vec<DebugView>> {
        if self.views.is_empty() {
            return Ok(DebugView::ALL.to_vec());
        }
        let named = |name: &String| DebugView::ALL.into_iter().find(|view| format!("{view:?}") == *name);
        let find =
            |name| named(name).with_context(|| format!("no view `{name}`; there are {:?}", DebugView::ALL));
        self.views.iter().map(find).collect()
    }
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Wrong {
    /// Motion vectors are said to come from the previous frame
    MotionDirection,
    /// Motion vectors in pixels are said to be in UV
    MotionUnit,
    /// Motion vectors are all zero
    NoMotion,
    /// World-space normals are said to be in view space
    NormalSpace,
    /// Radiance that comes straight from emitters is not given apart
    NoEmission,
}

impl Wrong {
    fn conventions(wrong: Option<Self>) -> Conventions {
        let right = Conventions::default().with_motion_unit(MotionUnit::Pixels);
        match wrong {
            Some(Self::MotionDirection) => right.with_motion_direction(MotionDirection::FromPrevious),
            Some(Self::MotionUnit) => right.with_motion_unit(MotionUnit::Uv),
            Some(Self::NoMotion) => right.with_motion_unit(MotionUnit::Scaled([0.0; 2])),
            Some(Self::NormalSpace) => right.with_normal_space(NormalSpace::View),
            Some(Self::NoEmission) | None => right,
        }
    }
}

fn main() -> Result<()> {
    let args = Args::parse();
    let capture = CaptureReader::open(&args.capture)?;
    ensure!(args.frame < capture.len(), "the capture has {} frames", capture.len());
    std::fs::create_dir_all(&args.out).with_context(|| format!("{}", args.out.display()))?;
    let gpu = Gpu::new()?;
    let header = *capture.header();
    let (width, height) = (header.width, header.height);
    let settings = Settings::default().with_far(header.far).with_conventions(Wrong::conventions(args.wrong));
    let pipelines = Arc::new(Pipelines::new(&gpu.device)?);
    let views = args.views()?;
    // A denoiser for each view: a frame has one.
    let descriptor = DenoiserDescriptor::new(width, height);
    let mut denoisers = views
        .iter()
        .map(|_| Denoiser::with_pipelines(&gpu.device, &descriptor, Arc::clone(&pipelines)))
        .collect::<Result<Vec<_>, _>>()?;
    let [output, debug] = [0; 2].map(|_| output_image(&gpu.device, width, height));
    let mut gbuffer = None;
    for i in 0..=args.frame {
        let frame = capture.read(i)?;
        let info = capture.info(i);
        let gbuffer = gbuffer.get_or_insert_with(|| gbuffer_for(&gpu.device, &frame));
        upload(&gpu.device, &gpu.queue, &frame, gbuffer);
        for (denoiser, view) in denoisers.iter_mut().zip(views.iter().copied()) {
            let inputs = FrameInputs::new(RequiredInputs {
                radiance: &gbuffer.radiance,
                albedo: &gbuffer.albedo,
                normal_roughness: &gbuffer.normal_roughness,
                depth: &gbuffer.depth,
                motion: &gbuffer.motion,
                output: &output,
                camera: info.camera(),
            })
            .with_history(if info.restart { HistoryMode::Restart } else { HistoryMode::Continue })
            .with_surface_id(&gbuffer.surface_id)
            .with_emission((args.wrong != Some(Wrong::NoEmission)).then_some(&gbuffer.emission))
            .with_debug((view, &debug));
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            denoiser.encode(&gpu.device, &gpu.queue, &mut encoder, &inputs, &settings)?;
            gpu.queue.submit([encoder.finish()]);
            if i == args.frame {
                let image = ImageRgb::read_back(&gpu, debug.texture())?;
                let path = args.out.join(format!("{view:?}.png"));
                if matches!(view, DebugView::Prediction | DebugView::TemporalMean) {
                    image.write_png(&path)?;
                } else {
                    let shown = image.pixels.iter().flatten().map(|&value| srgb_from_linear(value));
                    let rgb: Vec<u8> = shown.map(|value| (value * 255.0).round() as u8).collect();
                    write_png_rgb8(&path, width, height, &rgb)?;
                }
            }
        }
    }
    if let Some(reference) = capture.read(args.frame)?.reference_image() {
        reference.write_png(&args.out.join("reference.png"))?;
    }
    ImageRgb::read_back(&gpu, output.texture())?.write_png(&args.out.join("output.png"))?;
    Ok(())
}
