//! Frames that are a part of their images, of a size that changes.

use crate::gpu::{blank, upload};
use crate::sequence::{
    Frame, Images, camera, denoiser, frame, jittered_frame, psnr, read_output, submit, walk, with,
};
use glam::{Vec2, Vec3};
use quell::{Conventions, DebugView, DepthEncoding, HistoryMode, MotionUnit, SampleMap, Settings, Viewport};
use wgpu::TextureFormat as Format;

// No whole workgroups.
const SIZE: [u32; 2] = [61, 45];
const LARGEST: [u32; 2] = [93, 75];
const ORIGIN: [u32; 2] = [13, 7];
const STEP: Vec3 = Vec3::new(0.02, 0.0, -0.02);

/// The frame as a part of larger images, with garbage around it.
pub fn within(frame: &Frame, [width, height]: [u32; 2], origin: [u32; 2]) -> Frame {
    fn place<T: Copy>(texels: &[T], garbage: T, frame: [u32; 2], size: [u32; 2], origin: [u32; 2]) -> Vec<T> {
        if texels.is_empty() {
            return vec![];
        }
        let mut placed = vec![garbage; (size[0] * size[1]) as usize];
        for (y, row) in texels.chunks_exact(frame[0] as usize).enumerate() {
            let start = (origin[1] as usize + y) * size[0] as usize + origin[0] as usize;
            placed[start..start + row.len()].copy_from_slice(row);
        }
        placed
    }
    let Frame { size, camera, .. } = *frame;
    let whole = [width, height];
    Frame {
        size: whole,
        camera,
        radiance: place(&frame.radiance, [1e4; 4], size, whole, origin),
        albedo: place(&frame.albedo, [f32::NAN; 4], size, whole, origin),
        normal: place(&frame.normal, [0.3; 4], size, whole, origin),
        depth: place(&frame.depth, 0.7, size, whole, origin),
        motion: place(&frame.motion, [0.0; 2], size, whole, origin),
        id: place(&frame.id, 1, size, whole, origin),
        samples: place(&frame.samples, 9, size, whole, origin),
        specular: place(&frame.specular, [1e4; 4], size, whole, origin),
        hit_distance: place(&frame.hit_distance, 0.1, size, whole, origin),
        truth: vec![],
        mirror_truth: vec![],
    }
}

fn cut<T: Copy>(texels: &[T], size: [u32; 2], Viewport { origin, size: part }: Viewport) -> Vec<T> {
    let rows = texels.chunks_exact(size[0] as usize).skip(origin[1] as usize).take(part[1] as usize);
    rows.flat_map(|row| &row[origin[0] as usize..][..part[0] as usize]).copied().collect()
}

#[test]
fn a_part_of_larger_images_is_denoised_as_if_it_were_alone() {
    let viewport = Viewport { origin: ORIGIN, size: SIZE };
    for is_split in [false, true] {
        let mut frames: Vec<Frame> = walk(SIZE, 4, STEP, 3).collect();
        if is_split {
            frames = frames.iter().zip(0..).map(|(frame, i)| crate::mirror::mirrored(frame, i)).collect();
        }
        // Rays lead through the frame's pixels, not the images'.
        let conventions = Conventions::default().with_depth(DepthEncoding::Distance);
        let settings = Settings::default().with_conventions(conventions);
        let [mut alone, mut inside] = [denoiser(SIZE), denoiser(LARGEST)];
        for frame in &frames {
            let images = frame.upload();
            let [shown, samples] = [blank(SIZE, Format::Rgba16Float), blank(SIZE, Format::R32Uint)];
            let ask = |view| SampleMap::new(view, 1.0);
            let view = DebugView::Motion;
            // Any content will do for what is compared with itself.
            let inputs = images.inputs(frame.camera, HistoryMode::Continue);
            let inputs = inputs.with_emission(&images.albedo).with_roughness(&images.depth);
            submit(&mut alone, &inputs.with_debug((view, &shown)).with_sample_map(ask(&samples)), &settings);

            let placed: Images = within(frame, LARGEST, ORIGIN).upload();
            let grey = vec![[half::f16::from_f32(0.25); 4]; (LARGEST[0] * LARGEST[1]) as usize];
            let output = upload(LARGEST, Format::Rgba16Float, &grey);
            let [part_shown, part_samples] =
                [blank(LARGEST, Format::Rgba16Float), blank(LARGEST, Format::R32Uint)];
            let inputs = placed.inputs(frame.camera, HistoryMode::Continue).with_viewport(viewport);
            let inputs = with(inputs, |inputs| inputs.output = &output);
            let inputs = inputs.with_emission(&placed.albedo).with_roughness(&placed.depth);
            submit(
                &mut inside,
                &inputs.with_debug((view, &part_shown)).with_sample_map(ask(&part_samples)),
                &settings,
            );

            let written = read_output(&output);
            assert_eq!(cut(&written, LARGEST, viewport), read_output(&images.output));
            assert_eq!(cut(&read_output(&part_shown), LARGEST, viewport), read_output(&shown));
            let [all, part] = [&samples, &part_samples].map(crate::gpu::download::<u32>);
            assert_eq!(cut(&part, LARGEST, viewport), all);
            let outside =
                |touched: usize| assert!(touched <= (SIZE[0] * SIZE[1]) as usize, "{touched} pixels");
            outside(written.iter().filter(|&&texel| texel != [0.25; 3]).count());
            outside(read_output(&part_shown).iter().filter(|&&texel| texel != [0.0; 3]).count());
            outside(part.iter().filter(|&&samples| samples != 0).count());
        }
    }
}

/// Sizes of a walk under dynamic resolution: down, up, by a pixel, by a half.
const SIZES: [[u32; 2]; 16] = [
    [93, 75],
    [92, 74],
    [90, 72],
    [84, 68],
    [80, 64],
    [64, 48],
    [47, 38],
    [47, 38],
    [60, 48],
    [72, 60],
    [90, 72],
    [93, 75],
    [93, 75],
    [88, 71],
    [80, 64],
    [80, 64],
];

/// The last frame of a walk whose frames have these sizes.
fn of_sizes(sizes: &[[u32; 2]], history: HistoryMode) -> f64 {
    let mut quell = denoiser(LARGEST);
    let mut quality = 0.0;
    for (i, &size) in sizes.iter().enumerate() {
        let eye = |i: usize| Vec3::new(0.0, 1.4, 1.0) + STEP * i as f32;
        let frame = frame(size, eye(i), eye(i.saturating_sub(1)), i as u64);
        let images = within(&frame, LARGEST, [0, 0]).upload();
        let inputs = images.inputs(frame.camera, history);
        let viewport = Viewport::of_size(size[0], size[1]);
        submit(&mut quell, &inputs.with_viewport(viewport), &Settings::default());
        quality = psnr(&cut(&read_output(&images.output), LARGEST, viewport), &frame.truth);
    }
    quality
}

#[test]
fn history_is_kept_where_the_size_changes() {
    let last = SIZES[SIZES.len() - 1];
    let changing = of_sizes(&SIZES, HistoryMode::Continue);
    let constant = of_sizes(&[last; SIZES.len()], HistoryMode::Continue);
    let none = of_sizes(&SIZES, HistoryMode::Restart);
    println!("sizes that change {changing:.1} dB, one size {constant:.1} dB, no history {none:.1} dB");
    assert!(changing > constant - 1.0, "{changing:.1} against {constant:.1}");
    assert!(changing > none + 2.0, "{changing:.1} against {none:.1} without history");
}

/// Motion in pixels of the frame, with the jitter of both frames in it, through sizes that change: each jitter counts in the pixels of
/// its own frame.
#[test]
fn motion_is_that_of_its_frame_where_the_size_changes() {
    let jitter = |i: usize| Vec2::new(0.37, -0.29) * if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let conventions =
        Conventions::default().with_motion_unit(MotionUnit::Pixels).with_motion_is_jittered(true);
    let outputs = [Conventions::default(), conventions].map(|conventions| {
        let mut quell = denoiser(LARGEST);
        let mut output = vec![];
        for (i, &size) in SIZES[..6].iter().enumerate() {
            let eye = |i: usize| Vec3::new(0.0, 1.4, 1.0) + STEP * i as f32;
            let before = i.saturating_sub(1);
            let mut frame = jittered_frame(size, eye(i), eye(before), i as u64, jitter(i));
            if conventions.motion_is_jittered {
                let [now, then] = [size, SIZES[before]].map(|size| Vec2::new(size[0] as f32, size[1] as f32));
                for motion in &mut frame.motion {
                    let jittered = Vec2::from(*motion) + jitter(i) / now - jitter(before) / then;
                    *motion = (jittered * now).to_array();
                }
            }
            let images = within(&frame, LARGEST, [0, 0]).upload();
            let inputs = images.inputs(frame.camera, HistoryMode::Continue);
            let viewport = Viewport::of_size(size[0], size[1]);
            let settings = Settings::default().with_conventions(conventions);
            submit(&mut quell, &inputs.with_viewport(viewport), &settings);
            output = cut(&read_output(&images.output), LARGEST, viewport);
        }
        output
    });
    let alike = psnr(&outputs[0], &outputs[1]);
    assert!(alike > 80.0, "{alike:.1} dB");
}

#[test]
fn nothing_is_allocated_where_the_size_changes() {
    let mut quell = denoiser(LARGEST);
    let held = quell.memory();
    assert_eq!(held.total(), held.allocations().map(|allocation| allocation.bytes).sum());
    for size in SIZES {
        let frame = frame(size, Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.0, 1.4, 1.0), 1);
        let images = within(&frame, LARGEST, [0, 0]).upload();
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        submit(&mut quell, &inputs.with_viewport(Viewport::of_size(size[0], size[1])), &Settings::default());
        assert_eq!(quell.memory(), held);
    }
}

#[test]
fn viewports_that_do_not_fit_are_named() {
    let images = within(&frame(SIZE, Vec3::ONE, Vec3::ONE, 1), LARGEST, ORIGIN).upload();
    let mut quell = denoiser(SIZE);
    let gpu = crate::gpu::gpu();
    let cases = [
        ([0, 0], [0, 45], "[0, 45]"),
        ([0, 0], [62, 45], "[61, 45]"),
        ([u32::MAX, 0], [61, 45], "[4294967295, 0]"),
        ([33, 7], [61, 45], "93x75"),
        ([13, 31], [61, 45], "`radiance`"),
    ];
    let mut encode = |origin, size| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let camera = camera(Vec3::ONE, SIZE);
        let inputs = images.inputs(camera, HistoryMode::Continue).with_viewport(Viewport { origin, size });
        quell.encode(&gpu.device, &gpu.queue, &mut encoder, &inputs, &Settings::default())
    };
    for (origin, size, part) in cases {
        let message = encode(origin, size).unwrap_err().to_string();
        assert!(message.contains(part) && message.contains("viewport"), "{message}");
    }
    assert!(encode([32, 30], [61, 45]).is_ok());
}
