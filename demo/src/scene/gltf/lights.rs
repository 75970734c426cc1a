//! KHR_lights_punctual.

use super::Placed;
use crate::scene::{PunctualKind, PunctualLight, Scene};
use glam::Vec3;
use gltf::khr_lights_punctual::Kind;

pub(super) fn load(scene: &mut Scene, placed: &Placed<'_>) {
    for (document_node, &node) in placed.iter() {
        let Some(light) = document_node.light() else {
            continue;
        };
        let kind = match light.kind() {
            Kind::Directional => PunctualKind::Directional,
            Kind::Point => PunctualKind::Point,
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                PunctualKind::Spot { inner: inner_cone_angle, outer: outer_cone_angle }
            }
        };
        let intensity = Vec3::from(light.color()) * light.intensity();
        let range = light.range().filter(|r| *r > 0.0).unwrap_or(f32::INFINITY);
        scene.punctual_lights.push(PunctualLight { node, kind, intensity, range });
    }
}
