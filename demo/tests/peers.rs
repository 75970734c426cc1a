//! The peers on images made in code, compared with what their papers state.

mod sequence;
mod synthetic;

use quell_demo::capture::{Frame, gbuffer_for, upload};
use quell_demo::image::ImageRgb;
use quell_demo::method::{Method, MethodFrame, MethodRunner};
use sequence::{Sequence, gpu, position, rms, wall};
use synthetic::{FAR, noise};

const PEERS: [Method; 2] = [Method::Svgf, Method::Bmfr];

fn assert_near(found: f32, expected: f32, tolerance: f32) {
    assert!((found - expected).abs() <= tolerance, "{found} for {expected}");
}

/// What light is multiplied by where it becomes radiance.
fn demodulator(albedo: f32) -> f32 {
    0.1 + 0.9 * albedo
}

fn grey(frame: &mut Frame, value: impl Fn(usize) -> f32) {
    for (i, radiance) in frame.radiance.iter_mut().enumerate() {
        *radiance = [value(i); 3];
    }
}

#[test]
fn constant_light_without_noise_comes_back_exactly() {
    let gpu = gpu();
    let mut frame = wall(40, 36);
    let emission = frame.emission.as_mut().unwrap();
    for (i, albedo) in frame.albedo.iter_mut().enumerate() {
        *albedo = [0, 1, 2].map(|c| 0.1 + 0.8 * noise(9, i, c));
        emission[i] = [0.0, 0.25, 0.0];
        frame.radiance[i] = [0, 1, 2].map(|c| 0.7 * demodulator(albedo[c]) + emission[i][c]);
    }
    let images = Sequence::of(&gpu, Method::Svgf).run(&vec![frame.clone(); 6]);
    for image in &images {
        for (found, expected) in image.pixels.iter().flatten().zip(frame.radiance.iter().flatten()) {
            assert_near(*found, *expected, 2e-3);
        }
    }
    // The last accumulation of BMFR is of a still image here.
    let images = Sequence::of(&gpu, Method::Bmfr).run(&vec![frame.clone(); 6]);
    for (found, expected) in images[5].pixels.iter().flatten().zip(frame.radiance.iter().flatten()) {
        assert_near(*found, *expected, 2e-3);
    }
}

#[test]
fn a_pixel_alone_is_accumulated_with_the_papers_weights() {
    let gpu = gpu();
    let samples: Vec<f32> = (0..12).map(|i| 0.5 + noise(i, 0, 0)).collect();
    let frames: Vec<Frame> = samples
        .iter()
        .map(|&sample| {
            let mut frame = wall(1, 1);
            grey(&mut frame, |_| 0.5 * sample);
            frame
        })
        .collect();
    let pixel = |image: &ImageRgb| image.pixels[0][1];
    for (restart, max_history) in [(0, 32.0), (7, 32.0), (0, 3.0), (0, 1.0)] {
        let sequence =
            |method| Sequence { restarts: vec![restart], max_history, ..Sequence::of(&gpu, method) };
        let (svgf, bmfr) = (sequence(Method::Svgf).run(&frames), sequence(Method::Bmfr).run(&frames));
        let (mut count, mut mean, mut of_fits) = (0.0, 0.0, 0.0);
        for (i, &sample) in samples.iter().enumerate() {
            count = if i == restart { 1.0 } else { f32::min(count + 1.0, max_history) };
            // SVGF: alpha = 0.2. BMFR: 0.2 before the fit, which is the mean here, and 0.1 after it.
            mean += (sample - mean) * f32::max(0.2, 1.0 / count);
            of_fits += (mean - of_fits) * f32::max(0.1, 1.0 / count);
            assert_near(pixel(&svgf[i]), 0.5 * mean, 2e-3);
            assert_near(pixel(&bmfr[i]), 0.5 * of_fits, 2e-3);
        }
    }
}

#[test]
fn svgf_keeps_what_does_not_vary_in_time_and_smooths_what_does() {
    let gpu = gpu();
    let truth = |i: usize| if (i % 20 / 2 + i / 40).is_multiple_of(2) { 0.1 } else { 0.5 };
    let mut still = wall(20, 16);
    grey(&mut still, truth);
    let image = Sequence::of(&gpu, Method::Svgf).run(&vec![still.clone(); 30]).pop().unwrap();
    assert!(rms(&image, |i| [truth(i); 3]) < 0.005, "a pattern without variance is kept");

    let frames: Vec<Frame> = (0..30)
        .map(|frame| {
            let mut noisy = wall(20, 16);
            grey(&mut noisy, |i| 0.6 * noise(frame, i, 0));
            noisy
        })
        .collect();
    let noisy = Sequence::of(&gpu, Method::Svgf).run(&frames).pop().unwrap();
    let accumulated = Sequence { max_history: 5.0, ..Sequence::of(&gpu, Method::Accumulate) };
    let accumulated = accumulated.run(&frames).pop().unwrap();
    let error = |image| rms(image, |_| [0.3; 3]);
    assert!(error(&noisy) < 0.25 * error(&accumulated), "{} {}", error(&noisy), error(&accumulated));
}

#[test]
fn svgf_stops_at_normals_depths_and_ids() {
    let gpu = gpu();
    let (width, height) = (24, 12);
    // Red noise on the left, green noise of the same luminance on the right.
    let frames = |edit: &dyn Fn(&mut Frame, usize)| -> Vec<Frame> {
        let edited = (0..3).map(|index| {
            let mut frame = wall(width, height);
            for i in 0..frame.radiance.len() {
                let left = (i as u32 % width) < width / 2;
                let light = noise(index, i, 0);
                frame.radiance[i] =
                    if left { [light / 0.2126, 0.0, 0.0] } else { [0.0, light / 0.7152, 0.0] };
                if left {
                    edit(&mut frame, i);
                }
            }
            frame
        });
        edited.collect()
    };
    let bleeding = |edit: &dyn Fn(&mut Frame, usize)| {
        let image = Sequence::of(&gpu, Method::Svgf).run(&frames(edit)).pop().unwrap();
        let pixels = image.pixels.iter().enumerate();
        let foreign = pixels.map(|(i, rgb)| rgb[usize::from((i as u32 % width) < width / 2)]);
        foreign.fold(0.0, f32::max)
    };
    assert!(bleeding(&|_, _| {}) > 0.1, "nothing stops it on one surface");
    // Far less than the 256th of a full range.
    let none = 1e-4;
    assert!(bleeding(&|frame, i| frame.normal[i] = [0.6, 0.0, 0.8]) < none);
    assert!(bleeding(&|frame, i| frame.depth[i] *= 1.1) < none);
    assert!(bleeding(&|frame, i| frame.surface_id.as_mut().unwrap()[i] += 1) < none);
}

/// The history of colour is what the first level makes of a frame: seen by a frame without samples whose normals all
/// differ by too much for the filter, and by little enough for reprojection.
#[test]
fn svgf_feeds_its_first_level_back() {
    let gpu = gpu();
    let mut first = wall(5, 1);
    grey(&mut first, |i| if i == 2 { 0.5 } else { 0.0 });
    let mut second = first.clone();
    second.samples = Some(vec![0; 5]);
    for (i, normal) in second.normal.iter_mut().enumerate() {
        let (tilt, azimuth) = (22f32.to_radians(), 72f32.to_radians() * i as f32);
        *normal = [tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos()];
    }
    let image = Sequence::of(&gpu, Method::Svgf).run(&[first, second]).pop().unwrap();
    // Sections 4.2 to 4.4 by hand. Albedo is 0.5, so that the impulse is 1; all five pixels are one surface.
    let impulse = [0.0, 0.0, 1.0, 0.0, 0.0f32];
    let deviation = (1.0f32 / 5.0 - 1.0 / 25.0).sqrt();
    let spline = |distance: usize| [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0, 0.0, 0.0][distance];
    for p in 0..5usize {
        let weight =
            |q: usize| spline(p.abs_diff(q)) * (-(impulse[p] - impulse[q]).abs() / (4.0 * deviation)).exp();
        let expected = weight(2) / (0..5).map(weight).sum::<f32>();
        assert_near(image.pixels[p][1], 0.5 * expected, 1e-3);
    }
}

#[test]
fn svgf_follows_motion_and_searches_for_thin_surfaces() {
    let gpu = gpu();
    let pattern = |i: usize, index: usize| 0.1 + 0.4 * noise(3, i % 24 + 12 - index, i / 24);
    let frames: Vec<Frame> = (0..12)
        .map(|index| {
            let mut frame = wall(24, 12);
            grey(&mut frame, |i| pattern(i, index));
            frame.motion.iter_mut().for_each(|motion| *motion = [-1.0, 0.0]);
            frame
        })
        .collect();
    let image = Sequence::of(&gpu, Method::Svgf).run(&frames).pop().unwrap();
    for i in (0..24 * 12).filter(|i| i % 24 >= 22) {
        // On screen for all frames: no variance, so that nothing is smoothed.
        assert_near(image.pixels[i][0], pattern(i, 11), 0.04);
    }
    let thin: Vec<Frame> = [0.2, 0.4]
        .map(|value| {
            let mut frame = wall(11, 1);
            frame.surface_id.as_mut().unwrap()[5] = 99;
            frame.motion = vec![[-1.0, 0.0]; 11];
            grey(&mut frame, |_| value);
            frame
        })
        .into();
    // The motion misses the surface by a pixel: found in the 3x3 pixels around, section 4.1.
    let image = Sequence::of(&gpu, Method::Svgf).run(&thin).pop().unwrap();
    assert_near(image.pixels[5][0], 0.3, 1e-3);
}

#[test]
fn errors_fall_over_frames_of_a_still_noisy_view() {
    let gpu = gpu();
    let truth = |i: usize| 0.3 + 0.2 * (i % 48) as f32 / 48.0;
    let frames: Vec<Frame> = (0..16)
        .map(|index| {
            let mut frame = wall(48, 40);
            // Rare bright samples, as a path tracer's.
            grey(&mut frame, |i| if noise(index, i, 1) < 0.25 { 4.0 * truth(i) } else { 0.0 });
            frame
        })
        .collect();
    for method in PEERS {
        let images = Sequence::of(&gpu, method).run(&frames);
        let errors: Vec<f32> = [0, 3, 15].map(|i| rms(&images[i], |i| [truth(i); 3])).into();
        println!("{}: {errors:?}", method.name());
        assert!(errors[1] < 0.75 * errors[0] && errors[2] < errors[1], "{errors:?}");
        let accumulated = Sequence::of(&gpu, Method::Accumulate).run(&frames);
        assert!(errors[2] < 0.3 * rms(&accumulated[15], |i| [truth(i); 3]));
    }
}

/// A view of two by two blocks whose light is of the first and second order in the features, everywhere the same.
fn polynomial(amplitude: f32) -> (Frame, Vec<[f32; 3]>) {
    let mut frame = wall(64, 64);
    frame.albedo.fill([1.0; 3]); // radiance is the signal, without rounding
    let mut truth = Vec::new();
    for i in 0..frame.radiance.len() {
        let (x, y) = ((i % 64) as f32, (i / 64) as f32);
        frame.depth[i] = 4.0 + 0.5 * (0.3 * x).sin() + 0.02 * y;
        let tilt = [0.4 * (0.11 * x + 0.23 * y).sin(), 0.3 * (0.35 * y).cos()];
        frame.normal[i] = [tilt[0], tilt[1], (1.0 - tilt[0] * tilt[0] - tilt[1] * tilt[1]).sqrt()];
        let (n, p) = (frame.normal[i], position(&frame, i));
        let light = [
            2.0 + n[0] - 0.5 * n[1] + 0.4 * n[2],
            1.5 + 0.3 * p[0] - 0.2 * p[1] + 0.1 * p[2],
            1.0 + 0.2 * p[0] * p[0] + 0.3 * p[1] * p[1] - 0.02 * p[2] * p[2],
        ];
        truth.push(light.map(|light| 0.5 * light));
        frame.radiance[i] = [0, 1, 2].map(|c| 0.5 * (light[c] + amplitude * (2.0 * noise(0, i, c) - 1.0)));
    }
    (frame, truth)
}

#[test]
fn bmfr_reproduces_what_its_features_express() {
    let gpu = gpu();
    // Without history, so that every frame is one fit.
    let one_fit = Sequence { max_history: 1.0, ..Sequence::of(&gpu, Method::Bmfr) };
    let (frame, truth) = polynomial(0.0);
    for image in one_fit.run(&vec![frame; 4]) {
        for (&found, &truth) in image.pixels.iter().flatten().zip(truth.iter().flatten()) {
            // Four images of half precision lie between.
            assert_near(found, truth, 2e-3 * (1.0 + truth));
        }
    }
    let (frame, truth) = polynomial(0.5);
    let fitted = one_fit.run(&[frame]).pop().unwrap();
    let error = rms(&fitted, |i| truth[i]);
    // Ten coefficients from 1024 samples leave sqrt(10 / 1024) of the noise.
    let noise = 0.5 * 0.5 / 3f32.sqrt() * (10.0f32 / 1024.0).sqrt();
    assert!((0.7 * noise..1.2 * noise).contains(&error), "{error} for {noise}");
}

#[test]
fn bmfr_moves_its_blocks_from_frame_to_frame() {
    let gpu = gpu();
    // An edge of light that no feature knows.
    let mut frame = wall(80, 70);
    let [dark, bright] = [0.2, 1.0].map(|light| light * demodulator(0.5));
    grey(&mut frame, |i| if i % 80 > 31 { bright } else { dark });
    let one_fit = Sequence { max_history: 1.0, ..Sequence::of(&gpu, Method::Bmfr) };
    let images = one_fit.run(&vec![frame; 17]);
    for i in 1..16 {
        let difference = rms(&images[i], |pixel| images[i - 1].pixels[pixel]);
        assert!(difference > 0.003, "frame {i}: {difference}");
    }
    assert_eq!(images[16], images[0], "the sequence of offsets repeats");
    // Column 31 begins a block in the first frame, which thus has the edge exactly.
    assert_near(images[0].pixels[31][0], dark, 1e-3);
    assert_near(images[0].pixels[32][0], bright, 1e-3);
}

#[test]
fn bmfr_clamps_its_last_accumulation_to_the_neighbourhood() {
    let gpu = gpu();
    let (width, height) = (20usize, 15usize);
    // Emission goes past the other two accumulations.
    let emitting = |value: &dyn Fn(usize) -> f32| {
        let mut frame = wall(width as u32, height as u32);
        grey(&mut frame, value);
        frame.emission = Some(frame.radiance.clone());
        frame
    };
    let gradient = |i: usize| 0.1 + 0.01 * (i % width) as f32 + 0.02 * (i / width) as f32;
    let bright = emitting(&|_| 10.0);
    let image = Sequence::of(&gpu, Method::Bmfr).run(&[bright, emitting(&gradient)]).pop().unwrap();
    for (i, rgb) in image.pixels.iter().enumerate() {
        // The largest of 3x3 pixels is at most one to the right and below.
        assert!(rgb[1] <= gradient(i) + 0.03 + 1e-3, "{} of {}", rgb[1], gradient(i));
    }
    // What is within the bounds is averaged.
    let checker =
        |phase: usize| emitting(&move |i| if (i + i / width + phase).is_multiple_of(2) { 0.1 } else { 0.3 });
    let image = Sequence::of(&gpu, Method::Bmfr).run(&[checker(0), checker(1)]).pop().unwrap();
    let inner = image.pixels[7 * width + 7][1];
    // 0.2 of this frame and 0.8 of the last one, as shown by x / (1 + x).
    let (now, last) = if (7 * width + 7 + 7 + 1) % 2 == 0 { (0.1, 0.3) } else { (0.3, 0.1f32) };
    let toned = 0.2 * now / (1.0 + now) + 0.8 * last / (1.0 + last);
    assert_near(inner, toned / (1.0 - toned), 2e-3);
}

#[test]
fn pixels_without_a_usable_sample_are_filled_by_their_surface() {
    let gpu = gpu();
    let mut frame = wall(21, 13);
    grey(&mut frame, |_| 0.4);
    let holes = [0, 5 * 21 + 10, 12 * 21 + 20];
    for (i, invalid) in holes.into_iter().zip([f32::NAN, f32::INFINITY, 0.0]) {
        frame.radiance[i] = [0.4, invalid, 0.4];
    }
    frame.samples.as_mut().unwrap()[holes[2]] = 0;
    for method in PEERS {
        for image in Sequence::of(&gpu, method).run(&vec![frame.clone(); 3]) {
            for rgb in &image.pixels {
                assert!(rgb.iter().all(|&v| (v - 0.4).abs() < 2e-3), "{}: {rgb:?}", method.name());
            }
        }
    }
}

#[test]
fn every_size_and_every_input_gives_an_image_and_a_cut_begins_anew() {
    let gpu = gpu();
    for (width, height) in [(1, 1), (1, 2), (17, 9), (3, 70), (65, 33)] {
        let mut frames: Vec<Frame> = (0..5)
            .map(|index| {
                let mut frame = wall(width, height);
                for i in 0..frame.radiance.len() {
                    frame.radiance[i] = [0, 1, 2].map(|c| 3.0 * noise(index, i, c));
                    // One in eight is a miss.
                    if noise(7, i, 0) < 0.125 {
                        frame.depth[i] = [f32::INFINITY, f32::NAN, -4.0, 0.0, FAR][i % 5];
                        frame.normal[i] = [0.0; 3];
                    }
                }
                frame
            })
            .collect();
        for (i, radiance) in frames[1].radiance.iter_mut().enumerate() {
            radiance[i % 3] = [f32::NAN, f32::INFINITY, -1.0, f32::MAX][i % 4];
        }
        frames[2].motion.iter_mut().for_each(|motion| *motion = [f32::NAN, 1e30]);
        frames[2].normal.iter_mut().for_each(|normal| *normal = [f32::NAN; 3]);
        frames[3].albedo.iter_mut().for_each(|albedo| *albedo = [0.0, f32::NAN, 0.5]);
        for method in PEERS {
            let cut = Sequence { restarts: vec![4], ..Sequence::of(&gpu, method) };
            let images = cut.run(&frames);
            let valid = |rgb: &[f32; 3]| rgb.iter().all(|v| v.is_finite() && *v >= 0.0);
            assert!(images.iter().all(|image| image.pixels.iter().all(valid)), "{}", method.name());
            for (rgb, (radiance, depth)) in
                images[4].pixels.iter().zip(frames[4].radiance.iter().zip(&frames[4].depth))
            {
                if *depth != 4.0 {
                    (0..3).for_each(|c| assert_near(rgb[c], radiance[c], 2e-3));
                }
            }
            let anew = Sequence::of(&gpu, method).run(&frames[4..]);
            assert_eq!(images[4], anew[0], "{} after a cut, {width}x{height}", method.name());
        }
    }
}

#[test]
fn every_pass_is_timed_and_memory_is_as_documented() {
    let gpu = gpu();
    let frame = wall(32, 16);
    for (method, bytes_per_pixel) in [(Method::Svgf, 56), (Method::Bmfr, 88), (Method::Accumulate, 48)] {
        let mut runner = MethodRunner::new(&gpu, method, 32, 16).unwrap();
        let bytes: u64 = runner.memory().iter().map(|allocation| allocation.bytes).sum();
        assert_eq!(bytes, bytes_per_pixel * 32 * 16, "{}", method.name());

        let first_query = 4;
        let count = first_query + 2 * runner.passes().len() as u32;
        let query_set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: None,
            ty: wgpu::QueryType::Timestamp,
            count,
        });
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: u64::from(count) * 8,
                usage,
                mapped_at_creation: false,
            })
        };
        let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let readback = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let mut gbuffer = gbuffer_for(&gpu.device, &frame);
        upload(&gpu.device, &gpu.queue, &frame, &mut gbuffer);
        let settings = quell::Settings::default();
        let inputs = MethodFrame {
            timestamps: Some(quell::Timestamps { query_set: &query_set, first_query }),
            ..MethodFrame::new(&gbuffer, synthetic::info().camera(), true, &settings)
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        runner.encode(&gpu, &mut encoder, &inputs).unwrap();
        encoder.resolve_query_set(&query_set, first_query..count, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &readback, 0, u64::from(count - first_query) * 8);
        gpu.queue.submit([encoder.finish()]);
        readback.slice(..).map_async(wgpu::MapMode::Read, |result| result.unwrap());
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let bytes = readback.slice(..).get_mapped_range().unwrap();
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        let used = &ticks[..(count - first_query) as usize];
        assert!(used.iter().all(|&tick| tick > 0), "{}: {used:?}", method.name());
    }
}
