//! Methods on synthetic frames, compared with what the mathematics says.

mod synthetic;

use quell::Settings;
use quell_demo::capture::{Frame, gbuffer_for, upload};
use quell_demo::gpu::Gpu;
use quell_demo::image::ImageRgb;
use quell_demo::method::{Method, MethodFrame, MethodRunner};
use synthetic::{FAR, HEIGHT, SKY, WIDTH, frame, info, split_frame};

fn gpu() -> Gpu {
    Gpu::new().expect("tests need a Vulkan driver; Mesa's works without a GPU (mesa-vulkan-drivers)")
}

/// Runs a method over frames, of which those listed in `restarts` are cuts; returns every output.
fn run(gpu: &Gpu, method: Method, frames: &[Frame], restarts: &[usize], max_history: f32) -> Vec<ImageRgb> {
    let mut runner = MethodRunner::new(gpu, method, WIDTH, HEIGHT).unwrap();
    let settings = Settings::default().with_far(FAR).with_max_history(max_history);
    let mut gbuffer = gbuffer_for(&gpu.device, &frames[0]);
    let output = |(i, frame): (usize, &Frame)| {
        upload(&gpu.device, &gpu.queue, frame, &mut gbuffer);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let inputs = MethodFrame::new(&gbuffer, info().camera(), restarts.contains(&i), &settings);
        let view = runner.encode(gpu, &mut encoder, &inputs).unwrap();
        gpu.queue.submit([encoder.finish()]);
        ImageRgb::read_back(gpu, view.texture()).unwrap()
    };
    frames.iter().enumerate().map(output).collect()
}

fn at(x: u32, y: u32) -> usize {
    (y * WIDTH + x) as usize
}

fn assert_pixel(found: [f32; 3], expected: [f32; 3]) {
    for c in 0..3 {
        // Half-precision output.
        assert!((found[c] - expected[c]).abs() <= 1e-3 * (1.0 + expected[c]), "{found:?} for {expected:?}");
    }
}

fn mean(frames: &[Frame], pixels: impl Iterator<Item = usize>) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for (frame, pixel) in frames.iter().zip(pixels) {
        for (sum, value) in sum.iter_mut().zip(frame.radiance[pixel]) {
            *sum += value / frames.len() as f32;
        }
    }
    sum
}

#[test]
fn accumulation_is_the_mean_along_the_motion() {
    let gpu = gpu();
    let frames: Vec<Frame> = (0..5).map(frame).collect();
    for with_z in [true, false] {
        let mut frames = frames.clone();
        if !with_z {
            frames.iter_mut().for_each(|frame| frame.motion_depth = None);
        }
        let last = run(&gpu, Method::Accumulate, &frames, &[0], 32.0).pop().unwrap();
        // The static plane, far from the patch.
        assert_pixel(last.pixels[at(20, 14)], mean(&frames, std::iter::repeat(at(20, 14))));
        // The patch moves by a pixel a frame. Without motion.Z its depth of 2 is where a static point would be.
        assert_pixel(last.pixels[at(10, 8)], mean(&frames, (0..5).map(|i| at(6 + i, 8))));
        // Plane that the patch has just uncovered: only this frame.
        assert_pixel(last.pixels[at(7, 8)], frames[4].radiance[at(7, 8)]);
        // Sky is passed through.
        assert_pixel(last.pixels[at(5, SKY - 1)], frames[4].radiance[at(5, SKY - 1)]);
    }
}

#[test]
fn history_is_bounded_and_dropped_by_a_cut() {
    let gpu = gpu();
    let frames: Vec<Frame> = (0..4).map(frame).collect();
    let pixel = at(20, 14);
    let out = run(&gpu, Method::Accumulate, &frames, &[0, 2], 32.0);
    assert_pixel(out[2].pixels[pixel], frames[2].radiance[pixel]);
    assert_pixel(out[3].pixels[pixel], mean(&frames[2..], std::iter::repeat(pixel)));
    // With a history of 2 each frame counts for a half.
    let out = run(&gpu, Method::Accumulate, &frames, &[], 2.0);
    let mut expected = frames[0].radiance[pixel];
    for frame in &frames[1..] {
        expected = [0, 1, 2].map(|c| 0.5 * (expected[c] + frame.radiance[pixel][c]));
    }
    assert_pixel(out[3].pixels[pixel], expected);
}

#[test]
fn invalid_radiance_is_repaired_and_untraced_pixels_keep_their_history() {
    let gpu = gpu();
    let mut frames: Vec<Frame> = (0..3).map(frame).collect();
    let (invalid, untraced) = (at(20, 14), at(21, 14));
    frames[1].radiance[invalid] = [f32::NAN, f32::INFINITY, -5.0];
    frames[2].samples.as_mut().unwrap()[untraced] = 0;
    frames[2].radiance[untraced] = [f32::NAN; 3];
    for method in [Method::None, Method::Accumulate] {
        for (out, frame) in run(&gpu, method, &frames, &[], 32.0).iter().zip(&frames) {
            assert!(out.pixels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
            if method == Method::None {
                assert_pixel(out.pixels[at(3, 13)], frame.radiance[at(3, 13)]);
            }
        }
    }
    let out = run(&gpu, Method::None, &frames, &[], 32.0);
    assert_pixel(out[1].pixels[invalid], [0.0; 3]);
    let out = run(&gpu, Method::Accumulate, &frames, &[], 32.0);
    assert_pixel(out[2].pixels[untraced], mean(&frames[..2], std::iter::repeat(untraced)));
}

#[test]
fn all_but_quell_get_the_sum_of_a_split_frame() {
    let gpu = gpu();
    // Parts that sum to a frame's radiance to the last bit.
    let frames: Vec<Frame> = (0..3).map(split_frame).collect();
    let whole: Vec<Frame> =
        (0..3).map(|i| Frame { radiance: frames[i].combined_radiance(), ..frame(i) }).collect();
    for method in [Method::None, Method::Accumulate, Method::Svgf, Method::Bmfr] {
        let [split, whole] = [&frames, &whole].map(|frames| run(&gpu, method, frames, &[0], 32.0));
        assert_eq!(split, whole, "{}", method.name());
    }
    let [split, whole] = [&frames, &whole].map(|frames| run(&gpu, Method::Quell, frames, &[0], 32.0));
    assert_ne!(split, whole, "quell gets the two apart");
}
