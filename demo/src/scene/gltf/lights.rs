//! KHR_lights_punctual.

use super::error::fail;
use super::limits::MOST_LIGHT;
use super::read::File;
use super::{Placed, Result, element};
use crate::scene::{PunctualKind, PunctualLight, Scene};
use glam::Vec3;
use gltf::khr_lights_punctual::Kind;

pub(super) fn load(file: &File, scene: &mut Scene, placed: &Placed<'_>) -> Result<()> {
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
        if !intensity.to_array().iter().all(|value| (0.0..=MOST_LIGHT).contains(value)) {
            let reason = format!("its light is {intensity}, expected 0 to {MOST_LIGHT:e} each");
            return fail(&file.path, &element("light", light.index(), light.name()), reason);
        }
        if let PunctualKind::Spot { inner, outer } = kind
            && ![inner, outer].iter().all(|angle| (0.0..=std::f32::consts::PI).contains(angle))
        {
            let reason = format!("its cone angles are {inner} and {outer}, expected 0 to pi");
            return fail(&file.path, &element("light", light.index(), light.name()), reason);
        }
        let range = light.range().filter(|r| *r > 0.0).unwrap_or(f32::INFINITY);
        scene.punctual_lights.push(PunctualLight { node, kind, intensity, range });
    }
    Ok(())
}
