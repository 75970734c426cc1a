//! The models that the GPU fitted, with the windows that it chose, against the twin's.

use super::super::mismatches;
use super::super::regression::{HEAD, Model, Tile};
use super::tiles::{SIZE, adversarial_tiles, random_tiles};
use super::{F, N, candidates, run_fit};
use quell::{Centres, Windows};
use rand::{SeedableRng, rngs::StdRng};

/// How far the GPU is from the twin.
#[derive(Debug, PartialEq)]
struct Difference {
    /// Centres with a window that is not among the best.
    windows: usize,
    /// Centres whose weight, noises, trust or predicted error differ.
    heads: usize,
    /// Share of predictions that differ.
    predictions: f64,
}

const NONE: Difference = Difference { windows: 0, heads: 0, predictions: 0.0 };

/// Fits `gpu_tiles` on the GPU and `tiles` by the twin. Also counts the windows of each size that the GPU chose.
fn compare(
    gpu_tiles: &[Tile<N>],
    tiles: &[Tile<N>],
    windows: Windows,
    centres: Centres,
) -> (Difference, [usize; 4]) {
    let found = run_fit(gpu_tiles, SIZE, windows, centres);
    let (mut chosen, mut wrong_windows, mut wrong_heads) = ([0; 4], 0, 0);
    let mut wrong = vec![];
    for (centre, &size) in found.windows.iter().enumerate().filter(|(_, size)| **size > 0) {
        chosen[size as usize] += 1;
        let all = candidates(tiles, &found.frame, centre, windows == Windows::RingError);
        let least = all.iter().map(|candidate| candidate.risk).fold(f64::INFINITY, f64::min);
        let Some(twin) = all.into_iter().find(|candidate| candidate.size == size) else {
            wrong_windows += 1;
            continue;
        };
        // Rounding of f32: 1e-3 of an error, a millionth of the squared brightness that errors cancel from.
        let rounding = 1e-6 * twin.brightest * twin.brightest;
        wrong_windows += usize::from(twin.risk > 1.001 * least + rounding);
        let head = &found.models[centre][..HEAD];
        let head: Vec<f64> = head.iter().copied().map(f64::from).collect();
        let close = mismatches(&head[1..3], &[twin.noise_gain, twin.relative_noise], 1e-3, 1e-9) == 0.0
            // The residual of a perfect fit is what rounding leaves.
            && head[0] >= 0.97 * twin.trust(twin.residual + rounding * twin.weight)
            && head[0] <= 1.03 * twin.trust((twin.residual - rounding * twin.weight).max(0.0))
            && (head[3] - twin.error).abs() <= 1e-2 * twin.risk + rounding;
        wrong_heads += usize::from(!close);
        // Coefficients of collinear features are not unique to f32's eye; what they predict in the window is.
        let model = Model::<N>::stored(&found.models[centre]);
        let rows = || twin.rows.iter().step_by(3);
        let values =
            |model: &Model<N>| -> Vec<f64> { rows().flat_map(|(_, c)| model.value(&c[..F])).collect() };
        // f32 sums over up to 400 pixels and a system of condition up to 1/ridge: 1e-3 of the value; and where large values
        // cancel to small ones, the rounding of some hundred sums of the large.
        wrong.push(mismatches(&values(&model), &values(&twin.model), 1e-3, 1e-4 * twin.brightest));
    }
    let predictions = wrong.iter().sum::<f64>() / wrong.len() as f64;
    (Difference { windows: wrong_windows, heads: wrong_heads, predictions }, chosen)
}

#[test]
fn every_window_of_random_tiles_matches_its_twin() {
    let mut random = StdRng::seed_from_u64(32);
    let tiles = random_tiles(&mut random, SIZE, 16);
    // Mallows' Cp has the least and the widest to choose from.
    for (windows, sizes) in [(Windows::RingError, &[1, 2, 3][..]), (Windows::MallowsCp, &[1, 3])] {
        let (difference, chosen) = compare(&tiles, &tiles, windows, Centres::Uniform(1));
        assert_eq!(difference, NONE, "{windows:?}");
        // All of them are chosen somewhere, so all are tested.
        assert!(sizes.iter().all(|&size| chosen[size] >= 2), "{windows:?}: {chosen:?}");
        assert_eq!(
            sizes.iter().map(|&size| chosen[size]).sum::<usize>(),
            chosen[1..].iter().sum(),
            "{windows:?}"
        );
        assert_eq!(compare(&tiles, &tiles, windows, Centres::Adaptive).0, NONE, "{windows:?}, adaptive");
    }
    for size in 1..=3 {
        let windows = Windows::Fixed(size);
        let (difference, chosen) = compare(&tiles, &tiles, windows, Centres::Uniform(2));
        assert_eq!(difference, NONE, "{windows:?}");
        assert_eq!(chosen.iter().sum::<usize>(), chosen[size as usize], "{windows:?}: {chosen:?}");
    }
}

#[test]
fn adversarial_tiles_match_their_twin() {
    let mut random = StdRng::seed_from_u64(33);
    for (name, tiles) in adversarial_tiles(&mut random) {
        for windows in [Windows::RingError, Windows::MallowsCp, Windows::Fixed(2)] {
            let (difference, chosen) = compare(&tiles, &tiles, windows, Centres::Uniform(2));
            assert_eq!(difference, NONE, "{name}, {windows:?}, {chosen:?}");
        }
    }
}

/// The comparison fails where the twin gets other tiles than the GPU, in everything that depends on them.
#[test]
fn the_comparison_fails_on_other_tiles() {
    let mut random = StdRng::seed_from_u64(34);
    let tiles = random_tiles(&mut random, SIZE, 16);
    let mut steeper = tiles.clone();
    steeper.iter_mut().flat_map(|tile| &mut tile.rows).for_each(|(_, c)| c[F] += 0.1 * c[9]);
    let (difference, _) = compare(&tiles, &steeper, Windows::RingError, Centres::Uniform(2));
    assert!(difference.predictions > 0.1 && difference.heads > 10, "{difference:?}");
    // The edge elsewhere: other windows are best.
    let mut moved = tiles.clone();
    for (_, c) in moved.iter_mut().flat_map(|tile| &mut tile.rows) {
        c[F] += if (38.0..58.0).contains(&c[9]) { 4.0 } else { 0.0 };
    }
    let (difference, _) = compare(&tiles, &moved, Windows::RingError, Centres::Uniform(1));
    assert!(difference.windows > 10, "{difference:?}");
    // And a ring's error that was weighted wrongly.
    let mut noisier = tiles.clone();
    noisier.iter_mut().step_by(3).for_each(|tile| tile.noises[0] += 1.0);
    let (difference, _) = compare(&tiles, &noisier, Windows::RingError, Centres::Uniform(2));
    assert!(difference.heads > 10, "{difference:?}");
}
