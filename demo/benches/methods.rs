//! One frame of each method from submission until done, small enough for a CPU adapter: shows that a change made one slower.
//! For comparisons and for times of passes see `quell-demo bench`.

use clap::ValueEnum;
use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use quell::Settings;
use quell_demo::gpu::Gpu;
use quell_demo::method::{Method, MethodFrame, MethodRunner};
use quell_demo::walk::{Walk, WalkOptions};
use std::time::Duration;

const SIZE: [u32; 2] = [320, 180];

/// Records, submits and waits.
fn run(gpu: &Gpu, record: impl FnOnce(&mut wgpu::CommandEncoder)) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("the GPU must not get lost");
}

/// A still view traced once: what a method costs does not depend on where history comes from.
fn methods(criterion: &mut Criterion) {
    let gpu = Gpu::new().expect("a benchmark needs an adapter");
    let [width, height] = SIZE;
    let options =
        WalkOptions { scene: None, width, height, frames: 1, fps: 30.0, start_s: 0.0, spp: 1, seed: 0 };
    let walk = Walk::new(&gpu, options).expect("the gallery is built in");
    run(&gpu, |encoder| walk.trace(&gpu, encoder, 0));
    let settings = Settings::default();
    let camera = walk.view(0).camera;

    let mut group = criterion.benchmark_group(format!("{width}x{height}"));
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(4));
    for &method in Method::value_variants().iter().filter(|&&method| method != Method::None) {
        let mut runner = MethodRunner::new(&gpu, method, width, height).expect("a small size");
        let mut frame = |restart| {
            let frame = MethodFrame::new(walk.gbuffer(), camera, restart, &settings);
            run(&gpu, |encoder| {
                runner.encode(&gpu, encoder, &frame).expect("a valid frame");
            });
        };
        frame(true);
        group.bench_function(method.name(), |bencher| bencher.iter(|| frame(false)));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().without_plots();
    targets = methods
}
criterion_main!(benches);
