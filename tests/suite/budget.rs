//! Whole frames under a budget of models or of time.

use crate::gpu::{adapter, blank, gpu};
use crate::sequence::{
    Frame, Light, camera, denoise, denoiser, frame, lit_frame, psnr, read_output, submit, walk,
};
use crate::statistics::wait_for;
use glam::Vec3;
use quell::layout::{LEVEL_STRIDES, count, tiles};
use quell::{
    Budget, Centres, DebugView, Denoiser, DenoiserDescriptor, FrameInputs, HistoryMode, Notice,
    RequiredInputs, Settings, Statistics,
};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [90, 61];
const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);

fn with(budget: Budget) -> Settings {
    Settings::default().with_budget(budget)
}

/// Models of the coarsest level in a frame without sky.
fn coarsest(size: [u32; 2]) -> u32 {
    count(tiles(size).map(|side| side.div_ceil(LEVEL_STRIDES[0]))) as u32
}

/// What each frame came to.
fn statistics(quell: &mut Denoiser, frames: &[Frame], settings: &Settings) -> Vec<Statistics> {
    let each = (0..).zip(frames).map(|(i, frame)| {
        denoise(quell, frame, settings);
        wait_for(quell, i)
    });
    each.collect()
}

fn still(frames: u64) -> Vec<Frame> {
    (0..frames).map(|seed| frame(SIZE, EYE, EYE, seed)).collect()
}

#[test]
fn no_more_models_are_fitted_than_allowed() {
    let frames: Vec<Frame> = walk(SIZE, 3, Vec3::new(0.02, 0.0, -0.02), 1).collect();
    let mut fitted = vec![];
    for limit in [0, 10, 20, 40, u32::MAX] {
        let all = statistics(&mut denoiser(SIZE), &frames, &with(Budget::Models(limit)));
        for found in &all {
            assert!(found.models() <= limit.max(found.models_by_level[0]), "{limit}: {found:?}");
            assert!(found.models_by_level[0] <= coarsest(SIZE), "{limit}: {found:?}");
            assert_eq!(found.model_limit, Some(limit));
        }
        fitted.push(all[2].models());
    }
    assert!(fitted.is_sorted() && fitted[4] > 40, "more where more are allowed: {fitted:?}");
    // Uniform centres are fitted all.
    let uniform = with(Budget::Models(0)).with_centres(Centres::Uniform(1));
    let found = statistics(&mut denoiser(SIZE), &frames[..1], &uniform)[0];
    assert_eq!((found.models(), found.model_limit), (count(tiles(SIZE)) as u32, None));
}

#[test]
fn every_pixel_is_predicted_without_any_finer_model() {
    for size in [SIZE, [323, 201], [33, 9], [64, 40], [8, 8], [1, 1]] {
        let frame = frame(size, EYE, EYE, 1);
        let images = frame.upload();
        let coverage = blank(size, Format::Rgba16Float);
        let inputs =
            images.inputs(frame.camera, HistoryMode::Continue).with_debug((DebugView::Coverage, &coverage));
        submit(&mut denoiser(size), &inputs, &with(Budget::Models(0)));
        let covered = read_output(&coverage);
        let holes =
            covered.iter().zip(&frame.depth).filter(|(models, depth)| depth.is_finite() && models[0] <= 0.0);
        assert_eq!(holes.count(), 0, "{size:?}");
    }
}

#[test]
fn a_limited_sequence_is_the_same_every_time() {
    let frames: Vec<Frame> = walk(SIZE, 5, Vec3::new(0.02, 0.0, -0.02), 2).collect();
    let run = || {
        let mut quell = denoiser(SIZE);
        let outputs: Vec<_> =
            frames.iter().map(|f| denoise(&mut quell, f, &with(Budget::Models(25)))).collect();
        (outputs, wait_for(&mut quell, 4))
    };
    let first = run();
    assert!(first.1.models_kept > 0, "{:?}", first.1);
    assert_eq!(first, run());
}

#[test]
fn models_are_kept_until_a_restart_a_new_light_or_their_age() {
    let settings = with(Budget::Models(20));
    let mut quell = denoiser(SIZE);
    let found = statistics(&mut quell, &still(8), &settings);
    assert_eq!(found[0].models_kept, 0);
    assert!(found[1..].iter().all(|found| found.models_kept > 0), "{found:?}");
    // What is kept with what is fitted comes to more than the limit.
    assert!(found[7].models() + found[7].models_kept > 20, "{:?}", found[7]);

    let submit_one = |quell: &mut Denoiser, frame: &Frame, history, settings: &Settings, number| {
        submit(quell, &frame.upload().inputs(frame.camera, history), settings);
        wait_for(quell, number)
    };
    let bright = lit_frame(SIZE, EYE, EYE, 8, Light::all(10.0));
    let kept = submit_one(&mut quell, &bright, HistoryMode::Continue, &settings, 8).models_kept;
    assert!(kept <= found[7].models_kept / 4, "{kept} of {} in ten times the light", found[7].models_kept);
    let next = frame(SIZE, EYE, EYE, 9);
    assert_eq!(submit_one(&mut quell, &next, HistoryMode::Restart, &settings, 9).models_kept, 0);
    // A frame without a budget leaves none.
    submit_one(&mut quell, &next, HistoryMode::Continue, &Settings::default(), 10);
    assert_eq!(submit_one(&mut quell, &next, HistoryMode::Continue, &settings, 11).models_kept, 0);
}

/// Under a budget the image stays close to the one without, also while the camera moves.
#[test]
fn half_the_models_lose_little() {
    let frames: Vec<Frame> = walk([192, 108], 12, Vec3::new(0.02, 0.0, -0.03), 3).collect();
    let run = |budget| {
        let mut quell = denoiser([192, 108]);
        let all = frames.iter().map(|frame| psnr(&denoise(&mut quell, frame, &with(budget)), &frame.truth));
        let mean = all.sum::<f64>() / frames.len() as f64;
        (mean, wait_for(&mut quell, 11).models())
    };
    let (full, models) = run(Budget::Unlimited);
    let (half, _) = run(Budget::Models(models / 2));
    println!("{full:.2} dB with {models} models, {half:.2} dB with half");
    assert!(half > full - 0.3, "{full:.2} dB with {models} models, {half:.2} dB with half");
}

/// Each saving makes another image, which is close to that without; what is saved is told.
#[test]
fn savings_lose_little() {
    let size = [192, 108];
    let frames: Vec<Frame> = walk(size, 12, Vec3::new(0.02, 0.0, -0.03), 3).collect();
    let run = |savings: u32| {
        let mut quell = denoiser(size);
        let settings = Settings::default().with_savings(savings);
        let outputs: Vec<_> = frames.iter().map(|frame| denoise(&mut quell, frame, &settings)).collect();
        assert_eq!(wait_for(&mut quell, 11).savings, savings);
        let mean = outputs.iter().zip(&frames).map(|(output, frame)| psnr(output, &frame.truth)).sum::<f64>();
        (mean / frames.len() as f64, outputs)
    };
    let runs = [0, 1, 2].map(run);
    let [full, bilinear, sparse] = [0, 1, 2].map(|savings| runs[savings].0);
    println!("{full:.2} dB, {bilinear:.2} with bilinear history, {sparse:.2} with sparse moments");
    // Small frames have windows of 3x3 tiles at most, of which five are left.
    assert!(bilinear > full - 0.5 && sparse > full - 2.0, "{full:.2}, {bilinear:.2}, {sparse:.2} dB");
    assert!(runs[0].1[11] != runs[1].1[11] && runs[1].1[11] != runs[2].1[11]);
}

/// Encodes frames that take 1 ms, of which each saving saves a tenth, and 0.02 ms a model, as the caller measured it. Limits and
/// savings of all frames, and notices.
fn paced_by(
    quell: &mut Denoiser,
    frames: u32,
    settings: &Settings,
    measured: bool,
) -> (Vec<u32>, Vec<u32>, Vec<Notice>) {
    let frame = frame(SIZE, EYE, EYE, 1);
    let images = frame.upload();
    let (mut limits, mut savings, mut notices) = (vec![], vec![], vec![]);
    let mut measured_ms = None;
    for i in 0..frames {
        let inputs = images.inputs(frame.camera, HistoryMode::Continue).with_measured_ms(measured_ms);
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let outputs = quell.encode(&gpu().device, &gpu().queue, &mut encoder, &inputs, settings).unwrap();
        gpu().queue.submit([encoder.finish()]);
        notices.extend(outputs.notice);
        let found = wait_for(quell, i);
        limits.push(found.model_limit.unwrap());
        savings.push(found.savings);
        measured_ms = measured.then(|| 1.0 - 0.1 * found.savings as f32 + 0.02 * found.models() as f32);
    }
    (limits, savings, notices)
}

fn paced(quell: &mut Denoiser, frames: u32, target_ms: f32, measured: bool) -> (Vec<u32>, Vec<Notice>) {
    let settings = with(Budget::Milliseconds(target_ms)).with_most_savings(0);
    let (limits, savings, notices) = paced_by(quell, frames, &settings, measured);
    assert!(savings.iter().all(|&savings| savings == 0), "none was allowed");
    (limits, notices)
}

#[test]
fn savings_are_taken_where_fewer_models_are_not_enough() {
    let pace = |target_ms| {
        let settings = with(Budget::Milliseconds(target_ms));
        let (limits, savings, _) = paced_by(&mut denoiser(SIZE), 60, &settings, true);
        (limits[59], savings[59])
    };
    let floor_ms = 1.0 + 0.02 * coarsest(SIZE) as f32;
    assert_eq!(pace(100.0).1, 0);
    let (limit, savings) = pace(1.35);
    assert!(
        savings == 1 && limit > coarsest(SIZE),
        "the first, before models are given up: {limit}, {savings}"
    );
    assert_eq!(pace(0.5 * floor_ms), (coarsest(SIZE), 2), "all that there is");
}

#[test]
fn a_time_that_the_caller_measured_sets_the_limit() {
    let all = count(tiles(SIZE)) as u32;
    let (limits, notices) = paced(&mut denoiser(SIZE), 60, 1.0 + 0.02 * 40.0, true);
    assert!((30..=40).contains(&limits[59]), "{limits:?}");
    assert_eq!(notices, []);
    let (limits, _) = paced(&mut denoiser(SIZE), 40, 0.5, true);
    assert_eq!(limits[39], coarsest(SIZE), "the floor: {limits:?}");
    let (limits, _) = paced(&mut denoiser(SIZE), 60, 100.0, true);
    assert!(limits[59] > 40 && limits[59] <= all, "more than is needed: {limits:?}");
}

#[test]
fn without_times_the_limit_is_held_and_that_is_said_once() {
    let mut quell = denoiser(SIZE);
    let (limits, notices) = paced(&mut quell, 20, 2.0, false);
    let held = (SIZE[0] * SIZE[1]).div_ceil(256);
    assert!(limits.iter().all(|&limit| limit == held), "{limits:?}, expected {held}");
    assert_eq!(notices, [Notice::NoTimestamps]);
    let [width, height] = SIZE;
    quell.resize(&gpu().device, &DenoiserDescriptor::new(1, 1)).unwrap();
    quell.resize(&gpu().device, &DenoiserDescriptor::new(width, height)).unwrap();
    assert_eq!(paced(&mut quell, 20, 2.0, false).1, [], "not again after a resize");
}

/// What times mean on a CPU adapter is not tested: that they are taken, arrive and are used.
#[test]
fn own_timestamps_set_the_limit() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = adapter(&instance);
    let timestamps = wgpu::Features::TIMESTAMP_QUERY;
    if !adapter.features().contains(timestamps) {
        return;
    }
    let (device, queue) = pollster::block_on(
        adapter
            .request_device(&wgpu::DeviceDescriptor { required_features: timestamps, ..Default::default() }),
    )
    .unwrap();
    let [width, height] = SIZE;
    let mut quell = Denoiser::new(&device, &DenoiserDescriptor::new(width, height)).unwrap();
    // All of it sky: no models, but times all the same.
    let image = |format, usage| {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        });
        texture.create_view(&Default::default())
    };
    let sampled = |format| image(format, wgpu::TextureUsages::TEXTURE_BINDING);
    let (radiance, albedo, normal_roughness, depth, motion) = (
        sampled(Format::Rgba16Float),
        sampled(Format::Rgba16Float),
        sampled(Format::Rgba16Float),
        sampled(Format::R32Float),
        sampled(Format::Rg16Float),
    );
    let output = image(Format::Rgba16Float, wgpu::TextureUsages::STORAGE_BINDING);
    let good = FrameInputs::new(RequiredInputs {
        radiance: &radiance,
        albedo: &albedo,
        normal_roughness: &normal_roughness,
        depth: &depth,
        motion: &motion,
        output: &output,
        camera: camera(EYE, SIZE),
    });
    let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
        label: None,
        ty: wgpu::QueryType::Timestamp,
        count: 2 * quell::PASSES.len() as u32,
    });
    let timestamps = quell::Timestamps { query_set: &queries, first_query: 0 };
    for i in 0..40 {
        // The caller's own timestamps are no hindrance.
        let mut inputs = good;
        inputs.profiler = (i % 2 == 0).then_some(&timestamps);
        let mut encoder = device.create_command_encoder(&Default::default());
        // Less than any frame takes.
        let settings = with(Budget::Milliseconds(1e-6));
        let outputs = quell.encode(&device, &queue, &mut encoder, &inputs, &settings).unwrap();
        assert_eq!(outputs.notice, None);
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    }
    assert_eq!(quell.statistics().unwrap().model_limit, Some(coarsest(SIZE)), "{:?}", quell.statistics());
}
