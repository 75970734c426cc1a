//! Where the camera is at a time.

use super::Scene;
use glam::Vec3;

/// A camera, looking from `eye` to `target`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    pub eye: Vec3,
    pub target: Vec3,
    pub up: Vec3,
    /// In radians.
    pub vertical_fov: f32,
}

#[derive(Debug, Clone, PartialEq)]
pub enum CameraPath {
    Still(CameraPose),
    /// A slow figure of eight about a pose, `amplitude` wide, that keeps its target in view.
    Sway {
        pose: CameraPose,
        amplitude: f32,
        period: f32,
    },
    /// A smooth curve through points, at times that are equally spaced over `duration`.
    Spline {
        /// (eye, target)
        points: Vec<(Vec3, Vec3)>,
        vertical_fov: f32,
        duration: f32,
        /// Closed: after the last point comes the first. Open: there and back again.
        closed: bool,
    },
    /// A camera of the scene, with its node's animation.
    Node {
        node: usize,
        vertical_fov: f32,
        /// How far ahead the target lies; only matters to who steers from here.
        distance: f32,
    },
}

impl CameraPath {
    pub(super) fn at(&self, scene: &Scene, time_s: f32) -> CameraPose {
        match self {
            Self::Still(pose) => *pose,
            Self::Sway { pose, amplitude, period } => {
                let phase = time_s / period * std::f32::consts::TAU;
                let forward = (pose.target - pose.eye).normalize_or(Vec3::NEG_Z);
                let right = forward.cross(pose.up).normalize_or(Vec3::X);
                let offset = right * phase.sin() + pose.up * 0.3 * (2.0 * phase).sin();
                CameraPose { eye: pose.eye + offset * *amplitude, ..*pose }
            }
            Self::Spline { points, vertical_fov, duration, closed } => {
                let (eye, target) = spline(points, time_s / duration, *closed);
                CameraPose { eye, target, up: Vec3::Y, vertical_fov: *vertical_fov }
            }
            Self::Node { node, vertical_fov, distance } => {
                let world = scene.pose(time_s).world_from_node[*node];
                let forward = -world.transform_vector3(Vec3::Z).normalize_or(Vec3::Z);
                let eye = world.translation.into();
                let up = world.transform_vector3(Vec3::Y).normalize_or(Vec3::Y);
                CameraPose { eye, target: eye + forward * *distance, up, vertical_fov: *vertical_fov }
            }
        }
    }
}

/// Uniform Catmull-Rom spline. `turn` 0 to 1 goes once along the points.
fn spline(points: &[(Vec3, Vec3)], turn: f32, closed: bool) -> (Vec3, Vec3) {
    let count = points.len() as i64;
    let s = if closed {
        turn.rem_euclid(1.0) * count as f32
    } else {
        // Eases in and out at the ends, where the walk turns back.
        let there = 0.5 - 0.5 * (turn * std::f32::consts::PI).cos();
        there * (count - 1) as f32
    };
    let i = (s.floor() as i64).clamp(0, count - 1);
    let t = s - i as f32;
    let at = |k: i64| {
        let k = if closed { k.rem_euclid(count) } else { k.clamp(0, count - 1) };
        points[k as usize]
    };
    let [p0, p1, p2, p3] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
    (catmull_rom(p0.0, p1.0, p2.0, p3.0, t), catmull_rom(p0.1, p1.1, p2.1, p3.1, t))
}

fn catmull_rom(p0: Vec3, p1: Vec3, p2: Vec3, p3: Vec3, t: f32) -> Vec3 {
    let a = 2.0 * p1;
    let b = p2 - p0;
    let c = 2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3;
    let d = 3.0 * p1 - p0 - 3.0 * p2 + p3;
    0.5 * (a + t * (b + t * (c + t * d)))
}
