//! Whole frames against the truth of an analytic scene, as ratios to plain accumulation in the same run.

use crate::gpu::{blank, gpu};
use crate::sequence::{Frame, denoiser, frame, psnr, read_output, submit, walk};
use glam::Vec3;
use quell::{DebugView, Denoiser, FrameInputs, HistoryMode, Settings};

const SIZE: [u32; 2] = [192, 108];
const WARM_UP: usize = 4;

/// The denoised frame, and what plain accumulation makes of the same samples: the temporal mean, modulated.
fn denoise_and_accumulate(
    quell: &mut Denoiser,
    frame: &Frame,
    settings: &Settings,
) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let images = frame.upload();
    let mean = blank(SIZE, wgpu::TextureFormat::Rgba16Float);
    let inputs = FrameInputs {
        debug: Some((DebugView::TemporalMean, &mean)),
        ..images.inputs(frame.camera, HistoryMode::Continue)
    };
    submit(quell, &inputs, settings);
    let accumulated = read_output(&mean).into_iter().enumerate().map(|(i, mean)| {
        let hit = frame.depth[i].is_finite();
        std::array::from_fn(|c| if hit { mean[c] * frame.albedo[i][c] } else { frame.truth[i][c] })
    });
    (read_output(&images.output), accumulated.collect())
}

/// PSNR of the cells of a 4x3 grid over the image.
fn regions(image: &[[f32; 3]], truth: &[[f32; 3]]) -> Vec<f64> {
    let [width, height] = SIZE.map(|side| side as usize);
    let cut = |image: &[[f32; 3]], column: usize, row: usize| -> Vec<[f32; 3]> {
        let rows = row * height / 3..(row + 1) * height / 3;
        let columns = column * width / 4..(column + 1) * width / 4;
        rows.flat_map(|y| image[y * width..][columns.clone()].to_vec()).collect()
    };
    (0..12).map(|i| psnr(&cut(image, i % 4, i / 4), &cut(truth, i % 4, i / 4))).collect()
}

#[test]
fn a_walk_is_better_than_plain_accumulation_everywhere() {
    let mut quell = denoiser(SIZE);
    let mut gains = vec![];
    let mut lowest = f64::INFINITY;
    for (i, frame) in walk(SIZE, 20, Vec3::new(0.01, 0.0, -0.02), 1).enumerate() {
        let (output, accumulated) = denoise_and_accumulate(&mut quell, &frame, &Settings::default());
        gains.push(psnr(&output, &frame.truth) - psnr(&accumulated, &frame.truth));
        if i >= WARM_UP {
            let pairs = regions(&output, &frame.truth).into_iter().zip(regions(&accumulated, &frame.truth));
            lowest = pairs.map(|(ours, theirs)| ours - theirs).fold(lowest, f64::min);
        }
    }
    let mean = gains.iter().sum::<f64>() / gains.len() as f64;
    println!("gain over accumulation: mean {mean:.2} dB, lowest region {lowest:.2} dB");
    assert!(mean > 6.0, "mean gain {mean:.2} dB");
    assert!(lowest > 0.0, "a region is worse than plain accumulation by {lowest:.2} dB");
}

/// On a still view the error keeps falling: where the models are wrong, the mean is trusted more and more.
#[test]
fn a_still_view_converges() {
    let mut quell = denoiser(SIZE);
    let settings = Settings { max_history: 1024.0, ..Settings::default() };
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut at = vec![];
    for i in 0..128 {
        let frame = frame(SIZE, eye, eye, 1000 + i);
        let (output, _) = denoise_and_accumulate(&mut quell, &frame, &settings);
        if [0, 7, 31, 127].contains(&i) {
            at.push(psnr(&output, &frame.truth));
        }
    }
    println!("still view after 1, 8, 32, 128 frames: {at:.2?} dB");
    assert!(at.is_sorted_by(|a, b| *b > *a + 1.0), "{at:?}");
}

/// Two ids that no other feature tells apart: the border between them stays sharp.
#[test]
fn light_does_not_bleed_between_surface_ids() {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut frame = frame(SIZE, eye, eye, 5);
    for i in 0..frame.id.len() {
        let left = i % (SIZE[0] as usize) < 91; // off the grids of tiles and centres
        let value = if left { 0.2 } else { 3.0 };
        frame.id[i] = if left { 17 } else { 42 };
        frame.albedo[i] = [1.0; 4];
        frame.normal[i] = [0.0, 0.0, 1.0, 1.0];
        frame.depth[i] = 5.0;
        frame.truth[i] = [value; 3];
        // Mean 1, with no pattern along rows or columns.
        let noise = if (i % SIZE[0] as usize + i / SIZE[0] as usize).is_multiple_of(3) { 2.0 } else { 0.5 };
        frame.radiance[i] = [value * noise, value * noise, value * noise, 1.0];
    }
    let mut quell = denoiser(SIZE);
    let (output, _) = denoise_and_accumulate(&mut quell, &frame, &Settings::default());
    // The mean of each column, so that noise does not hide a bleed.
    let [width, height] = SIZE.map(|side| side as usize);
    let ratio = |i: usize| output[i][0] / frame.truth[i][0];
    let error =
        |x: usize| ((0..height).map(|y| ratio(y * width + x)).sum::<f32>() / height as f32 - 1.0).abs();
    let worst = (80..102).map(error).fold(0.0, f32::max);
    println!("worst mean error of a column near a border of ids: {worst:.3}");
    assert!(worst < 0.1, "{worst}");
}

#[test]
fn the_gpu_is_the_one_the_suite_expects() {
    // WebGPU's defaults, no optional feature: the suite shows that the library needs no more.
    let (limits, defaults) = (gpu().device.limits(), wgpu::Limits::default());
    assert!(gpu().device.features().is_empty());
    assert_eq!(limits.max_storage_textures_per_shader_stage, defaults.max_storage_textures_per_shader_stage);
    assert_eq!(limits.max_storage_buffers_per_shader_stage, defaults.max_storage_buffers_per_shader_stage);
    assert_eq!(limits.max_storage_buffer_binding_size, defaults.max_storage_buffer_binding_size);
    assert_eq!(limits.max_compute_workgroup_storage_size, defaults.max_compute_workgroup_storage_size);
}
