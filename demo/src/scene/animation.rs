//! Keyframes, and the nodes they move.

use glam::{Affine3A, Quat, Vec3};

/// How a value goes from one key to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    #[default]
    Linear,
    Step,
}

/// What a track can hold.
pub trait Animated: Copy {
    fn mix(self, other: Self, t: f32) -> Self;
}

impl Animated for f32 {
    fn mix(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }
}

impl Animated for Vec3 {
    fn mix(self, other: Self, t: f32) -> Self {
        self.lerp(other, t)
    }
}

impl Animated for Quat {
    fn mix(self, other: Self, t: f32) -> Self {
        self.slerp(other, t)
    }
}

/// Keyframes that repeat.
#[derive(Debug, Clone, PartialEq)]
pub struct Track<T> {
    /// Time in seconds, ascending, and value.
    pub keys: Vec<(f32, T)>,
    pub interpolation: Interpolation,
    /// Length of the loop in seconds; 0 holds the last key for ever.
    pub period: f32,
}

impl<T: Animated> Track<T> {
    /// The value at `time_s`: the first key's before it, the last one's after it.
    ///
    /// Panics without keys, which no constructor here makes.
    pub fn at(&self, time_s: f32) -> T {
        let time = if self.period > 0.0 { time_s.rem_euclid(self.period) } else { time_s };
        let next = self.keys.partition_point(|&(t, _)| t <= time);
        if next == 0 {
            return self.keys[0].1;
        }
        let (t0, before) = self.keys[next - 1];
        match self.keys.get(next) {
            Some(&(t1, after)) if self.interpolation == Interpolation::Linear => {
                before.mix(after, (time - t0) / (t1 - t0))
            }
            _ => before,
        }
    }
}

/// Translation, rotation, scale; applied in the reverse order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trs {
    pub translation: Vec3,
    pub rotation: Quat,
    pub scale: Vec3,
}

impl Trs {
    pub const IDENTITY: Self = Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    pub fn at(translation: Vec3) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    fn matrix(&self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// Tracks that replace parts of a node's transform.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NodeAnimation {
    pub translation: Option<Track<Vec3>>,
    pub rotation: Option<Track<Quat>>,
    pub scale: Option<Track<Vec3>>,
}

/// A place in the hierarchy.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    pub name: String,
    /// Index of a node before this one.
    pub parent: Option<usize>,
    pub local: Trs,
    pub animation: Option<NodeAnimation>,
}

impl Node {
    /// A root node that does not move.
    pub fn still(local: Trs) -> Self {
        Self { name: String::new(), parent: None, local, animation: None }
    }

    /// A root node that turns about `axis` once in `period` seconds.
    pub fn spinning(local: Trs, axis: Vec3, period: f32) -> Self {
        const KEYS: usize = 8;
        let key = |i: usize| {
            let turn = i as f32 / KEYS as f32;
            (turn * period, Quat::from_axis_angle(axis, turn * std::f32::consts::TAU) * local.rotation)
        };
        let keys = (0..=KEYS).map(key).collect();
        let rotation = Some(Track { keys, interpolation: Interpolation::Linear, period });
        Self { animation: Some(NodeAnimation { rotation, ..Default::default() }), ..Self::still(local) }
    }

    pub fn parent_from_node(&self, time_s: f32) -> Affine3A {
        let mut local = self.local;
        if let Some(animation) = &self.animation {
            if let Some(track) = &animation.translation {
                local.translation = track.at(time_s);
            }
            if let Some(track) = &animation.rotation {
                local.rotation = track.at(time_s);
            }
            if let Some(track) = &animation.scale {
                local.scale = track.at(time_s);
            }
        }
        local.matrix()
    }
}
