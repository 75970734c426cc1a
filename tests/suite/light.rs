//! Light that changes, light that does not, and single bright samples: what the innovation is for, and what it must not cost.

use crate::sequence::{Frame, Light, denoise, denoiser, frame, lit_frame, lit_walk, psnr};
use glam::Vec3;
use quell::Settings;

const SIZE: [u32; 2] = [128, 72];
const SMALL: [u32; 2] = [96, 54];
const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);

fn with(innovation: bool) -> Settings {
    Settings::default().with_innovation(innovation)
}

/// Quality of each frame of a sequence, in dB.
fn qualities(frames: &[Frame], settings: &Settings) -> Vec<f64> {
    let mut quell = denoiser(frames[0].size);
    frames.iter().map(|frame| psnr(&denoise(&mut quell, frame, settings), &frame.truth)).collect()
}

/// By how much innovation helps in the two frames after each of the `switches`.
fn gains_after(frames: &[Frame], switches: &[usize]) -> Vec<f64> {
    let (on, off) = (qualities(frames, &with(true)), qualities(frames, &with(false)));
    println!("with    {on:.1?}\nwithout {off:.1?}");
    switches.iter().flat_map(|&at| [at, at + 1]).map(|i| on[i] - off[i]).collect()
}

/// A slow walk, in another light between the switches.
fn switched(size: [u32; 2], light: Light, switches: [usize; 2]) -> Vec<Frame> {
    let [from, to] = switches.map(|at| at as u32);
    let at = |i| if (from..to).contains(&i) { light } else { Light::ON };
    lit_walk(size, to + 2, Vec3::new(0.004, 0.0, -0.008), 5, at).collect()
}

#[test]
fn a_switched_light_is_followed_at_once() {
    // Dark for as long as history is, so that without innovation the image has come to rest as well.
    let switches = [16, 48];
    let gains = gains_after(&switched(SIZE, Light::all(0.2), switches), &switches);
    println!("gain in the two frames after each switch: {gains:.2?} dB");
    assert!(gains.iter().all(|&gain| gain >= 10.0), "{gains:.2?}");
}

/// One of two lights: how much a pixel changes is not what it was lit by.
#[test]
fn one_of_two_lights_is_followed() {
    let switches = [16, 48];
    let gains_of = |light| gains_after(&switched(SMALL, light, switches), &switches);
    let gains = gains_of(Light { lamp: 0.2, sun: 1.0 });
    println!("gain in the two frames after each switch of the lamp: {gains:.2?} dB");
    let gains_of_sun = gains_of(Light { lamp: 1.0, sun: 0.0 });
    println!("and of the sun: {gains_of_sun:.2?} dB");
    assert!(gains.iter().chain(&gains_of_sun).all(|&gain| gain > 5.0), "{gains:.2?} {gains_of_sun:.2?}");
}

/// Mean over pixels of the variance over frames, of a still view in constant light after `warm_up` frames.
fn flicker(settings: &Settings, warm_up: u64, frames: u64) -> f64 {
    let mut quell = denoiser(SMALL);
    let pixels = (SMALL[0] * SMALL[1]) as usize;
    let (mut sums, mut squares) = (vec![0.0; pixels], vec![0.0; pixels]);
    for i in 0..warm_up + frames {
        let output = denoise(&mut quell, &frame(SMALL, EYE, EYE, 3000 + i), settings);
        if i >= warm_up {
            for (p, colour) in output.iter().enumerate() {
                let level = f64::from(colour.iter().sum::<f32>());
                sums[p] += level;
                squares[p] += level * level;
            }
        }
    }
    let n = frames as f64;
    let variance = |p: usize| (squares[p] - sums[p] * sums[p] / n) / (n - 1.0);
    (0..pixels).map(variance).sum::<f64>() / pixels as f64
}

#[test]
fn constant_light_flickers_no_more_with_innovation() {
    for max_history in [32.0, 1024.0] {
        let of = |settings: Settings| flicker(&settings.with_max_history(max_history), 40, 32);
        let ratio = of(with(true)) / of(with(false));
        println!("temporal variance with innovation over that without, history of {max_history}: {ratio:.3}");
        assert!(ratio <= 1.1, "history of {max_history}: {ratio}");
    }
}

/// On a still view the error keeps falling, and the innovation takes nothing that counts from it.
#[test]
fn innovation_does_not_stop_convergence() {
    let of = |settings: Settings| -> Vec<f64> {
        let mut quell = denoiser(SMALL);
        let mut at = vec![];
        for i in 0..128 {
            let frame = frame(SMALL, EYE, EYE, 5000 + i);
            let settings = settings.with_max_history(1024.0);
            let output = denoise(&mut quell, &frame, &settings);
            if [0, 7, 31, 127].contains(&i) {
                at.push(psnr(&output, &frame.truth));
            }
        }
        at
    };
    let (on, off) = (of(with(true)), of(with(false)));
    println!("still view after 1, 8, 32, 128 frames: {on:.2?} dB, without innovation {off:.2?} dB");
    assert!(on.is_sorted_by(|a, b| *b > *a + 1.0), "{on:?}");
    assert!(on.iter().zip(&off).all(|(on, off)| *on > off - 0.5), "{on:?} {off:?}");
}

/// Sum of absolute differences of two images.
fn distance(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).sum()
}

/// Settings with the limit of the defaults, and without.
fn limits() -> [Settings; 2] {
    [Settings::default().firefly_limit, f32::INFINITY]
        .map(|firefly_limit| Settings::default().with_firefly_limit(firefly_limit))
}

#[test]
fn a_firefly_is_cut() {
    // The frame of the firefly, and those after it.
    let images = |settings: &Settings, firefly: bool| -> Vec<Vec<[f32; 3]>> {
        let mut quell = denoiser(SMALL);
        let mut frames = (0..12).map(|i| frame(SMALL, EYE, EYE, 4000 + i)).collect::<Vec<_>>();
        if firefly {
            frames[8].radiance[30 * SMALL[0] as usize + 41] = [1e4; 4];
        }
        frames.iter().map(|frame| denoise(&mut quell, frame, settings)).skip(8).collect()
    };
    let changes = |settings: &Settings| -> Vec<f32> {
        let (with, without) = (images(settings, true), images(settings, false));
        with.iter().zip(&without).map(|(with, without)| distance(with, without)).collect()
    };
    let [limited, unlimited] = limits().map(|settings| changes(&settings));
    println!("what a sample of 1e4 changes, in sum: {limited:.1?}, without limit {unlimited:.1?}");
    assert!(limited.iter().zip(&unlimited).all(|(limited, unlimited)| limited < unlimited));
    assert!(limited.iter().sum::<f32>() < 0.75 * unlimited.iter().sum::<f32>());
}

/// Where nothing was lit there is no variance to measure fireflies by; what lights up then is no firefly.
#[test]
fn light_from_darkness_is_not_cut_for_good() {
    let frames: Vec<Frame> = (0..40)
        .map(|i| lit_frame(SMALL, EYE, EYE, 6000 + i, Light::all(if i < 8 { 0.0 } else { 1.0 })))
        .collect();
    let [limited, unlimited] = limits().map(|settings| qualities(&frames, &settings));
    println!("light from darkness: {:.1?} dB, without limit {:.1?} dB", &limited[6..], &unlimited[6..]);
    assert!(limited[39] > unlimited[39] - 1.0, "{} {}", limited[39], unlimited[39]);
    assert!(limited[8] > unlimited[8] - 1.0, "{} {}", limited[8], unlimited[8]);
}
