//! One frame of each method from recording until done, small enough for a CPU adapter: shows that a change made one slower.
//! For comparisons of methods and for times of passes see `quell-demo bench`.

use clap::ValueEnum;
use divan::Bencher;
use quell::Settings;
use quell_demo::gbuffer::Split;
use quell_demo::gpu::Gpu;
use quell_demo::method::{Method, MethodFrame, MethodRunner};
use quell_demo::tracer::Sampling;
use quell_demo::walk::{Walk, WalkOptions};
use std::sync::LazyLock;

const SIZE: [u32; 2] = [320, 180];
/// Frames before the timed ones: pipelines compile in the first, and history fills.
const WARM_UP: u32 = 8;

static WALK: LazyLock<(Gpu, Walk)> = LazyLock::new(|| {
    let gpu = Gpu::new().expect("a benchmark needs an adapter");
    let [width, height] = SIZE;
    let options = WalkOptions {
        scene: None,
        width,
        height,
        frames: 1,
        fps: 30.0,
        start_s: 0.0,
        spp: 1.0,
        sampling: Sampling::Uniform,
        seed: 0,
        jitter: false,
        split: Split::default(),
    };
    let walk = Walk::new(&gpu, options).expect("the gallery is built in");
    (gpu, walk)
});

fn main() {
    divan::main();
}

/// Records, submits and waits.
fn run(gpu: &Gpu, record: impl FnOnce(&mut wgpu::CommandEncoder)) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("the GPU must not get lost");
}

fn timed_methods() -> impl Iterator<Item = &'static str> {
    Method::value_variants().iter().filter(|&&method| method != Method::None).map(|method| method.name())
}

#[divan::bench(args = timed_methods(), sample_count = 20, sample_size = 1, max_time = 5, skip_ext_time)]
fn frame(bencher: Bencher<'_, '_>, method: &str) {
    let (gpu, walk) = &*WALK;
    let method = Method::from_str(method, false).expect("the name of a method");
    let mut runner = MethodRunner::new(gpu, method, SIZE[0], SIZE[1]).expect("a small size");
    let settings = Settings::default();
    let mut denoise = |index: u32| {
        let frame = MethodFrame::new(walk.gbuffer(), walk.view(index).camera, index == 0, &settings);
        run(gpu, |encoder| {
            runner.encode(gpu, encoder, &frame).expect("a valid frame");
        });
    };
    let mut frames = 0..;
    let mut trace = || {
        let index = frames.next().expect("an endless walk");
        run(gpu, |encoder| walk.trace(gpu, encoder, index));
        index
    };
    (0..WARM_UP).for_each(|_| denoise(trace()));
    // Inputs are not timed.
    bencher.with_inputs(trace).bench_local_values(denoise);
}
