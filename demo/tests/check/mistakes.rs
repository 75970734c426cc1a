//! What renderers get wrong, done to frames that are right.

use crate::stretch::SIZE;
use glam::{Mat3, Mat4, Vec2, Vec3};
use quell::Mistake;
use quell_demo::capture::{Frame, FrameInfo};

/// A mistake, and what is to be said of it.
pub struct Injected {
    pub name: &'static str,
    pub input: &'static str,
    pub mistake: Mistake,
    /// The stretches that can tell.
    pub on: &'static [&'static str],
    /// Of a frame, its camera, that of the frame before as it is right, and the frame's number.
    pub inject: fn(&mut Frame, &mut FrameInfo, &FrameInfo, u32),
}

const BOTH: &[&str] = &["colonnade", "reflections"];

const fn injected(
    name: &'static str,
    input: &'static str,
    mistake: Mistake,
    inject: fn(&mut Frame, &mut FrameInfo, &FrameInfo, u32),
) -> Injected {
    Injected { name, input, mistake, on: BOTH, inject }
}

pub static MISTAKES: [Injected; 35] = [
    injected("motion backwards", "motion", Mistake::MotionSign, |frame, _, _, _| {
        scale_motion(frame, [-1.0, -1.0])
    }),
    injected("motion y up", "motion", Mistake::MotionSign, |frame, _, _, _| scale_motion(frame, [1.0, -1.0])),
    injected("motion x backwards", "motion", Mistake::MotionSign, |frame, _, _, _| {
        scale_motion(frame, [-1.0, 1.0])
    }),
    injected("motion in UV", "motion", Mistake::MotionScale, |frame, _, _, _| {
        scale_motion(frame, [1.0 / SIZE[0] as f32, 1.0 / SIZE[1] as f32]);
    }),
    injected("motion in pixels where UV was said", "motion", Mistake::MotionScale, |frame, _, _, _| {
        scale_motion(frame, [SIZE[0] as f32, SIZE[1] as f32]);
    }),
    injected("motion in NDC", "motion", Mistake::MotionScale, |frame, _, _, _| {
        scale_motion(frame, [2.0, -2.0])
    }),
    injected("motion missing", "motion", Mistake::MotionMissing, |frame, _, _, _| {
        scale_motion(frame, [0.0, 0.0])
    }),
    injected("motion doubled", "motion", Mistake::MotionScale, |frame, _, _, _| {
        scale_motion(frame, [2.0, 2.0])
    }),
    injected("motion halved", "motion", Mistake::MotionScale, |frame, _, _, _| {
        scale_motion(frame, [0.5, 0.5])
    }),
    injected("jitter in motion", "motion", Mistake::JitterInMotion, |frame, info, before, _| {
        let jitter = before.jitter_px - info.jitter_px;
        frame.motion.iter_mut().for_each(|m| *m = (Vec2::from(*m) - jitter).to_array());
    }),
    injected("jitter in motion, other way", "motion", Mistake::JitterInMotion, |frame, info, before, _| {
        let jitter = before.jitter_px - info.jitter_px;
        frame.motion.iter_mut().for_each(|m| *m = (Vec2::from(*m) + jitter).to_array());
    }),
    injected(
        "normals in view space",
        "normal_roughness",
        Mistake::NormalsInViewSpace,
        |frame, info, _, _| {
            let view_from_world = Mat3::from_mat4(info.view);
            frame.normal.iter_mut().for_each(|n| *n = (view_from_world * Vec3::from(*n)).to_array());
        },
    ),
    injected("normals inverted", "normal_roughness", Mistake::NormalsInverted, |frame, _, _, _| {
        frame.normal.iter_mut().for_each(|n| *n = n.map(|v| -v));
    }),
    injected("normals packed", "normal_roughness", Mistake::NormalEncoding, |frame, _, _, _| {
        frame.normal.iter_mut().for_each(|n| *n = n.map(|v| 0.5 + 0.5 * v));
    }),
    injected("hardware depth of the projection", "depth", Mistake::DepthNotLinear, |frame, info, _, _| {
        let clip = info.projection;
        frame.depth.iter_mut().for_each(|d| *d = clip.w_axis.z / *d - clip.z_axis.z);
    }),
    injected("hardware depth, not reversed", "depth", Mistake::DepthNotLinear, |frame, _, _, _| {
        frame.depth.iter_mut().for_each(|d| *d = 1.0 - 0.1 / *d);
    }),
    injected("inverse depth", "depth", Mistake::DepthReversed, |frame, info, _, _| {
        // With another projection, so that depth is not just that of clip space.
        info.projection.z_axis.z = -1.0;
        info.projection.w_axis.z = -0.1;
        frame.depth.iter_mut().for_each(|d| *d = 1.0 / *d);
    }),
    injected("depth reversed", "depth", Mistake::DepthReversed, |frame, _, _, _| {
        frame.depth.iter_mut().for_each(|d| *d = (1.0 - *d / 100.0).max(0.0));
    }),
    injected("depth along the ray", "depth", Mistake::DepthAlongRay, |frame, info, _, _| {
        along_ray(frame, info)
    }),
    injected("depth negative", "depth", Mistake::DepthNegative, |frame, _, _, _| {
        frame.depth.iter_mut().for_each(|d| *d = -*d);
    }),
    injected("albedo missing", "albedo", Mistake::AlbedoMissing, |frame, _, _, _| {
        frame.albedo.fill([1.0; 3])
    }),
    injected("albedo black", "albedo", Mistake::AlbedoMissing, |frame, _, _, _| frame.albedo.fill([0.0; 3])),
    injected("albedo in sRGB", "albedo", Mistake::AlbedoNotLinear, |frame, _, _, _| {
        frame.albedo.iter_mut().for_each(|a| *a = a.map(srgb));
    }),
    injected("jitter in matrices", "camera", Mistake::JitterInMatrices, |_, info, _, i| {
        let jitter =
            if info.jitter_px == Vec2::ZERO { quell_demo::halton::jitter_px(i) } else { info.jitter_px };
        info.projection.z_axis.x += 2.0 * jitter.x / SIZE[0] as f32;
        info.projection.z_axis.y -= 2.0 * jitter.y / SIZE[1] as f32;
    }),
    injected("ids anew each frame", "surface_id", Mistake::IdsChange, |frame, _, _, i| {
        let ids = frame.surface_id.as_mut().unwrap();
        ids.iter_mut().for_each(|id| *id = id.wrapping_mul(31).wrapping_add(1000 * i));
    }),
    injected("view transposed", "camera", Mistake::CameraTransposed, |_, info, _, _| {
        info.view = info.view.transpose()
    }),
    injected("projection transposed", "camera", Mistake::CameraTransposed, |_, info, _, _| {
        info.projection = info.projection.transpose();
    }),
    injected("world from view", "camera", Mistake::CameraTransposed, |_, info, _, _| {
        let (_, rotation, translation) = info.view.inverse().to_scale_rotation_translation();
        info.view = Mat4::from_rotation_translation(rotation, translation);
    }),
    injected("rotation transposed", "camera", Mistake::CameraTransposed, |_, info, _, _| {
        let eye = info.view.w_axis;
        info.view = Mat4::from_mat3(Mat3::from_mat4(info.view).transpose());
        info.view.w_axis = eye;
    }),
    injected("camera late", "camera", Mistake::CameraLate, |_, info, before, _| {
        info.view = before.view;
    }),
    Injected {
        on: &["reflections"],
        ..injected("emission twice", "emission", Mistake::EmissionTwice, |frame, _, _, _| {
            add_emission(frame, 1.0)
        })
    },
    Injected {
        on: &["reflections"],
        ..injected("emission left out", "emission", Mistake::EmissionLacking, |frame, _, _, _| {
            add_emission(frame, -1.0)
        })
    },
    injected("hit distances in millimetres", "hit_distance", Mistake::HitDistanceUnit, |frame, _, _, _| {
        frame.hit_distance.iter_mut().flatten().for_each(|d| *d *= 1000.0);
    }),
    injected("hit distances over 50", "hit_distance", Mistake::HitDistanceUnit, |frame, _, _, _| {
        frame.hit_distance.iter_mut().flatten().for_each(|d| *d = (*d / 50.0).min(1.0));
    }),
    injected(
        "hit distances from the eye",
        "hit_distance",
        Mistake::HitDistanceFromEye,
        |frame, info, _, _| {
            let linear = frame.depth.clone();
            along_ray(frame, info);
            let rays = std::mem::replace(&mut frame.depth, linear);
            for (distance, ray) in frame.hit_distance.iter_mut().flatten().zip(rays) {
                *distance += if *distance > 0.0 { ray } else { 0.0 };
            }
        },
    ),
];

fn scale_motion(frame: &mut Frame, scale: [f32; 2]) {
    frame.motion.iter_mut().for_each(|m| *m = [m[0] * scale[0], m[1] * scale[1]]);
}

fn add_emission(frame: &mut Frame, factor: f32) {
    let emission = frame.emission.as_ref().unwrap();
    for (radiance, emission) in frame.radiance.iter_mut().zip(emission) {
        *radiance = [0, 1, 2].map(|c| radiance[c] + factor * emission[c]);
    }
}

fn along_ray(frame: &mut Frame, info: &FrameInfo) {
    for (i, depth) in frame.depth.iter_mut().enumerate() {
        let pixel =
            Vec2::new((i as u32 % SIZE[0]) as f32, (i as u32 / SIZE[0]) as f32) + 0.5 + info.jitter_px;
        let ndc = Vec2::new(2.0 * pixel.x / SIZE[0] as f32 - 1.0, 1.0 - 2.0 * pixel.y / SIZE[1] as f32);
        let slope = ndc / Vec2::new(info.projection.x_axis.x, info.projection.y_axis.y);
        *depth *= slope.extend(1.0).length();
    }
}

fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
