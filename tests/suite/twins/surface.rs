//! Surfaces, views and features in f64.

use crate::sequence::Frame;
use glam::{DMat3, DVec2, DVec3};
use quell::gpu::{FrameUniforms, ViewUniforms};
use quell::layout::{MODELS, SURFACE_FEATURES};

#[derive(Debug, Clone, Copy)]
pub struct Surface {
    pub normal: DVec3,
    pub depth: f64,
    pub inverse_albedo: f64,
    pub roughness: f64,
    pub id: u32,
}

impl Surface {
    pub fn is_miss(&self) -> bool {
        self.depth <= 0.0
    }
}

/// The words `prepare` writes for a pixel.
pub fn pack(frame: &Frame, i: usize) -> [u32; 4] {
    let depth = if frame.depth[i].is_finite() { frame.depth[i] } else { 0.0 };
    let n = DVec3::new(frame.normal[i][0].into(), frame.normal[i][1].into(), frame.normal[i][2].into());
    let n = n.try_normalize().unwrap_or(DVec3::Z);
    let mut e = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    if n.z < 0.0 {
        let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
        e = DVec2::new((1.0 - e.y.abs()) * sign(e.x), (1.0 - e.x.abs()) * sign(e.y));
    }
    let snorm = |v: f64| u32::from((v * 32767.0).round() as i16 as u16);
    let a = frame.albedo[i].map(|c| f64::from(c).max(0.02));
    let q = 0.1 / super::luminance([a[0], a[1], a[2]]);
    let unorm = |v: f64| (v * 65535.0).round() as u32;
    [
        snorm(e.x) | snorm(e.y) << 16,
        depth.to_bits(),
        unorm(q / 5.0) | unorm(frame.normal[i][3].into()) << 16,
        frame.id[i],
    ]
}

pub fn unpack([normal, depth, material, id]: [u32; 4]) -> Surface {
    let half = |bits: u32| f64::from(bits as u16 as i16) / 32767.0;
    let e = DVec2::new(half(normal), half(normal >> 16));
    let z = 1.0 - e.x.abs() - e.y.abs();
    let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
    let folded = DVec2::new((1.0 - e.y.abs()) * sign(e.x), (1.0 - e.x.abs()) * sign(e.y));
    let xy = if z < 0.0 { folded } else { e };
    Surface {
        normal: xy.extend(z).normalize(),
        depth: f32::from_bits(depth).into(),
        inverse_albedo: f64::from(material & 0xffff) / 65535.0 * 5.0,
        roughness: f64::from(material >> 16) / 65535.0,
        id,
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

pub fn same_surface(a: &Surface, b: &Surface, offset: DVec3) -> bool {
    !b.is_miss()
        && a.id == b.id
        && a.normal.dot(b.normal) > 0.9
        && a.normal.dot(offset).abs() < 0.01 * a.depth
}

fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The feature table.
pub fn surface_features(frame: &FrameUniforms, i: usize, s: &Surface) -> [f64; SURFACE_FEATURES as usize] {
    let p = position_of(frame, &frame.current, pixel(frame, i), s.depth);
    let id = f64::from(pcg(s.id)) / 2_147_483_648.0 - 1.0;
    [s.normal.x, s.normal.y, s.normal.z, p.x, p.y, p.z, s.inverse_albedo, id, s.roughness]
}

/// With those that only the models of the prediction have.
pub fn features(frame: &FrameUniforms, i: usize, s: &Surface) -> [f64; MODELS.features as usize] {
    let (own, pixel) = (surface_features(frame, i, s), pixel(frame, i));
    std::array::from_fn(|f| *own.get(f).unwrap_or(if f == own.len() { &pixel.x } else { &pixel.y }))
}

fn pixel(frame: &FrameUniforms, i: usize) -> DVec2 {
    let width = frame.size[0] as usize;
    DVec2::new((i % width) as f64, (i / width) as f64)
}
