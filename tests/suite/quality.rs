//! Whole frames against the truth of an analytic scene, as ratios to plain accumulation in the same run.

use crate::sequence::{Frame, denoise, denoiser, psnr, walk};
use glam::Vec3;
use quell::Settings;

const SIZE: [u32; 2] = [192, 108];

#[test]
fn a_walk_is_denoised_better_frame_by_frame_than_its_input() {
    let mut quell = denoiser(SIZE);
    for (i, frame) in walk(SIZE, 24, Vec3::new(0.01, 0.0, -0.02), 1).enumerate() {
        let output = denoise(&mut quell, &frame, &Settings::default());
        if std::env::var_os("QUELL_DUMP").is_some() {
            dump(&format!("out{i}"), &output);
            dump(&format!("noisy{i}"), &noisy(&frame));
            dump(&format!("truth{i}"), &frame.truth);
        }
        println!("{i}: noisy {:.2}, quell {:.2}", psnr(&noisy(&frame), &frame.truth), psnr(&output, &frame.truth));
    }
}

fn dump(name: &str, image: &[[f32; 3]]) {
    let mut text = format!("P3 {} {} 255\n", SIZE[0], SIZE[1]);
    for p in image { for c in p { text += &format!("{} ", ((c/(1.0+c)).max(0.0).powf(1.0/2.2)*255.0) as u32); } }
    std::fs::write(format!("/tmp/dump/{name}.ppm"), text).unwrap();
}

fn noisy(frame: &Frame) -> Vec<[f32; 3]> {
    frame.radiance.iter().map(|t| [t[0], t[1], t[2]]).collect()
}
