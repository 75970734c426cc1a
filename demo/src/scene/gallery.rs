//! The gallery.
use super::Scene;
pub fn gallery() -> Scene {
    Scene::empty("gallery")
}
