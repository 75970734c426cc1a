//! `reproject` against its f64 twin.

use super::noise::{Noise, random_noise, unpack};
use super::surface::{Surface, position_at, position_of, project};
use super::{guide, mismatches, random_history, run, uniforms, wide};
use crate::gpu::{blank, download, gpu, upload};
use crate::sequence::{Frame, frame, jittered_frame};
use glam::{DVec2, DVec3, Vec2, Vec3};
use quell::gpu::{FrameUniforms, flags};
use quell::passes::reproject::{Reproject, ReprojectViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

struct Previous<'a> {
    surfaces: &'a [Surface],
    history: &'a [[f64; 4]],
    noise: &'a [Noise],
}

/// Texel, position relative to the previous eye, surface and tolerance of a pixel's origin.
struct Origin {
    texel: DVec2,
    position: DVec3,
    surface: Surface,
    tolerance: f64,
}

fn find_origin(u: &FrameUniforms, i: usize, surface: Surface, motion: [f32; 3]) -> Option<Origin> {
    let size = DVec2::new(u.size[0].into(), u.size[1].into());
    let pixel = DVec2::new((i as u32 % u.size[0]).into(), (i as u32 / u.size[0]).into());
    let uv = (pixel + 0.5) / size;
    let offset = DVec2::new(motion[0].into(), motion[1].into());
    if !offset.is_finite() || offset.abs().max_element() > 4.0 {
        return None;
    }
    let mut texel = (uv + offset) * size - 0.5;
    if (texel - texel.round()).abs().max_element() < 0.002 {
        texel = texel.round();
    }
    let jitter = DVec2::new(u.current.jitter[0].into(), u.current.jitter[1].into());
    let sampled = uv + jitter / size;
    let still =
        project(&u.previous, position_at(&u.current, sampled, surface.depth) + u.eye_delta.as_dvec3());
    let stands_still = ((still.truncate() - sampled - offset).abs() * size).max_element() < 0.5;
    let (depth, slack) = if u.flags & flags::MOTION_DEPTH != 0 && motion[2].is_finite() {
        (surface.depth + f64::from(motion[2]), 1.0)
    } else if stands_still {
        (still.z, 1.0)
    } else {
        (surface.depth, 10.0)
    };
    let position = position_at(&u.previous, sampled + offset, depth);
    Some(Origin { texel, position, surface, tolerance: 0.01 * surface.depth * slack })
}

/// Index of a tap that belongs to the origin's surface.
fn tap(u: &FrameUniforms, texel: DVec2, origin: &Origin, previous: &Previous<'_>) -> Option<usize> {
    let [width, height] = u.size.map(f64::from);
    if texel.x < 0.0 || texel.y < 0.0 || texel.x >= width || texel.y >= height {
        return None;
    }
    let index = (texel.y * width + texel.x) as usize;
    let tap = previous.surfaces[index];
    let offset = position_of(u, &u.previous, texel, tap.depth) - origin.position;
    let belongs = !tap.is_miss()
        && tap.id == origin.surface.id
        && tap.normal.dot(origin.surface.normal) > 0.8
        && tap.normal.dot(offset).abs() < origin.tolerance;
    belongs.then_some(index)
}

fn cubic(f: f64) -> [f64; 4] {
    let (f2, f3) = (f * f, f * f * f);
    [-f3 + 2.0 * f2 - f, 3.0 * f3 - 5.0 * f2 + 2.0, -3.0 * f3 + 4.0 * f2 + f, f3 - f2].map(|w| 0.5 * w)
}

fn reproject(u: &FrameUniforms, origin: &Origin, previous: &Previous<'_>) -> ([f64; 4], Noise) {
    let base = origin.texel.floor();
    let f = origin.texel - base;
    let (mut sum, mut noise, mut weight, mut all_valid) = ([0.0; 4], Noise::default(), 0.0, true);
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let w = (1.0 - (f.x - dx).abs()) * (1.0 - (f.y - dy).abs());
        if w == 0.0 {
            continue;
        }
        match tap(u, base + DVec2::new(dx, dy), origin, previous) {
            Some(i) if previous.history[i][3] > 0.0 => {
                (0..4).for_each(|c| sum[c] += w * previous.history[i][c]);
                noise.variance += w * previous.noise[i].variance;
                (0..3).for_each(|k| noise.deviations[k] += w * previous.noise[i].deviations[k]);
                weight += w;
            }
            Some(_) => {}
            None => all_valid = false,
        }
    }
    if weight < 0.05 {
        return ([0.0; 4], Noise::default());
    }
    let mut history = sum.map(|s| s / weight);
    noise.variance /= weight;
    noise.deviations = noise.deviations.map(|s| s / weight);
    if all_valid && f != DVec2::ZERO {
        let mut sharp = Some([0.0; 6]);
        for (y, wy) in (-1..).zip(cubic(f.y)) {
            for (x, wx) in (-1..).zip(cubic(f.x)) {
                if wx * wy == 0.0 {
                    continue;
                }
                let at = base + DVec2::new(x.into(), y.into());
                let index = tap(u, at, origin, previous).filter(|&i| previous.history[i][3] > 0.0);
                sharp = sharp.zip(index).map(|(mut sum, i)| {
                    (0..3).for_each(|c| sum[c] += wx * wy * previous.history[i][c]);
                    (0..3).for_each(|k| sum[3 + k] += wx * wy * previous.noise[i].deviations[k]);
                    sum
                });
            }
        }
        if let Some(sharp) = sharp {
            (0..3).for_each(|c| history[c] = sharp[c].max(0.0));
            noise.deviations.copy_from_slice(&sharp[3..]);
        }
    }
    (history, noise)
}

/// Motion without a change of depth.
fn flat(motion: &[[f32; 2]]) -> Vec<[f32; 3]> {
    motion.iter().map(|m| [m[0], m[1], 0.0]).collect()
}

/// Share of mismatches between the GPU, given the first motion, and the twin, given the second.
fn check(
    now: &Frame,
    before: &Frame,
    [gpu_motion, motion]: [&[[f32; 3]]; 2],
    extra_flags: u32,
    seed: u64,
) -> f64 {
    let gpu_motion: Vec<_> = gpu_motion.iter().map(|m| [m[0], m[1], m[2], 0.0]).collect();
    let mut random = StdRng::seed_from_u64(seed);
    let mut u = uniforms(now, before);
    u.flags |= extra_flags;
    let (words, surfaces) = guide(now);
    let (previous_words, previous_surfaces) = guide(before);
    let history = random_history(&mut random, surfaces.len());
    let noise = random_noise(&mut random, surfaces.len());
    let size = now.size;
    let reprojected = blank(size, Format::Rgba16Float);
    let reprojected_noise = blank(size, Format::Rgba16Float);
    let pass = Reproject::new(&gpu().device);
    run(&u, |recorder| {
        let views = ReprojectViews {
            guide: &upload(size, Format::Rgba32Uint, &words),
            motion: &upload(size, Format::Rgba32Float, &gpu_motion),
            previous_guide: &upload(size, Format::Rgba32Uint, &previous_words),
            previous_history: &upload(size, Format::Rgba16Float, &history),
            previous_noise: &upload(size, Format::Rgba16Float, &noise),
            reprojected: &reprojected,
            reprojected_noise: &reprojected_noise,
        };
        pass.record(recorder, &views, size);
    });
    let found = wide(&download(&reprojected));
    let found_noise = wide(&download(&reprojected_noise));

    let (wide_history, noise) = (wide(&history), unpack(&noise));
    let previous = Previous { surfaces: &previous_surfaces, history: &wide_history, noise: &noise };
    let expected: Vec<_> = surfaces
        .iter()
        .enumerate()
        .map(|(i, &surface)| {
            let origin = find_origin(&u, i, surface, motion[i]).filter(|_| !surface.is_miss());
            origin.map_or(([0.0; 4], Noise::default()), |origin| reproject(&u, &origin, &previous))
        })
        .collect();
    assert!(expected.iter().any(|(h, _)| h[3] > 0.0), "no pixel has history: the test would show nothing");
    let flat: Vec<f64> = expected.iter().flat_map(|(h, noise)| [*h, noise.packed()].concat()).collect();
    let flat_found: Vec<f64> =
        found.iter().zip(&found_noise).flat_map(|(h, noise)| [*h, *noise].concat()).collect();
    // Half floats round to 2^-10 of the value (dithered: up to one whole step); 2e-3 near 0 is that of a texel's weight.
    mismatches(&flat_found, &flat, 2.0_f64.powi(-10) + 1e-4, 2e-3)
}

const SIZE: [u32; 2] = [83, 61];

// A tap that lies on a threshold falls to either side by rounding: a few pixels in a thousand may differ.
const ON_A_THRESHOLD: f64 = 0.005;

#[test]
fn matches_its_twin_under_camera_motion() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (before, now) = (frame(SIZE, from, from, 1), frame(SIZE, to, from, 2));
    let wrong = check(&now, &before, [&flat(&now.motion); 2], 0, 3);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}

#[test]
fn matches_its_twin_under_arbitrary_and_invalid_motion() {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let (before, now) = (frame(SIZE, eye, eye, 1), frame(SIZE, eye, eye, 2));
    let mut random = StdRng::seed_from_u64(4);
    let motion: Vec<[f32; 2]> = now
        .motion
        .iter()
        .map(|_| match random.random_range(0..10) {
            0 => [f32::NAN, 0.0],
            1 => [0.0, f32::INFINITY],
            2 => [1e30, -1e30],
            3 => [0.0, 0.0],
            _ => [random.random_range(-0.2..0.2), random.random_range(-0.2..0.2)],
        })
        .collect();
    let wrong = check(&now, &before, [&flat(&motion); 2], 0, 5);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}

#[test]
fn matches_its_twin_where_motion_tells_the_change_of_depth() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (before, now) = (frame(SIZE, from, from, 1), frame(SIZE, to, from, 2));
    let mut random = StdRng::seed_from_u64(6);
    let motion: Vec<[f32; 3]> = now
        .motion
        .iter()
        .map(|m| [m[0], m[1], [0.0, 0.1, -0.02, f32::NAN][random.random_range(0..4)]])
        .collect();
    let wrong = check(&now, &before, [&motion; 2], flags::MOTION_DEPTH, 7);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
    // Without the flag the same change of depth is not looked at.
    assert!(check(&now, &before, [&motion, &flat(&now.motion)], flags::MOTION_DEPTH, 7) > 0.1);
}

#[test]
fn matches_its_twin_with_jitter() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let before = jittered_frame(SIZE, from, from, 1, Vec2::new(0.4, -0.3));
    let now = jittered_frame(SIZE, to, from, 2, Vec2::new(-0.2, 0.45));
    let wrong = check(&now, &before, [&flat(&now.motion); 2], 0, 8);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}

#[test]
fn the_comparison_fails_where_the_gpu_gets_motion_that_is_off_by_a_pixel() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (before, now) = (frame(SIZE, from, from, 1), frame(SIZE, to, from, 2));
    let motion = flat(&now.motion);
    let shifted: Vec<_> = motion.iter().map(|m| [m[0] + 1.0 / SIZE[0] as f32, m[1], 0.0]).collect();
    assert!(check(&now, &before, [&shifted, &motion], 0, 3) > 0.2);
}
