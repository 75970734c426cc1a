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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::gallery::{WALK_S, gallery, tour};
    use glam::vec3;

    fn shown(part: usize, time_s: f32) -> Shown {
        Shown { part, time_s }
    }

    #[test]
    fn a_single_scene_goes_on_for_ever() {
        let single = Tour::of(Scene::empty("single"));
        for time_s in [-1.0, 0.0, 24.0, 1e6] {
            assert_eq!(single.at(time_s), shown(0, time_s));
        }
    }

    #[test]
    fn parts_take_turns() {
        let tour = tour();
        let before = f32::from_bits(24.0_f32.to_bits() - 1);
        for (time_s, expected) in [
            (0.0, shown(0, 0.0)),
            (15.3, shown(0, 15.3)),
            (before, shown(0, before)),
            (24.0, shown(1, 0.0)),
            (35.5, shown(1, 11.5)),
            (36.0, shown(0, 0.0)),
            (61.0, shown(1, 1.0)),
            (-1.0, shown(1, 11.0)),
        ] {
            assert_eq!(tour.at(time_s), expected, "{time_s} s");
        }
        assert_eq!(tour.start_s(1), WALK_S);
    }

    fn emitters(scene: &Scene) -> Vec<(&str, usize)> {
        let emits = |mesh: &&crate::scene::Mesh| scene.materials[mesh.material].is_emissive();
        let meshes = scene.meshes.iter().filter(emits);
        meshes.map(|mesh| (mesh.name.as_str(), mesh.triangles.len())).collect()
    }

    /// Published measurements are of these images.
    #[test]
    fn the_first_walk_stays_as_it_is() {
        let (tour, gallery) = (tour(), gallery());
        let first = tour.scene(0);
        assert_eq!(emitters(first), emitters(&gallery));
        assert_eq!(emitters(first), [("lamp", 576)]);
        for (time_s, x, z) in [(0.0, -6.2, 3.3), (7.9, 5.273_054, 2.213_624), (15.0, 1.233_203, -2.192_285)] {
            let eye = tour.camera(time_s).eye;
            assert!(eye.abs_diff_eq(vec3(x, 1.68, z), 1e-5), "{time_s} s: {eye}");
        }
    }
}
