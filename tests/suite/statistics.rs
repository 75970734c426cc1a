//! What a frame says it came to.

use crate::gpu::gpu;
use crate::sequence::{denoiser, frame, submit};
use glam::Vec3;
use quell::layout::{LEVEL_STRIDES, count, tiles};
use quell::{Centres, Denoiser, HistoryMode, Settings, Statistics, Windows};

const SIZE: [u32; 2] = [90, 61];
const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);

/// Polls until the statistics of a frame are there. More than once: while other tests poll the same device, one of these may
/// be about to call back.
pub fn wait_for(quell: &mut Denoiser, frame: u32) -> Statistics {
    for _ in 0..1000 {
        gpu().device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        if let Some(found) = quell.statistics().filter(|found| found.frame == frame) {
            return found;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("no statistics of frame {frame}: {:?}", quell.statistics());
}

fn submit_frame(quell: &mut Denoiser, settings: &Settings) {
    let frame = frame(SIZE, EYE, EYE, 1);
    let images = frame.upload();
    submit(quell, &images.inputs(frame.camera, HistoryMode::Continue), settings);
}

fn statistics(settings: &Settings) -> Statistics {
    let mut quell = denoiser(SIZE);
    submit_frame(&mut quell, settings);
    wait_for(&mut quell, 0)
}

#[test]
fn they_arrive_after_the_frame_is_done() {
    let mut quell = denoiser(SIZE);
    assert_eq!(quell.statistics(), None);
    submit_frame(&mut quell, &Settings::default());
    let first = wait_for(&mut quell, 0);
    assert_eq!(quell.statistics(), Some(first), "they stay until newer ones arrive");
    (0..3).for_each(|_| submit_frame(&mut quell, &Settings::default()));
    wait_for(&mut quell, 3); // the newest of several
}

#[test]
fn they_count_the_models_of_each_level() {
    let all = count(tiles(SIZE)) as u32;
    let cells = |stride: u32| -> u32 {
        tiles(SIZE).map(|side| (side - stride / 2).div_ceil(stride)).into_iter().product()
    };
    let of = |centres| statistics(&Settings::default().with_centres(centres));
    let dense = of(Centres::Uniform(1));
    assert_eq!(dense.models_by_level, [0, 0, all]);
    for (level, stride) in [(0, 4), (1, 2)] {
        let uniform = of(Centres::Uniform(stride));
        let centres = cells(stride);
        assert_eq!(LEVEL_STRIDES[level], stride);
        assert_eq!(uniform.models_by_level[level], centres, "{stride}");
        assert_eq!(uniform.models(), centres + uniform.models_by_level[2], "{stride}");
        assert!(uniform.models_by_level[2] < centres, "{stride}: more holes than centres");
    }
    let adaptive = of(Centres::Adaptive);
    assert_eq!(adaptive.models_by_level[0], cells(4), "nothing covers the first level");
    assert!(adaptive.models() < all, "{adaptive:?}");
    assert!(adaptive.models_by_level[1..].iter().any(|&models| models > 0), "{adaptive:?}");
    assert_eq!(adaptive.models(), adaptive.models_by_level.iter().sum::<u32>());
    // Narrow windows cover less than the widest, whose tents alone reach further.
    let [narrow, wide] =
        [1, 3].map(|size| statistics(&Settings::default().with_windows(Windows::Fixed(size))));
    assert!(narrow.models() > wide.models(), "{narrow:?} {wide:?}");
}

/// Frames that were recorded and dropped, more of them than are kept in mind, leave the next ones' statistics alone.
#[test]
fn a_dropped_encoder_does_no_harm() {
    let frame = frame(SIZE, EYE, EYE, 1);
    let images = frame.upload();
    let inputs = images.inputs(frame.camera, HistoryMode::Continue);
    let mut quell = denoiser(SIZE);
    for dropped in 1..=10 {
        for _ in 0..dropped {
            let mut encoder = gpu().device.create_command_encoder(&Default::default());
            quell.encode(&gpu().device, &gpu().queue, &mut encoder, &inputs, &Settings::default()).unwrap();
        }
        submit_frame(&mut quell, &Settings::default());
        wait_for(&mut quell, (1..=dropped).sum::<u32>() + dropped - 1);
    }
}
