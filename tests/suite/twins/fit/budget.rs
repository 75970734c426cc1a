//! Models under a budget: which tiles get one, which keep one and for how long, against the formulas.

use super::super::luminance;
use super::super::regression::{Model, Tile};
use super::tiles::random_tiles;
use super::{Found, N, limited_uniforms, run_fit, run_pass};
use crate::sequence::camera;
use glam::{Vec2, Vec3};
use quell::gpu::FrameUniforms;
use quell::layout::{self, BUCKETS, COVERAGE_ONE};
use quell::{Camera, Centres, Windows};
use rand::{Rng, SeedableRng, rngs::StdRng};

/// Not of whole cells either way.
const SIZE: [u32; 2] = [376, 328];
/// As in `gains`.
const KEPT_FRAMES: u32 = 16;
const WINDOW_BITS: u32 = 2;

fn limited(u: &FrameUniforms, limit: u32, tiles: &[Tile<N>], models: &[f32], kept: &[u32]) -> Found {
    let u = FrameUniforms { model_limit: limit, ..*u };
    run_pass(&u, tiles, models, kept)
}

fn uniforms() -> FrameUniforms {
    limited_uniforms(SIZE)
}

fn nothing_kept() -> Vec<u32> {
    vec![0; layout::count(layout::tiles(SIZE)) as usize]
}

fn no_models() -> Vec<f32> {
    vec![0.0; layout::models(layout::count(layout::tiles(SIZE))) as usize]
}

fn base_centre(tile: usize) -> usize {
    let [columns, rows] = layout::tiles(SIZE).map(|side| side as usize);
    let middle = |at: usize, side: usize| (at / 4 * 4 + 2).min(side - 1);
    middle(tile / columns, rows) * columns + middle(tile % columns, columns)
}

fn is_base(tile: usize) -> bool {
    base_centre(tile) == tile
}

fn mean(tile: &Tile<N>, of: impl Fn(&[f64; N]) -> f64) -> f64 {
    tile.rows.iter().map(|(w, c)| w * of(c)).sum::<f64>() / tile.weight()
}

/// The formula of `gains` without a kept model: relative squared error beyond noise, times pixels.
fn gain(tile: &Tile<N>, model: &Model<N>) -> f64 {
    let [variance, found, expected] = tile.noises;
    let error = model.squared_error(&tile.rows) / tile.weight();
    let light = mean(tile, |c| luminance([c[N - 3], c[N - 2], c[N - 1]]));
    let pixels = (tile.weight() * expected / variance).clamp(1.0, 64.0);
    (error - found).max(0.02 * found) / (light * light + 1e-2) * pixels
}

/// 16 buckets an octave from 1e-12 on.
fn bucket(gain: f64) -> f64 {
    (1.0 + 16.0 * (gain / 1e-12).log2()).min(f64::from(BUCKETS - 1))
}

#[test]
fn tiles_are_ranked_by_their_gain_and_the_best_are_chosen() {
    let tiles = random_tiles(&mut StdRng::seed_from_u64(41), SIZE, 16);
    let bases = (0..tiles.len()).filter(|&tile| is_base(tile)).count() as u32;
    for limit in [0, bases, bases + 7, bases + 100, u32::MAX] {
        let found = limited(&uniforms(), limit, &tiles, &no_models(), &nothing_kept());
        let counts: Vec<u32> = (0..3).map(|level| found.levels[4 * level + 3]).collect();
        assert_eq!(counts[0], bases);
        let fitted: u32 = counts.iter().sum();
        assert!(fitted <= limit.max(bases), "{counts:?} of {limit}");
        // No more is left than the bucket holds in which the budget ends.
        assert!(limit != bases + 100 || fitted > bases + 80, "{counts:?} of {limit}");
        // The last look at a tile is the finest level's.
        let (mut chosen, mut left) = (vec![], vec![]);
        for (t, tile) in tiles.iter().enumerate().filter(|(_, tile)| tile.weight() > 0.0) {
            let found_bucket = found.kept[t] >> 16;
            if found_bucket == 0 {
                continue;
            }
            assert!(!is_base(t), "{t} has a model of the coarsest level");
            let expected = gain(tile, &Model::stored(&found.models[base_centre(t)]));
            // A quarter of jitter either way is less than 7 buckets; rounding may cost one.
            let apart = f64::from(found_bucket) - bucket(expected);
            assert!(apart.abs() <= 8.0, "tile {t}: bucket {found_bucket}, expected {}", bucket(expected));
            if found.windows[t] > 0 { chosen.push(found_bucket) } else { left.push(found_bucket) }
        }
        let [least, most] = [chosen.iter().min(), left.iter().max()].map(|b| b.copied());
        assert!(least.is_none() || most.is_none() || least > most, "{limit}: {least:?} and {most:?}");
        assert_eq!(left.is_empty(), limit == u32::MAX, "{limit}");
    }
}

#[test]
fn models_go_where_the_image_is_complicated() {
    let mut random = StdRng::seed_from_u64(42);
    let mut tiles = random_tiles(&mut random, SIZE, 16);
    let columns = layout::tiles(SIZE)[0] as usize;
    let in_corner = |tile: usize| tile % columns >= 30 && tile / columns >= 26;
    for (t, tile) in tiles.iter_mut().enumerate() {
        let level = 1.0 + random.random_range(0.0..4.0) * f64::from(u8::from(in_corner(t)));
        tile.rows.iter_mut().for_each(|(_, c)| c[N - 3..].fill(level));
        tile.noises = [0.1, 0.01, 0.01];
    }
    let bases = (0..tiles.len()).filter(|&tile| is_base(tile)).count() as u32;
    let found = limited(&uniforms(), bases + 40, &tiles, &no_models(), &nothing_kept());
    let fine: Vec<usize> = (0..tiles.len()).filter(|&t| found.windows[t] > 0 && !is_base(t)).collect();
    // Beside it, the coarsest models err as well.
    let near = |tile: usize| tile % columns >= 28 && tile / columns >= 24;
    assert!(fine.len() >= 25 && fine.iter().all(|&tile| near(tile)), "{fine:?}");
}

/// A model of each tile's own, as dense centres fit it; and the entries of `kept` for the frame after.
fn dense(tiles: &[Tile<N>], windows: Windows, age: u32) -> (Vec<f32>, Vec<u32>) {
    let found = run_fit(tiles, SIZE, windows, Centres::Uniform(1));
    let kept = found.windows.iter().map(|window| window | age << WINDOW_BITS).collect();
    (found.models.concat(), kept)
}

/// How old the models are that were kept, by tile; none that were fitted.
fn ages(found: &Found) -> Vec<(usize, u32)> {
    let entries = found.windows.iter().enumerate().map(|(tile, entry)| (tile, entry >> WINDOW_BITS));
    entries.filter(|&(_, age)| age > 0).collect()
}

#[test]
fn models_are_kept_while_they_hold_and_are_not_too_old() {
    let tiles = random_tiles(&mut StdRng::seed_from_u64(43), SIZE, 16);
    let u = uniforms();
    let (models, kept) = dense(&tiles, Windows::MallowsCp, 3);
    let found = limited(&u, 0, &tiles, &models, &kept);
    let aged = ages(&found);
    assert!(aged.len() > tiles.len() / 8 && aged.iter().all(|&(_, age)| age == 4), "{aged:?}");
    assert_eq!(found.levels[12], aged.len() as u32, "they are counted");
    assert!(aged.iter().all(|&(tile, _)| !is_base(tile)));
    for (tile, _) in &aged {
        assert_eq!(found.models[*tile], models[40 * tile..][..40], "the camera stands still");
    }
    // Those of the last age are kept once more, then no longer.
    for (age, is_kept) in [(KEPT_FRAMES - 1, true), (KEPT_FRAMES, false)] {
        let (models, kept) = dense(&tiles, Windows::MallowsCp, age);
        assert_eq!(!ages(&limited(&u, 0, &tiles, &models, &kept)).is_empty(), is_kept, "{age}");
    }
    // In another light they do not hold.
    let mut brighter = tiles.clone();
    brighter
        .iter_mut()
        .flat_map(|tile| &mut tile.rows)
        .for_each(|(_, c)| c[N - 3..].iter_mut().for_each(|v| *v *= 10.0));
    assert_eq!(ages(&limited(&u, 0, &brighter, &models, &kept)), []);
    // Nor where the mean is as it was, but an edge runs through the tile of which no feature tells.
    let mut split = tiles.clone();
    for tile in &mut split {
        let middle = tile.weight() / 2.0;
        let mut weight = 0.0;
        for (w, c) in &mut tile.rows {
            weight += *w;
            let side = if weight < middle { 3.0 } else { -3.0 };
            c[N - 3..].iter_mut().for_each(|v| *v += side);
        }
    }
    let kept_split = ages(&limited(&u, 0, &split, &models, &kept)).len();
    assert!(kept_split < aged.len() / 10, "{kept_split} of {}", aged.len());
    // With a budget for all, none is needed.
    assert_eq!(ages(&limited(&u, u32::MAX, &tiles, &models, &kept)), []);
}

/// Tiles of a wall that fills the view, its colour linear in world position.
fn wall(camera: &Camera, eye: Vec3, seed: u64) -> Vec<Tile<N>> {
    let mut random = StdRng::seed_from_u64(seed);
    let world_from_clip = (camera.clip_from_view * camera.view_from_world).inverse();
    let [columns, rows] = layout::tiles(SIZE);
    let mut row = |tile: u32| {
        let corner = Vec2::new((tile % columns) as f32, (tile / columns) as f32) * 8.0;
        let pixel = corner + Vec2::new(random.random_range(0..8) as f32, random.random_range(0..8) as f32);
        let uv = (pixel + 0.5 + camera.jitter_px) / Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
        let far = world_from_clip.project_point3(Vec3::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.5));
        let direction = (far - eye).normalize();
        let position = eye + direction * ((-6.0 - eye.z) / direction.z);
        let mut c = [0.0; N];
        c[2] = 1.0;
        (0..3).for_each(|i| c[3 + i] = f64::from((position - eye)[i]));
        (c[6], c[7], c[8]) = (0.2, 0.3, 0.5);
        (c[9], c[10]) = (f64::from(pixel.x), f64::from(pixel.y));
        c[N - 3..].fill(4.0 + 0.5 * f64::from(position.x) + 0.3 * f64::from(position.y));
        (8.0, c)
    };
    (0..columns * rows)
        .map(|tile| Tile { rows: (0..32).map(|_| row(tile)).collect(), noises: [1e-3, 1e-5, 1e-5] })
        .collect()
}

#[test]
fn kept_models_move_along_with_the_camera() {
    let eyes = [Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.25, 1.3, 0.8)];
    let cameras = [
        Camera { jitter_px: Vec2::new(0.3, -0.2), ..camera(eyes[0], SIZE) },
        Camera { jitter_px: Vec2::new(-0.4, 0.1), ..camera(eyes[1], SIZE) },
    ];
    // Of windows that leave the tiles beside them uncovered.
    let (models, kept) = dense(&wall(&cameras[0], eyes[0], 44), Windows::Fixed(1), 0);
    let now = wall(&cameras[1], eyes[1], 45);
    let after = |previous: &Camera| {
        let mut u = uniforms();
        u.set_cameras(&cameras[1], previous, u.size);
        // So that all tiles have to do with what they have, and not with what others cover.
        u.levels.iter_mut().skip(1).for_each(|level| level.covered = COVERAGE_ONE);
        let found = limited(&u, 0, &now, &models, &kept);
        let aged = ages(&found);
        let error = |&(tile, _): &(usize, u32)| {
            let model = Model::<N>::stored(&found.models[tile]);
            (model.squared_error(&now[tile].rows) / now[tile].weight()).sqrt()
        };
        (aged.len(), aged.iter().map(error).fold(0.0, f64::max))
    };
    let (held, worst) = after(&cameras[0]);
    // Colours are about 4; a tile spans 0.1 of them, and the ridge holds slopes back a little.
    assert!(held > now.len() / 2 && worst < 0.01, "{held} kept of {}, off by {worst}", now.len());
    // Taken as they were, they are wrong, and dropped.
    let (held_as_if_still, _) = after(&cameras[1]);
    assert!(held_as_if_still < held / 4, "{held_as_if_still} as if the camera had stood still, {held} moved");
}
