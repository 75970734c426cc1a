//! Cameras with [`Quell`], copied to the render world.

use crate::{Quell, QuellView};
use bevy::camera::Camera;
use bevy::ecs::component::Component;
use bevy::ecs::system::{Commands, Query};
use bevy::render::{Extract, sync_world::RenderEntity};

/// What the camera's [`Quell`] says in this frame. Not [`Quell`] itself, which would bring what it requires along and hide that it is
/// missing.
#[derive(Component)]
pub struct ExtractedQuell(pub Quell);

pub fn extract(cameras: Extract<Query<(RenderEntity, &Camera, Option<&Quell>)>>, mut commands: Commands) {
    for (entity, camera, quell) in &cameras {
        let Ok(mut view) = commands.get_entity(entity) else { continue };
        match quell {
            Some(quell) if camera.is_active => {
                view.insert(ExtractedQuell(quell.clone())).insert_if_new(QuellView::default());
            }
            _ => {
                view.remove::<(ExtractedQuell, QuellView)>();
            }
        }
    }
}
