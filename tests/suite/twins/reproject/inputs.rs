//! What `reproject` makes of the caller's images: the packed surface and sample of each pixel.

use super::super::packed::{NO_SAMPLE, signal_step, unpack_signal};
use super::super::surface::{demodulator, pack, read, unpack};
use super::{Ran, SIZE, flat, no_emission, run_pass};
use crate::sequence::{Frame, frame};
use glam::Vec3;
use half::f16;
use quell::gpu::flags;
use rand::{Rng, SeedableRng, rngs::StdRng};

const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);

/// Replaces some values by what renderers leave there by mistake.
fn break_some(random: &mut StdRng, values: &mut [f32], chance: f64) {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e30, f32::MAX];
    for value in values {
        if random.random_bool(chance) {
            *value = bad[random.random_range(0..bad.len())];
        }
    }
}

/// A frame in which every image is broken somewhere, and normals and materials are arbitrary elsewhere.
fn broken_frame(random: &mut StdRng) -> (Frame, Vec<[f16; 4]>) {
    let mut frame = frame(SIZE, EYE, EYE, 1);
    let mut emission = vec![0.0; 4 * frame.depth.len()];
    break_some(random, frame.radiance.as_flattened_mut(), 0.02);
    break_some(random, &mut frame.depth, 0.05);
    break_some(random, &mut emission, 0.02);
    for i in 0..frame.depth.len() {
        frame.normal[i] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
        frame.albedo[i] = std::array::from_fn(|_| random.random_range(0.0..1.0_f32).powi(3));
        frame.id[i] = random.random();
        frame.samples[i] = [0, 1, 1, 7, 1024, 5000][random.random_range(0..6)];
        emission[4 * i] += random.random_range(0.0..1.0_f32);
    }
    break_some(random, frame.normal.as_flattened_mut(), 0.02);
    break_some(random, frame.albedo.as_flattened_mut(), 0.02);
    let emission: Vec<f16> = emission.into_iter().map(f16::from_f32).collect();
    let emission = emission.chunks(4).map(|e| [e[0], e[1], e[2], e[3]]).collect();
    (frame, emission)
}

/// What is seen of a pixel without emission, demodulated; none if it cannot be used.
pub fn sample(frame: &Frame, emission: Option<&[[f16; 4]]>, i: usize) -> Option<[f64; 3]> {
    let [r, g, b, _] = frame.radiance[i].map(f64::from);
    let usable = [r, g, b].iter().all(|c| c.is_finite()) && frame.samples[i] > 0;
    if !usable || read(frame, f64::INFINITY, i).is_miss() {
        return None;
    }
    let emitted = emission.map_or([0.0; 3], |emission| {
        let [r, g, b, _] = emission[i].map(f64::from);
        let rgb = [r, g, b];
        if rgb.iter().all(|c| c.is_finite()) { rgb.map(|c| c.max(0.0)) } else { [0.0; 3] }
    });
    let albedo = demodulator(frame, i);
    // The largest that the image holds.
    Some(std::array::from_fn(|c| (([r, g, b][c].max(0.0) - emitted[c]).max(0.0) / albedo[c]).min(65408.0)))
}

/// Mean error of the samples, in steps of their mantissas.
fn check_signal(ran: &Ran, frame: &Frame, emission: Option<&[[f16; 4]]>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, &word) in ran.signal.iter().enumerate() {
        let Some(expected) = sample(frame, emission, i) else {
            assert_eq!(word, NO_SAMPLE, "pixel {i} has no sample");
            continue;
        };
        assert_ne!(word, NO_SAMPLE, "pixel {i} has a sample");
        let (found, step) = (unpack_signal(word), signal_step(expected));
        for c in 0..3 {
            let off = (found[c] - expected[c]) / step;
            // At the end of the range there is nothing to round to.
            assert!(off.abs() < 1.01, "pixel {i}: {found:?} {expected:?}");
            if expected[c] > 0.0 && expected[c] < 65000.0 {
                (sum, count) = (sum + off, count + 1.0);
            }
        }
    }
    assert!(count > 3000.0, "{count}");
    sum / count
}

#[test]
fn inputs_are_repaired_and_packed_as_by_the_twin() {
    let mut random = StdRng::seed_from_u64(13);
    let (frame, emission) = broken_frame(&mut random);
    let ran = run_pass(&frame, &frame, &flat(&frame.motion), &emission, |flags| flags | flags::EMISSION, 14);
    let mut unequal = 0;
    for (i, &words) in ran.guide.iter().enumerate() {
        let expected = pack(&read(&frame, f64::INFINITY, i));
        let (found, twin) = (unpack(words), unpack(expected));
        // What lies between two codes may fall to either by rounding.
        unequal += usize::from(words != expected);
        let close = found.id == twin.id
            // A step of 1/1023 in each axis of the octahedron's square, stretched by up to 3.
            && found.normal.dot(twin.normal) > (3.0 * 2.0_f64.sqrt() / 1023.0).cos()
            && (found.roughness - twin.roughness).abs() < 1.01 / 31.0
            && (found.cue.sqrt() - twin.cue.sqrt()).abs() < 1.01 / 127.0
            && (found.depth - twin.depth).abs() <= twin.depth / 8191.0;
        assert!(close, "pixel {i}: {found:?} {twin:?}");
    }
    assert!(unequal < ran.guide.len() / 200, "{unequal}");
    let drift = check_signal(&ran, &frame, Some(&emission));
    assert!(drift.abs() < 0.02, "samples drift by {drift} steps");
}

#[test]
fn optional_images_are_not_looked_at_without_their_flags() {
    let mut random = StdRng::seed_from_u64(15);
    let (mut frame, emission) = broken_frame(&mut random);
    let none = |flags: u32| flags & !(flags::SURFACE_ID | flags::SAMPLE_COUNT);
    let ran = run_pass(&frame, &frame, &flat(&frame.motion), &emission, none, 16);
    frame.samples.fill(1);
    check_signal(&ran, &frame, None);
    assert!(ran.surfaces.iter().all(|surface| surface.id == 0));
}

/// A miss shows its radiance, repaired, and has no history.
#[test]
fn a_miss_carries_its_radiance() {
    let mut random = StdRng::seed_from_u64(17);
    let (mut frame, _) = broken_frame(&mut random);
    frame.depth.iter_mut().step_by(2).for_each(|depth| *depth = f32::INFINITY);
    let ran = run_pass(&frame, &frame, &flat(&frame.motion), &no_emission(&frame), |flags| flags, 18);
    let mut misses = 0;
    for i in (0..ran.surfaces.len()).filter(|&i| ran.surfaces[i].is_miss()) {
        misses += 1;
        let seen = [0, 1, 2].map(|c| f64::from(frame.radiance[i][c]));
        let finite = seen.iter().all(|c| c.is_finite());
        let [r, g, b, count] = ran.history[i];
        assert_eq!(count, 0.0);
        for (found, seen) in [r, g, b].into_iter().zip(seen) {
            let expected = if finite { seen.clamp(0.0, 65504.0) } else { 0.0 };
            // One dithered step of a half float.
            assert!((found - expected).abs() <= expected / 1024.0, "{found} {expected}");
        }
    }
    assert!(misses > 1000, "{misses}");
}
