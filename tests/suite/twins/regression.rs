//! Weighted moments and ridge regression over rows of N columns, the last three of which are colour; and how tiles of rows lie
//! in the GPU's buffer.

use super::luminance;
use crate::gpu::upload_buffer;
use quell::layout::{self, TILE};

/// A pixel: its weight, then features and colour.
pub type Row<const N: usize> = (f64, [f64; N]);

pub struct Moments<const N: usize> {
    pub weight: f64,
    pub mean: [f64; N],
    /// About the mean.
    pub squares: [[f64; N]; N],
}

impl<const N: usize> Moments<N> {
    pub fn of(rows: &[Row<N>]) -> Self {
        let weight: f64 = rows.iter().map(|(w, _)| w).sum();
        let mean = std::array::from_fn(|i| {
            if weight > 0.0 { rows.iter().map(|(w, c)| w * c[i]).sum::<f64>() / weight } else { 0.0 }
        });
        let mut squares = [[0.0; N]; N];
        for (w, columns) in rows {
            let d: [f64; N] = std::array::from_fn(|i| columns[i] - mean[i]);
            for i in 0..N {
                for j in 0..N {
                    squares[i][j] += w * d[i] * d[j];
                }
            }
        }
        Self { weight, mean, squares }
    }

    /// Upper triangle, row by row.
    pub fn triangle(&self) -> Vec<f64> {
        (0..N).flat_map(|i| self.squares[i][i..].to_vec()).collect()
    }

    /// Inverse deviations of the features, which are no less than their floors.
    pub fn scales(&self, floors: &[f64]) -> Vec<f64> {
        let deviation = |i: usize| (self.squares[i][i] / self.weight).sqrt();
        (0..N - 3).map(|i| 1.0 / deviation(i).max(floors[i])).collect()
    }

    /// Slopes per feature and channel. The ridge is a share of the weight; `priors` are in the features' own units.
    pub fn slopes(&self, ridge: f64, floors: &[f64], priors: &[f64]) -> Vec<[f64; 3]> {
        if self.weight <= 0.0 {
            return vec![[0.0; 3]; N - 3];
        }
        let scales = self.scales(floors);
        let mut system: Vec<Vec<f64>> = (0..N - 3)
            .map(|i| {
                let ridge = ridge * self.weight + priors[i] * scales[i] * scales[i];
                let features = (0..N - 3)
                    .map(|j| scales[i] * scales[j] * self.squares[i][j] + if i == j { ridge } else { 0.0 });
                features.chain((N - 3..N).map(|j| scales[i] * self.squares[i][j])).collect()
            })
            .collect();
        eliminate(&mut system);
        (0..N - 3).map(|i| std::array::from_fn(|c| scales[i] * system[i][N - 3 + c])).collect()
    }
}

/// Gauss and Jordan's, with pivoting.
fn eliminate(system: &mut [Vec<f64>]) {
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

/// Floats of a stored model before its rows, and of a row.
pub const HEAD: usize = 4;
pub const ROW: usize = 12;

/// A linear model of the colour.
pub struct Model<const N: usize> {
    /// Origin in the features, and the colour there.
    pub mean: [f64; N],
    pub slopes: Vec<[f64; 3]>,
}

impl<const N: usize> Model<N> {
    /// As the GPU stores it after the head: per channel its value at features 0, then slopes, then zeros.
    pub fn stored(floats: &[f32]) -> Self {
        let row = |c: usize, i: usize| f64::from(floats[HEAD + ROW * c + i]);
        let mut mean = [0.0; N];
        (0..3).for_each(|c| mean[N - 3 + c] = row(c, 0));
        let slopes = (1..=N - 3).map(|i| std::array::from_fn(|c| row(c, i))).collect();
        Self { mean, slopes }
    }

    pub fn value(&self, features: &[f64]) -> [f64; 3] {
        std::array::from_fn(|c| {
            let slopes = self.slopes.iter().zip(features).zip(&self.mean);
            self.mean[N - 3 + c] + slopes.map(|((slope, z), mean)| slope[c] * (z - mean)).sum::<f64>()
        })
    }

    /// Weighted sum of squared errors of luminance over pixels, one by one.
    pub fn squared_error(&self, rows: &[Row<N>]) -> f64 {
        let error = |c: &[f64; N]| luminance([c[N - 3], c[N - 2], c[N - 1]]) - luminance(self.value(c));
        rows.iter().map(|(w, c)| w * error(c).powi(2)).sum()
    }
}

/// What the GPU knows of a tile of pixels: moments of its rows, and means of its three noises.
#[derive(Clone)]
pub struct Tile<const N: usize> {
    pub rows: Vec<Row<N>>,
    pub noises: [f64; 3],
}

impl<const N: usize> Tile<N> {
    pub fn weight(&self) -> f64 {
        self.rows.iter().map(|(w, _)| w).sum()
    }

    /// Weight, noises, means, squares.
    pub fn flat(&self) -> Vec<f64> {
        let moments = Moments::of(&self.rows);
        let noises = self.noises.map(|noise| if moments.weight > 0.0 { noise } else { 0.0 });
        [&[moments.weight], &noises[..], &fours(&moments.mean), &fours(&moments.triangle())].concat()
    }
}

/// With zeros up to a whole group of four.
fn fours(values: &[f64]) -> Vec<f64> {
    let mut filled = values.to_vec();
    filled.resize(values.len().next_multiple_of(4), 0.0);
    filled
}

/// Squares of flat tiles of N columns over what they can be at most by Cauchy and Schwarz, as `expected` has it: f32's rounding
/// is relative to the terms that a square is summed from, not to the square. A column that hardly varies has the rounding of
/// its values.
pub fn correlations<const N: usize>(tiles: &[f64], expected: &[f64]) -> Vec<f64> {
    let first = 4 + N.next_multiple_of(4);
    let stride = first + (N * (N + 1) / 2).next_multiple_of(4);
    let mut scaled = tiles.to_vec();
    for (tile, expected) in scaled.chunks_mut(stride).zip(expected.chunks(stride)) {
        let row = |i: usize| first + i * N - i * (i + 1) / 2;
        let rounding = |i: usize| 1e-4 * expected[0].sqrt() * expected[4 + i].abs().max(1.0);
        let root = |i: usize| expected[row(i) + i].max(0.0).sqrt().max(rounding(i));
        for (i, j) in (0..N).flat_map(|i| (i..N).map(move |j| (i, j))) {
            tile[row(i) + j] /= (root(i) * root(j)).max(1e-30);
        }
    }
    scaled
}

/// The buffer of the moments of tiles.
pub fn upload_tiles<const N: usize>(tiles: &[Tile<N>]) -> wgpu::Buffer {
    upload_buffer(&tiles.iter().flat_map(Tile::flat).map(|v| v as f32).collect::<Vec<_>>())
}

/// A pixel of a tile, with its noises.
pub struct Pixel<const N: usize> {
    pub weight: f64,
    pub columns: [f64; N],
    pub noises: [f64; 3],
}

/// The tiles of an image, some of whose pixels are left out. By quarters, pixels are weighted by inverse variance within
/// their tile: by the variance of their 4x4 pixels over that of the whole.
pub fn tiles_of<const N: usize>(
    [width, height]: [u32; 2],
    by_quarters: bool,
    pixel: impl Fn(usize) -> Option<Pixel<N>>,
) -> Vec<Tile<N>> {
    let [columns, rows] = layout::tiles([width, height]);
    let tile = |t: u32| {
        let (left, top) = (t % columns * TILE, t / columns * TILE);
        let quarters: [Vec<Pixel<N>>; 4] = std::array::from_fn(|q| {
            let (x, y) = (left + q as u32 % 2 * TILE / 2, top + q as u32 / 2 * TILE / 2);
            let places = (y..(y + TILE / 2).min(height))
                .flat_map(|y| (x..(x + TILE / 2).min(width)).map(move |x| (y * width + x) as usize));
            places.filter_map(&pixel).collect()
        });
        let variance = |pixels: &mut dyn Iterator<Item = &Pixel<N>>| {
            let sums = pixels.fold([0.0; 2], |[v, w], p| [v + p.weight * p.noises[0], w + p.weight]);
            sums[0] / f64::max(sums[1], 1e-30)
        };
        let whole = variance(&mut quarters.iter().flatten());
        let weight = |quarter: &[Pixel<N>]| {
            let own = if whole > 0.0 { variance(&mut quarter.iter()) / whole } else { 0.0 };
            if by_quarters { (1.0 + VARIANCE_FLOOR) / (own + VARIANCE_FLOOR) } else { 1.0 }
        };
        let factors: Vec<f64> = quarters.iter().map(|quarter| weight(quarter)).collect();
        let mut tile = Tile { rows: vec![], noises: [0.0; 3] };
        for (quarter, factor) in quarters.iter().zip(factors) {
            for p in quarter {
                (0..3).for_each(|k| tile.noises[k] += factor * p.weight * p.noises[k]);
                tile.rows.push((factor * p.weight, p.columns));
            }
        }
        let total = f64::max(tile.weight(), 1e-30);
        tile.noises = tile.noises.map(|sum| sum / total);
        tile
    };
    (0..columns * rows).map(tile).collect()
}

/// How much more a tile, or a quarter of one, without noise may count than an average one.
const VARIANCE_FLOOR: f64 = 0.1;

/// How much more a tile counts than by its number of samples: by inverse variance, floored.
pub fn factor<const N: usize>(tile: &Tile<N>, window: &[&Tile<N>]) -> f64 {
    let weight: f64 = window.iter().map(|t| t.weight()).sum();
    let variance = window.iter().map(|t| t.weight() * t.noises[0]).sum::<f64>() / weight.max(1e-30);
    (1.0 + VARIANCE_FLOOR) / (tile.noises[0] / variance.max(1e-30) + VARIANCE_FLOOR)
}

/// Least deviation of a feature of the surface that counts, and the change over which colour may change by as much as it is.
pub fn floor_and_unit(feature: usize, distance: f64) -> (f64, f64) {
    match feature {
        3..=5 => (0.02 * distance, 0.1 * distance),
        7 => (0.05, 0.1),
        _ => (0.05, 1.0),
    }
}

/// Every other tile has no moments where they are sparse, of which its weight alone is written: empties these, and what was found of them.
pub fn leave_out<const N: usize>(tiles: &mut [Tile<N>], found: &mut [f64], columns: u32) {
    let stride = found.len() / tiles.len();
    for (t, (tile, found)) in (0..).zip(tiles.iter_mut().zip(found.chunks_mut(stride))) {
        if (t % columns + t / columns) % 2 == 1 {
            assert_eq!(found[..4], [0.0; 4], "the head of tile {t}");
            found.fill(0.0);
            tile.rows.clear();
        }
    }
}
