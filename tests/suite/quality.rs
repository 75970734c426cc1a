//! Whole frames against the truth of an analytic scene, as ratios to plain accumulation in the same run.

use crate::gpu::{blank, gpu};
use crate::sequence::{Frame, denoiser, frame, psnr, read_output, submit, walk};
use glam::Vec3;
use quell::{DebugView, Denoiser, HistoryMode, Settings};

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
    let inputs =
        images.inputs(frame.camera, HistoryMode::Continue).with_debug((DebugView::TemporalMean, &mean));
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

/// What only the first frame saw, of which nobody knew how samples scatter, is noise like any other.
#[test]
fn a_firefly_of_the_first_frame_leaves_no_speck() {
    let [width, height] = SIZE.map(|side| side as usize);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let last = |firefly: f32| {
        let mut quell = denoiser(SIZE);
        let mut output = vec![];
        for i in 0..8 {
            let mut frame = frame(SIZE, eye, eye, 60 + i);
            // Two neighbours in every square of 24 pixels.
            let places = (0..width * height).filter(|p| p % width % 24 < 2 && p / width % 24 == 0 && i == 0);
            places.for_each(|p| frame.radiance[p] = frame.radiance[p].map(|c| firefly * c));
            output = denoise_and_accumulate(&mut quell, &frame, &Settings::default()).0;
        }
        (output, frame(SIZE, eye, eye, 0).truth)
    };
    let ((without, truth), (with, _)) = (last(1.0), last(50.0));
    let loss = psnr(&without, &truth) - psnr(&with, &truth);
    println!("fireflies cost {loss:.2} dB");
    assert!(loss < 1.0, "fireflies of the first of eight frames cost {loss:.2} dB");
}

/// On a still view the error keeps falling: where the models are wrong, the mean is trusted more and more.
#[test]
fn a_still_view_converges() {
    let mut quell = denoiser(SIZE);
    let settings = Settings::default().with_max_history(1024.0);
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

/// The mean of `spp` frames' samples as one frame.
fn many_samples(spp: u32, seed: u64) -> Frame {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut sum = frame(SIZE, eye, eye, seed);
    for i in 1..u64::from(spp) {
        let more = frame(SIZE, eye, eye, seed + i);
        sum.radiance.iter_mut().flatten().zip(more.radiance.iter().flatten()).for_each(|(s, m)| *s += m);
    }
    sum.radiance.iter_mut().flatten().for_each(|s| *s /= spp as f32);
    sum.samples.fill(spp);
    sum
}

/// More samples are never worse, in the first frame (where all history a pixel has is this frame's) and later.
#[test]
fn more_samples_per_pixel_are_better() {
    let quality = |spp: u32| {
        let mut quell = denoiser(SIZE);
        [1000, 2000].map(|seed| {
            let frame = many_samples(spp, seed);
            psnr(&denoise_and_accumulate(&mut quell, &frame, &Settings::default()).0, &frame.truth)
        })
    };
    let found = [1, 3, 4, 8].map(quality);
    println!("first and second frame at 1, 3, 4, 8 spp: {found:.2?} dB");
    assert!(found.is_sorted_by(|fewer, more| more[0] > fewer[0] && more[1] > fewer[1]), "{found:?}");
}

/// Without memory every frame is a first one: the tenth is as good as the first.
#[test]
fn a_history_of_one_is_a_frame_on_its_own() {
    let mut quell = denoiser(SIZE);
    let settings = Settings::default().with_max_history(1.0);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let quality: Vec<f64> = (0..10)
        .map(|seed| {
            let frame = frame(SIZE, eye, eye, seed);
            psnr(&denoise_and_accumulate(&mut quell, &frame, &settings).0, &frame.truth)
        })
        .collect();
    assert!((quality[9] - quality[0]).abs() < 1.0, "{quality:.2?}");
}

/// Checkerboard sampling: half the pixels in each frame, in turn. Noise must not pass for detail.
#[test]
fn a_checkerboard_of_samples_is_denoised_as_well_as_half_the_frames() {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let (mut board, mut whole) = (denoiser(SIZE), denoiser(SIZE));
    let mut last = (0.0, 0.0);
    for i in 0..16 {
        let mut sparse = frame(SIZE, eye, eye, 100 + i);
        for (p, samples) in sparse.samples.iter_mut().enumerate() {
            let (x, y) = (p % SIZE[0] as usize, p / SIZE[0] as usize);
            *samples = u32::from((x + y + i as usize).is_multiple_of(2));
        }
        last.0 = psnr(&denoise_and_accumulate(&mut board, &sparse, &Settings::default()).0, &sparse.truth);
        if i % 2 == 0 {
            let full = frame(SIZE, eye, eye, 200 + i);
            last.1 = psnr(&denoise_and_accumulate(&mut whole, &full, &Settings::default()).0, &full.truth);
        }
    }
    println!("16 checkerboards {:.2} dB, 8 whole frames {:.2} dB", last.0, last.1);
    assert!(last.0 > last.1 - 1.0, "{last:?}");
}

/// While the camera moves, history is resampled far more often than it gets samples: noise that blurs must not pass for light that
/// the models do not know.
#[test]
fn few_samples_are_not_mistaken_for_detail() {
    let alone = Settings::default().with_mix_temporal_mean(false);
    let (mut mixed, mut models) = (denoiser(SIZE), denoiser(SIZE));
    let mut last = (0.0, 0.0);
    for (i, mut sparse) in walk(SIZE, 24, Vec3::new(0.013, 0.0, -0.01), 300).enumerate() {
        for (p, samples) in sparse.samples.iter_mut().enumerate() {
            let (x, y) = (p % SIZE[0] as usize, p / SIZE[0] as usize);
            let turn = (0.754_877 * x as f64 + 0.569_840 * y as f64 + 0.618_034 * i as f64).fract();
            *samples = u32::from(turn > 0.75);
        }
        // The walls, which no shadow falls on.
        let of_walls = |image: &[[f32; 3]]| -> Vec<[f32; 3]> {
            let pixels = image.iter().zip(&sparse.id);
            pixels.filter(|&(_, &id)| id > 1).map(|(pixel, _)| *pixel).collect()
        };
        let measure = |denoiser: &mut Denoiser, settings: &Settings| {
            let output = denoise_and_accumulate(denoiser, &sparse, settings).0;
            psnr(&of_walls(&output), &of_walls(&sparse.truth))
        };
        last = (measure(&mut mixed, &Settings::default()), measure(&mut models, &alone));
    }
    println!("a quarter of a sample per pixel: {:.2} dB, models alone {:.2} dB", last.0, last.1);
    assert!(last.0 > last.1 - 0.3, "{last:?}");
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
