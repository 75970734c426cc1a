//! `fit` against its f64 twin, and the twin against the paper's recursion over pixels.

use super::moments::{Row, moments};
use super::{mismatches, run, uniforms};
use crate::gpu::{download_buffer, gpu, upload_buffer};
use crate::sequence::frame;
use glam::Vec3;
use quell::layout::{self, COLUMNS, FEATURES, HALF_SQUARES, MODEL_STRIDE, SQUARES, TILE_STRIDE};
use quell::passes::fit::{Fit, FitViews};
use rand::{Rng, SeedableRng, rngs::StdRng};

const F: usize = FEATURES as usize;
const N: usize = COLUMNS as usize;
const RIDGE: f64 = 1e-3;
const VARIANCE_FLOOR: f64 = 0.1;

pub struct Model {
    pub weight: f64,
    pub mean: [f64; N],
    pub slopes: [[f64; 3]; F],
}

fn index(i: usize, j: usize) -> usize {
    i * N - i * (i + 1) / 2 + j
}

fn floor(feature: usize, distance: f64) -> f64 {
    match feature {
        3..=5 => 0.02 * distance,
        8..=9 => 0.5,
        _ => 0.05,
    }
}

/// Scales of the features over a window.
fn scales(weight: f64, mean: &[f64; N], squares: &[f64]) -> [f64; F] {
    let distance = (mean[3] * mean[3] + mean[4] * mean[4] + mean[5] * mean[5]).sqrt();
    std::array::from_fn(|i| 1.0 / (squares[index(i, i)] / weight).sqrt().max(floor(i, distance)))
}

/// Ridge in the features' own units: what a slope of the mean colour per feature unit weighs in samples.
fn priors(variance: f64, mean: &[f64; N], window_radius: u32) -> [f64; F] {
    let distance = (mean[3] * mean[3] + mean[4] * mean[4] + mean[5] * mean[5]).sqrt();
    let colour = super::luminance([mean[F], mean[F + 1], mean[F + 2]]);
    let noise = (variance / (colour * colour).max(1e-12)).min(1e3);
    std::array::from_fn(|i| {
        let unit = match i {
            3..=5 => 0.1 * distance,
            7 => 0.3,
            8..=9 => f64::from(window_radius * 4 + 2),
            _ => 1.0,
        };
        noise * unit * unit
    })
}

/// Slopes by ridge regression from moments about their means, by Gaussian elimination with pivoting.
pub fn fit(weight: f64, mean: [f64; N], squares: &[f64], priors: &[f64; F]) -> Model {
    let mut slopes = [[0.0; 3]; F];
    if weight > 0.0 {
        let scales = scales(weight, &mean, squares);
        let at = |i: usize, j: usize| squares[index(i.min(j), i.max(j))];
        let mut system: Vec<Vec<f64>> = (0..F)
            .map(|i| {
                let prior = priors[i] * scales[i] * scales[i];
                let ridge = |j| if i == j { RIDGE * weight + prior } else { 0.0 };
                let features = (0..F).map(|j| scales[i] * scales[j] * at(i, j) + ridge(j));
                features.chain((F..N).map(|j| scales[i] * at(i, j))).collect()
            })
            .collect();
        solve(&mut system);
        for i in 0..F {
            slopes[i] = std::array::from_fn(|c| scales[i] * system[i][F + c]);
        }
    }
    Model { weight, mean, slopes }
}

/// Squared ratio of noise (0.5 at every tile of these tests) and residual of luminance, at most 1.
fn trust(model: &Model, squares: &[f64]) -> f64 {
    let at = |i: usize, j: usize| squares[index(i.min(j), i.max(j))];
    let l = [0.2126, 0.7152, 0.0722];
    let channels = || (0..3).flat_map(|c| (0..3).map(move |d| (c, d)));
    let spread: f64 = channels().map(|(c, d)| l[c] * l[d] * at(F + c, F + d)).sum();
    let explained =
        |i: usize| -> f64 { channels().map(|(c, d)| l[c] * model.slopes[i][c] * l[d] * at(i, F + d)).sum() };
    let residual = spread - (0..F).map(explained).sum::<f64>();
    (0.5 * model.weight / residual.max(1e-20)).clamp(1e-4, 1.0).powi(2)
}

fn solve(system: &mut [Vec<f64>]) {
    for k in 0..system.len() {
        let pivot =
            (k..system.len()).max_by(|&a, &b| system[a][k].abs().total_cmp(&system[b][k].abs())).unwrap();
        system.swap(k, pivot);
        let row: Vec<f64> = system[k].iter().map(|v| v / system[k][k]).collect();
        system[k].clone_from(&row);
        for (i, other) in system.iter_mut().enumerate() {
            if i != k {
                let factor = other[k];
                other.iter_mut().zip(&row).for_each(|(o, r)| *o -= factor * r);
            }
        }
    }
}

/// Recursive least squares over pixels, as in the paper: P starts at the inverse of the ridge (for the constant, large),
/// each pixel updates it and the coefficients. Features are centred and scaled; the first coefficient is the constant.
fn recursive_least_squares(
    rows: &[Row],
    mean: &[f64; N],
    scales: &[f64; F],
    ridge: &[f64; F],
) -> Vec<[f64; 3]> {
    let n = F + 1;
    let mut p = vec![vec![0.0; n]; n];
    p[0][0] = 1e4;
    (1..n).for_each(|i| p[i][i] = 1.0 / ridge[i - 1]);
    let mut beta = vec![[0.0; 3]; n];
    for (w, columns) in rows {
        let z: Vec<f64> = (0..n)
            .map(|i| if i == 0 { 1.0 } else { (columns[i - 1] - mean[i - 1]) * scales[i - 1] })
            .collect();
        let pz: Vec<f64> = p.iter().map(|row| row.iter().zip(&z).map(|(a, b)| a * b).sum()).collect();
        let denominator = 1.0 / w + z.iter().zip(&pz).map(|(a, b)| a * b).sum::<f64>();
        let gain: Vec<f64> = pz.iter().map(|v| v / denominator).collect();
        for c in 0..3 {
            let predicted: f64 = (0..n).map(|i| z[i] * beta[i][c]).sum();
            let error = columns[F + c] - predicted;
            (0..n).for_each(|i| beta[i][c] += gain[i] * error);
        }
        for i in 0..n {
            for j in 0..n {
                p[i][j] -= gain[i] * pz[j];
            }
        }
    }
    beta
}

/// Random pixels of a tile about a point: correlated features, colour linear in them plus noise.
fn random_tile(random: &mut StdRng, tile: [f64; 2], pixels: usize) -> Vec<Row> {
    (0..pixels)
        .map(|_| {
            let (x, y) = (
                4.0 * tile[0] + random.random_range(0.0..4.0),
                4.0 * tile[1] + random.random_range(0.0..4.0),
            );
            let mut c = [0.0; N];
            let tilt = random.random_range(-0.2..0.2_f64);
            c[..3].copy_from_slice(&[tilt, (1.0 - tilt * tilt).sqrt(), 0.1 * tilt]);
            c[3..6].copy_from_slice(&[0.1 * x, -1.4, -5.0 - 0.1 * y + 0.05 * random.random::<f64>()]);
            c[6] = if random.random_bool(0.5) { 0.2 } else { 0.9 };
            c[7] = 0.3;
            c[8..10].copy_from_slice(&[x.floor(), y.floor()]);
            for channel in 0..3 {
                c[F + channel] = 1.0 + 0.5 * c[0] + 0.02 * x - 0.3 * c[6] + random.random_range(-0.5..0.5);
            }
            (random.random_range(1.0..32.0), c)
        })
        .collect()
}

#[test]
fn nested_moments_equal_recursive_least_squares_over_pixels() {
    let mut random = StdRng::seed_from_u64(31);
    let tiles: Vec<Vec<Row>> =
        (0..25).map(|t| random_tile(&mut random, [f64::from(t % 5), f64::from(t / 5)], 16)).collect();
    let all: Vec<Row> = tiles.concat();
    // Merge the tiles' moments about their own means, as the GPU does.
    let parts: Vec<_> = tiles.iter().map(|tile| moments(tile)).collect();
    let weight: f64 = parts.iter().map(|(w, ..)| w).sum();
    let mean: [f64; N] =
        std::array::from_fn(|i| parts.iter().map(|(w, m, _)| w * m[i]).sum::<f64>() / weight);
    let mut squares = vec![0.0; SQUARES as usize];
    for (w, m, s) in &parts {
        for i in 0..N {
            for j in i..N {
                squares[index(i, j)] += s[index(i, j)] + w * (m[i] - mean[i]) * (m[j] - mean[j]);
            }
        }
    }
    let priors = priors(0.7, &mean, 2);
    let model = fit(weight, mean, &squares, &priors);
    let scales = scales(weight, &mean, &squares);
    let ridge = std::array::from_fn(|i| RIDGE * weight + priors[i] * scales[i] * scales[i]);
    let recursive = recursive_least_squares(&all, &mean, &scales, &ridge);
    for c in 0..3 {
        // The recursion's constant starts with a ridge of 1e-4, a hundred-millionth of the weight.
        assert!((recursive[0][c] - mean[F + c]).abs() < 1e-6, "constant {c}");
        for i in 0..F {
            let plain = recursive[i + 1][c] * scales[i];
            let nested = model.slopes[i][c];
            assert!((plain - nested).abs() < 1e-6 * (1.0 + nested.abs()), "slope {i},{c}: {plain} {nested}");
        }
    }
    // The summed squared error of a ring from its moments: q - 2 beta^T b + beta^T A beta, exactly.
    let ring = random_tile(&mut random, [6.0, 2.0], 64);
    let predict = |c: &[f64; N], channel: usize| {
        mean[F + channel] + (0..F).map(|i| (c[i] - mean[i]) * model.slopes[i][channel]).sum::<f64>()
    };
    for channel in 0..3 {
        let direct: f64 = ring.iter().map(|(w, c)| w * (c[F + channel] - predict(c, channel)).powi(2)).sum();
        // The error is a linear form of the columns, (1, -beta) . (y, z): its square needs first and second moments only.
        let (w, m, s) = moments(&ring);
        let form = |i: usize| {
            if i < F { -model.slopes[i][channel] } else { f64::from(u8::from(i == F + channel)) }
        };
        let spread: f64 = (0..N)
            .flat_map(|i| (0..N).map(move |j| (i, j)))
            .map(|(i, j)| form(i) * form(j) * s[index(i.min(j), i.max(j))])
            .sum();
        let bias = (0..N).map(|i| form(i) * (m[i] - mean[i])).sum::<f64>();
        let from_moments = spread + w * bias * bias;
        assert!((direct - from_moments).abs() < 1e-9 * direct, "{direct} {from_moments}");
    }
}

/// Runs `fit` on tiles of random rows; returns the share of predictions that differ from the twin's.
fn check(tiles: &[(f64, Vec<Row>)], size: [u32; 2], window_radius: u32) -> f64 {
    compare(tiles, tiles, size, window_radius)
}

/// As [`check`], with tiles of its own for the twin.
fn compare(
    gpu_tiles: &[(f64, Vec<Row>)],
    tiles: &[(f64, Vec<Row>)],
    size: [u32; 2],
    window_radius: u32,
) -> f64 {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let any_frame = frame(size, eye, eye, 1);
    let mut u = uniforms(&any_frame, &any_frame);
    u.window_radius = window_radius;
    let [columns, rows] = layout::tiles(size).map(|side| side as i64);
    assert_eq!(tiles.len(), (columns * rows) as usize);
    let (mut means, mut low, mut high) = (vec![], vec![], vec![]);
    let mut wide = vec![];
    for (variance, rows) in gpu_tiles {
        let (weight, mean, squares) = moments(rows);
        let narrow = |v: &f64| *v as f32;
        // Found half of what is expected: a noise gain of 0.5.
        means.extend([weight as f32, *variance as f32, 0.5, 1.0]);
        means.extend(mean.iter().map(narrow));
        low.extend(squares[..HALF_SQUARES as usize].iter().map(narrow));
        high.extend(squares[HALF_SQUARES as usize..].iter().map(narrow));
        high.resize(low.len(), 0.0);
    }
    for (variance, rows) in tiles {
        let (weight, mean, squares) = moments(rows);
        // The twin starts from what f32 holds.
        let stored = |v: f64| f64::from(v as f32);
        wide.push((
            stored(weight),
            stored(*variance),
            mean.map(stored),
            squares.iter().map(|&s| stored(s)).collect::<Vec<_>>(),
        ));
    }
    assert_eq!(means.len(), tiles.len() * TILE_STRIDE as usize);
    let [centre_columns, centre_rows] = layout::centres(size);
    let stride = MODEL_STRIDE as usize;
    let models = upload_buffer(&vec![0.0; (centre_columns * centre_rows) as usize * stride]);
    let pass = Fit::new(&gpu().device);
    run(&u, |recorder| {
        let views = FitViews {
            tile_means: &upload_buffer(&means),
            tile_squares_low: &upload_buffer(&low),
            tile_squares_high: &upload_buffer(&high),
            models: &models,
        };
        pass.record(recorder, &views, layout::centres(size));
    });
    let found = download_buffer(&models);
    let (mut predicted, mut expected) = (vec![], vec![]);
    let radius = i64::from(window_radius);
    for centre in 0..(centre_columns * centre_rows) as usize {
        let (cx, cy) = (
            2 * (centre as i64 % i64::from(centre_columns)),
            2 * (centre as i64 / i64::from(centre_columns)),
        );
        let members: Vec<usize> = (cy - radius..=cy + radius)
            .flat_map(|y| (cx - radius..=cx + radius).map(move |x| (x, y)))
            .filter(|&(x, y)| x >= 0 && y >= 0 && x < columns && y < rows)
            .map(|(x, y)| (y * columns + x) as usize)
            .collect();
        let total: f64 = members.iter().map(|&t| wide[t].0).sum();
        let noise: f64 = members.iter().map(|&t| wide[t].0 * wide[t].1).sum::<f64>() / total.max(1e-30);
        let factor = |t: usize| (1.0 + VARIANCE_FLOOR) / (wide[t].1 / noise.max(1e-30) + VARIANCE_FLOOR);
        let weight: f64 = members.iter().map(|&t| factor(t) * wide[t].0).sum();
        let mean: [f64; N] = std::array::from_fn(|i| {
            members.iter().map(|&t| factor(t) * wide[t].0 * wide[t].2[i]).sum::<f64>() / weight.max(1e-30)
        });
        let mut squares = vec![0.0; SQUARES as usize];
        for &t in &members {
            let (w, _, m, s) = &wide[t];
            for i in 0..N {
                for j in i..N {
                    squares[index(i, j)] +=
                        factor(t) * (s[index(i, j)] + w * (m[i] - mean[i]) * (m[j] - mean[j]));
                }
            }
        }
        let twin = fit(weight, mean, &squares, &priors(noise, &mean, window_radius));
        let gpu_model = &found[centre * stride..][..stride];
        assert_eq!(gpu_model[0] > 0.0, twin.weight > 0.0, "centre {centre}");
        assert!((gpu_model[1] - if twin.weight > 0.0 { 0.5 } else { 1.0 }).abs() < 1e-5);
        if twin.weight == 0.0 {
            continue;
        }
        let trust = trust(&twin, &squares);
        let gpu_trust = f64::from(gpu_model[3]);
        // The residual of a perfect fit is what rounding leaves.
        assert!((gpu_trust - trust).abs() < 0.02 * trust + 1e-6, "centre {centre}: {gpu_trust} {trust}");
        // Coefficients of collinear features are not unique to f32's eye; what they predict in the window is.
        for &t in &members {
            for (_, c) in tiles[t].1.iter().step_by(3) {
                for channel in 0..3 {
                    let value = |mean: &dyn Fn(usize) -> f64, slope: &dyn Fn(usize) -> f64| {
                        mean(F + channel) + (0..F).map(|i| (c[i] - mean(i)) * slope(i)).sum::<f64>()
                    };
                    expected.push(value(&|i| twin.mean[i], &|i| twin.slopes[i][channel]));
                    predicted.push(value(&|i| gpu_model[4 + i].into(), &|i| {
                        gpu_model[4 + N + 3 * i + channel].into()
                    }));
                }
            }
        }
    }
    assert!(predicted.iter().all(|p| p.is_finite()));
    let scale = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    // f32 sums over up to 784 pixels and a system of condition up to 1/ridge: 1e-3 of the value; and where large values
    // cancel to small ones, the rounding of some hundred sums of the large.
    mismatches(&predicted, &expected, 1e-3, 1e-3 * scale.min(1.0) + 1e-5 * scale)
}

fn random_tiles(random: &mut StdRng, size: [u32; 2], pixels: usize) -> Vec<(f64, Vec<Row>)> {
    let [columns, rows] = layout::tiles(size);
    let tile = |random: &mut StdRng, t: u32| {
        let at = [f64::from(t % columns), f64::from(t / columns)];
        (random.random_range(0.0..2.0), random_tile(random, at, pixels))
    };
    (0..columns * rows).map(|t| tile(random, t)).collect()
}

const SIZE: [u32; 2] = [45, 30];

#[test]
fn matches_its_twin_on_random_tiles() {
    let mut random = StdRng::seed_from_u64(32);
    for radius in 1..=3 {
        let tiles = random_tiles(&mut random, SIZE, 16);
        assert_eq!(check(&tiles, SIZE, radius), 0.0, "radius {radius}");
    }
}

/// The comparison fails where the twin gets other tiles than the GPU: what it compares depends on them.
#[test]
fn the_comparison_fails_on_other_tiles() {
    let mut random = StdRng::seed_from_u64(34);
    let tiles = random_tiles(&mut random, SIZE, 16);
    let mut others = tiles.clone();
    others.iter_mut().flat_map(|(_, rows)| rows).for_each(|(_, c)| c[F] += 0.1 * c[8]);
    assert!(compare(&tiles, &others, SIZE, 2) > 0.1);
}

#[test]
fn matches_its_twin_on_adversarial_tiles() {
    let mut random = StdRng::seed_from_u64(33);
    // One pixel valid in the whole image.
    let mut lonely: Vec<_> = random_tiles(&mut random, SIZE, 0);
    lonely[17] = (0.5, random_tile(&mut random, [5.0, 1.0], 1));
    assert_eq!(check(&lonely, SIZE, 2), 0.0, "one pixel");
    // One colour, no noise.
    let mut flat = random_tiles(&mut random, SIZE, 16);
    flat.iter_mut().for_each(|(v, rows)| {
        *v = 0.0;
        rows.iter_mut().for_each(|(_, c)| c[F..].fill(0.25));
    });
    assert_eq!(check(&flat, SIZE, 2), 0.0, "one colour");
    // Collinear features: every one a multiple of x.
    let mut collinear = random_tiles(&mut random, SIZE, 16);
    for (_, c) in collinear.iter_mut().flat_map(|(_, rows)| rows) {
        let x = c[8];
        (0..F).for_each(|i| c[i] = 0.05 * x * (i + 1) as f64);
    }
    assert_eq!(check(&collinear, SIZE, 2), 0.0, "collinear");
    // Radiance of 1e4 beside 1e-4.
    let mut steep = random_tiles(&mut random, SIZE, 16);
    for (_, c) in steep.iter_mut().flat_map(|(_, rows)| rows) {
        let value = if c[8] < 20.0 { 1e4 } else { 1e-4 };
        c[F..].fill(value);
    }
    assert_eq!(check(&steep, SIZE, 2), 0.0, "1e4 against 1e-4");
}
