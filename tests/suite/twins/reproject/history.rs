//! Where a pixel's surface was, and what history it has there.

use super::super::luminance;
use super::super::packed::Noise;
use super::super::surface::{Surface, position_at, position_of, project};
use glam::{DVec2, DVec3};
use quell::gpu::{FrameUniforms, flags};

/// What outlived the previous frame.
pub struct Previous {
    pub surfaces: Vec<Surface>,
    pub history: Vec<[f64; 4]>,
    pub noise: Vec<Noise>,
}

/// Texel, position relative to the previous eye, surface and tolerance of a pixel's origin.
pub struct Origin {
    pub texel: DVec2,
    pub position: DVec3,
    pub surface: Surface,
    pub tolerance: f64,
    /// Of what the specular signal shows.
    pub nearness: Option<f64>,
}

pub fn find_origin(u: &FrameUniforms, i: usize, surface: Surface, motion: [f32; 3]) -> Option<Origin> {
    let size = DVec2::new(u.size[0].into(), u.size[1].into());
    let pixel = DVec2::new((i as u32 % u.size[0]).into(), (i as u32 / u.size[0]).into());
    let uv = (pixel + 0.5) / size;
    let offset = DVec2::new(motion[0].into(), motion[1].into());
    if !offset.is_finite() || offset.abs().max_element() > 4.0 {
        return None;
    }
    let mut texel = (uv + offset) * size - 0.5;
    if (texel - texel.round()).abs().max_element() < 0.002 {
        texel = texel.round();
    }
    let jitter = DVec2::new(u.current.jitter[0].into(), u.current.jitter[1].into());
    let sampled = uv + jitter / size;
    let still =
        project(&u.previous, position_at(&u.current, sampled, surface.depth) + u.eye_delta.as_dvec3());
    let stands_still = ((still.truncate() - sampled - offset).abs() * size).max_element() < 0.5;
    let (depth, slack) = if u.flags & flags::MOTION_DEPTH != 0 && motion[2].is_finite() {
        (surface.depth + f64::from(motion[2]), 1.0)
    } else if stands_still {
        (still.z, 1.0)
    } else {
        (surface.depth, 10.0)
    };
    let position = position_at(&u.previous, sampled + offset, depth);
    Some(Origin { texel, position, surface, tolerance: 0.01 * surface.depth * slack, nearness: None })
}

/// Index of a tap that belongs to the origin's surface.
fn tap(u: &FrameUniforms, texel: DVec2, origin: &Origin, previous: &Previous) -> Option<usize> {
    let [width, height] = u.size.map(f64::from);
    if texel.x < 0.0 || texel.y < 0.0 || texel.x >= width || texel.y >= height {
        return None;
    }
    let index = (texel.y * width + texel.x) as usize;
    let tap = previous.surfaces[index];
    let offset = position_of(u, &u.previous, texel, tap.depth) - origin.position;
    let belongs = !tap.is_miss()
        && tap.id == origin.surface.id
        && tap.normal.dot(origin.surface.normal) > 0.8
        && origin.surface.normal.dot(offset).abs() < origin.tolerance
        && origin
            .nearness
            .is_none_or(|nearness| tap.cue == 0.0 || (nearness - tap.cue).abs() <= 0.01 + tap.roughness);
    belongs.then_some(index)
}

fn cubic(f: f64) -> [f64; 4] {
    let (f2, f3) = (f * f, f * f * f);
    [-f3 + 2.0 * f2 - f, 3.0 * f3 - 5.0 * f2 + 2.0, -3.0 * f3 + 4.0 * f2 + f, f3 - f2].map(|w| 0.5 * w)
}

pub fn fetch(u: &FrameUniforms, origin: &Origin, previous: &Previous) -> ([f64; 4], Noise) {
    let base = origin.texel.floor();
    let f = origin.texel - base;
    let (mut sum, mut noise, mut weight, mut all_valid) = ([0.0; 4], Noise::default(), 0.0, true);
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let w = (1.0 - (f.x - dx).abs()) * (1.0 - (f.y - dy).abs());
        if w == 0.0 {
            continue;
        }
        match tap(u, base + DVec2::new(dx, dy), origin, previous) {
            Some(i) if previous.history[i][3] > 0.0 => {
                (0..4).for_each(|c| sum[c] += w * previous.history[i][c]);
                noise.variance += w * previous.noise[i].variance;
                (0..3).for_each(|k| noise.deviations[k] += w * previous.noise[i].deviations[k]);
                weight += w;
            }
            Some(_) => {}
            None => all_valid = false,
        }
    }
    if weight < 0.05 {
        return ([0.0; 4], Noise::default());
    }
    let mut history = sum.map(|s| s / weight);
    noise.variance /= weight;
    noise.deviations = noise.deviations.map(|s| s / weight);
    if all_valid && f != DVec2::ZERO && u.flags & flags::BILINEAR == 0 {
        let mut sharp = Some([0.0; 6]);
        for (y, wy) in (-1..).zip(cubic(f.y)) {
            for (x, wx) in (-1..).zip(cubic(f.x)) {
                let is_corner = [-1, 2].contains(&x) && [-1, 2].contains(&y);
                if wx * wy == 0.0 || is_corner {
                    continue;
                }
                let at = base + DVec2::new(x.into(), y.into());
                let index = tap(u, at, origin, previous).filter(|&i| previous.history[i][3] > 0.0);
                sharp = sharp.zip(index).map(|(mut sum, i)| {
                    (0..3).for_each(|c| sum[c] += wx * wy * previous.history[i][c]);
                    (0..3).for_each(|k| sum[3 + k] += wx * wy * previous.noise[i].deviations[k]);
                    sum
                });
            }
        }
        let outer = [f.x, f.y].map(|f| cubic(f)[0] + cubic(f)[3]);
        let sharp = sharp.map(|sum| sum.map(|value| value / (1.0 - outer[0] * outer[1])));
        if let Some(sharp) = sharp {
            let inner = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
                let at = base + DVec2::new(x, y);
                previous.history[(at.y * f64::from(u.size[0]) + at.x) as usize]
            });
            let [least, most] = [f64::min, f64::max].map(|pick| {
                inner.map(|tap| luminance([tap[0], tap[1], tap[2]])).into_iter().reduce(pick).unwrap()
            });
            let l = luminance([sharp[0], sharp[1], sharp[2]]);
            if l >= 0.5 * least {
                (0..3).for_each(|c| history[c] = sharp[c].max(0.0) * l.clamp(least, most) / l.max(1e-30));
                noise.deviations.copy_from_slice(&sharp[3..]);
            }
        }
    }
    (history, noise)
}
