//! What real applications do to a denoiser: odd sizes, broken pixels, cuts, resizes, wrong images.

use crate::gpu::{blank, gpu, upload};
use crate::sequence::{
    Frame, denoise, denoiser, frame, jittered_frame, psnr, read_output, submit, walk, with,
};
use glam::{Mat4, Vec2, Vec3, camera::rh};
use quell::{
    Budget, Camera, Centres, Conventions, CreateError, DebugView, Denoiser, DenoiserDescriptor, FrameError,
    FrameInputs, HistoryMode, MotionUnit, Settings, Windows,
};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);
const SIZE: [u32; 2] = [64, 48];

fn assert_sound(output: &[[f32; 3]]) {
    assert!(output.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "NaN, infinite or negative output");
}

#[test]
fn odd_sizes_work() {
    for size in [[1, 1], [1, 2], [2, 1], [17, 9], [191, 347]] {
        let mut quell = denoiser(size);
        for frame in walk(size, 3, Vec3::new(0.02, 0.0, 0.0), 3) {
            let output = denoise(&mut quell, &frame, &Settings::default());
            assert_eq!(output.len(), (size[0] * size[1]) as usize);
            assert_sound(&output);
        }
    }
}

#[test]
fn all_ways_to_place_and_fit_models_work_at_odd_sizes() {
    let windows = [Windows::RingError, Windows::MallowsCp, Windows::Fixed(1), Windows::Fixed(3)];
    let centres = [Centres::Adaptive, Centres::Uniform(1), Centres::Uniform(2), Centres::Uniform(4)];
    let pairs = windows.into_iter().flat_map(|w| centres.into_iter().map(move |c| (w, c)));
    for (i, (windows, centres)) in pairs.enumerate() {
        for size in [[1, 1], [17, 9], [61, 43]] {
            let mut quell = denoiser(size);
            let innovation = i % 2 == 0;
            let firefly_limit = if i % 3 == 0 { 3.0 } else { f32::INFINITY };
            let settings = Settings::default()
                .with_windows(windows)
                .with_centres(centres)
                .with_innovation(innovation)
                .with_firefly_limit(firefly_limit);
            let frames = walk(size, 3, Vec3::new(0.02, 0.0, 0.0), 3);
            let (mut last, mut truth) = (vec![], vec![]);
            for frame in frames {
                last = denoise(&mut quell, &frame, &settings);
                assert_sound(&last);
                truth = frame.truth;
            }
            let quality = psnr(&last, &truth);
            assert!(size == [1, 1] || quality > 20.0, "{size:?} {windows:?} {centres:?}: {quality:.1} dB");
        }
    }
}

#[test]
fn an_empty_size_is_refused() {
    for (width, height) in [(0, 0), (0, 5), (5, 0)] {
        let error = Denoiser::new(&gpu().device, &DenoiserDescriptor::new(width, height)).unwrap_err();
        assert_eq!(error, CreateError::EmptySize { width, height });
    }
}

#[test]
fn a_size_beyond_the_device_names_limit_need_and_what_there_is() {
    let descriptor = DenoiserDescriptor::new(20_000, 4);
    let message = Denoiser::new(&gpu().device, &descriptor).unwrap_err().to_string();
    for part in ["max_texture_dimension_2d", "8192", "20000"] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn the_largest_promised_size_fits_default_limits() {
    assert!(Denoiser::new(&gpu().device, &DenoiserDescriptor::new(3840, 2160)).is_ok());
}

/// NaN, infinite and negative radiance are repaired and never poison history.
#[test]
fn broken_pixels_are_repaired_and_forgotten() {
    let clean = frame(SIZE, EYE, EYE, 1);
    let mut broken = clean.clone();
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -5.0];
    for (i, pixel) in broken.radiance.iter_mut().enumerate().filter(|(i, _)| i % 7 == 0) {
        pixel[i % 3] = bad[i % bad.len()];
    }
    for (i, pixel) in broken.albedo.iter_mut().enumerate().filter(|(i, _)| i % 11 == 0) {
        *pixel = if i % 2 == 0 { [0.0; 4] } else { [f32::NAN; 4] };
    }
    for (i, pixel) in broken.normal.iter_mut().enumerate().filter(|(i, _)| i % 13 == 0) {
        *pixel = if i % 2 == 0 { [0.0; 4] } else { [f32::NAN; 4] };
    }
    for (i, pixel) in broken.motion.iter_mut().enumerate().filter(|(i, _)| i % 17 == 0) {
        *pixel = if i % 2 == 0 { [f32::NAN; 2] } else { [f32::INFINITY, 1e30] };
    }
    for (i, pixel) in broken.depth.iter_mut().enumerate().filter(|(i, _)| i % 19 == 0) {
        *pixel = [f32::NAN, -1.0, 0.0, f32::NEG_INFINITY, 1e30, f32::MAX][i / 19 % 6];
    }
    let mut quell = denoiser(SIZE);
    assert_sound(&denoise(&mut quell, &broken, &Settings::default()));
    let mut last = vec![];
    for seed in 2..14 {
        last = denoise(&mut quell, &frame(SIZE, EYE, EYE, seed), &Settings::default());
        assert_sound(&last);
    }
    let after = psnr(&last, &clean.truth);
    assert!(after > 22.0, "history is poisoned: {after:.1} dB");
}

/// The largest number is a sample like any other: it must stay a number on its way through.
#[test]
fn the_largest_radiance_stays_finite() {
    let mut bright = frame(SIZE, EYE, EYE, 1);
    bright.radiance.fill([f32::MAX; 4]);
    let mut quell = denoiser(SIZE);
    for _ in 0..6 {
        assert_sound(&denoise(&mut quell, &bright, &Settings::default()));
    }
}

#[test]
fn a_frame_of_misses_passes_through() {
    let mut sky = frame(SIZE, EYE, EYE, 1);
    sky.depth.fill(f32::INFINITY);
    let mut quell = denoiser(SIZE);
    let output = denoise(&mut quell, &sky, &Settings::default());
    for (output, input) in output.iter().zip(&sky.radiance) {
        for c in 0..3 {
            assert!((output[c] - input[c]).abs() <= input[c] / 1024.0, "{output:?} {input:?}");
        }
    }
    // `far` makes a miss as well, and the image recovers after it.
    let near = Settings::default().with_far(0.5);
    assert_sound(&denoise(&mut quell, &frame(SIZE, EYE, EYE, 2), &near));
    let truth = frame(SIZE, EYE, EYE, 3);
    assert!(psnr(&denoise(&mut quell, &truth, &Settings::default()), &truth.truth) > 25.0);
}

#[test]
fn one_flat_surface_of_one_colour_stays_what_it_is() {
    let mut flat = frame(SIZE, EYE, EYE, 1);
    flat.depth.fill(3.0);
    flat.normal.fill([0.0, 0.0, 1.0, 1.0]);
    flat.albedo.fill([0.5, 0.5, 0.5, 1.0]);
    flat.id.fill(1);
    flat.radiance.fill([0.75, 0.5, 0.25, 1.0]);
    let mut quell = denoiser(SIZE);
    for _ in 0..4 {
        let output = denoise(&mut quell, &flat, &Settings::default());
        let worst = output.iter().flat_map(|o| [o[0] - 0.75, o[1] - 0.5, o[2] - 0.25]).map(f32::abs);
        assert!(worst.fold(0.0, f32::max) < 2e-3);
    }
}

/// Pixels without samples are predicted from the others, also in the first frame.
#[test]
fn pixels_without_samples_are_predicted() {
    let mut sparse = frame(SIZE, EYE, EYE, 1);
    let mut quell = denoiser(SIZE);
    for (i, samples) in sparse.samples.iter_mut().enumerate() {
        if i % 4 != 0 {
            *samples = 0;
            sparse.radiance[i] = [f32::NAN; 4]; // must not be looked at
        }
    }
    // Misses are passed through: theirs is looked at.
    for i in (0..sparse.radiance.len()).filter(|&i| !sparse.depth[i].is_finite()) {
        let t = sparse.truth[i];
        sparse.radiance[i] = [t[0], t[1], t[2], 1.0];
    }
    let output = denoise(&mut quell, &sparse, &Settings::default());
    let quality = psnr(&output, &sparse.truth);
    assert!(quality > 22.0, "{quality:.1} dB");
}

/// One sample in 200 pixels: windows that choose their size reach as far for one as those that are always the widest, in a
/// frame that is large enough for these.
#[test]
fn pixels_far_from_any_sample_are_predicted() {
    let size = [320, 320];
    let mut sparse = frame(size, EYE, EYE, 1);
    sparse.truth.fill([1.0; 3]);
    sparse.radiance.fill([1.0; 4]);
    let mut random = StdRng::seed_from_u64(7);
    sparse.samples.iter_mut().for_each(|samples| *samples = random.random_bool(0.01).into());
    let black = |windows| {
        let settings = Settings::default().with_windows(windows);
        let output = denoise(&mut denoiser(size), &sparse, &settings);
        output.iter().filter(|colour| colour[1] == 0.0).count()
    };
    let [by_ring, by_cp, widest] = [Windows::RingError, Windows::MallowsCp, Windows::Fixed(3)].map(black);
    println!(
        "pixels without prediction: {by_ring} by ring error, {by_cp} by Cp, {widest} with the widest windows"
    );
    assert!(by_ring <= widest && by_cp <= widest);
}

#[test]
fn optional_images_may_be_missing() {
    let frame = frame(SIZE, EYE, EYE, 1);
    let images = frame.upload();
    let mut quell = denoiser(SIZE);
    let inputs =
        images.inputs(frame.camera, HistoryMode::Continue).with_surface_id(None).with_sample_count(None);
    submit(&mut quell, &inputs, &Settings::default());
    assert!(psnr(&read_output(&images.output), &frame.truth) > 25.0);
}

/// Mean of the debug view `HistoryLength` over the pixels that hit something: 1 where all history was found again. What the
/// innovation takes from it is left out: these tests are about where history is looked for.
fn history_kept(quell: &mut Denoiser, frames: &[Frame]) -> f32 {
    let lengths = blank(frames[0].size, Format::Rgba16Float);
    let settings = Settings::default().with_max_history(frames.len() as f32).with_innovation(false);
    for frame in frames {
        let images = frame.upload();
        let inputs = images
            .inputs(frame.camera, HistoryMode::Continue)
            .with_debug((DebugView::HistoryLength, &lengths));
        submit(quell, &inputs, &settings);
    }
    let last = frames.last().unwrap();
    let kept: Vec<f32> = read_output(&lengths)
        .iter()
        .zip(&last.depth)
        .filter(|(_, depth)| depth.is_finite())
        .map(|(length, _)| length[0])
        .collect();
    kept.iter().sum::<f32>() / kept.len() as f32
}

#[test]
fn jitter_does_not_cost_history() {
    let still: Vec<Frame> = (0..8)
        .map(|i| {
            let jitter = Vec2::new(i as f32 * 0.618, i as f32 * 0.382).fract() - 0.5;
            jittered_frame(SIZE, EYE, EYE, i, jitter)
        })
        .collect();
    let kept = history_kept(&mut denoiser(SIZE), &still);
    assert!(kept > 0.9, "{kept}");
}

/// Motion vectors of the wrong sign lose history: what a user sees in the debug view.
#[test]
fn wrong_motion_shows_in_the_history_length() {
    let mut frames: Vec<Frame> = walk(SIZE, 8, Vec3::new(0.06, 0.02, 0.0), 3).collect();
    let right = history_kept(&mut denoiser(SIZE), &frames);
    frames.iter_mut().flat_map(|frame| &mut frame.motion).for_each(|m| *m = [-10.0 * m[0], -10.0 * m[1]]);
    let wrong = history_kept(&mut denoiser(SIZE), &frames);
    assert!(right > 0.85 && wrong < 0.6, "{right} {wrong}");
}

#[test]
fn an_orthographic_camera_works() {
    let mut flat = frame(SIZE, EYE, EYE, 1);
    let slope = |i: usize| 3.0 + 0.01 * (i % SIZE[0] as usize) as f32;
    flat.depth = (0..flat.depth.len()).map(slope).collect();
    // 64 pixels are 4 units, over which depth grows by 0.64.
    flat.normal.fill(Vec3::new(-0.16, 0.0, 1.0).normalize().extend(1.0).to_array());
    flat.id.fill(1);
    flat.camera = Camera {
        view_from_world: Mat4::IDENTITY,
        clip_from_view: rh::proj::directx::orthographic(-2.0, 2.0, -1.5, 1.5, 0.1, 10.0),
        jitter_px: Vec2::ZERO,
    };
    flat.motion.fill([0.0; 2]);
    let kept = history_kept(&mut denoiser(SIZE), &vec![flat; 8]);
    assert!(kept > 0.99, "{kept}");
}

/// All formats of the contract that the other tests do not use.
#[test]
fn every_format_of_the_contract_works() {
    let frame = frame(SIZE, EYE, EYE, 1);
    let half = |v: f32| half::f16::from_f32(v);
    let bytes = |texels: &[[f32; 4]], scale: f32, encode: fn(f32) -> f32| -> Vec<u8> {
        texels.iter().flatten().map(|&v| (encode(v) * scale).round() as i32 as u8).collect()
    };
    let srgb = |v: f32| if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    let with_depth: Vec<[half::f16; 4]> =
        frame.motion.iter().map(|m| [half(m[0]), half(m[1]), half(0.0), half(0.0)]).collect();
    let motion: Vec<[half::f16; 2]> = frame.motion.iter().map(|m| m.map(half)).collect();
    let radiance: Vec<[half::f16; 4]> = frame.radiance.iter().map(|t| t.map(half)).collect();
    let samples = vec![1_u8; frame.samples.len()];
    let albedo_srgb = upload(SIZE, Format::Rgba8UnormSrgb, &bytes(&frame.albedo, 255.0, srgb));
    let albedo = upload(SIZE, Format::Rgba8Unorm, &bytes(&frame.albedo, 255.0, |v| v));
    let normal = upload(SIZE, Format::Rgba8Snorm, &bytes(&frame.normal, 127.0, |v| v));
    let radiance = upload(SIZE, Format::Rgba16Float, &radiance);
    let motion = upload(SIZE, Format::Rg16Float, &motion);
    let with_depth = upload(SIZE, Format::Rgba16Float, &with_depth);
    let samples = upload(SIZE, Format::R8Uint, &samples);
    let images = frame.upload();
    let good = images.inputs(frame.camera, HistoryMode::Continue);
    let mut reference = denoiser(SIZE);
    (0..4).for_each(|_| submit(&mut reference, &good, &Settings::default()));
    let expected = read_output(&images.output);
    let variants = [
        with(good, |i| i.albedo = &albedo_srgb),
        with(good, |i| (i.albedo, i.radiance) = (&albedo, &radiance)),
        with(good, |i| (i.normal_roughness, i.motion) = (&normal, &motion)),
        with(good, |i| i.motion = &with_depth).with_sample_count(&samples),
    ];
    for (i, inputs) in variants.iter().enumerate() {
        let mut quell = denoiser(SIZE);
        (0..4).for_each(|_| submit(&mut quell, inputs, &Settings::default()));
        // Coarser formats: nearly the same picture.
        let likeness = psnr(&read_output(&images.output), &expected);
        assert!(likeness > 35.0, "variant {i}: {likeness:.1} dB");
    }
}

#[test]
fn emission_is_kept_sharp() {
    let mut frame = frame(SIZE, EYE, EYE, 1);
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let mut emission = vec![[half::f16::ZERO; 4]; pixels];
    let lamp = 20 * SIZE[0] as usize + 30;
    emission[lamp] = [half::f16::from_f32(50.0); 4];
    (0..3).for_each(|c| frame.radiance[lamp][c] += 50.0);
    let images = frame.upload();
    let emission = crate::gpu::upload(SIZE, Format::Rgba16Float, &emission);
    let inputs = images.inputs(frame.camera, HistoryMode::Continue).with_emission(&emission);
    let mut quell = denoiser(SIZE);
    submit(&mut quell, &inputs, &Settings::default());
    let output = read_output(&images.output);
    assert!(output[lamp][0] > 49.0);
    assert!(output[lamp - 1][0] < 5.0 && output[lamp + 1][0] < 5.0, "the lamp bled into its neighbours");
}

/// After `Restart` a frame depends on nothing that came before.
#[test]
fn restart_forgets_everything() {
    let other = frame(SIZE, EYE + Vec3::new(0.5, 0.0, 0.0), EYE, 9);
    let this = frame(SIZE, EYE, EYE, 1);
    let (mut used, mut fresh) = (denoiser(SIZE), denoiser(SIZE));
    denoise(&mut used, &other, &Settings::default());
    denoise(&mut fresh, &this, &Settings::default()); // the same number of frames: dithering depends on it
    let images = [this.upload(), this.upload()];
    for (denoiser, images) in [&mut used, &mut fresh].into_iter().zip(&images) {
        submit(denoiser, &images.inputs(this.camera, HistoryMode::Restart), &Settings::default());
    }
    assert_eq!(read_output(&images[0].output), read_output(&images[1].output));
    // And without it, it does.
    denoise(&mut used, &other, &Settings::default());
    let continued = denoise(&mut used, &this, &Settings::default());
    assert_ne!(continued, read_output(&images[0].output));
}

#[test]
fn resizing_up_and_down_starts_anew_at_the_new_size() {
    let mut quell = denoiser(SIZE);
    for size in [[96, 80], [33, 21], SIZE] {
        let before = frame(quell.size(), EYE, EYE, 1);
        denoise(&mut quell, &before, &Settings::default());
        let [width, height] = size;
        quell.resize(&gpu().device, &DenoiserDescriptor::new(width, height)).unwrap();
        let next = frame(size, EYE, EYE, 2);
        let output = denoise(&mut quell, &next, &Settings::default());
        assert!(psnr(&output, &next.truth) > 25.0, "{size:?}");
    }
    let before = quell.size();
    assert!(quell.resize(&gpu().device, &DenoiserDescriptor::new(0, 1)).is_err());
    assert_eq!(quell.size(), before);
}

/// Two cameras with one set of pipelines see what each would see alone.
#[test]
fn two_denoisers_share_pipelines_and_nothing_else() {
    let device = &gpu().device;
    let (mut left, mut alone) = (denoiser(SIZE), denoiser(SIZE));
    let [width, height] = [40, 40];
    let mut right =
        Denoiser::with_pipelines(device, &DenoiserDescriptor::new(width, height), left.pipelines()).unwrap();
    for (seed, frame) in walk(SIZE, 4, Vec3::new(0.02, 0.0, 0.0), 3).enumerate() {
        let shared = denoise(&mut left, &frame, &Settings::default());
        denoise(&mut right, &crate::sequence::frame([40, 40], EYE, EYE, seed as u64), &Settings::default());
        assert_eq!(shared, denoise(&mut alone, &frame, &Settings::default()));
    }
}

/// Several frames may be recorded before one submission.
#[test]
fn frames_recorded_into_one_encoder_are_the_frames_submitted_one_by_one() {
    let frames: Vec<Frame> = walk(SIZE, 3, Vec3::new(0.02, 0.0, 0.0), 3).collect();
    let mut one_by_one = denoiser(SIZE);
    let expected: Vec<_> = frames.iter().map(|f| denoise(&mut one_by_one, f, &Settings::default())).collect();
    let mut quell = denoiser(SIZE);
    let images: Vec<_> = frames.iter().map(Frame::upload).collect();
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    for (frame, images) in frames.iter().zip(&images) {
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        quell.encode(&gpu().device, &gpu().queue, &mut encoder, &inputs, &Settings::default()).unwrap();
    }
    gpu().queue.submit([encoder.finish()]);
    for (images, expected) in images.iter().zip(&expected) {
        assert_eq!(&read_output(&images.output), expected);
    }
}

fn refusal(quell: &mut Denoiser, inputs: &FrameInputs<'_>, settings: &Settings) -> FrameError {
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    quell.encode(&gpu().device, &gpu().queue, &mut encoder, inputs, settings).unwrap_err()
}

#[test]
fn wrong_images_are_named_and_history_stays() {
    let frames: Vec<Frame> = walk(SIZE, 2, Vec3::new(0.02, 0.0, 0.0), 3).collect();
    let (mut quell, mut undisturbed) = (denoiser(SIZE), denoiser(SIZE));
    denoise(&mut quell, &frames[0], &Settings::default());
    denoise(&mut undisturbed, &frames[0], &Settings::default());

    let images = frames[1].upload();
    let good = images.inputs(frames[1].camera, HistoryMode::Continue);
    let small = blank([32, 48], Format::R32Float);
    let wrong_format = blank(SIZE, Format::R32Float);
    let unstorable = gpu()
        .device
        .create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Format::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
        .create_view(&Default::default());
    let cases = [
        (with(good, |i| i.depth = &small), ["`depth`", "32x48", "64x48"]),
        (with(good, |i| i.albedo = &wrong_format), ["`albedo`", "R32Float", "Rgba16Float"]),
        (good.with_surface_id(&wrong_format), ["`surface_id`", "R32Float", "R32Uint"]),
        (with(good, |i| i.output = &unstorable), ["`output`", "STORAGE_BINDING", "TEXTURE_BINDING"]),
        (with(good, |i| i.output = &images.albedo), ["`output`", "`albedo`", "same texture"]),
    ];
    for (inputs, parts) in &cases {
        let message = refusal(&mut quell, inputs, &Settings::default()).to_string();
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    }
    assert_eq!(
        denoise(&mut quell, &frames[1], &Settings::default()),
        denoise(&mut undisturbed, &frames[1], &Settings::default()),
        "a refused frame changed history"
    );
}

#[test]
fn wrong_settings_and_cameras_are_named() {
    let frame = frame(SIZE, EYE, EYE, 1);
    let images = frame.upload();
    let good = images.inputs(frame.camera, HistoryMode::Continue);
    let mut quell = denoiser(SIZE);
    let conventions = Conventions::default().with_motion_unit(MotionUnit::Scaled([f32::NAN, 1.0]));
    let scaled = Settings::default().with_conventions(conventions);
    let settings = [
        (Settings::default().with_max_history(0.0), "max_history"),
        (Settings::default().with_max_history(f32::NAN), "max_history"),
        (Settings::default().with_windows(Windows::Fixed(0)), "windows"),
        (Settings::default().with_windows(Windows::Fixed(4)), "windows"),
        (Settings::default().with_centres(Centres::Uniform(0)), "centres"),
        (Settings::default().with_centres(Centres::Uniform(3)), "centres"),
        (Settings::default().with_firefly_limit(0.0), "firefly_limit"),
        (Settings::default().with_firefly_limit(f32::NAN), "firefly_limit"),
        (Settings::default().with_far(-1.0), "far"),
        (scaled, "conventions.motion_unit"),
        (Settings::default().with_savings(3), "savings"),
        (Settings::default().with_most_savings(u32::MAX), "most_savings"),
        (Settings::default().with_budget(Budget::Milliseconds(0.0)), "budget"),
        (Settings::default().with_budget(Budget::Milliseconds(f32::INFINITY)), "budget"),
    ];
    for (settings, name) in settings {
        let message = refusal(&mut quell, &good, &settings).to_string();
        assert!(message.contains(&format!("`{name}`")), "{message}");
    }
    for measured_ms in [f32::NAN, f32::INFINITY, -1.0] {
        let inputs = good.with_measured_ms(measured_ms);
        let message = refusal(&mut quell, &inputs, &Settings::default()).to_string();
        assert!(message.contains("`measured_ms`"), "{message}");
    }
    let mut cameras = [frame.camera; 6];
    cameras[4].view_from_world = cameras[4].view_from_world.transpose();
    // Left-handed, without saying so.
    cameras[5].clip_from_view.z_axis *= -1.0;
    cameras[0].view_from_world *= 2.0;
    cameras[1].clip_from_view = Mat4::ZERO;
    cameras[2].clip_from_view.x_axis.x = f32::NAN;
    cameras[3].jitter_px = Vec2::NAN;
    let (view, clip) = ("view_from_world", "clip_from_view");
    for (camera, name) in cameras.into_iter().zip([view, clip, clip, "jitter_px", view, "handedness"]) {
        let message =
            refusal(&mut quell, &with(good, |i| i.camera = camera), &Settings::default()).to_string();
        assert!(message.contains(name), "{message}");
    }
}
