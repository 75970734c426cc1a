//! Tiles to fit: random ones, and those that break things.

use super::super::regression::{Row, Tile};
use super::{F, N};
use quell::layout;
use rand::{Rng, rngs::StdRng};

pub const SIZE: [u32; 2] = [90, 60];

/// Random pixels of a tile about a point: correlated features, colour linear in them plus noise.
pub fn random_rows(random: &mut StdRng, tile: [f64; 2], pixels: usize) -> Vec<Row<N>> {
    (0..pixels)
        .map(|_| {
            let (x, y) = (
                8.0 * tile[0] + random.random_range(0.0..8.0),
                8.0 * tile[1] + random.random_range(0.0..8.0),
            );
            let mut c = [0.0; N];
            let tilt = random.random_range(-0.2..0.2_f64);
            c[..3].copy_from_slice(&[tilt, (1.0 - tilt * tilt).sqrt(), 0.1 * tilt]);
            c[3..6].copy_from_slice(&[0.1 * x, -1.4, -5.0 - 0.1 * y + 0.05 * random.random::<f64>()]);
            c[6] = if random.random_bool(0.5) { 0.2 } else { 0.9 };
            c[7] = 0.3;
            c[8] = random.random();
            c[9..11].copy_from_slice(&[x.floor(), y.floor()]);
            for channel in 0..3 {
                c[F + channel] = 1.0 + 0.5 * c[0] + 0.02 * x - 0.3 * c[6] + random.random_range(-0.5..0.5);
            }
            (random.random_range(1.0..32.0), c)
        })
        .collect()
}

/// Tiles of an image with an edge across it that no feature tells of, so that all windows are best somewhere.
pub fn random_tiles(random: &mut StdRng, size: [u32; 2], pixels: usize) -> Vec<Tile<N>> {
    let [columns, rows] = layout::tiles(size);
    let tile = |random: &mut StdRng, t: u32| {
        let mut rows = random_rows(random, [f64::from(t % columns), f64::from(t / columns)], pixels);
        for (_, c) in &mut rows {
            let lit = if c[9] + 0.7 * c[10] > 62.0 { 2.0 } else { 0.0 };
            c[F..].iter_mut().for_each(|colour| *colour += lit);
        }
        let noises =
            [random.random_range(0.0..2.0), random.random_range(0.0..0.1), random.random_range(0.02..0.1)];
        Tile { rows, noises }
    };
    (0..columns * rows).map(|t| tile(random, t)).collect()
}

/// What has broken fits before, by name.
pub fn adversarial_tiles(random: &mut StdRng) -> Vec<(&'static str, Vec<Tile<N>>)> {
    let mut of = |name, change: &mut dyn FnMut(usize, &mut Tile<N>)| {
        let mut tiles = random_tiles(random, SIZE, 16);
        tiles.iter_mut().enumerate().for_each(|(t, tile)| change(t, tile));
        (name, tiles)
    };
    vec![
        of("one pixel in the image", &mut |t, tile| tile.rows.truncate(usize::from(t == 17))),
        of("few tiles with pixels", &mut |t, tile| tile.rows.truncate(if t % 5 == 0 { 3 } else { 0 })),
        of("one colour, no noise", &mut |_, tile| {
            tile.noises = [0.0; 3];
            tile.rows.iter_mut().for_each(|(_, c)| c[F..].fill(0.25));
        }),
        of("every feature a multiple of x", &mut |_, tile| {
            for (_, c) in &mut tile.rows {
                let x = c[9];
                (0..F).for_each(|i| c[i] = 0.05 * x * (i + 1) as f64);
            }
        }),
        of("1e4 beside 1e-4", &mut |_, tile| {
            for (_, c) in &mut tile.rows {
                let value = if c[9] < 40.0 { 1e4 } else { 1e-4 };
                c[F..].fill(value);
            }
        }),
        of("weights a thousandfold", &mut |t, tile| {
            let factor = if t.is_multiple_of(3) { 1e3 } else { 1.0 };
            tile.rows.iter_mut().for_each(|(w, _)| *w *= factor);
        }),
    ]
}
