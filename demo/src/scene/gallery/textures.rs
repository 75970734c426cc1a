//! The gallery's images, drawn by functions of uv. Surfaces tile; paintings do not.

use crate::scene::Image;
use glam::{Vec2, Vec3, vec3};

const SIZE: u32 = 512;

/// Two by two polished tiles with veins.
pub(super) fn checker() -> Image {
    Image::from_fn("checker", SIZE, |uv| {
        let cell = (uv * 2.0).floor();
        let is_light = (cell.x + cell.y) as i32 % 2 == 0;
        let within = (uv * 2.0).fract();
        let joint = within.min(1.0 - within).min_element() < 0.006;
        let vein = (1.0 - (fbm(uv, 4.0) * 2.0 - 1.0).abs()).powi(12);
        let (stone, marking) = if is_light {
            (vec3(0.74, 0.70, 0.63), vec3(0.48, 0.44, 0.40))
        } else {
            (vec3(0.085, 0.095, 0.105), vec3(0.32, 0.33, 0.34))
        };
        let color = stone.lerp(marking, 0.7 * vein) * (0.92 + 0.16 * fbm(uv + 0.37, 8.0));
        srgb(if joint { vec3(0.25, 0.23, 0.21) } else { color })
    })
}

/// Roughness in green: tiles are polished, worn in clouds, and their joints are rough.
pub(super) fn checker_roughness() -> Image {
    Image::from_fn("checker roughness", SIZE, |uv| {
        let within = (uv * 2.0).fract();
        let joint = within.min(1.0 - within).min_element() < 0.006;
        let rough = if joint { 0.8 } else { 0.13 + 0.14 * fbm(uv, 4.0) };
        [255, byte(rough), 0, 255]
    })
}

/// Four by four dark tiles, wet; light joints.
pub(super) fn wet_tiles() -> Image {
    Image::from_fn("wet tiles", SIZE, |uv| {
        let (id, joint) = tile(uv);
        let slate = vec3(0.035, 0.038, 0.042) * (0.7 + 0.6 * id) * (0.8 + 0.4 * fbm(uv, 16.0));
        // Water darkens what it soaks into.
        let soaked = 1.0 - 0.35 * puddle(uv);
        srgb(if joint { vec3(0.16, 0.15, 0.14) } else { slate } * soaked)
    })
}

/// Roughness in green: 0.03 where water stands, up to 0.3 where it has dried.
pub(super) fn wet_tiles_roughness() -> Image {
    Image::from_fn("wet tiles roughness", SIZE, |uv| {
        let (id, joint) = tile(uv);
        let dry = if joint { 0.6 } else { 0.13 + 0.12 * id + 0.05 * fbm(uv, 32.0) };
        [255, byte(dry + (0.03 - dry) * puddle(uv)), 0, 255]
    })
}

/// Identity of the tile, and whether it is its joint.
fn tile(uv: Vec2) -> (f32, bool) {
    let within = (uv * 4.0).fract();
    (hash((uv * 4.0).floor()), within.min(1.0 - within).min_element() < 0.012)
}

/// 1 under standing water, 0 where it is dry.
fn puddle(uv: Vec2) -> f32 {
    smooth(0.50, 0.56, fbm(uv + 0.13, 3.0))
}

/// Roughness in green: fine streaks along u.
pub(super) fn streaks() -> Image {
    Image::from_fn("streaks", SIZE, |uv| {
        let streak = fbm(Vec2::new(0.0625 * uv.x, uv.y), 64.0);
        [255, byte(0.35 + 0.65 * streak), 255, 255]
    })
}

const PLANKS: f32 = 6.0;

/// Along u; every plank starts elsewhere.
fn plank(uv: Vec2) -> (f32, Vec2) {
    let row = (uv.y * PLANKS).floor().rem_euclid(PLANKS);
    let u = uv.x * 2.0 + hash(Vec2::new(row, 3.0));
    (hash(Vec2::new(row, u.floor().rem_euclid(2.0))), Vec2::new(u.fract(), (uv.y * PLANKS).fract()))
}

pub(super) fn wood() -> Image {
    Image::from_fn("wood", SIZE, |uv| {
        let (id, within) = plank(uv);
        let grain = fbm(Vec2::new(uv.x * 0.25, uv.y) + id, 32.0) * 0.6
            + fbm(Vec2::new(uv.x * 0.125, uv.y) + id, 64.0) * 0.4;
        let tone = vec3(0.48, 0.29, 0.15).lerp(vec3(0.72, 0.50, 0.30), 0.65 * grain + 0.35 * id);
        let gap = within.y.min(1.0 - within.y) < 0.02 || within.x.min(1.0 - within.x) < 0.003;
        srgb(if gap { tone * 0.25 } else { tone })
    })
}

pub(super) fn wood_normal() -> Image {
    Image::normals_from_height("wood normal", SIZE, |uv| {
        let (id, within) = plank(uv);
        let edge = within.y.min(1.0 - within.y).min(4.0 * within.x.min(1.0 - within.x));
        0.004 * (edge / 0.05).min(1.0) + 0.0012 * fbm(Vec2::new(uv.x * 0.25, uv.y) + id, 32.0)
    })
}

const COURSES: f32 = 8.0;

/// Identity of the brick, and the distance to its edge in courses.
fn brick(uv: Vec2) -> (f32, f32) {
    let row = (uv.y * COURSES).floor().rem_euclid(COURSES);
    let u = uv.x * 4.0 + 0.5 * (row % 2.0);
    let within = Vec2::new(u.fract(), (uv.y * COURSES).fract());
    let edge = Vec2::new(2.0 * within.x.min(1.0 - within.x), within.y.min(1.0 - within.y)).min_element();
    (hash(Vec2::new(row, u.floor().rem_euclid(4.0))), edge)
}

pub(super) fn bricks() -> Image {
    Image::from_fn("bricks", SIZE, |uv| {
        let (id, edge) = brick(uv);
        let grit = fbm(uv, 32.0);
        let clay = vec3(0.46, 0.21, 0.14).lerp(vec3(0.62, 0.33, 0.22), id) * (0.75 + 0.5 * grit);
        let mortar = vec3(0.62, 0.59, 0.54) * (0.85 + 0.3 * grit);
        srgb(mortar.lerp(clay, smooth(0.04, 0.07, edge)))
    })
}

pub(super) fn brick_normal() -> Image {
    Image::normals_from_height("brick normal", SIZE, |uv| {
        let (id, edge) = brick(uv);
        0.012 * smooth(0.02, 0.10, edge) * (0.8 + 0.2 * id) + 0.003 * fbm(uv, 32.0)
    })
}

pub(super) fn plaster_normal() -> Image {
    Image::normals_from_height("plaster normal", SIZE, |uv| 0.006 * fbm(uv, 16.0))
}

/// Coloured fields between black bars.
pub(super) fn painting_fields() -> Image {
    const FIELDS: [(Vec2, Vec2, Vec3); 5] = [
        (Vec2::new(0.36, 0.0), Vec2::new(1.0, 0.58), vec3(0.78, 0.07, 0.05)),
        (Vec2::new(0.0, 0.62), Vec2::new(0.32, 1.0), vec3(0.05, 0.12, 0.50)),
        (Vec2::new(0.80, 0.80), Vec2::new(1.0, 1.0), vec3(0.92, 0.72, 0.08)),
        (Vec2::new(0.0, 0.0), Vec2::new(0.32, 0.25), vec3(0.92, 0.72, 0.08)),
        (Vec2::new(0.36, 0.80), Vec2::new(0.76, 1.0), vec3(0.80, 0.80, 0.76)),
    ];
    Image::from_fn("fields", SIZE, |uv| {
        let field = FIELDS.iter().find(|(low, high, _)| uv.cmpge(*low).all() && uv.cmple(*high).all());
        let bars = [(uv.x, 0.34), (uv.y, 0.60), (uv.x, 0.78), (uv.y, 0.27)];
        let is_bar = bars.iter().any(|(v, at)| (v - at).abs() < 0.018);
        let weave = 0.94 + 0.06 * ((uv.x * 700.0).sin() * (uv.y * 700.0).sin());
        let paint = field.map_or(vec3(0.84, 0.83, 0.78), |f| f.2);
        srgb(if is_bar { vec3(0.03, 0.03, 0.03) } else { paint * weave })
    })
}

/// A low sun over water.
pub(super) fn painting_sea() -> Image {
    Image::from_fn("sea", SIZE, |uv| {
        let sun = Vec2::new(0.62, 0.46);
        let near = (1.0 - 2.2 * uv.distance(sun)).max(0.0);
        if uv.y < 0.58 {
            let sky = vec3(0.10, 0.20, 0.42).lerp(vec3(0.95, 0.55, 0.25), smooth(0.0, 0.6, uv.y));
            let cloud = smooth(0.5, 0.75, fbm(Vec2::new(uv.x, 3.0 * uv.y), 6.0));
            let disc = if uv.distance(sun) < 0.07 { 1.0 } else { 0.0 };
            let sky = sky.lerp(vec3(0.85, 0.72, 0.66), 0.6 * cloud) + vec3(0.35, 0.22, 0.05) * near * near;
            srgb(sky.lerp(vec3(1.0, 0.93, 0.70), disc))
        } else {
            let depth = (uv.y - 0.58) / 0.42;
            let wave = (uv.y * 60.0 / (0.3 + depth) + 5.0 * fbm(uv, 8.0)).sin();
            let path = (1.0 - ((uv.x - sun.x) / (0.06 + 0.3 * depth)).abs()).max(0.0);
            let water = vec3(0.05, 0.14, 0.24).lerp(vec3(0.11, 0.26, 0.34), 0.5 + 0.5 * wave);
            srgb(water + vec3(0.9, 0.55, 0.25) * path * smooth(0.0, 0.9, wave))
        }
    })
}

/// Rings in squares, a different set of colours in each.
pub(super) fn painting_rings() -> Image {
    Image::from_fn("rings", SIZE, |uv| {
        let cell = (uv * 3.0).floor();
        let radius = ((uv * 3.0).fract() - 0.5).length();
        let ring = (radius * 9.0 + 0.3 * hash(cell)).floor();
        let hue = hash(cell * 7.0 + ring * 3.7);
        let wheel = |shift: f32| 0.5 + 0.5 * (std::f32::consts::TAU * (hue + shift)).cos();
        let color = vec3(wheel(0.0), wheel(0.33), wheel(0.67));
        srgb(color * 0.7 * (0.85 + 0.3 * fbm(uv, 16.0)) + 0.05)
    })
}

/// Fine black and white waves: what a denoiser must not smear.
pub(super) fn painting_waves() -> Image {
    Image::from_fn("waves", SIZE, |uv| {
        let bend = 0.06 * (uv.y * 9.0).sin() + 0.05 * (uv.x * 5.0 + uv.y * 3.0).sin();
        let stripe = ((uv.x + bend) * 44.0 * std::f32::consts::PI).sin();
        srgb(Vec3::splat(0.04 + 0.80 * smooth(-0.25, 0.25, stripe)))
    })
}

fn srgb(linear: Vec3) -> [u8; 4] {
    let encode = |v: f32| {
        let v = v.clamp(0.0, 1.0);
        byte(if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 })
    };
    [encode(linear.x), encode(linear.y), encode(linear.z), 255]
}

fn byte(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

fn smooth(low: f32, high: f32, v: f32) -> f32 {
    let t = ((v - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 0 to 1 from integer coordinates.
fn hash(p: Vec2) -> f32 {
    let mut h = (p.x * 8.0) as i32 as u32 ^ ((p.y * 8.0) as i32 as u32).wrapping_mul(0x9e37_79b9);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    (h ^ (h >> 16)) as f32 / u32::MAX as f32
}

/// Four octaves of value noise, 0 to 1, that tile over uv for whole `cells`.
fn fbm(uv: Vec2, cells: f32) -> f32 {
    let (mut sum, mut weight, mut cells) = (0.0, 0.5, cells);
    for _ in 0..4 {
        sum += weight * noise(uv, cells);
        weight *= 0.5;
        cells *= 2.0;
    }
    sum / 0.9375
}

fn noise(uv: Vec2, cells: f32) -> f32 {
    let p = uv * cells;
    let (cell, t) = (p.floor(), p.fract());
    let t = t * t * (3.0 - 2.0 * t);
    let wrap = |v: f32| v.rem_euclid(cells);
    let corner = |dx: f32, dy: f32| hash(Vec2::new(wrap(cell.x + dx), wrap(cell.y + dy)));
    let top = corner(0.0, 0.0) + (corner(1.0, 0.0) - corner(0.0, 0.0)) * t.x;
    let bottom = corner(0.0, 1.0) + (corner(1.0, 1.0) - corner(0.0, 1.0)) * t.x;
    top + (bottom - top) * t.y
}
