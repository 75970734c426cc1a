//! Where models are placed, against a plain placement coarse to fine.

use super::super::regression::Tile;
use super::tiles::random_tiles;
use super::{Found, N, REACHES, ring, run_fit};
use quell::layout::{self, COVERAGE_ONE, LEVEL_STRIDES, LEVEL_WORDS, LEVELS};
use quell::{Centres, Windows};
use rand::{SeedableRng, rngs::StdRng};

/// Centres per level, and the coverage of each tile in the end, given each centre's window and which tiles have samples.
fn place(found: &Found, centres: Centres, sampled: &[bool]) -> ([Vec<usize>; LEVELS], Vec<u32>) {
    let (grid, windows) = (found.frame.tiles, &found.windows);
    let has_samples = |tile: usize| {
        (1..=found.frame.widest_window).any(|size| ring(grid, tile, size).into_iter().any(|t| sampled[t]))
    };
    let mut coverage = vec![0; windows.len()];
    let levels = LEVEL_STRIDES.map(|stride| {
        let enough = match centres {
            Centres::Adaptive => COVERAGE_ONE / 2,
            Centres::Uniform(only) if stride == only || stride == 1 => 1,
            _ => 0,
        };
        let middle = |side: u32| (stride / 2..side).step_by(stride as usize);
        let tiles = middle(grid[1]).flat_map(|y| middle(grid[0]).map(move |x| (y * grid[0] + x) as usize));
        // All of a level are listed before any of them covers.
        let listed: Vec<usize> = tiles.filter(|&tile| coverage[tile] < enough && has_samples(tile)).collect();
        for &centre in &listed {
            cover(&mut coverage, grid, centre, windows[centre]);
        }
        listed
    });
    (levels, coverage)
}

/// The tent of the centre's window, at the middle of every tile.
fn cover(coverage: &mut [u32], grid: [u32; 2], centre: usize, window: u32) {
    let side = |a: u32, b: u32| (1.0 - 8.0 * f64::from(a.abs_diff(b)) / REACHES[window as usize]).max(0.0);
    let (cx, cy) = (centre as u32 % grid[0], centre as u32 / grid[0]);
    for (tile, covered) in (0..).zip(coverage) {
        *covered += (side(tile % grid[0], cx) * side(tile / grid[0], cy) * f64::from(COVERAGE_ONE)) as u32;
    }
}

/// What is wrong with the placement, in words.
fn faults(found: &Found, centres: Centres, sampled: &[bool]) -> Vec<String> {
    let (levels, coverage) = place(found, centres, sampled);
    let mut faults = vec![];
    let mut expected = vec![false; found.windows.len()];
    for (level, listed) in levels.iter().enumerate() {
        listed.iter().for_each(|&tile| expected[tile] = true);
        let words = &found.levels[level * LEVEL_WORDS as usize..][..LEVEL_WORDS as usize];
        let count = listed.len() as u32;
        if words[3] != count || words[0] != 64 || words[1] != count.div_ceil(64) || words[2] != 1 {
            faults.push(format!("level {level}: {words:?} for {count} centres"));
        }
    }
    let placed: Vec<bool> = found.windows.iter().map(|&window| window > 0).collect();
    if placed != expected {
        faults.push("models at other tiles".into());
    }
    if found.coverage != coverage {
        faults.push("coverage differs".into());
    }
    let least = if centres == Centres::Adaptive { COVERAGE_ONE / 2 } else { 1 };
    if found.coverage.iter().zip(sampled).any(|(&covered, &sampled)| sampled && covered < least) {
        faults.push("a tile with samples is not covered".into());
    }
    faults
}

const ALL: [Centres; 4] = [Centres::Adaptive, Centres::Uniform(1), Centres::Uniform(2), Centres::Uniform(4)];

fn tiles_of(size: [u32; 2]) -> Vec<Tile<N>> {
    random_tiles(&mut StdRng::seed_from_u64(36), size, 4)
}

fn sampled(tiles: &[Tile<N>]) -> Vec<bool> {
    tiles.iter().map(|tile| tile.weight() > 0.0).collect()
}

#[test]
fn the_sky_gets_no_models_and_a_hole_in_the_samples_does() {
    let size = [200, 120];
    let mut tiles = tiles_of(size);
    let columns = layout::tiles(size)[0] as usize;
    // The right half, and one tile of the left.
    for (t, tile) in tiles.iter_mut().enumerate() {
        if t % columns >= columns / 2 || t == 3 * columns + 4 {
            tile.rows.clear();
        }
    }
    for centres in ALL {
        let found = run_fit(&tiles, size, Windows::MallowsCp, centres);
        let faults = faults(&found, centres, &sampled(&tiles));
        assert!(faults.is_empty(), "{centres:?}: {faults:?}");
        assert!(found.coverage[3 * columns + 4] > 0, "{centres:?}: the hole");
        let in_sky = (0..tiles.len()).filter(|t| t % columns > columns / 2 + 2);
        assert!(in_sky.into_iter().all(|t| found.windows[t] == 0), "{centres:?}: the sky");
    }
}

#[test]
fn centres_are_where_a_plain_placement_puts_them() {
    // Not of whole tiles or cells; larger than a workgroup's 8x8 centres; smaller than a coarse cell; a pixel.
    for size in [[90, 60], [382, 134], [580, 18], [30, 22], [10, 128], [1, 1]] {
        let tiles = tiles_of(size);
        for centres in ALL {
            for windows in [Windows::RingError, Windows::Fixed(1)] {
                let found = run_fit(&tiles, size, windows, centres);
                assert!(
                    faults(&found, centres, &sampled(&tiles)).is_empty(),
                    "{size:?} {centres:?} {windows:?}: {:?}",
                    faults(&found, centres, &sampled(&tiles))
                );
            }
        }
    }
}

#[test]
fn dense_centres_are_every_tile_and_adaptive_ones_are_fewer() {
    let size = [382, 134];
    let tiles = tiles_of(size);
    let count = |windows, centres| {
        let found = run_fit(&tiles, size, windows, centres);
        found.windows.iter().filter(|&&window| window > 0).count() as u64
    };
    let [adaptive, dense, second, fourth] = ALL.map(|centres| count(Windows::MallowsCp, centres));
    let grid = layout::tiles(size);
    assert_eq!(dense, layout::count(grid));
    assert!(fourth < second && second < dense / 2, "{dense} {second} {fourth}");
    let [narrow, wide] = [1, 3].map(|size| count(Windows::Fixed(size), Centres::Adaptive));
    println!(
        "{dense} dense centres, {narrow} with narrow windows, {adaptive} by Cp, {wide} with wide windows"
    );
    // Four narrow windows about a tile cover it by 4/9, so it gets a centre: half the tiles do, and those on borders.
    assert!(narrow < dense / 2 + u64::from(grid[0] + grid[1]), "{narrow}");
    assert!(wide < dense / 3 && wide < adaptive && adaptive < narrow, "{narrow} {adaptive} {wide}");
}

#[test]
fn a_wrong_placement_is_noticed() {
    let tiles = tiles_of([90, 60]);
    let found = |centres| run_fit(&tiles, [90, 60], Windows::RingError, centres);
    let faults = |found: &Found| faults(found, Centres::Adaptive, &sampled(&tiles));
    assert!(!faults(&found(Centres::Uniform(2))).is_empty());
    let mut missing = found(Centres::Adaptive);
    let centre = missing.windows.iter().position(|&window| window > 0).unwrap();
    missing.windows[centre] = 0;
    assert!(!faults(&missing).is_empty());
    let mut wider = found(Centres::Adaptive);
    let narrow = wider.windows.iter().position(|&window| window < 3).unwrap();
    wider.windows[narrow] = 3;
    assert!(!faults(&wider).is_empty());
}
