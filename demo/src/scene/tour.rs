//! Scenes shown one after the other.

use super::{CameraPose, Scene};

/// Scenes that follow each other over and over, a cut between any two. Each is a world of its own: nothing of one is lit by, or
/// costs time in, another.
#[derive(Debug, Clone)]
pub struct Tour {
    pub name: String,
    /// At least one, each with its time in seconds.
    parts: Vec<(Scene, f32)>,
}

/// What a tour shows at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    pub part: usize,
    /// Time in that part's scene.
    pub time_s: f32,
}

impl Tour {
    /// Panics without parts.
    pub fn new(name: &str, parts: Vec<(Scene, f32)>) -> Self {
        assert!(!parts.is_empty(), "a tour has a scene to show");
        Self { name: name.to_owned(), parts }
    }

    /// A single scene, whose time goes on for ever.
    pub fn of(scene: Scene) -> Self {
        Self::new(&scene.name.clone(), vec![(scene, f32::INFINITY)])
    }

    pub fn scenes(&self) -> impl Iterator<Item = &Scene> {
        self.parts.iter().map(|(scene, _)| scene)
    }

    pub fn scene(&self, part: usize) -> &Scene {
        &self.parts[part].0
    }

    /// When a part first begins.
    pub fn start_s(&self, part: usize) -> f32 {
        self.parts[..part].iter().map(|part| part.1).sum()
    }

    pub fn at(&self, time_s: f32) -> Shown {
        let length = self.start_s(self.parts.len());
        let time_s = if length.is_finite() { time_s.rem_euclid(length) } else { time_s };
        let is_begun = |part: &usize| self.start_s(*part) <= time_s;
        let part = (0..self.parts.len()).rev().find(is_begun).unwrap_or(0);
        Shown { part, time_s: time_s - self.start_s(part) }
    }

    pub fn camera(&self, time_s: f32) -> CameraPose {
        let Shown { part, time_s } = self.at(time_s);
        self.scene(part).camera(time_s)
    }
}
