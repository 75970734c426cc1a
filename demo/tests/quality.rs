//! Quality on the path tracer's own frames: the gallery at one sample per pixel, against a converged trace.

use quell_demo::gbuffer::Split;
use quell_demo::gpu::Gpu;
use quell_demo::image::ImageRgb;
use quell_demo::method::{Method, MethodFrame, MethodRunner};
use quell_demo::metrics::{FrameMetrics, compare};
use quell_demo::tracer::Sampling;
use quell_demo::walk::{Walk, WalkOptions};

const FRAMES: u32 = 10;
/// The noise that is left in the reference is the same for all methods, and can only narrow what is between them.
const REFERENCE_SPP: u32 = 64;

#[test]
fn quell_and_the_peers_beat_accumulation_on_a_traced_walk() {
    let gpu =
        Gpu::new().expect("tests need a Vulkan driver; Mesa's works without a GPU (mesa-vulkan-drivers)");
    let options = WalkOptions {
        scene: None,
        width: 160,
        height: 90,
        frames: FRAMES,
        fps: 15.0,
        start_s: 0.0,
        spp: 1.0,
        sampling: Sampling::Uniform,
        seed: 0,
        jitter: false,
        split: Split::default(),
    };
    let walk = Walk::new(&gpu, options).unwrap();
    let settings = quell::Settings::default();
    let mut runners = [Method::None, Method::Accumulate, Method::Quell, Method::Svgf, Method::Bmfr]
        .map(|method| MethodRunner::new(&gpu, method, 160, 90).unwrap());
    for i in 0..FRAMES {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        walk.trace(&gpu, &mut encoder, i);
        let frame = MethodFrame::new(walk.gbuffer(), walk.view(i).camera, i == 0, &settings);
        for runner in &mut runners {
            runner.encode(&gpu, &mut encoder, &frame).unwrap();
        }
        gpu.queue.submit([encoder.finish()]);
    }
    let reference = walk.reference(&gpu, FRAMES - 1, REFERENCE_SPP, |_| {}).unwrap();
    let [none, accumulate, quell, svgf, bmfr] = runners.map(|runner| {
        let image = ImageRgb::read_back(&gpu, runner.output().texture()).unwrap();
        let metrics: FrameMetrics = compare(&image, &reference).unwrap();
        println!("{:<12} {:.2} dB, SSIM {:.4}", runner.method().name(), metrics.psnr_db, metrics.ssim);
        metrics
    });
    assert!(accumulate.psnr_db > none.psnr_db + 1.0, "the peer is one worth beating");
    assert!(quell.psnr_db > accumulate.psnr_db + 3.0);
    assert!(quell.ssim > accumulate.ssim);
    for peer in [svgf, bmfr] {
        assert!(peer.psnr_db > accumulate.psnr_db + 1.0 && peer.ssim > accumulate.ssim);
    }
}
