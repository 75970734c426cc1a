//! Which pixels get samples.

use crate::scenes::{lit_box, look_at};
use crate::{GPU, read, still};
use glam::vec3;
use quell_demo::gbuffer::GBuffer;
use quell_demo::image::write_texture;
use quell_demo::scene::{CameraPose, Scene, Sky};
use quell_demo::tracer::{Sampling, TraceSettings, Tracer};

const SIZE: u32 = 24;
const PIXELS: usize = (SIZE * SIZE) as usize;

/// A box in front of the sky.
fn scene() -> (Scene, CameraPose) {
    let (mut scene, _) = lit_box();
    scene.sky = Sky::constant(vec3(0.25, 0.5, 0.75));
    (scene, look_at(vec3(0.5, 0.7, 4.0), vec3(0.0, 0.0, 0.0), 0.9))
}

/// Counts and radiance of frames traced one after the other.
struct Traced {
    tracer: Tracer,
    pose: CameraPose,
    out: GBuffer,
}

impl Traced {
    fn new() -> Self {
        let (scene, pose) = scene();
        Self {
            tracer: Tracer::new(&GPU, &scene).expect("the scene fits"),
            pose,
            out: GBuffer::new(&GPU.device, SIZE, SIZE),
        }
    }

    fn frame(&self, sampling: Sampling, spp: f32, frame: u32) -> (Vec<u32>, Vec<[f32; 4]>) {
        let settings = TraceSettings { spp, sampling, frame, ..Default::default() };
        let mut encoder = GPU.device.create_command_encoder(&Default::default());
        self.tracer.encode(&GPU, &mut encoder, &still(&self.pose, SIZE, 0.0), &settings, &self.out);
        GPU.queue.submit([encoder.finish()]);
        (read(&self.out.sample_count), read(&self.out.radiance))
    }

    fn is_sky(&self) -> Vec<bool> {
        let depth: Vec<f32> = read(&self.out.depth);
        depth.iter().map(|depth| !depth.is_finite()).collect()
    }
}

/// Pixels without samples are black; the others see what they see in a frame in which all get as many.
fn assert_same_paths(traced: &Traced, counts: &[u32], radiance: &[[f32; 4]], frame: u32) {
    let most = *counts.iter().max().unwrap();
    for k in 1..=most {
        let (_, all) = traced.frame(Sampling::Uniform, k as f32, frame);
        let alike = (0..PIXELS).filter(|&i| counts[i] == k);
        alike.for_each(|i| assert_eq!(radiance[i], all[i], "pixel {i} with {k} samples"));
    }
    let left_out = (0..PIXELS).filter(|&i| counts[i] == 0);
    left_out.for_each(|i| assert_eq!(radiance[i][..3], [0.0; 3]));
}

#[test]
fn fewer_than_one_sample_a_pixel_are_spread_over_pixels_and_frames() {
    let traced = Traced::new();
    let mut sums = vec![0; PIXELS];
    for frame in 0..16 {
        let (counts, radiance) = traced.frame(Sampling::Uniform, 0.25, frame);
        let sky = traced.is_sky();
        assert!(sky.iter().filter(|&&is_sky| is_sky).count() > 50, "the test shows no sky");
        let surface: Vec<u32> = (0..PIXELS).filter(|&i| !sky[i]).map(|i| counts[i]).collect();
        let mean = f64::from(surface.iter().sum::<u32>()) / surface.len() as f64;
        assert!((mean - 0.25).abs() < 0.04, "{mean} in frame {frame}");
        assert!(
            (0..PIXELS).all(|i| !sky[i] || counts[i] == 1),
            "the sky is not denoised, so it is always seen"
        );
        sums.iter_mut().zip(&counts).for_each(|(sum, count)| *sum += count);
        if frame < 2 {
            assert_same_paths(&traced, &counts, &radiance, frame);
        }
    }
    let sky = traced.is_sky();
    assert!((0..PIXELS).all(|i| sky[i] || (3..=5).contains(&sums[i])), "{sums:?}");
}

#[test]
fn a_checkerboard_alternates() {
    let traced = Traced::new();
    let [(first, radiance), (second, _)] =
        [4, 5].map(|frame| traced.frame(Sampling::Checkerboard, 0.5, frame));
    let sky = traced.is_sky();
    for i in 0..PIXELS {
        let is_white = (i as u32 % SIZE + i as u32 / SIZE).is_multiple_of(2);
        let expected = if sky[i] { [1, 1] } else { [u32::from(is_white), u32::from(!is_white)] };
        assert_eq!([first[i], second[i]], expected, "pixel {i}");
    }
    assert_same_paths(&traced, &first, &radiance, 4);
}

#[test]
fn the_map_is_obeyed() {
    let traced = Traced::new();
    let map: Vec<u32> = (0..PIXELS as u32).map(|i| (i * 7 + i / 5) % 4).collect();
    write_texture(&GPU.queue, traced.out.sample_map.texture(), &map);
    let (counts, radiance) = traced.frame(Sampling::Adaptive, 1.0, 3);
    let sky = traced.is_sky();
    (0..PIXELS).for_each(|i| assert_eq!(counts[i], if sky[i] { map[i].max(1) } else { map[i] }));
    assert!((0..4).all(|k| counts.contains(&k)));
    assert_same_paths(&traced, &counts, &radiance, 3);
}
