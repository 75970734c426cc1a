//! Stretches of the tour, recorded once and checked as they are or with a mistake in them.

use crate::mistakes::Injected;
use quell::{Conventions, HistoryMode, InputCheck};
use quell_demo::capture::{Frame, FrameInfo, download, gbuffer_for, upload};
use quell_demo::check::{Given, check_frame, conventions};
use quell_demo::gbuffer::Split;
use quell_demo::gpu::Gpu;
use quell_demo::tracer::Sampling;
use quell_demo::walk::{Walk, WalkOptions};
use std::sync::LazyLock;

pub static GPU: LazyLock<Gpu> = LazyLock::new(|| {
    Gpu::new().expect("tests need a Vulkan driver; Mesa's works without a GPU (mesa-vulkan-drivers)")
});

pub const SIZE: [u32; 2] = [160, 90];
const FRAMES: u32 = 8;

/// Consecutive frames and their cameras.
#[derive(Clone)]
pub struct Stretch {
    pub frames: Vec<(Frame, FrameInfo)>,
    /// What is said of their numbers.
    pub conventions: Conventions,
}

pub fn options(start_s: f32, jitter: bool) -> WalkOptions {
    WalkOptions {
        scene: None,
        width: SIZE[0],
        height: SIZE[1],
        frames: FRAMES,
        fps: 30.0,
        start_s,
        spp: 1.0,
        sampling: Sampling::Uniform,
        seed: 1,
        jitter,
        split: Split::Full,
    }
}

pub fn record(options: &WalkOptions) -> Stretch {
    let walk = Walk::new(&GPU, options.clone()).unwrap();
    let frame = |index| {
        let mut encoder = GPU.device.create_command_encoder(&Default::default());
        walk.trace(&GPU, &mut encoder, index);
        GPU.queue.submit([encoder.finish()]);
        let camera = walk.view(index).camera;
        let info = FrameInfo {
            view: camera.view_from_world,
            projection: camera.clip_from_view,
            jitter_px: camera.jitter_px,
            restart: walk.is_cut(index),
        };
        (download(&GPU, walk.gbuffer()).unwrap(), info)
    };
    Stretch { frames: (0..options.frames).map(frame).collect(), conventions: conventions() }
}

impl Stretch {
    pub fn check(&self, check: &mut InputCheck) {
        let mut gbuffer = gbuffer_for(&GPU.device, &self.frames[0].0);
        for (frame, info) in &self.frames {
            upload(&GPU.device, &GPU.queue, frame, &mut gbuffer);
            let history = if info.restart { HistoryMode::Restart } else { HistoryMode::Continue };
            let camera = info.camera();
            let given = Given {
                has_ids: true,
                has_emission: true,
                far: f32::INFINITY,
                camera,
                history,
                conventions: self.conventions,
            };
            check_frame(&GPU, check, &gbuffer, &given).unwrap();
        }
        // While another test polls the same device, it may be about to call back. Refused frames do not come.
        for _ in 0..50 {
            if check.frames() as usize == self.frames.len() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }

    /// Of each frame, with the cameras of it and the one before as they are right.
    pub fn inject(&mut self, mistake: &Injected) {
        let infos: Vec<FrameInfo> = self.frames.iter().map(|(_, info)| *info).collect();
        for (i, (frame, info)) in self.frames.iter_mut().enumerate() {
            (mistake.inject)(frame, info, &infos[i.saturating_sub(1)], i as u32);
        }
        // What comes before the first frame is not known, so it has not all mistakes.
        self.frames.remove(0);
        self.frames[0].1.restart = true;
    }
}
