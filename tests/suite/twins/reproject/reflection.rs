//! Where what is seen in a surface was seen, and what history it has there.

use super::super::surface::{Surface, position_of, project, read, towards_eye};
use super::super::{luminance, rgb};
use super::history::{Origin, Previous, fetch, find_origin};
use super::inputs::sample;
use super::{Noise, ON_A_THRESHOLD, SIZE, check, flat, run_pass};
use crate::mirror::mirrored;
use crate::sequence::{Frame, frame};
use glam::{DMat2, DVec2, DVec3, Vec3};
use quell::gpu::{FrameUniforms, flags};
use quell::layout;
use rand::{Rng, SeedableRng, rngs::StdRng};

/// What is known of a pixel, not rounded as in the guide.
struct Pixel {
    surface: Surface,
    position: DVec3,
    texel: DVec2,
}

fn pixel_at(u: &FrameUniforms, frame: &Frame, texel: DVec2) -> Option<Pixel> {
    let surface = read(frame, u.far.into(), index_at(u, texel)?);
    Some(Pixel { surface, position: position_of(u, &u.current, texel, surface.depth), texel })
}

fn nearness(eye: f64, hit: f64) -> f64 {
    eye / (eye + hit)
}

/// Pixels at these offsets that continue the surface.
fn neighbours<'a>(
    u: &'a FrameUniforms,
    frame: &'a Frame,
    own: &'a Pixel,
    offsets: &'a [[f64; 2]],
) -> impl Iterator<Item = Pixel> + 'a {
    offsets.iter().filter_map(move |&[x, y]| {
        let other = pixel_at(u, frame, own.texel + DVec2::new(x, y))?;
        let n = own.surface.normal;
        let off = n.dot(other.position - own.position).abs();
        let continues = n.dot(other.surface.normal) > 0.9 && off < 0.01 * own.surface.depth;
        (continues && !other.surface.is_miss()).then_some(other)
    })
}

const AROUND: [[f64; 2]; 9] = [
    [-1.0, -1.0],
    [0.0, -1.0],
    [1.0, -1.0],
    [-1.0, 0.0],
    [0.0, 0.0],
    [1.0, 0.0],
    [-1.0, 1.0],
    [0.0, 1.0],
    [1.0, 1.0],
];

/// Mean inverse, weighted by how far beyond a pixel the lobe reaches.
fn hit_distance(u: &FrameUniforms, frame: &Frame, own: &Pixel) -> Option<f64> {
    let told = |pixel: &Pixel| {
        let index = pixel.texel.y * f64::from(u.size[0]) + pixel.texel.x;
        let found = f64::from(frame.hit_distance[index as usize]);
        let [nearest, farthest] = [1e-3, 1e3].map(|range| range * own.surface.depth);
        (found > 0.0).then(|| if found >= u.far.into() { farthest } else { found.clamp(nearest, farthest) })
    };
    let pixel_width = 2.0 * own.surface.depth / f64::from(u.current.scale[1]) / f64::from(u.size[1]);
    let is_known = told(own).is_some();
    let weighted: Vec<[f64; 2]> = neighbours(u, frame, own, &AROUND)
        .filter_map(|pixel| {
            let found = told(&pixel)?;
            let reach = 2.0 * own.surface.roughness.powi(2) * found / pixel_width - 1.0;
            let weight = if pixel.texel == own.texel || !is_known { 1.0 } else { reach.clamp(0.0, 1.0) };
            Some([weight, weight / found])
        })
        .collect();
    let sum = |k: usize| weighted.iter().map(|pair| pair[k]).sum::<f64>();
    (sum(0) > 0.0).then(|| sum(0) / sum(1))
}

/// The tangent plane's basis; the result does not depend on which.
fn tangents(n: DVec3) -> [DVec3; 2] {
    let a = n.any_orthonormal_vector();
    [a, n.cross(a)]
}

fn in_plane(basis: [DVec3; 2], v: DVec3) -> DVec2 {
    DVec2::new(basis[0].dot(v), basis[1].dot(v))
}

fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}

fn curvature(u: &FrameUniforms, frame: &Frame, own: &Pixel, basis: [DVec3; 2]) -> DMat2 {
    let offsets = [[-2.0, 0.0], [2.0, 0.0], [0.0, -2.0], [0.0, 2.0]];
    let (mut products, mut squares) = (DMat2::ZERO, DMat2::ZERO);
    for other in neighbours(u, frame, own, &offsets) {
        let along = in_plane(basis, other.position - own.position);
        products += outer(in_plane(basis, other.surface.normal - own.surface.normal), along);
        squares += outer(along, along);
    }
    let size = squares.x_axis.x + squares.y_axis.y;
    if size == 0.0 {
        return DMat2::ZERO;
    }
    let turned = products * (squares + DMat2::from_diagonal(DVec2::splat(1e-3 * size))).inverse();
    0.5 * (turned + turned.transpose())
}

/// Where the surface showed it, and its normal there.
fn previous_reflector(
    u: &FrameUniforms,
    frame: &Frame,
    own: &Pixel,
    towards: DVec3,
    hit: f64,
) -> Option<(DVec3, DVec3)> {
    let n = own.surface.normal;
    let basis = tangents(n);
    let curvature = curvature(u, frame, own, basis);
    let before = own.position + u.eye_delta.as_dvec3();
    let eye = towards_eye(&u.previous, before);
    let perpendicular = |v: DVec3| DMat2::IDENTITY - outer(in_plane(basis, v), in_plane(basis, v));
    let scale = 1.0 / (eye + towards).length();
    let eye_nearness = f64::from(u.previous.perspective) / before.length();
    let flat = (perpendicular(eye) * eye_nearness + perpendicular(towards) / hit) * scale;
    let bent = flat + curvature;
    if bent.x_axis.x + bent.y_axis.y <= 0.0 || bent.determinant() <= 0.1 * flat.determinant() {
        return None;
    }
    let step = bent.inverse() * in_plane(basis, eye + towards) * scale;
    let turn = curvature * step;
    let lift = |v: DVec2| basis[0] * v.x + basis[1] * v.y;
    Some((own.position + lift(step) - 0.5 * step.dot(turn) * n, (n + lift(turn)).normalize()))
}

/// As far as the surface's view may turn by the width of its lobe.
fn memory(u: &FrameUniforms, own: &Pixel) -> f64 {
    let before = towards_eye(&u.previous, own.position + u.eye_delta.as_dvec3());
    let turn = (towards_eye(&u.current, own.position) - before).length();
    if turn < 1e-4 { f64::INFINITY } else { (2.0 * own.surface.roughness.powi(2) / turn).max(3.0) }
}

/// Where a pixel's history may be: that of its surface, and that of what is seen in it.
struct Origins {
    surface: Origin,
    reflected: Option<Origin>,
    /// Frames that the surface's own may count for.
    frames: f64,
}

/// `surface` is as the guide has rounded it.
fn origins(
    u: &FrameUniforms,
    frame: &Frame,
    i: usize,
    surface: Surface,
    motion: [f32; 3],
    previous: &Previous,
) -> Option<Origins> {
    let origin = find_origin(u, i, surface, motion)?;
    let width = u.size[0] as usize;
    let own = pixel_at(u, frame, DVec2::new((i % width) as f64, (i / width) as f64))?;
    let hit = hit_distance(u, frame, &own).filter(|_| u.flags & flags::HIT_DISTANCE != 0);
    let is_specular = !frame.specular.is_empty();
    // Where no ray tells, what the surface knew.
    let hit = hit.or_else(|| {
        let tap = previous.surfaces[index_at(u, origin.texel.round()).filter(|_| is_specular)?];
        let is_known = !tap.is_miss() && tap.id == origin.surface.id && tap.cue > 0.0;
        is_known.then(|| origin.position.length() * (1.0 / tap.cue - 1.0))
    });
    let nearness_at = |eye: f64, hit: f64| is_specular.then_some(nearness(eye, hit));
    let size = DVec2::new(u.size[0].into(), u.size[1].into());
    let jitter = DVec2::new(u.current.jitter[0].into(), u.current.jitter[1].into());
    let texel_of = |position| project(&u.previous, position).truncate() * size - jitter - 0.5;
    let eye_delta = u.eye_delta.as_dvec3();
    let reflected = hit.and_then(|hit| {
        let n = own.surface.normal;
        let view = -towards_eye(&u.current, own.position);
        let towards = view - 2.0 * n.dot(view) * n;
        let (position, normal) = previous_reflector(u, frame, &own, towards, hit)?;
        let moved = origin.texel - texel_of(own.position + eye_delta);
        let moved = if moved.abs().max_element() < 0.5 { DVec2::ZERO } else { moved };
        let to_hit = (own.position + towards * hit - position).length();
        Some(Origin {
            texel: texel_of(position + eye_delta) + moved,
            position: origin.position + position - own.position,
            surface: Surface { normal, ..origin.surface },
            tolerance: origin.tolerance,
            nearness: nearness_at((position + eye_delta).length(), to_hit),
        })
    });
    let rounded = Pixel { surface, ..own };
    let frames = memory(u, &rounded);
    let of_surface = hit.and_then(|hit| nearness_at(origin.position.length(), hit));
    Some(Origins { surface: Origin { nearness: of_surface, ..origin }, reflected, frames })
}

/// History of a pixel whose surface's own history, or what is seen in it, may be `follow`ed.
pub fn fetch_signal(
    u: &FrameUniforms,
    frame: &Frame,
    i: usize,
    surface: Surface,
    motion: [f32; 3],
    previous: &Previous,
    follows: bool,
) -> ([f64; 4], Noise) {
    let Some(Origins { surface, reflected, frames }) = origins(u, frame, i, surface, motion, previous) else {
        return ([0.0; 4], Noise::default());
    };
    let reflected = reflected.filter(|_| follows && frames < u.max_history.into());
    let fetched = reflected.map(|origin| fetch(u, &origin, previous)).filter(|(history, _)| history[3] > 0.0);
    fetched.unwrap_or_else(|| {
        let (mut history, noise) = fetch(u, &surface, previous);
        history[3] = history[3].min(frames * f64::from(frame.samples[i].clamp(1, 1024)));
        (history, noise)
    })
}

/// Of each tile, whether samples of one signal are better explained by what is seen in the surfaces.
pub fn favoured(
    u: &FrameUniforms,
    frame: &Frame,
    surfaces: &[Surface],
    motion: &[[f32; 3]],
    previous: &Previous,
) -> Vec<bool> {
    let mut votes = vec![0.0; layout::count(u.tiles) as usize];
    for (i, &surface) in surfaces.iter().enumerate() {
        let Some(sample) = sample(frame, None, i) else { continue };
        let Some(Origins { surface, reflected: Some(reflected), .. }) =
            origins(u, frame, i, surface, motion[i], previous)
        else {
            continue;
        };
        let ((shown, noise), (seen, _)) = (fetch(u, &surface, previous), fetch(u, &reflected, previous));
        if shown[3] > 0.0 && seen[3] > 0.0 {
            let square = |history: [f64; 4]| (luminance(sample) - luminance(rgb(&history))).powi(2);
            let (shown, seen) = (square(shown), square(seen));
            votes[tile_of(u, i)] += (shown - seen) / (noise.variance + shown + seen).max(1e-12);
        }
    }
    votes.into_iter().map(|vote| vote >= 0.0).collect()
}

/// None outside of the image.
fn index_at(u: &FrameUniforms, texel: DVec2) -> Option<usize> {
    let [width, height] = u.size.map(f64::from);
    let is_inside = texel.x >= 0.0 && texel.y >= 0.0 && texel.x < width && texel.y < height;
    is_inside.then_some((texel.y * width + texel.x) as usize)
}

pub fn tile_of(u: &FrameUniforms, i: usize) -> usize {
    let [x, y] = [i as u32 % u.size[0], i as u32 / u.size[0]];
    (y / layout::TILE * u.tiles[0] + x / layout::TILE) as usize
}

const EYES: [Vec3; 2] = [Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.03, 1.42, 0.98)];

/// Two frames with hit distances; normals of the second are bent, so that surfaces are curved.
fn frames(bend: f32) -> [Frame; 2] {
    let mut frames = [frame(SIZE, EYES[0], EYES[0], 1), frame(SIZE, EYES[1], EYES[0], 2)];
    for frame in &mut frames {
        for (i, normal) in frame.normal.iter_mut().enumerate() {
            let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|p| p as f32 * bend);
            let bent = Vec3::new(normal[0] + x.sin(), normal[1] + y.sin(), normal[2] + (x + y).sin());
            *normal = (Vec3::new(normal[0], normal[1], normal[2]) + 0.3 * bend * bent)
                .extend(0.05 + 0.01 * (i % 50) as f32)
                .to_array();
        }
        *frame = mirrored(frame, 3);
    }
    frames
}

#[test]
fn matches_its_twin_on_flat_and_on_curved_mirrors() {
    for bend in [0.0, 0.2] {
        let [before, now] = frames(bend);
        let wrong = check(&now, &before, [&flat(&now.motion); 2], flags::SPLIT | flags::HIT_DISTANCE, 31);
        assert!(wrong <= ON_A_THRESHOLD, "{bend}: {wrong}");
    }
    // The surface's own history is another.
    let [before, now] = frames(0.0);
    let none = Frame { hit_distance: vec![0.0; now.depth.len()], ..now.clone() };
    let run = |now: &Frame| {
        let flags = |own| own | flags::SPLIT | flags::HIT_DISTANCE;
        run_pass(now, &before, &flat(&now.motion), &super::no_emission(now), flags, 31)
    };
    let (surface, mirror) = (run(&none), run(&now));
    let unequal = surface.history.iter().zip(&mirror.history).filter(|(a, b)| a != b).count();
    assert!(unequal > surface.history.len() / 3, "{unequal}");
}

#[test]
fn matches_its_twin_with_broken_hit_distances_and_motion() {
    let [before, mut now] = frames(0.1);
    let mut random = StdRng::seed_from_u64(32);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 0.0, 1e-30, 1e30, f32::MAX];
    for distance in &mut now.hit_distance {
        if random.random_bool(0.6) {
            *distance = bad[random.random_range(0..bad.len())];
        }
    }
    let mut motion = flat(&now.motion);
    for motion in &mut motion {
        match random.random_range(0..12) {
            0 => motion[0] = f32::NAN,
            1 => motion[1] += 0.1,
            _ => {}
        }
    }
    let wrong = check(&now, &before, [&motion; 2], flags::SPLIT | flags::HIT_DISTANCE, 33);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}

/// The same mirrors, seen as one signal: some tiles follow what is seen, others the surface.
#[test]
fn matches_its_twin_on_one_signal_with_hit_distances() {
    let frames = frames(0.1);
    let [before, now] = frames.map(|frame| Frame { specular: vec![], ..frame });
    let wrong = check(&now, &before, [&flat(&now.motion); 2], flags::HIT_DISTANCE, 34);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}
