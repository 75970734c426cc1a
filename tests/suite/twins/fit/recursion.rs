//! What the library's moments replace: the paper's recursion over pixels, and errors found pixel by pixel.

use super::super::regression::{Model, Moments, Row};
use super::tiles::random_rows;
use super::{F, N, RIDGE, floors, priors, ridge};
use rand::{SeedableRng, rngs::StdRng};

/// Recursive least squares over pixels, as in the paper: P starts at the inverse of the ridge (for the constant, large),
/// each pixel updates it and the coefficients. Features are centred and scaled; the first coefficient is the constant.
fn recursive_least_squares(rows: &[Row<N>], mean: &[f64; N], scales: &[f64], ridge: &[f64]) -> Vec<[f64; 3]> {
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

/// Moments of tiles about their own means, merged as the GPU does.
fn merged(parts: &[Moments<N>]) -> Moments<N> {
    let weight: f64 = parts.iter().map(|part| part.weight).sum();
    let mean: [f64; N] =
        std::array::from_fn(|i| parts.iter().map(|part| part.weight * part.mean[i]).sum::<f64>() / weight);
    let square = |i: usize, j: usize| -> f64 {
        let of = |p: &Moments<N>| p.squares[i][j] + p.weight * (p.mean[i] - mean[i]) * (p.mean[j] - mean[j]);
        parts.iter().map(of).sum()
    };
    let squares = std::array::from_fn(|i| std::array::from_fn(|j| square(i, j)));
    Moments { weight, mean, squares }
}

#[test]
fn nested_moments_equal_recursive_least_squares_over_pixels() {
    let mut random = StdRng::seed_from_u64(31);
    let tiles: Vec<Vec<Row<N>>> =
        (0..25).map(|t| random_rows(&mut random, [f64::from(t % 5), f64::from(t / 5)], 16)).collect();
    let window = merged(&tiles.iter().map(|tile| Moments::of(tile)).collect::<Vec<_>>());
    let (mean, floors, priors) = (window.mean, floors(&window.mean), priors(&window.mean, 0.3, 2));
    let model = Model { mean, slopes: ridge(&window, &mean, 0.3, 2) };
    let scales = window.scales(&floors);
    let ridge: Vec<f64> = (0..F).map(|i| RIDGE * window.weight + priors[i] * scales[i] * scales[i]).collect();
    let recursive = recursive_least_squares(&tiles.concat(), &mean, &scales, &ridge);
    for c in 0..3 {
        // The recursion's constant starts with a ridge of 1e-4, a hundred-millionth of the weight.
        assert!((recursive[0][c] - mean[F + c]).abs() < 1e-6, "constant {c}");
        for i in 0..F {
            let plain = recursive[i + 1][c] * scales[i];
            let nested = model.slopes[i][c];
            assert!((plain - nested).abs() < 1e-6 * (1.0 + nested.abs()), "slope {i},{c}: {plain} {nested}");
        }
    }
}

/// The summed squared error of a ring from its moments: q - 2 beta^T b + beta^T A beta, exactly.
#[test]
fn errors_on_a_ring_from_its_moments_equal_those_of_its_pixels() {
    let mut random = StdRng::seed_from_u64(35);
    let window = Moments::of(&random_rows(&mut random, [5.0, 2.0], 64));
    let model = Model { mean: window.mean, slopes: ridge(&window, &window.mean, 0.3, 1) };
    let rows = random_rows(&mut random, [6.0, 2.0], 64);
    let ring = Moments::of(&rows);
    // The error is a linear form of the columns, (1, -beta) . (y, z): its square needs first and second moments only.
    let l = [0.2126, 0.7152, 0.0722];
    let form: Vec<f64> = (0..N)
        .map(|i| if i < F { -(0..3).map(|c| l[c] * model.slopes[i][c]).sum::<f64>() } else { l[i - F] })
        .collect();
    let spread: f64 = (0..N)
        .flat_map(|i| (0..N).map(move |j| (i, j)))
        .map(|(i, j)| form[i] * form[j] * ring.squares[i][j])
        .sum();
    let bias: f64 = (0..N).map(|i| form[i] * (ring.mean[i] - window.mean[i])).sum();
    let (direct, from_moments) = (model.squared_error(&rows), spread + ring.weight * bias * bias);
    assert!((direct - from_moments).abs() < 1e-9 * direct, "{direct} {from_moments}");
}
