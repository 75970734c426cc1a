//! The moments of the change of the light, of the images as the pass wrote them.

use super::super::packed::unpack_noises;
use super::super::regression::{Pixel, Tile, correlations, leave_out, tiles_of};
use super::super::surface::surface_features;
use super::super::{Signal, luminance, mismatches, rgb, unpack_samples};
use super::{Ran, flat, no_emission, run_pass};
use crate::mirror::mirrored;
use crate::sequence::{Frame, frame};
use glam::Vec3;
use quell::gpu::flags;
use quell::layout::{INNOVATIONS, SURFACE_FEATURES};
use rand::{Rng, SeedableRng, rngs::StdRng};

const N: usize = INNOVATIONS.columns() as usize;

/// Of the pixels that have a surface, samples and history.
fn expected(ran: &Ran, frame: &Frame, signal: Signal) -> Vec<Tile<N>> {
    let noise = unpack_noises(&ran.noise, &ran.history);
    let samples = unpack_samples(&ran.signal, &frame.samples);
    tiles_of(frame.size, false, |i| {
        let (sample, old) = (samples[i], ran.history[i]);
        if ran.surfaces[i].is_miss() || sample[3] <= 0.0 || old[3] <= 0.0 {
            return None;
        }
        let mut columns = [0.0; N];
        columns[..SURFACE_FEATURES as usize].copy_from_slice(&surface_features(
            &ran.uniforms,
            signal,
            i,
            &ran.surfaces[i],
        ));
        (0..3).for_each(|c| columns[N - 3 + c] = sample[c] - old[c]);
        let noises = [noise[i].variance, luminance(rgb(&old)), old[3]];
        Some(Pixel { weight: sample[3], columns, noises })
    })
}

fn check(signal: Signal, saving: u32) {
    let size = [45, 35]; // not a multiple of the tile
    let mut random = StdRng::seed_from_u64(22);
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (mut before, mut now) = (frame(size, from, from, 1), frame(size, to, from, 2));
    now.normal.iter_mut().for_each(|n| n[3] = random.random());
    now.samples.iter_mut().for_each(|samples| *samples = [0, 1, 1, 2, 3, 8, 40][random.random_range(0..7)]);
    let mut flags = 0;
    if signal == Signal::Specular {
        [before, now] = [mirrored(&before, 5), mirrored(&now, 6)];
        flags = flags::SPLIT | flags::HIT_DISTANCE;
    }
    let ran = run_pass(&now, &before, &flat(&now.motion), &no_emission(&now), |own| own | flags | saving, 23);
    let mut tiles = expected(&ran, &now, signal);
    let mut found = ran.moments.clone();
    let least = if saving == flags::SPARSE { 7 } else { 15 };
    if saving == flags::SPARSE {
        leave_out(&mut tiles, &mut found, ran.uniforms.tiles[0]);
    }
    assert!(tiles.iter().filter(|tile| tile.rows.len() > 20).count() > least, "the test shows too little");
    let mut expected: Vec<f64> = tiles.iter().flat_map(Tile::flat).collect();
    let wrong = |expected: &[f64]| match signal {
        // Sums of 64 products of f32 with weights up to 40; squares near 0 keep the rounding of the terms they cancel from.
        Signal::Combined => mismatches(&found, expected, 1e-4, 1e-3),
        // What is reflected may lie far away, and its squares are rounded as those of their size.
        Signal::Specular => {
            let [found, expected] = [&found, expected].map(|tiles| correlations::<N>(tiles, expected));
            mismatches(&found, &expected, 1e-4, 1e-3)
        }
    };
    assert_eq!(wrong(&expected), 0.0);
    expected.iter_mut().step_by(N).for_each(|v| *v += 0.1);
    assert!(wrong(&expected) > 0.01);
}

#[test]
fn matches_its_twin_on_every_tile() {
    check(Signal::Combined, 0);
}

#[test]
fn matches_its_twin_on_every_tile_of_mirrors() {
    check(Signal::Specular, 0);
}

#[test]
fn matches_its_twin_where_tiles_are_left_out() {
    check(Signal::Combined, flags::SPARSE);
}
