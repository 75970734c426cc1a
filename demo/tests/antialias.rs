//! Temporal antialiasing on frames made in code.

mod sequence;
mod synthetic;

use glam::{Mat4, Vec2};
use quell_demo::capture::{Frame, gbuffer_for, upload};
use quell_demo::gpu::Gpu;
use quell_demo::halton::jitter_px;
use quell_demo::image::ImageRgb;
use quell_demo::peers::{Antialias, PeerFrame};
use sequence::{gpu, rms, wall};
use synthetic::{FAR, noise};

const SIZE: u32 = 24;
/// Frames of the walk's jitter until it repeats.
const JITTERS: usize = 16;

/// Every frame's radiance, antialiased.
fn antialiased(gpu: &Gpu, frames: &[Frame], restarts: &[usize]) -> Vec<ImageRgb> {
    let mut antialias = Antialias::new(&gpu.device, SIZE, SIZE);
    let mut gbuffer = gbuffer_for(&gpu.device, &frames[0]);
    let output = |(i, frame): (usize, &Frame)| {
        upload(&gpu.device, &gpu.queue, frame, &mut gbuffer);
        let camera = quell::Camera {
            view_from_world: Mat4::IDENTITY,
            clip_from_view: glam::camera::rh::proj::directx::perspective(1.0, 1.0, 0.1, FAR),
            jitter_px: jitter_px(i as u32),
        };
        let peer_frame = PeerFrame { camera, restart: restarts.contains(&i), far: FAR, max_history: 32.0 };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        antialias.encode(gpu, &mut encoder, &gbuffer, &gbuffer.radiance, &peer_frame);
        gpu.queue.submit([encoder.finish()]);
        ImageRgb::read_back(gpu, antialias.output().texture()).unwrap()
    };
    frames.iter().enumerate().map(output).collect()
}

/// A wall with the value of `shade` where each pixel's sample lies.
fn jittered(index: usize, shade: impl Fn(Vec2) -> f32) -> Frame {
    let mut frame = wall(SIZE, SIZE);
    for (i, radiance) in frame.radiance.iter_mut().enumerate() {
        let pixel = Vec2::new((i as u32 % SIZE) as f32, (i as u32 / SIZE) as f32);
        *radiance = [shade(pixel + 0.5 + jitter_px(index as u32)); 3];
    }
    frame
}

fn tone(radiance: f32) -> f32 {
    radiance / (1.0 + radiance)
}

const DARK: f32 = 0.1;
const BRIGHT: f32 = 0.8;

/// 0 to 1: how far the tonemapped radiance is from dark to bright.
fn brightness(radiance: f32) -> f32 {
    (tone(radiance) - tone(DARK)) / (tone(BRIGHT) - tone(DARK))
}

/// Bright below a line through the image that rises by a fifth of a pixel per pixel.
fn below(place: Vec2) -> bool {
    place.y > 6.3 + 0.2 * place.x
}

/// Part of each pixel that is bright.
fn coverage(i: usize) -> f32 {
    const SIDE: u32 = 32;
    let pixel = Vec2::new((i as u32 % SIZE) as f32, (i as u32 / SIZE) as f32);
    let places = (0..SIDE * SIDE).map(|k| Vec2::new((k % SIDE) as f32 + 0.5, (k / SIDE) as f32 + 0.5));
    places.filter(|place| below(pixel + place / SIDE as f32)).count() as f32 / (SIDE * SIDE) as f32
}

/// Frames of the edge; its bright side is a surface of its own in front of the other.
fn edge() -> Vec<Frame> {
    let shaded = |i| {
        let mut frame = jittered(i, |place| if below(place) { BRIGHT } else { DARK });
        for (depth, radiance) in frame.depth.iter_mut().zip(&frame.radiance) {
            *depth = if radiance[0] == BRIGHT { 2.0 } else { 9.0 };
        }
        frame
    };
    (0..6 * JITTERS).map(shaded).collect()
}

#[test]
fn a_still_jittered_edge_converges_to_its_coverage() {
    let gpu = gpu();
    let frames = edge();
    let images = antialiased(&gpu, &frames, &[0]);
    let error = |image: &ImageRgb| {
        let toned = image.pixels.iter().map(|pixel| [brightness(pixel[0]); 3]).collect();
        rms(&ImageRgb { pixels: toned, ..*image }, |i| [coverage(i); 3])
    };
    let last = images.last().unwrap();
    let aliased = ImageRgb { pixels: frames[0].radiance.clone(), ..*last };
    let (before, after) = (error(&aliased), error(last));
    assert!(before > 0.05 && after < 0.2 * before, "{after}, {before} before");
    let on_edge = (0..last.pixels.len()).filter(|&i| (0.01..0.99).contains(&coverage(i)));
    for i in on_edge {
        // Over one turn of the jitter, recent frames count no more than others.
        let turn = &images[images.len() - JITTERS..];
        let mean = turn.iter().map(|image| brightness(image.pixels[i][0])).sum::<f32>() / JITTERS as f32;
        let pixel = Vec2::new((i as u32 % SIZE) as f32, (i as u32 / SIZE) as f32) + 0.5;
        let hits = (0..JITTERS as u32).filter(|&k| below(pixel + jitter_px(k))).count();
        let sampled = hits as f32 / JITTERS as f32;
        assert!((mean - sampled).abs() < 0.02, "pixel {i}: {mean} instead of {sampled}");
        // Sixteen places for all of a pixel.
        assert!((sampled - coverage(i)).abs() < 0.1, "pixel {i}: {sampled} for {}", coverage(i));
    }
    // The measure notices a line elsewhere.
    let shifted =
        error(&ImageRgb { pixels: last.pixels[1..].iter().chain([&[DARK; 3]]).copied().collect(), ..*last });
    assert!(shifted > 2.0 * after, "{shifted} {after}");
}

#[test]
fn a_constant_image_stays_as_it_is() {
    let gpu = gpu();
    for value in [0.0, 0.37, 20.0, 3000.0] {
        let frames: Vec<_> = (0..6).map(|i| jittered(i, |_| value)).collect();
        for pixel in antialiased(&gpu, &frames, &[0]).iter().flat_map(|image| &image.pixels) {
            // Half precision, of what is tonemapped to just below 1 at the end.
            assert!(pixel.iter().all(|v| (v - value).abs() <= 2e-3 * value), "{pixel:?} instead of {value}");
        }
    }
}

/// Left half, right half: what noise of one frame leaves in the next.
#[test]
fn history_is_used_where_it_showed_the_surface_and_nowhere_else() {
    let gpu = gpu();
    let noisy = |index: usize| {
        let mut frame = wall(SIZE, SIZE);
        for (i, radiance) in frame.radiance.iter_mut().enumerate() {
            *radiance = [0.2 + 0.6 * noise(index, i, 0); 3];
        }
        frame
    };
    let kept = |second: &Frame, restarts: &[usize]| {
        let last = antialiased(&gpu, &[noisy(0), second.clone()], restarts).pop().unwrap();
        // Per pixel, whether anything but the second frame is in it; half precision apart.
        let differs = last.pixels.iter().zip(&second.radiance).map(|(a, b)| (a[0] - b[0]).abs() > 2e-3);
        differs.collect::<Vec<_>>()
    };
    let share = |kept: &[bool], of: &dyn Fn(u32, u32) -> bool| {
        let chosen: Vec<bool> =
            (0..SIZE * SIZE).filter(|i| of(i % SIZE, i / SIZE)).map(|i| kept[i as usize]).collect();
        chosen.iter().filter(|&&kept| kept).count() as f32 / chosen.len() as f32
    };
    let all = |_, _| true;
    assert!(share(&kept(&noisy(1), &[0]), &all) > 0.9, "a still wall keeps its history");
    assert_eq!(share(&kept(&noisy(1), &[0, 1]), &all), 0.0, "a cut keeps nothing");

    // What stood in front of the left half is gone; the wall behind it was not seen before.
    let mut uncovered = noisy(1);
    let left = |x: u32, _| x < SIZE / 2;
    for (i, depth) in uncovered.depth.iter_mut().enumerate() {
        *depth *= if left(i as u32 % SIZE, 0) { 2.0 } else { 1.0 };
    }
    let kept_uncovered = kept(&uncovered, &[0]);
    // One pixel at the border sees both walls around it.
    assert_eq!(share(&kept_uncovered, &|x, _| x + 1 < SIZE / 2), 0.0);
    assert!(share(&kept_uncovered, &|x, y| !left(x, y)) > 0.9);

    // The same change of depth, but of a wall that moved away from the eye.
    uncovered.motion_depth = Some(uncovered.depth.iter().map(|depth| 4.0 - depth).collect());
    assert!(share(&kept(&uncovered, &[0]), &all) > 0.9);

    let mut from_outside = noisy(1);
    from_outside.motion.fill([SIZE as f32 / 2.0, 0.0]);
    let kept_outside = kept(&from_outside, &[0]);
    assert_eq!(share(&kept_outside, &|x, _| x >= SIZE / 2), 0.0, "there was no image");
    assert!(share(&kept_outside, &left) > 0.9);
}

/// The image moves by three pixels a frame; an edge that is averaged where it was would be a ramp.
#[test]
fn history_follows_the_motion() {
    let gpu = gpu();
    let moving = |right: bool| {
        let frame = |i: usize| {
            let mut frame = wall(SIZE, SIZE);
            for (p, radiance) in frame.radiance.iter_mut().enumerate() {
                // Stripes of four pixels.
                *radiance =
                    [if (p as u32 % SIZE + SIZE - 3 * i as u32).is_multiple_of(8) { BRIGHT } else { DARK };
                        3];
            }
            frame.motion.fill([if right { -3.0 } else { 0.0 }, 0.0]);
            frame
        };
        let frames: Vec<_> = (0..6).map(frame).collect();
        let last = antialiased(&gpu, &frames, &[0]).pop().unwrap();
        rms(&last, |p| frames[5].radiance[p])
    };
    let (followed, ignored) = (moving(true), moving(false));
    assert!(followed < 2e-3 && ignored > 0.02, "{followed} {ignored}");
}
