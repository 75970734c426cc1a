//! The check of inputs: on the analytic room, where nothing is wrong and where something is, and what real applications do to it.

use crate::gpu::{blank, gpu, upload};
use crate::mirror::mirrored;
use crate::sequence::{Frame, frame, jittered_frame, with};
use crate::viewport::within;
use glam::{Mat4, Vec2, Vec3, camera::rh};
use quell::{
    Camera, Conventions, CreateError, DenoiserDescriptor, DepthEncoding, FrameError, FrameInputs, Handedness,
    HistoryMode, InputCheck, Mistake, MotionDirection, MotionUnit, Settings, Viewport,
};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [120, 80];
const FRAMES: u32 = 6;

fn check([width, height]: [u32; 2]) -> InputCheck {
    InputCheck::new(&gpu().device, &DenoiserDescriptor::new(width, height)).unwrap()
}

/// On a path that bends, so that no two steps are alike.
fn eye(i: u32) -> Vec3 {
    let t = i as f32;
    Vec3::new(0.04 * t * t, 1.4 + 0.1 * t, 1.0 - 0.05 * t)
}

fn jitter(i: u32) -> Vec2 {
    Vec2::new(0.4 * (2.4 * i as f32).sin(), 0.4 * (1.7 * i as f32).cos())
}

/// A walk through the room, with jitter, a lamp on the wall and mirrors everywhere.
struct Room {
    frames: Vec<Frame>,
    emission: Vec<Vec<[f32; 4]>>,
}

const EMITTED: [f32; 4] = [4.0, 3.0, 2.0, 1.0];

fn room() -> Room {
    let shot = |i: u32| {
        let mut frame = jittered_frame(SIZE, eye(i), eye(i.saturating_sub(1)), u64::from(i), jitter(i));
        frame = mirrored(&frame, u64::from(i));
        frame.normal.iter_mut().for_each(|n| n[3] = 0.1);
        let lamp: Vec<_> =
            (0..frame.depth.len()).map(|p| if is_lamp(&frame, p) { EMITTED } else { [0.0; 4] }).collect();
        for (radiance, emitted) in frame.radiance.iter_mut().zip(&lamp) {
            (0..3).for_each(|c| radiance[c] += emitted[c]);
        }
        (frame, lamp)
    };
    let (frames, emission) = (0..FRAMES).map(shot).unzip();
    Room { frames, emission }
}

/// A third of the back wall.
fn is_lamp(frame: &Frame, pixel: usize) -> bool {
    frame.id[pixel] == 2 && pixel as u32 % SIZE[0] > SIZE[0] / 2
}

/// What of a room may be other than it is given.
#[derive(Default)]
struct Given {
    without_ids: bool,
    settings: Settings,
}

impl Room {
    /// Checks all frames and waits for their counts.
    fn check(&self, check: &mut InputCheck, given: &Given) {
        for (i, (frame, emission)) in self.frames.iter().zip(&self.emission).enumerate() {
            let images = frame.upload();
            let half: Vec<_> = emission.iter().map(|texel| texel.map(half::f16::from_f32)).collect();
            let emission = upload(frame.size, Format::Rgba16Float, &half);
            let history = if i == 0 { HistoryMode::Restart } else { HistoryMode::Continue };
            let mut inputs = images.inputs(frame.camera, history).with_emission(&emission);
            if given.without_ids {
                inputs = inputs.with_surface_id(None);
            }
            submit(check, &inputs, &given.settings).unwrap();
        }
        wait_for(check, self.frames.len() as u32);
    }

    fn findings(&self, given: &Given) -> (Vec<(&'static str, Mistake)>, String) {
        let mut check = check(SIZE);
        self.check(&mut check, given);
        let found = check.findings();
        let text: String = found.iter().map(|finding| format!("{finding}\n")).collect();
        let pairs = found.iter().map(|finding| (finding.input, finding.mistake)).collect();
        (pairs, format!("{text}{}", check.evidence()))
    }
}

fn submit(check: &mut InputCheck, inputs: &FrameInputs<'_>, settings: &Settings) -> Result<(), FrameError> {
    let mut encoder = gpu().device.create_command_encoder(&Default::default());
    check.encode(&gpu().device, &mut encoder, inputs, settings)?;
    gpu().queue.submit([encoder.finish()]);
    Ok(())
}

/// While other tests poll the same device, one of these may be about to call back.
fn wait_for(check: &mut InputCheck, frames: u32) {
    for _ in 0..1000 {
        gpu().device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        if check.frames() == frames {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("{} of {frames} frames arrived", check.frames());
}

#[test]
fn nothing_is_raised_by_the_room() {
    for without_ids in [false, true] {
        let (found, text) = room().findings(&Given { without_ids, ..Given::default() });
        assert_eq!(found, [], "{text}");
    }
}

/// What is done to each frame; its number, and its emission.
type Inject = fn(&mut Frame, &mut Vec<[f32; 4]>, u32);

#[test]
fn mistakes_are_named_in_the_room() {
    let cases: [(&str, Mistake, Inject); 12] = [
        ("motion", Mistake::MotionSign, |frame, _, _| motion(frame, |m| -m)),
        ("motion", Mistake::MotionScale, |frame, _, _| motion(frame, |m| m * Vec2::new(120.0, 80.0))),
        ("motion", Mistake::JitterInMotion, |frame, _, i| {
            let moved = (jitter(i.saturating_sub(1)) - jitter(i)) / Vec2::new(120.0, 80.0);
            frame.motion.iter_mut().for_each(|m| *m = (Vec2::from(*m) - moved).to_array());
        }),
        ("normal_roughness", Mistake::NormalsInverted, |frame, _, _| {
            frame.normal.iter_mut().for_each(|n| (0..3).for_each(|c| n[c] = -n[c]));
        }),
        ("depth", Mistake::DepthReversed, |frame, _, _| {
            frame.depth.iter_mut().for_each(|d| *d = 1.0 / *d);
        }),
        ("albedo", Mistake::AlbedoMissing, |frame, _, _| frame.albedo.fill([1.0; 4])),
        ("albedo", Mistake::AlbedoNotLinear, |frame, _, _| {
            frame.albedo.iter_mut().for_each(|a| (0..3).for_each(|c| a[c] = a[c].powf(1.0 / 2.2)));
        }),
        ("camera", Mistake::CameraLate, |frame, _, i| {
            frame.camera.view_from_world = frame_camera(i.saturating_sub(1)).view_from_world;
        }),
        ("surface_id", Mistake::IdsChange, |frame, _, i| frame.id.iter_mut().for_each(|id| *id += 7 * i)),
        ("emission", Mistake::EmissionTwice, |frame, emission, _| {
            for (radiance, emitted) in frame.radiance.iter_mut().zip(emission) {
                (0..3).for_each(|c| radiance[c] += emitted[c]);
            }
        }),
        ("emission", Mistake::EmissionLacking, |frame, emission, _| {
            for (radiance, emitted) in frame.radiance.iter_mut().zip(emission) {
                (0..3).for_each(|c| radiance[c] -= emitted[c]);
            }
        }),
        ("hit_distance", Mistake::HitDistanceUnit, |frame, _, _| {
            frame.hit_distance.iter_mut().for_each(|d| *d *= 0.01);
        }),
    ];
    for (input, mistake, inject) in cases {
        let mut room = room();
        for (i, (frame, emission)) in room.frames.iter_mut().zip(&mut room.emission).enumerate() {
            inject(frame, emission, i as u32);
        }
        // The first has no step before it that could be wrong.
        room.frames.remove(0);
        room.emission.remove(0);
        let (found, text) = room.findings(&Given::default());
        assert_eq!(found, [(input, mistake)], "{text}");
    }
}

fn motion(frame: &mut Frame, change: fn(Vec2) -> Vec2) {
    frame.motion.iter_mut().for_each(|m| *m = change(Vec2::from(*m)).to_array());
}

fn frame_camera(i: u32) -> Camera {
    crate::sequence::camera(eye(i), SIZE)
}

#[test]
fn settings_that_undo_a_mistake_are_believed() {
    let mut room = room();
    room.frames.iter_mut().for_each(|frame| motion(frame, |m| m * Vec2::new(-120.0, -80.0)));
    let settings = Settings::default().with_conventions(
        Conventions::default()
            .with_motion_unit(MotionUnit::Pixels)
            .with_motion_direction(MotionDirection::FromPrevious),
    );
    let (found, text) = room.findings(&Given { settings, ..Given::default() });
    assert_eq!(found, [], "{text}");
}

/// The same room by a left-handed camera, whose depth is that of a depth buffer.
#[test]
fn other_conventions_raise_nothing() {
    let flip = Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0));
    let mut room = room();
    for frame in &mut room.frames {
        let clip = frame.camera.clip_from_view;
        frame.depth.iter_mut().for_each(|d| *d = clip.w_axis.z / *d - clip.z_axis.z);
        frame.camera.view_from_world = flip * frame.camera.view_from_world;
        frame.camera.clip_from_view = clip * flip;
    }
    let conventions =
        Conventions::default().with_handedness(Handedness::Left).with_depth(DepthEncoding::Hardware);
    let settings = Settings::default().with_conventions(conventions);
    let (found, text) = room.findings(&Given { settings, ..Given::default() });
    assert_eq!(found, [], "{text}");
}

#[test]
fn a_part_of_larger_images_counts_as_if_it_were_alone() {
    const LARGEST: [u32; 2] = [151, 101];
    let room = room();
    let [mut alone, mut inside] = [check(SIZE), check(LARGEST)];
    for frame in &room.frames {
        let images = frame.upload();
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        submit(&mut alone, &inputs, &Settings::default()).unwrap();
        let origin = [13, 7];
        let images = within(frame, LARGEST, origin).upload();
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        let inputs = inputs.with_viewport(Viewport { origin, size: SIZE });
        submit(&mut inside, &inputs, &Settings::default()).unwrap();
    }
    [&mut alone, &mut inside].into_iter().for_each(|check| wait_for(check, FRAMES));
    assert!(alone.evidence() == inside.evidence(), "{}{}", alone.evidence(), inside.evidence());
}

/// As for dynamic resolution: every frame has another size.
#[test]
fn sizes_that_change_raise_nothing() {
    let mut check = check(SIZE);
    for i in 0..FRAMES {
        let size = [SIZE[0] - 10 * (i % 3), SIZE[1] - 6 * (i % 3)];
        let frame = jittered_frame(size, eye(i), eye(i.saturating_sub(1)), u64::from(i), jitter(i));
        let images = within(&frame, SIZE, [0, 0]).upload();
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        let inputs = inputs.with_viewport(Viewport::of_size(size[0], size[1]));
        submit(&mut check, &inputs, &Settings::default()).unwrap();
    }
    wait_for(&mut check, FRAMES);
    assert_eq!(check.findings(), [], "{}", check.evidence());
}

#[test]
fn jitter_in_the_matrices_is_seen_whether_or_not_it_is_said() {
    for is_said in [true, false] {
        let mut room = room();
        for frame in &mut room.frames {
            let jitter = frame.camera.jitter_px;
            frame.camera.clip_from_view.z_axis.x += 2.0 * jitter.x / SIZE[0] as f32;
            frame.camera.clip_from_view.z_axis.y -= 2.0 * jitter.y / SIZE[1] as f32;
            frame.camera.jitter_px *= if is_said { 1.0 } else { 0.0 };
        }
        let (found, text) = room.findings(&Given::default());
        assert_eq!(found, [("camera", Mistake::JitterInMatrices)], "{text}");
    }
}

#[test]
fn a_transposed_matrix_is_a_finding_and_any_other_unusable_camera_an_error() {
    let frame = frame(SIZE, eye(0), eye(0), 1);
    let images = frame.upload();
    let mut check = check(SIZE);
    let transposed = Camera { view_from_world: frame.camera.view_from_world.transpose(), ..frame.camera };
    submit(&mut check, &images.inputs(transposed, HistoryMode::Continue), &Settings::default()).unwrap();
    let found = check.findings();
    assert_eq!(
        found.iter().map(|f| (f.input, f.mistake)).collect::<Vec<_>>(),
        [("camera", Mistake::CameraTransposed)]
    );
    assert!(found[0].to_string().contains("view_from_world"), "{}", found[0]);
    let broken = Camera { view_from_world: Mat4::NAN, ..frame.camera };
    let error = submit(&mut check, &images.inputs(broken, HistoryMode::Continue), &Settings::default());
    assert!(matches!(error, Err(FrameError::Camera { .. })), "{error:?}");
    check.clear();
    assert_eq!(check.findings(), []);
}

/// NaN everywhere, nothing but misses, an orthographic camera, cuts all the time, tiny frames: no word, no trouble.
#[test]
fn what_tells_nothing_raises_nothing() {
    let nan = |frame: &mut Frame| {
        frame.radiance.fill([f32::NAN; 4]);
        frame.albedo.fill([f32::NAN; 4]);
        frame.normal.fill([f32::NAN; 4]);
        frame.motion.fill([f32::NAN; 2]);
        frame.hit_distance.fill(f32::NAN);
    };
    let misses = |frame: &mut Frame| frame.depth.fill(f32::INFINITY);
    let orthographic = |frame: &mut Frame| {
        frame.camera.clip_from_view = rh::proj::directx::orthographic(-3.0, 3.0, -2.0, 2.0, 0.1, 100.0);
    };
    for change in [nan, misses, orthographic] {
        let mut room = room();
        room.frames.iter_mut().for_each(change);
        let (found, text) = room.findings(&Given::default());
        // An orthographic camera does not fit these images; but nothing that is known explains them better.
        assert_eq!(found, [], "{text}");
    }
    for size in [[1, 1], [1, 2], [17, 9]] {
        let mut check = check(size);
        for i in 0..4 {
            let frame = frame(size, eye(i), eye(i), 1);
            let images = frame.upload();
            submit(&mut check, &images.inputs(frame.camera, HistoryMode::Restart), &Settings::default())
                .unwrap();
        }
        wait_for(&mut check, 4);
        assert_eq!(check.findings(), []);
        assert!(check.untold().iter().any(|untold| untold.input == "motion"));
    }
}

/// An encoder that is never submitted takes its counts with it.
#[test]
fn frames_that_are_not_submitted_do_not_count() {
    let frame = frame(SIZE, eye(0), eye(0), 1);
    let images = frame.upload();
    let mut check = check(SIZE);
    for is_submitted in [false, true, false, true] {
        let mut encoder = gpu().device.create_command_encoder(&Default::default());
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        check.encode(&gpu().device, &mut encoder, &inputs, &Settings::default()).unwrap();
        if is_submitted {
            gpu().queue.submit([encoder.finish()]);
        }
    }
    wait_for(&mut check, 2);
}

#[test]
fn wrong_sizes_and_images_are_refused() {
    let error = InputCheck::new(&gpu().device, &DenoiserDescriptor::new(0, 5)).unwrap_err();
    assert_eq!(error, CreateError::EmptySize { width: 0, height: 5 });
    let frame = frame(SIZE, eye(0), eye(0), 1);
    let images = frame.upload();
    let small = blank([8, 8], Format::R32Float);
    let inputs = with(images.inputs(frame.camera, HistoryMode::Continue), |inputs| inputs.depth = &small);
    let error = submit(&mut check(SIZE), &inputs, &Settings::default());
    assert!(matches!(error, Err(FrameError::Size { image: "depth", .. })), "{error:?}");
}
