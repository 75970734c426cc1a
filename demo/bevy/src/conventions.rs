//! What bevy's numbers mean, in quell's words. Needs no bevy, so that quell's own tests hold it to its word.

use quell::glam::{Mat4, Vec2};
use quell::{Camera, Conventions, MotionDirection};

/// Bevy's motion-vector prepass: UV, y down, without jitter, where a point is now minus where it was. All else is as quell has it: depth
/// and normals come from the decoding pass.
pub fn conventions() -> Conventions {
    Conventions::default().with_motion_direction(MotionDirection::FromPrevious)
}

/// A bevy camera without jitter, from column-major matrices (bevy and quell need not have the same glam), and bevy's `TemporalJitter`:
/// in pixels, y down, it says where a pixel's sample lies.
pub fn camera(world_from_view: [f32; 16], clip_from_view: [f32; 16], jitter: [f32; 2]) -> Camera {
    let view_from_world = Mat4::from_cols_array(&world_from_view).inverse();
    Camera::new(view_from_world, Mat4::from_cols_array(&clip_from_view)).with_jitter(Vec2::from_array(jitter))
}
