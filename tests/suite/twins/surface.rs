//! Surfaces, views and features in f64.

use super::packed::pcg;
use super::{Signal, luminance};
use crate::sequence::Frame;
use glam::{DMat3, DVec2, DVec3};
use quell::gpu::{FrameUniforms, ViewUniforms};
use quell::layout::{MODELS, SURFACE_FEATURES};

#[derive(Debug, Clone, Copy)]
pub struct Surface {
    pub normal: DVec3,
    pub depth: f64,
    /// 0.1 / luminance of the demodulator; of the specular signal, how near what it reflects is.
    pub cue: f64,
    pub roughness: f64,
    pub id: u32,
}

impl Surface {
    pub fn is_miss(&self) -> bool {
        self.depth <= 0.0
    }
}

const IDS: u32 = 1024;

/// What is known of a pixel of a frame's images (whose albedo, normal and roughness are half floats), repaired.
pub fn read(frame: &Frame, far: f64, i: usize) -> Surface {
    let half = |v: f32| f64::from(half::f16::from_f32(v));
    let depth = f64::from(frame.depth[i]);
    let hit = depth > 0.0 && depth < far.min(1e12); // NaN is none
    let [x, y, z, roughness] = frame.normal[i].map(half);
    let n = DVec3::new(x, y, z);
    let usable = n.is_finite() && n.length_squared() >= 1e-8;
    Surface {
        normal: if usable { n.normalize() } else { DVec3::Z },
        depth: if hit { depth } else { 0.0 },
        cue: 0.1 / luminance(demodulator(frame, i)),
        roughness: if roughness.is_finite() { roughness.clamp(0.0, 1.0) } else { 1.0 },
        id: pcg(frame.id[i]) % IDS,
    }
}

/// What radiance is divided by.
pub fn demodulator(frame: &Frame, i: usize) -> [f64; 3] {
    let [r, g, b, _] = frame.albedo[i].map(|c| f64::from(half::f16::from_f32(c)));
    let rgb = [r, g, b];
    if rgb.iter().all(|c| c.is_finite()) { rgb.map(of_albedo) } else { [1.0; 3] }
}

/// What radiance is divided by where albedo is finite.
pub fn of_albedo(albedo: f64) -> f64 {
    0.1 + 0.9 * albedo.max(0.0)
}

fn sign(v: f64) -> f64 {
    if v >= 0.0 { 1.0 } else { -1.0 }
}

/// Normal 11 + 11 bits, id 10; roughness 5, cue 7, depth 20.
pub fn pack(s: &Surface) -> [u32; 2] {
    let n = s.normal;
    let mut e = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    if n.z < 0.0 {
        e = DVec2::new((1.0 - e.y.abs()) * sign(e.x), (1.0 - e.x.abs()) * sign(e.y));
    }
    let signed = |v: f64| ((v * 1023.0).round() + 1023.0) as u32;
    let cue = s.cue.clamp(0.0, 1.0).sqrt();
    [
        signed(e.x) | signed(e.y) << 11 | s.id << 22,
        (s.roughness * 31.0).round() as u32 | ((cue * 127.0).round() as u32) << 5 | pack_depth(s.depth) << 12,
    ]
}

/// Exponents of the least and the largest depth, which has a mantissa of 13 bits. Code 0 is a miss.
pub const DEPTH_EXPONENTS: [i32; 2] = [-64, 63];

fn pack_depth(depth: f64) -> u32 {
    if depth <= 0.0 {
        return 0;
    }
    let [least, most] = DEPTH_EXPONENTS;
    let exponent = (depth.log2().floor() as i32).clamp(least, most);
    // A mantissa that is rounded up to 2 is the next exponent's first.
    let mantissa = ((depth / 2.0_f64.powi(exponent) - 1.0) * 8192.0).round();
    let code = f64::from(exponent - least) * 8192.0 + mantissa;
    code.clamp(1.0, f64::from((1 << 20) - 1)) as u32
}

fn unpack_depth(code: u32) -> f64 {
    if code == 0 {
        return 0.0;
    }
    (1.0 + f64::from(code % 8192) / 8192.0) * 2.0_f64.powi((code / 8192) as i32 + DEPTH_EXPONENTS[0])
}

pub fn unpack([low, high]: [u32; 2]) -> Surface {
    let signed = |bits: u32| (f64::from(bits & 2047) - 1023.0) / 1023.0;
    let e = DVec2::new(signed(low), signed(low >> 11));
    let z = 1.0 - e.x.abs() - e.y.abs();
    let folded = DVec2::new((1.0 - e.y.abs()) * sign(e.x), (1.0 - e.x.abs()) * sign(e.y));
    let xy = if z < 0.0 { folded } else { e };
    Surface {
        normal: xy.extend(z).normalize(),
        depth: unpack_depth(high >> 12),
        cue: (f64::from(high >> 5 & 127) / 127.0).powi(2),
        roughness: f64::from(high & 31) / 31.0,
        id: low >> 22,
    }
}

fn rotation(view: &ViewUniforms) -> DMat3 {
    DMat3::from_mat4(view.view_from_world.as_dmat4())
}

fn vec2(v: [f32; 2]) -> DVec2 {
    DVec2::new(v[0].into(), v[1].into())
}

pub fn position_at(view: &ViewUniforms, uv: DVec2, depth: f64) -> DVec3 {
    let ndc = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
    let w = if view.perspective == 1.0 { depth } else { 1.0 };
    let xy = (ndc * w + vec2(view.shift) * depth - vec2(view.offset)) / vec2(view.scale);
    rotation(view).transpose() * xy.extend(-depth)
}

pub fn position_of(frame: &FrameUniforms, view: &ViewUniforms, pixel: DVec2, depth: f64) -> DVec3 {
    let size = DVec2::new(frame.size[0].into(), frame.size[1].into());
    position_at(view, (pixel + 0.5 + vec2(view.jitter)) / size, depth)
}

pub fn project(view: &ViewUniforms, position: DVec3) -> DVec3 {
    let p = rotation(view) * position;
    let w = if view.perspective == 1.0 { -p.z } else { 1.0 };
    let ndc = (vec2(view.scale) * p.truncate() + vec2(view.shift) * p.z + vec2(view.offset)) / w;
    DVec3::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y, -p.z)
}

/// Unit vector from a position relative to the eye to the eye.
pub fn towards_eye(view: &ViewUniforms, position: DVec3) -> DVec3 {
    if view.perspective == 1.0 { -position.normalize() } else { rotation(view).transpose() * DVec3::Z }
}

pub fn same_surface(a: &Surface, b: &Surface, offset: DVec3) -> bool {
    is_alike(a, b, offset, 0.9)
}

/// Whether both are of one object and plane, with normals whose cosine is above `cosine`.
pub fn is_alike(a: &Surface, b: &Surface, offset: DVec3, cosine: f64) -> bool {
    !b.is_miss()
        && a.id == b.id
        && a.normal.dot(b.normal) > cosine
        && a.normal.dot(offset).abs() < 0.01 * a.depth
}

/// The feature table.
pub fn surface_features(
    frame: &FrameUniforms,
    signal: Signal,
    i: usize,
    s: &Surface,
) -> [f64; SURFACE_FEATURES as usize] {
    let mut p = position_of(frame, &frame.current, pixel(frame, i), s.depth);
    let mut cue = s.cue;
    if signal == Signal::Specular {
        // That of what is reflected.
        let view = -towards_eye(&frame.current, p);
        let distance = if s.cue > 0.0 { p.length() * (1.0 / s.cue.max(0.0625) - 1.0) } else { 0.0 };
        let mirrored = (1.0 - 5.0 * s.roughness).max(0.0);
        p += (view - 2.0 * s.normal.dot(view) * s.normal) * distance * mirrored;
        cue *= mirrored;
    }
    let id = f64::from(s.id) * 2.0 / f64::from(IDS - 1) - 1.0;
    [s.normal.x, s.normal.y, s.normal.z, p.x, p.y, p.z, cue, id, s.roughness]
}

/// With those that only the models of the prediction have.
pub fn features(
    frame: &FrameUniforms,
    signal: Signal,
    i: usize,
    s: &Surface,
) -> [f64; MODELS.features as usize] {
    let (own, pixel) = (surface_features(frame, signal, i, s), pixel(frame, i));
    std::array::from_fn(|f| *own.get(f).unwrap_or(if f == own.len() { &pixel.x } else { &pixel.y }))
}

pub fn pixel(frame: &FrameUniforms, i: usize) -> DVec2 {
    let width = frame.size[0] as usize;
    DVec2::new((i % width) as f64, (i / width) as f64)
}
