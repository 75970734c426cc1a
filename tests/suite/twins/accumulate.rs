//! `accumulate` against its f64 twin.

use super::packed::{Noise, compare_noise, half_drift, random_noise, unpack_noises};
use super::regression::{HEAD, Model, Pixel, ROW, Tile, correlations, leave_out, tiles_of};
use super::surface::{features, position_of, same_surface, surface_features, towards_eye};
use super::{
    Signal, Surface, guide, luminance, mismatches, random_history, random_signal, rgb, run, uniforms, wide,
};
use crate::gpu::{blank, download, download_buffer, gpu, upload, upload_buffer};
use crate::mirror::mirrored;
use crate::sequence::frame;
use glam::{DVec2, Vec3};
use quell::gpu::{FrameUniforms, flags};
use quell::layout::{self, INNOVATIONS, MODEL_STRIDE, MODELS};
use quell::passes::accumulate::{Accumulate, AccumulateViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [61, 47];

/// Columns of the innovation's models, and of the sparse ones.
const N: usize = INNOVATIONS.columns() as usize;
const M: usize = MODELS.columns() as usize;

/// Pixels as far as `reach` to each side that lie on the same surface.
fn around(u: &FrameUniforms, i: usize, reach: [i64; 2], surfaces: &[Surface]) -> Vec<usize> {
    let [width, height] = u.size.map(i64::from);
    let (x, y) = (i as i64 % width, i as i64 / width);
    let position = |x: i64, y: i64, depth| position_of(u, &u.current, DVec2::new(x as f64, y as f64), depth);
    let mut found = vec![];
    for ty in (y - reach[1]).max(0)..=(y + reach[1]).min(height - 1) {
        for tx in (x - reach[0]).max(0)..=(x + reach[0]).min(width - 1) {
            let t = (ty * width + tx) as usize;
            let offset = position(tx, ty, surfaces[t].depth) - position(x, y, surfaces[i].depth);
            if same_surface(&surfaces[i], &surfaces[t], offset) {
                found.push(t);
            }
        }
    }
    found
}

/// Mean and variance.
fn spatial_spread(u: &FrameUniforms, i: usize, signal: &[[f64; 4]], surfaces: &[Surface]) -> [f64; 2] {
    let taps = around(u, i, [3, 3], surfaces);
    let taps: Vec<usize> = taps.into_iter().filter(|&t| signal[t][3] > 0.0).collect();
    let samples: f64 = taps.iter().map(|&t| signal[t][3]).sum();
    if taps.len() < 2 {
        return [0.0, luminance(rgb(&signal[i])).powi(2) * signal[i][3]];
    }
    let values = || taps.iter().map(|&t| luminance(rgb(&signal[t])));
    let n = taps.len() as f64;
    let mean = values().sum::<f64>() / n;
    let spread = values().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, spread * samples / n]
}

/// What the history is believed to be in this frame's light.
struct Relit {
    mean: [f64; 3],
    count: f64,
    noise: Noise,
    /// That are in it, whatever they count for.
    samples: f64,
    most: f64,
}

/// Frames that the view of the surface takes to turn by the width of its lobe.
fn memory(u: &FrameUniforms, i: usize, surface: &Surface) -> f64 {
    let width = u.size[0] as usize;
    let pixel = DVec2::new((i % width) as f64, (i / width) as f64);
    let position = position_of(u, &u.current, pixel, surface.depth);
    let before = towards_eye(&u.previous, position + u.eye_delta.as_dvec3());
    let turn = (towards_eye(&u.current, position) - before).length();
    if turn < 1e-4 { f64::INFINITY } else { (2.0 * surface.roughness.powi(2) / turn).max(3.0) }
}

/// Models of the innovation, at every other tile.
fn relight(
    u: &FrameUniforms,
    signal: Signal,
    i: usize,
    surface: &Surface,
    old: [f64; 4],
    noise: Noise,
    models: &[f32],
) -> Relit {
    let mean = rgb(&old);
    let before = luminance(mean);
    let unlit = Relit { mean, count: old[3], noise, samples: old[3], most: f64::INFINITY };
    if surface.is_miss() || old[3] <= 0.0 {
        return unlit;
    }
    let z = surface_features(u, signal, i, surface);
    let is_sparse = u.flags & flags::SPARSE != 0;
    let [columns, rows] = layout::innovation_centres(u.size, is_sparse).map(i64::from);
    let pitch = if is_sparse { 32.0 } else { 16.0 };
    let [x, y] = [i as u32 % u.size[0], i as u32 / u.size[0]].map(|p| (f64::from(p) + 0.5 - 4.0) / pitch);
    let (mut total, mut change, mut spread) = (0.0, [0.0; 3], 0.0);
    for (tile, floats) in models.chunks(MODEL_STRIDE as usize).enumerate() {
        // Bilinear: the four nearest centres have a weight.
        let (tx, ty) = (tile as i64 % columns, tile as i64 / columns);
        assert!(ty < rows);
        let weight = (1.0 - (x - tx as f64).abs()).max(0.0) * (1.0 - (y - ty as f64).abs()).max(0.0);
        let [samples, variance] = [floats[0], floats[1]].map(f64::from);
        if weight > 0.0 && samples > 0.0 {
            let model = Model::<N>::stored(floats);
            // What is not significant says nothing.
            let value = if floats[2] > 0.0 { model.value(&z) } else { [0.0; 3] };
            total += weight;
            (0..3).for_each(|c| change[c] += weight * value[c]);
            spread += weight * (samples * variance).sqrt();
        }
    }
    if total == 0.0 {
        return unlit;
    }
    let moved: [f64; 3] = std::array::from_fn(|c| (mean[c] + change[c] / total).max(0.0));
    let after = luminance(moved);
    let gain = (after / before.max(1e-6)).min(16.0);
    let doubt = 3.0 * old[3] * (after - before).powi(2) / noise.variance.max(1e-12);
    Relit {
        mean: moved,
        count: old[3] / (1.0 + doubt),
        noise: Noise { variance: noise.variance * gain * gain, ..noise },
        most: if spread > 0.0 { after + f64::from(u.firefly_limit) * spread / total } else { f64::INFINITY },
        ..unlit
    }
}

/// Square of how far histories about the pixel are off in the mean, beyond chance and what is predicted; variance of a sample.
fn drift(
    u: &FrameUniforms,
    i: usize,
    signal: &[[f64; 4]],
    old: &[[f64; 4]],
    surfaces: &[Surface],
    predicted: f64,
) -> [f64; 2] {
    // Rows of what goes with their middle, if this is smooth and goes with the pixel.
    let differences: Vec<[f64; 2]> = around(u, i, [0, 3], surfaces)
        .into_iter()
        .filter(|&middle| surfaces[middle].roughness < 1.0 / 3.0)
        .flat_map(|middle| around(u, middle, [3, 0], surfaces))
        .filter(|&t| signal[t][3] > 0.0 && old[t][3] > 0.0)
        .map(|t| [luminance(rgb(&signal[t])) - luminance(rgb(&old[t])), signal[t][3]])
        .collect();
    if differences.len() < 4 {
        return [0.0; 2];
    }
    let weight: f64 = differences.iter().map(|[_, k]| k).sum();
    let mean = differences.iter().map(|[d, k]| k * d).sum::<f64>() / weight;
    let spread: f64 = differences.iter().map(|[d, k]| k * (d - mean).powi(2)).sum();
    let variance = spread / (differences.len() - 1) as f64;
    let share = (2.0 - 6.0 * surfaces[i].roughness).clamp(0.0, 1.0);
    [share * ((mean - predicted).powi(2) - 4.0 * variance / weight).max(0.0), variance]
}

/// Random models: small changes, large ones, and tiles without.
fn random_models(random: &mut StdRng, u: &FrameUniforms) -> Vec<f32> {
    let model = |random: &mut StdRng| {
        let mut model: Vec<f32> = (0..MODEL_STRIDE).map(|_| random.random_range(-0.05..0.05)).collect();
        model[0] = if random.random_bool(0.2) { 0.0 } else { random.random_range(1.0..600.0) };
        model[1] = if random.random_bool(0.2) { 0.0 } else { random.random_range(0.0..2.0) };
        model[2] = if model[2] < -0.02 { 0.0 } else { 1.0 };
        let change = random.random_range(-1.0..1.0_f32).powi(3);
        (0..3).for_each(|c| model[HEAD + ROW * c] = change);
        model
    };
    let centres = layout::innovation_centres(u.size, u.flags & flags::SPARSE != 0);
    (0..layout::count(centres)).flat_map(|_| model(random)).collect()
}

/// The moments are those of the images as they are stored.
fn check_moments(
    u: &FrameUniforms,
    signal: Signal,
    surfaces: &[Surface],
    history: &[[f64; 4]],
    noise: &[u32],
    moments: &[f32],
) {
    let noise = unpack_noises(noise, history);
    let mut tiles: Vec<Tile<M>> = tiles_of(SIZE, true, |i| {
        let count = history[i][3];
        if surfaces[i].is_miss() || count <= 0.0 {
            return None;
        }
        let mut columns = [0.0; M];
        columns[..M - 3].copy_from_slice(&features(u, signal, i, &surfaces[i]));
        columns[M - 3..].copy_from_slice(&history[i][..3]);
        let noises = [noise[i].variance, noise[i].found(), noise[i].variance / count];
        Some(Pixel { weight: count, columns, noises })
    });
    let mut found: Vec<f64> = moments.iter().copied().map(f64::from).collect();
    if u.flags & flags::SPARSE != 0 {
        leave_out(&mut tiles, &mut found, u.tiles[0]);
    }
    let mut expected: Vec<f64> = tiles.iter().flat_map(Tile::flat).collect();
    // Sums of 64 products of f32; of positions that deviate by a thousandth of their size, whose rounding is 1e-7 of it.
    let wrong = |expected: &[f64]| {
        let [found, expected] = [&found, expected].map(|tiles| correlations::<M>(tiles, expected));
        mismatches(&found, &expected, 1e-4, 1e-3)
    };
    assert_eq!(wrong(&expected), 0.0);
    // The comparator notices weights that are not by quarters.
    let unweighted = tiles_of(SIZE, false, |i| {
        let columns = [0.0; M];
        let noises = [noise[i].variance, 0.0, 0.0];
        (history[i][3] > 0.0 && !surfaces[i].is_miss()).then_some(Pixel {
            weight: history[i][3],
            columns,
            noises,
        })
    });
    let stride = MODELS.tile_stride() as usize;
    expected.chunks_mut(stride).zip(&unweighted).for_each(|(tile, other)| tile[0] = other.weight());
    assert!(wrong(&expected) > 0.5 / stride as f64);
}

/// Runs the pass on random images; how many samples the twin cut as fireflies, and how many histories were moved.
fn check(of: Signal, innovation: bool, firefly_limit: f32, index: u32) -> (usize, usize) {
    check_saving(of, innovation, firefly_limit, index, 0)
}

/// Likewise, with the flag of a saving.
fn check_saving(of: Signal, innovation: bool, firefly_limit: f32, index: u32, saving: u32) -> (usize, usize) {
    let mut random = StdRng::seed_from_u64(11);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut frame = frame(SIZE, eye, eye, 1);
    frame.normal.iter_mut().enumerate().for_each(|(i, normal)| normal[3] = (i % 7) as f32 / 6.0);
    if of == Signal::Specular {
        frame = mirrored(&frame, 12);
    }
    let mut u = uniforms(&frame, &frame);
    u.flags |= saving | if of == Signal::Specular { flags::SPLIT } else { 0 };
    u.firefly_limit = firefly_limit;
    u.index = index;
    // Views of some surfaces turn by more than their lobe is wide.
    u.eye_delta = Vec3::new(0.4, 0.0, 0.0);
    let mut models = random_models(&mut random, &u);
    if !innovation {
        models.fill(0.0); // no tile has samples
    }
    let (words, surfaces) = guide(&frame);
    let mut old = random_history(&mut random, surfaces.len());
    // Some all but black, that light may make brighter by more than is believed.
    for texel in old.iter_mut().step_by(5) {
        (0..3).for_each(|c| texel[c] = half::f16::from_f32(0.01 * f32::from(texel[c])));
    }
    let old_noise = random_noise(&mut random, surfaces.len());
    let (signal, samples) = random_signal(&mut random, &surfaces);
    let (history, noise) = (blank(SIZE, Format::Rgba16Float), blank(SIZE, Format::R32Uint));
    let floats = layout::count(u.tiles) as usize * MODELS.tile_stride() as usize;
    let moments = upload_buffer(&vec![f32::NAN; floats]);
    let device = &gpu().device;
    let pass = match of {
        Signal::Combined => Accumulate::new(device),
        Signal::Specular => Accumulate::specular(device),
    };
    run(&u, |recorder| {
        let views = AccumulateViews {
            signal: &upload(SIZE, Format::R32Uint, &signal),
            guide: &upload(SIZE, Format::Rg32Uint, &words),
            sample_count: &upload(SIZE, Format::R32Uint, &samples),
            reprojected: &upload(SIZE, Format::Rg32Uint, &old), // four half floats are two words
            reprojected_noise: &upload(SIZE, Format::R32Uint, &old_noise),
            innovations: &upload_buffer(&models),
            history: &history,
            noise: &noise,
            moments: &moments,
        };
        pass.record(recorder, &views, SIZE);
    });
    let found = wide(&download(&history));
    let found_noise: Vec<u32> = download(&noise);
    check_moments(&u, of, &surfaces, &found, &found_noise, &download_buffer(&moments));

    let (signal, old) = (super::unpack_samples(&signal, &samples), wide(&old));
    let old_noise = unpack_noises(&old_noise, &old);
    let (mut expected, mut expected_noise) = (vec![], vec![]);
    let (mut cut, mut moved, mut forgot) = (0, 0, 0);
    for i in 0..signal.len() {
        if surfaces[i].is_miss() {
            expected.push(old[i]); // its radiance
            expected_noise.push(Noise::default());
            continue;
        }
        let relit = relight(&u, of, i, &surfaces[i], old[i], old_noise[i], &models);
        let k = signal[i][3];
        let mut relit = relit;
        let most = match of {
            Signal::Combined => k.max(1.0) * memory(&u, i, &surfaces[i]),
            Signal::Specular => {
                let predicted = luminance(relit.mean) - luminance(rgb(&old[i]));
                let [square, variance] = drift(&u, i, &signal, &old, &surfaces, predicted);
                relit.most = if square > 0.0 { f64::INFINITY } else { relit.most };
                relit.count / (1.0 + relit.count * square / variance.max(1e-12))
            }
        };
        forgot += usize::from(most < relit.count);
        relit.count = relit.count.min(most);
        let [r, g, b] = relit.mean;
        moved += usize::from(relit.mean != rgb(&old[i]));
        // Samples' signs flip every one, two and four frames.
        let flip = |s: usize| if u.index.is_multiple_of(1 << s) { -1.0 } else { 1.0 };
        let flipped: [f64; 3] = std::array::from_fn(|s| flip(s) * relit.noise.deviations[s]);
        if k == 0.0 {
            expected.push([r, g, b, joined_count(relit.count, 0.0)]);
            expected_noise.push(Noise { deviations: flipped, ..relit.noise });
            continue;
        }
        let uncut = luminance(rgb(&signal[i]));
        let share = if uncut > relit.most { relit.most / uncut } else { 1.0 };
        cut += usize::from(share < 1.0);
        let sample = rgb(&signal[i]).map(|c| c * share);
        let n = joined_count(relit.count, k);
        let alpha = k / n;
        let mean: Vec<f64> = (0..3).map(|c| relit.mean[c] + alpha * (sample[c] - relit.mean[c])).collect();
        expected.push([mean[0], mean[1], mean[2], n]);
        let d = luminance(sample) - luminance(relit.mean);
        let new_share = relit.samples / (relit.samples + k);
        let [mean, spread] = spatial_spread(&u, i, &signal, &surfaces);
        // Nothing of the past is left that f32 would know of.
        let first = alpha > 1.0 - 2.0_f64.powi(-25);
        let innovation = if first { luminance(sample) - mean } else { new_share.sqrt() * d };
        let old_v = relit.noise.variance;
        let variance =
            if first || n < 4.0 { spread } else { old_v + alpha * (new_share * k * d * d - old_v) };
        let deviations = flipped.map(|old| alpha * innovation + (1.0 - alpha) * old);
        expected_noise.push(Noise { variance, deviations });
    }
    // One dithered step of a half float.
    assert!(forgot > 0, "no history was too long for its surface");
    let step = 2.0_f64.powi(-10);
    let wrong = mismatches(found.as_flattened(), expected.as_flattened(), step, 1e-5);
    assert_eq!(wrong, 0.0);
    // A neighbour on the threshold of a surface test may fall to either side.
    let of_noise = compare_noise(&found_noise, &found, &expected_noise);
    assert!(of_noise.wrong <= 0.005, "{of_noise:?}");
    // Random rounding is right in the mean.
    let drift = half_drift(&found, &expected);
    assert!(drift.abs() < 0.02, "history drifts by {drift} of its last place");
    assert!(of_noise.drift.iter().all(|drift| drift.abs() < 0.03), "{of_noise:?}");
    // The comparators notice samples that vary by a tenth more, and deviations of another sign.
    let mut noisier = expected_noise.clone();
    noisier.iter_mut().for_each(|noise| noise.variance *= 1.1);
    assert!(compare_noise(&found_noise, &found, &noisier).wrong > 0.5);
    expected_noise.iter_mut().for_each(|noise| noise.deviations[1] *= -1.0);
    assert!(compare_noise(&found_noise, &found, &expected_noise).wrong > 0.3);
    // The comparator notices a sample that entered with the wrong weight.
    expected.iter_mut().for_each(|h| h[3] += 1.0);
    assert!(mismatches(found.as_flattened(), expected.as_flattened(), step, 1e-6) > 0.2);
    (cut, moved)
}

/// History keeps 32 samples whole, and of more a 32nd less in each frame.
fn joined_count(old: f64, k: f64) -> f64 {
    if old + k <= 32.0 { old + k } else { (old - old / 32.0 + k).max(32.0) }
}

#[test]
fn matches_its_twin_on_random_history() {
    // Frames in which the signs of three, one and two of the deviations flip.
    for index in [4, 5, 6] {
        assert_eq!(check(Signal::Combined, false, f32::INFINITY, index), (0, 0));
    }
    assert_eq!(
        check(Signal::Combined, false, 0.01, 7),
        (0, 0),
        "without samples around nothing is known of fireflies"
    );
}

#[test]
fn matches_its_twin_with_random_innovations() {
    let (cut, moved) = check(Signal::Combined, true, f32::INFINITY, 7);
    assert!(cut == 0 && moved > 500, "{cut} {moved}");
    let (cut, _) = check(Signal::Combined, true, 0.05, 8);
    assert!(cut > 100, "{cut}");
}

#[test]
fn matches_its_twin_where_tiles_are_left_out() {
    let (cut, moved) = check_saving(Signal::Combined, true, 0.05, 8, flags::SPARSE);
    assert!(cut > 100 && moved > 500, "{cut} {moved}");
}

#[test]
fn matches_its_twin_on_mirrors() {
    let (cut, moved) = check(Signal::Specular, true, 0.05, 7);
    assert!(cut > 30 && moved > 500, "{cut} {moved}");
}
