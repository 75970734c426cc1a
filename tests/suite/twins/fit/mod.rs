//! `fit` and `centres` against their f64 twins, and the twin against the paper's recursion over pixels.

mod budget;
mod compare;
mod placement;
mod recursion;
mod tiles;

use self::tiles::random_tiles;
use super::regression::{Model, Moments, Row, Tile, factor, floor_and_unit, upload_tiles};
use super::{luminance, run, uniforms};
use crate::gpu::{download_buffer, download_words, gpu, upload_buffer, upload_words};
use crate::sequence::frame;
use glam::{DVec3, Vec3};
use quell::gpu::{FrameUniforms, flags};
use quell::layout::{
    self, BUCKETS, LEVELS, LEVELS_WORDS, MODEL_STRIDE, MODELS, SURFACE_FEATURES, WIDEST_WINDOW_PX,
};
use quell::passes::fit::{Fit, FitViews};
use quell::{Centres, Windows};
use rand::{SeedableRng, rngs::StdRng};

const N: usize = MODELS.columns() as usize;
const F: usize = MODELS.features as usize;
/// Half a window's width in pixels, by window from 1.
const REACHES: [f64; 4] = [0.0, 12.0, 12.0, 20.0];
const RIDGE: f64 = 1e-3;

/// What the pass left behind.
struct Found {
    frame: FrameUniforms,
    models: Vec<Vec<f32>>,
    windows: Vec<u32>,
    coverage: Vec<u32>,
    levels: Vec<u32>,
    kept: Vec<u32>,
}

fn run_fit(tiles: &[Tile<N>], size: [u32; 2], windows: Windows, centres: Centres) -> Found {
    run_fit_after(tiles, size, windows, centres, &vec![0; tiles.len()])
}

/// Likewise, in the frame after one whose models had these windows.
fn run_fit_after(
    tiles: &[Tile<N>],
    size: [u32; 2],
    windows: Windows,
    centres: Centres,
    kept: &[u32],
) -> Found {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let any_frame = frame(size, eye, eye, 1);
    let mut u = uniforms(&any_frame, &any_frame);
    // As in a frame that is large enough for all windows.
    u.size = [8 * WIDEST_WINDOW_PX; 2];
    u.set_windows(windows, centres);
    u.size = size;
    u.flags |= if windows == Windows::RingError { flags::RING_ERROR } else { 0 };
    run_pass(&u, tiles, &vec![0.0; tiles.len() * MODEL_STRIDE as usize], kept)
}

/// Of a frame with a limit of models, which are placed adaptively; the camera stands still.
fn limited_uniforms(size: [u32; 2]) -> FrameUniforms {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let any_frame = frame(size, eye, eye, 1);
    let mut u = uniforms(&any_frame, &any_frame);
    u.set_windows(Windows::MallowsCp, Centres::Adaptive);
    u.flags |= flags::LIMITED;
    u
}

/// The pass alone, with what the frame before may have left.
fn run_pass(u: &FrameUniforms, tiles: &[Tile<N>], models: &[f32], kept: &[u32]) -> Found {
    assert_eq!(tiles.len() as u64, layout::count(u.tiles));
    let moments = upload_tiles(tiles);
    let nothing = || upload_words(&vec![0; tiles.len()]);
    let (centre_list, windows, coverage) = (nothing(), nothing(), nothing());
    let levels = upload_words(&[0; LEVELS_WORDS as usize]);
    let histogram = upload_words(&vec![0; BUCKETS as usize * LEVELS]);
    let (models, kept) = (upload_buffer(models), upload_words(kept));
    let pass = Fit::new(&gpu().device);
    run(u, |recorder| {
        let views = FitViews {
            moments: &moments,
            centre_list: &centre_list,
            levels: &levels,
            models: &models,
            windows: &windows,
            coverage: &coverage,
            kept: &kept,
            histogram: &histogram,
        };
        pass.record(recorder, &views, u.tiles, u.flags & flags::LIMITED != 0);
    });
    let models = download_buffer(&models);
    Found {
        frame: *u,
        models: models.chunks(MODEL_STRIDE as usize).map(<[f32]>::to_vec).collect(),
        windows: download_words(&windows),
        coverage: download_words(&coverage),
        levels: download_words(&levels),
        kept: download_words(&kept),
    }
}

/// A window that a centre may choose, and what it would be worth.
struct Candidate {
    size: u32,
    /// Estimated squared error of its predictions.
    risk: f64,
    weight: f64,
    noise_gain: f64,
    relative_noise: f64,
    /// Variance of the temporal means.
    noise: f64,
    /// Squared error on the window itself, summed.
    residual: f64,
    error: f64,
    model: Model<N>,
    rows: Vec<Row<N>>,
    /// Largest luminance in it, to which rounding is relative.
    brightest: f64,
}

impl Candidate {
    /// Squared ratio of noise and residual.
    fn trust(&self, residual: f64) -> f64 {
        (self.noise * self.weight / residual.max(1e-20)).clamp(1e-4, 1.0).powi(2)
    }
}

/// Tiles that a window has beyond those of the window inside it: a cross, its corners, the border of 5x5.
pub fn ring(grid: [u32; 2], centre: usize, size: u32) -> Vec<usize> {
    let [columns, rows] = grid.map(i64::from);
    let (cx, cy) = (centre as i64 % columns, centre as i64 / columns);
    let offsets = (-2..=2_i64).flat_map(|y| (-2..=2_i64).map(move |x| (x, y)));
    let window = |(x, y): (i64, i64)| match (x.abs() + y.abs(), x.abs().max(y.abs())) {
        (0..=1, _) => 1,
        (_, 1) => 2,
        _ => 3,
    };
    let places = offsets.filter(|&offset| window(offset) == size).map(|(x, y)| (cx + x, cy + y));
    let inside = places.filter(|&(x, y)| (0..columns).contains(&x) && (0..rows).contains(&y));
    inside.map(|(x, y)| (y * columns + x) as usize).collect()
}

/// All windows that the centre may choose, inside out. Errors on rings are found by predicting pixel by pixel.
fn candidates(tiles: &[Tile<N>], frame: &FrameUniforms, centre: usize, by_ring: bool) -> Vec<Candidate> {
    let rings: Vec<Vec<usize>> =
        (1..=frame.widest_window).map(|size| ring(frame.tiles, centre, size)).collect();
    let all: Vec<&Tile<N>> = rings.iter().flatten().map(|&t| &tiles[t]).collect();
    let weighted = |t: usize| -> Vec<Row<N>> {
        let factor = factor(&tiles[t], &all);
        tiles[t].rows.iter().map(|&(w, c)| (factor * w, c)).collect()
    };
    let rows_of = |tiles: &[usize]| -> Vec<Row<N>> { tiles.iter().flat_map(|&t| weighted(t)).collect() };
    // A window without pixels expects what the innermost tiles show that have any.
    let near: Vec<Row<N>> = rings.iter().take(2).flat_map(|ring| rows_of(ring)).collect();
    let far: Vec<Row<N>> = rings.iter().flat_map(|ring| rows_of(ring)).collect();
    let nowhere = Moments::of(if near.is_empty() { &far } else { &near }).mean;

    let noise_of = |k: usize, members: &[usize], weight: f64| -> f64 {
        let sum = |t: &usize| factor(&tiles[*t], &all) * tiles[*t].weight() * tiles[*t].noises[k];
        members.iter().map(sum).sum::<f64>() / weight.max(1e-30)
    };
    let (mut found, mut members, mut rows) = (vec![], vec![], vec![]);
    let mut inner: Option<Model<N>> = None;
    let (mut error, mut tested) = (0.0, 0.0);
    for (size, ring) in (1..).zip(&rings) {
        let ring_rows = rows_of(ring);
        if let Some(inner) = &inner {
            error += inner.squared_error(&ring_rows);
            tested += ring_rows.iter().map(|(w, _)| w).sum::<f64>();
        }
        rows.extend(ring_rows);
        members.extend(ring.iter().copied());
        let moments = Moments::of(&rows);
        let weight = moments.weight;
        let noise = |k: usize| noise_of(k, &members, weight);
        let mean = if weight > 0.0 { moments.mean } else { nowhere };
        let colour = luminance([mean[F], mean[F + 1], mean[F + 2]]);
        let relative_noise = (noise(0) / (colour * colour).max(1e-12)).min(1e3);
        let slopes = ridge(&moments, &mean, relative_noise, size);
        let model = Model { mean, slopes };
        let residual = model.squared_error(&rows);
        let pixels = 64 * members.iter().filter(|&&t| tiles[t].weight() > 0.0).count();
        let cp = residual / weight.max(1e-30) + 2.0 * (F as f64 + 1.0) * noise(1) / pixels.max(1) as f64;
        if size == 1 {
            (error, tested) = (cp * weight, weight);
        }
        let risk = if by_ring { error / tested.max(1e-30) } else { cp };
        // A window without samples has shown nothing.
        let risk = if weight <= 0.0 && size < frame.widest_window { f64::INFINITY } else { risk };
        // Mallows' Cp chooses between the least and the widest.
        let may_choose = by_ring || size == frame.least_window || size == frame.widest_window;
        if size >= frame.least_window && may_choose {
            let luminances = rows.iter().map(|(_, c)| luminance([c[F], c[F + 1], c[F + 2]]));
            found.push(Candidate {
                size,
                risk,
                weight,
                noise_gain: if noise(2) > 0.0 { (noise(1) / noise(2)).min(1.0) } else { 1.0 },
                relative_noise,
                noise: noise(1),
                residual,
                error: (risk - noise(1)).max(0.0),
                model: Model { mean: model.mean, slopes: model.slopes.clone() },
                rows: rows.clone(),
                brightest: luminances.fold(0.0, f64::max),
            });
        }
        inner = Some(model);
    }
    found
}

fn floors(mean: &[f64; N]) -> Vec<f64> {
    let distance = DVec3::new(mean[3], mean[4], mean[5]).length();
    let own = SURFACE_FEATURES as usize;
    (0..F).map(|i| if i < own { floor_and_unit(i, distance).0 } else { 0.5 }).collect()
}

/// Ridge in the features' own units: what a slope of the mean colour per feature unit weighs in samples.
fn priors(mean: &[f64; N], relative_noise: f64, size: u32) -> Vec<f64> {
    let distance = DVec3::new(mean[3], mean[4], mean[5]).length();
    let own = SURFACE_FEATURES as usize;
    let unit = |i| if i < own { floor_and_unit(i, distance).1 } else { REACHES[size as usize] };
    (0..F).map(|i| relative_noise * unit(i) * unit(i)).collect()
}

fn ridge(moments: &Moments<N>, mean: &[f64; N], relative_noise: f64, size: u32) -> Vec<[f64; 3]> {
    moments.slopes(RIDGE, &floors(mean), &priors(mean, relative_noise, size))
}

/// A tile keeps to the window that it chose lately, and chooses again in one of four frames; its model is the one of that window.
#[test]
fn windows_are_chosen_in_turns() {
    let size = [200, 160];
    let mut tiles = random_tiles(&mut StdRng::seed_from_u64(38), size, 4);
    // Where the least window has no samples and the widest has, a tile may not keep to the least.
    let columns = layout::tiles(size)[0] as usize;
    let hole = 8 * columns + 8;
    for t in [hole, hole - 1, hole + 1, hole - columns, hole + columns] {
        tiles[t].rows.clear();
    }
    let dense = |windows, kept: &[u32]| run_fit_after(&tiles, size, windows, Centres::Uniform(1), kept);
    let none = vec![0; tiles.len()];
    let chosen = dense(Windows::MallowsCp, &none);
    for window in [1, 3] {
        let fixed = dense(Windows::Fixed(window), &none);
        // The age of a kept model lies above its window.
        let found = dense(Windows::MallowsCp, &vec![window | 5 << 2; tiles.len()]);
        let (mut choosing, mut differing) = (0, 0);
        for (t, tile) in tiles.iter().enumerate() {
            let [x, y] = [t as u32 % found.frame.tiles[0], t as u32 / found.frame.tiles[0]];
            let chooses = (x + 2 * y + found.frame.index).is_multiple_of(4) || tile.weight() == 0.0;
            let expected = if chooses { &chosen } else { &fixed };
            assert_eq!(found.windows[t], expected.windows[t], "window {window}, tile {t}");
            if found.windows[t] > 0 {
                // The head's last, the risk, is of what was compared.
                assert_eq!(found.models[t][..3], expected.models[t][..3], "window {window}, tile {t}");
                assert_eq!(found.models[t][4..], expected.models[t][4..], "window {window}, tile {t}");
            }
            choosing += u32::from(chooses);
            differing += u32::from(chosen.windows[t] != fixed.windows[t]);
        }
        assert!(choosing > 30 && differing > 10, "{window}: {choosing}, {differing}");
    }
    // What Cp does not choose between is no choice of its own; nor is it asked for by the ring error.
    assert_eq!(dense(Windows::MallowsCp, &vec![2; tiles.len()]).windows, chosen.windows);
    let by_ring = dense(Windows::RingError, &none);
    assert_eq!(dense(Windows::RingError, &vec![1; tiles.len()]).windows, by_ring.windows);
}

#[test]
fn the_widest_windows_need_a_large_frame() {
    let windows = |size, windows, centres| {
        let mut u: FrameUniforms = bytemuck::Zeroable::zeroed();
        u.size = size;
        u.set_windows(windows, centres);
        [u.least_window, u.widest_window]
    };
    let (cp, adaptive) = (Windows::MallowsCp, Centres::Adaptive);
    assert_eq!(windows([320, 320], cp, adaptive), [1, 3]);
    assert_eq!(windows([319, 2000], cp, adaptive), [1, 2]);
    assert_eq!(windows([2000, 319], Windows::RingError, Centres::Uniform(2)), [1, 2]);
    // Those of uniform centres reach each other, whatever the frame's size.
    assert_eq!(windows([64, 64], cp, Centres::Uniform(4)), [3, 3]);
    assert_eq!(windows([64, 64], Windows::Fixed(1), Centres::Uniform(4)), [3, 3]);
    assert_eq!(windows([64, 64], Windows::Fixed(3), adaptive), [3, 3]);
    assert_eq!(windows([640, 640], Windows::Fixed(1), adaptive), [1, 1]);
}
