//! `innovation` against its f64 twin.

use super::fit::ring;
use super::regression::{Model, Moments, Row, Tile, factor, floor_and_unit, upload_tiles};
use super::{luminance, mismatches, run, uniforms};
use crate::gpu::{download_buffer, gpu, upload_buffer};
use crate::sequence::frame;
use glam::{DVec3, Vec3};
use quell::gpu::flags;
use quell::layout::{self, INNOVATION_TILES, INNOVATIONS, MODEL_STRIDE};
use quell::passes::innovation::{Innovation, InnovationViews};
use rand::{Rng, SeedableRng, rngs::StdRng};

const N: usize = INNOVATIONS.columns() as usize;
const F: usize = INNOVATIONS.features as usize;
const RIDGE: f64 = 0.3;
const LEAST_VARIATION: f64 = 0.3;
const SIZE: [u32; 2] = [90, 53];

/// A tile's model, shrunk, with what it was fitted to.
struct Twin {
    samples: f64,
    variance: f64,
    significance: f64,
    model: Model<N>,
    rows: Vec<Row<N>>,
}

fn twin(tiles: &[Tile<N>], grid: [u32; 2], centre: usize) -> Twin {
    let members: Vec<usize> = (1..=3).flat_map(|size| ring(grid, centre, size)).collect();
    let window: Vec<&Tile<N>> = members.iter().map(|&t| &tiles[t]).collect();
    let samples: f64 = window.iter().map(|t| t.weight()).sum();
    let rows: Vec<Row<N>> = window
        .iter()
        .flat_map(|tile| tile.rows.iter().map(|&(w, c)| (w * factor(tile, &window), c)))
        .collect();
    let moments = Moments::of(&rows);
    let weight = moments.weight;
    if weight == 0.0 {
        let model = Model { mean: [0.0; N], slopes: vec![[0.0; 3]; F] };
        return Twin { samples, variance: 0.0, significance: 0.0, model, rows };
    }
    let noise =
        |k: usize| window.iter().map(|t| factor(t, &window) * t.weight() * t.noises[k]).sum::<f64>() / weight;
    let (variance, history, length) = (noise(0), noise(1), noise(2));
    let mean = moments.mean;
    let change = luminance([mean[F], mean[F + 1], mean[F + 2]]);
    let level = history.max(history + change).max(1e-6);
    let distance = DVec3::new(mean[3], mean[4], mean[5]).length();
    let units: Vec<f64> = (0..F).map(|i| floor_and_unit(i, distance).1).collect();
    let floors: Vec<f64> = units.iter().map(|unit| LEAST_VARIATION * unit).collect();
    let priors: Vec<f64> = units.iter().map(|unit| variance / (level * level) * unit * unit).collect();
    let slopes = moments.slopes(RIDGE, &floors, &priors);
    // What the model explains of the change's energy, in luminance.
    let l = [0.2126, 0.7152, 0.0722];
    let slope_energy = |i: usize| {
        let of_slope: f64 = (0..3).map(|c| l[c] * slopes[i][c]).sum();
        of_slope * (0..3).map(|c| l[c] * moments.squares[i][F + c]).sum::<f64>()
    };
    let mean_energy = weight * change * change;
    let explained = mean_energy + (0..F).map(slope_energy).sum::<f64>();
    let about_mean: f64 = (0..3)
        .flat_map(|c| (0..3).map(move |d| (c, d)))
        .map(|(c, d)| l[c] * l[d] * moments.squares[F + c][F + d])
        .sum();
    let unknowns = F as f64 + 1.0;
    let residual = (mean_energy + about_mean - explained).max(0.0) / (samples - unknowns).max(1.0);
    let expected = variance * (1.0 + 1.0 / length.max(1.0)) * weight / samples;
    let x = (1.0 + length).ln();
    let chance = unknowns + 2.0 * (unknowns * x).sqrt() + 2.0 * x;
    let doubt = chance * residual.max(expected) / explained;
    let known = samples > unknowns && explained > 0.0;
    let significance = if known { (1.0 - doubt * doubt).max(0.0) } else { 0.0 };
    let mut model = Model { mean, slopes };
    model.mean[F..].iter_mut().for_each(|change| *change *= significance);
    model.slopes.iter_mut().flatten().for_each(|slope| *slope *= significance);
    Twin { samples, variance, significance, model, rows }
}

/// Random pixels of a tile; `change` says what the light does to a pixel at x with a history.
fn random_tile(
    random: &mut StdRng,
    [tx, ty]: [u32; 2],
    change: &dyn Fn(f64, f64) -> f64,
    noise: f64,
) -> Tile<N> {
    let rows = (0..64)
        .map(|_| {
            let x = 8.0 * f64::from(tx) + random.random_range(0.0..8.0);
            let y = 8.0 * f64::from(ty) + random.random_range(0.0..8.0);
            let mut c = [0.0; N];
            let tilt = random.random_range(-0.2..0.2_f64);
            c[..3].copy_from_slice(&[tilt, (1.0 - tilt * tilt).sqrt(), 0.1 * tilt]);
            c[3..6].copy_from_slice(&[0.1 * x, -1.4, -5.0 - 0.1 * y]);
            c[6] = if random.random_bool(0.5) { 0.2 } else { 0.9 };
            c[7] = 0.3;
            c[8] = random.random();
            let history = 1.0 + 0.5 * (0.2 * x).sin() + random.random_range(-0.1..0.1);
            let sampled = noise * random.random_range(-1.0..1.0);
            c[F..].copy_from_slice(&[1.0, 0.9, 0.7].map(|tint| tint * change(x, history) + sampled));
            (random.random_range(1..=4).into(), c)
        })
        .collect();
    let variance = noise * noise / 3.0 * random.random_range(0.5..1.5);
    Tile { rows, noises: [variance, random.random_range(0.5..1.5), random.random_range(1.0..32.0)] }
}

fn random_tiles(seed: u64, change: impl Fn(f64, f64) -> f64, noise: f64) -> Vec<Tile<N>> {
    let mut random = StdRng::seed_from_u64(seed);
    let [columns, rows] = layout::tiles(SIZE);
    (0..columns * rows)
        .map(|t| random_tile(&mut random, [t % columns, t / columns], &change, noise))
        .collect()
}

/// Share of the GPU's predicted changes that differ from the twin's, and the twin's significance of each tile.
fn compare(gpu_tiles: &[Tile<N>], tiles: &[Tile<N>]) -> (f64, Vec<f64>) {
    compare_saving(gpu_tiles, tiles, 0)
}

/// Likewise, with the flag of a saving.
fn compare_saving(gpu_tiles: &[Tile<N>], tiles: &[Tile<N>], saving: u32) -> (f64, Vec<f64>) {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let any_frame = frame(SIZE, eye, eye, 1);
    let mut u = uniforms(&any_frame, &any_frame);
    u.flags |= flags::INNOVATION | saving;
    let is_sparse = saving == flags::SPARSE;
    let step = if is_sparse { 2 * INNOVATION_TILES } else { INNOVATION_TILES };
    let moments = upload_tiles(gpu_tiles);
    let stride = MODEL_STRIDE as usize;
    let grid = layout::innovation_centres(SIZE, is_sparse);
    let models = upload_buffer(&vec![f32::NAN; layout::count(grid) as usize * stride]);
    let pass = Innovation::new(&gpu().device);
    run(&u, |recorder| {
        let views = InnovationViews { moments: &moments, innovations: &models };
        pass.record(recorder, &views, grid);
    });
    let models = download_buffer(&models);
    let (mut wrong, mut significances) = (vec![], vec![]);
    for (centre, model) in models.chunks(stride).enumerate() {
        let tile = (centre as u32 / grid[0] * u.tiles[0] + centre as u32 % grid[0]) * step;
        let twin = twin(tiles, u.tiles, tile as usize);
        let head = [f64::from(model[0]), f64::from(model[1])];
        wrong.push(mismatches(&head, &[twin.samples, twin.variance], 1e-4, 1e-9));
        assert!(model.iter().all(|v| v.is_finite()), "tile {centre}");
        let found = Model::<N>::stored(model);
        let rows = || twin.rows.iter().step_by(7);
        let values =
            |model: &Model<N>| -> Vec<f64> { rows().flat_map(|(_, c)| model.value(&c[..F])).collect() };
        let size = |c: &[f64; N]| c[F..].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let largest = twin.rows.iter().map(|(_, c)| size(c)).fold(0.0, f64::max);
        // As for the models of `fit`: f32 sums over up to 1600 pixels.
        if !twin.rows.is_empty() {
            wrong.push(mismatches(&values(&found), &values(&twin.model), 2e-3, 2e-4 * largest));
        }
        significances.push(twin.significance);
    }
    (wrong.iter().sum::<f64>() / wrong.len() as f64, significances)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn matches_its_twin_whatever_the_light_does() {
    // Nothing, but noise.
    let (wrong, significances) =
        compare(&random_tiles(61, |_, _| 0.0, 1.0), &random_tiles(61, |_, _| 0.0, 1.0));
    assert_eq!(wrong, 0.0);
    assert!(mean(&significances) < 0.05, "{significances:.2?}");
    // It goes, comes, or moves on; or changes by less than the noise in parts of the image.
    let switch = |change: fn(f64, f64) -> f64, noise: f64, least: f64| {
        let tiles = random_tiles(62, change, noise);
        let (wrong, significances) = compare(&tiles, &tiles);
        assert_eq!(wrong, 0.0);
        assert!(mean(&significances) >= least, "{significances:.2?}");
        significances
    };
    switch(|_, history| -history, 0.0, 0.9);
    switch(|_, history| -0.8 * history, 0.5, 0.5);
    switch(|_, history| 4.0 * history, 2.0, 0.5);
    switch(|x, _| if x < 40.0 { 1.0 } else { -0.5 }, 0.5, 0.5);
    let slight = switch(|x, _| 0.005 * x, 1.0, 0.0);
    assert!(slight.iter().any(|&s| s > 0.0 && s < 0.9), "{slight:.2?}");
}

#[test]
fn matches_its_twin_where_tiles_are_left_out() {
    let mut tiles = random_tiles(62, |_, history| -0.8 * history, 0.5);
    let columns = layout::tiles(SIZE)[0] as usize;
    let left_out = |t: &usize| (t % columns + t / columns) % 2 == 1;
    (0..tiles.len()).filter(left_out).for_each(|t| tiles[t].rows.clear());
    let (wrong, significances) = compare_saving(&tiles, &tiles, flags::SPARSE);
    assert_eq!(wrong, 0.0);
    assert!(mean(&significances) >= 0.5, "{significances:.2?}");
}

#[test]
fn matches_its_twin_on_adversarial_tiles() {
    let base = || random_tiles(63, |_, history| -0.5 * history, 0.5);
    let check = |name: &str, tiles: &[Tile<N>]| {
        let (wrong, significances) = compare(tiles, tiles);
        assert_eq!(wrong, 0.0, "{name}");
        significances
    };
    let mut outlier = random_tiles(64, |_, _| 0.0, 0.5);
    outlier[30].rows[5].1[F..].fill(1e4);
    let significances = check("one bright outlier", &outlier);
    let [columns, _] = layout::tiles(SIZE);
    let reached: Vec<usize> = (1..=3).flat_map(|size| ring(layout::tiles(SIZE), 30, size)).collect();
    let centre_of = |t: usize| {
        let (x, y) = (t as u32 % columns, t as u32 / columns);
        let is_centre = x % INNOVATION_TILES == 0 && y % INNOVATION_TILES == 0;
        let centres = layout::innovation_centres(SIZE, false)[0];
        is_centre.then_some((y / INNOVATION_TILES * centres + x / INNOVATION_TILES) as usize)
    };
    let centres: Vec<usize> = reached.into_iter().filter_map(centre_of).collect();
    assert!(
        centres.len() >= 4 && centres.iter().all(|&c| significances[c] == 0.0),
        "a firefly passes for light"
    );
    let mut steep = base();
    for (_, c) in steep.iter_mut().flat_map(|tile| &mut tile.rows) {
        let level = if c[3] < 3.0 { 1e4 } else { 1e-4 };
        c[F..].iter_mut().for_each(|v| *v *= level);
    }
    check("1e4 against 1e-4", &steep);
    let mut sparse = base();
    sparse.iter_mut().enumerate().for_each(|(t, tile)| tile.rows.truncate([0, 0, 0, 1, 0, 3][t % 6]));
    check("few samples", &sparse);
    let mut none = base();
    none.iter_mut().for_each(|tile| tile.rows.clear());
    assert!(check("no samples", &none).iter().all(|&s| s == 0.0));
    let mut silent = base();
    for tile in &mut silent {
        tile.noises = [0.0, 0.0, 32.0];
        tile.rows.iter_mut().for_each(|(_, c)| c[F..].fill(0.0));
    }
    check("no light at all", &silent);
}

#[test]
fn the_comparison_fails_on_another_change() {
    let of = |level: f64| random_tiles(65, move |_, history| level * history, 0.5);
    assert!(compare(&of(-0.8), &of(-0.7)).0 > 0.3);
}
