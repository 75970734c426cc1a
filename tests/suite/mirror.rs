//! The analytic scene with every surface a mirror: what is reflected in it, and how far that is.

use crate::sequence::{Frame, radiance_along};
use glam::{Vec2, Vec3};
use rand::{Rng, SeedableRng, rngs::StdRng};

/// Part of the light that mirrors reflect.
pub const REFLECTANCE: f32 = 0.5;

/// The frame with a specular signal that is as noisy as the other, and with hit distances. Its truth is the sum.
pub fn mirrored(frame: &Frame, seed: u64) -> Frame {
    let mut random = StdRng::seed_from_u64(seed);
    let [width, height] = frame.size;
    let world_from_clip = (frame.camera.clip_from_view * frame.camera.view_from_world).inverse();
    let eye = frame.camera.view_from_world.inverse().w_axis.truncate();
    let mut mirrored = frame.clone();
    mirrored.specular = vec![[0.0; 4]; frame.depth.len()];
    mirrored.hit_distance = vec![0.0; frame.depth.len()];
    mirrored.mirror_truth = vec![[0.0; 3]; frame.depth.len()];
    for (i, &depth) in frame.depth.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
        let pixel = Vec2::new((i as u32 % width) as f32, (i as u32 / width) as f32);
        let uv = (pixel + 0.5 + frame.camera.jitter_px) / Vec2::new(width as f32, height as f32);
        let far = world_from_clip.project_point3(Vec3::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.5));
        let view = (far - eye).normalize();
        let forwards = -frame.camera.view_from_world.row(2).truncate();
        let position = eye + view * (depth / forwards.dot(view));
        let [x, y, z, _] = frame.normal[i];
        let normal = Vec3::new(x, y, z).normalize();
        let towards = view - 2.0 * normal.dot(view) * normal;
        let (radiance, distance) = radiance_along(position + 1e-3 * normal, towards);
        let seen = if random.random_bool(0.4) { 2.5 } else { 0.0 };
        mirrored.specular[i] = (REFLECTANCE * radiance * seen).extend(1.0).to_array();
        mirrored.hit_distance[i] = distance;
        mirrored.mirror_truth[i] = (REFLECTANCE * radiance).to_array();
        mirrored.truth[i] = (Vec3::from_array(frame.truth[i]) + REFLECTANCE * radiance).to_array();
    }
    mirrored
}
