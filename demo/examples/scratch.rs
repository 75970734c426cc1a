use quell_demo::{gpu::Gpu, method::*, walk::*};
use std::time::Instant;
fn main() {
    let gpu = Gpu::new().unwrap();
    let scene = std::env::args().nth(1).filter(|s| s != "gallery").map(Into::into);
    let walk = Walk::new(&gpu, WalkOptions { scene, width: 320, height: 180, frames: 8, fps: 30.0, start_s: 0.0, spp: 1, seed: 0 }).unwrap();
    let settings = quell::Settings::default();
    let mut q = MethodRunner::new(&gpu, Method::Quell, 320, 180).unwrap();
    let mut a = MethodRunner::new(&gpu, Method::Accumulate, 320, 180).unwrap();
    let wait = || gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    for i in 0..8 {
        let t = Instant::now();
        let mut e = gpu.device.create_command_encoder(&Default::default());
        walk.trace(&gpu, &mut e, i, None);
        gpu.queue.submit([e.finish()]); wait();
        let t1 = t.elapsed(); let t = Instant::now();
        let mut e = gpu.device.create_command_encoder(&Default::default());
        q.encode(&gpu, &mut e, &MethodFrame::new(walk.gbuffer(), walk.view(i).camera, i == 0, &settings)).unwrap();
        gpu.queue.submit([e.finish()]); wait();
        let t2 = t.elapsed(); let t = Instant::now();
        let mut e = gpu.device.create_command_encoder(&Default::default());
        a.encode(&gpu, &mut e, &MethodFrame::new(walk.gbuffer(), walk.view(i).camera, i == 0, &settings)).unwrap();
        gpu.queue.submit([e.finish()]); wait();
        println!("trace {t1:?} quell {t2:?} accumulate {:?}", t.elapsed());
    }
}
