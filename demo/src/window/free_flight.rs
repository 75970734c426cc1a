//! A camera that flies freely.

use glam::camera::rh::view::look_to_mat4;
use glam::{Mat4, Vec2, Vec3};

/// Radians per pixel of mouse movement.
const LOOK_SPEED: f32 = 0.003;
/// Just short of straight up and down, where left and right would flip.
const MAX_PITCH: f32 = 1.55;
/// How much faster shift makes it.
const FAST: f32 = 5.0;

/// Position and direction; y is up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeFlight {
    pub position: Vec3,
    /// Turn to the left in radians; 0 looks down -z.
    pub yaw: f32,
    /// Upwards in radians.
    pub pitch: f32,
    /// Scene units per second.
    pub speed: f32,
}

/// What the user asks for during one frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FlightInput {
    /// Right, up and forward, each -1 to 1.
    pub direction: Vec3,
    pub fast: bool,
    /// Mouse movement in pixels, +x right, +y down.
    pub look_px: Vec2,
}

impl FreeFlight {
    /// Starts where a camera is. Roll is lost: the horizon becomes level.
    pub fn from_view(view_from_world: Mat4, speed: f32) -> Self {
        let world_from_view = view_from_world.inverse();
        let forward = -world_from_view.z_axis.truncate().normalize_or(Vec3::Z);
        Self {
            position: world_from_view.w_axis.truncate(),
            yaw: (-forward.x).atan2(-forward.z),
            pitch: forward.y.clamp(-1.0, 1.0).asin().clamp(-MAX_PITCH, MAX_PITCH),
            speed,
        }
    }

    pub fn forward(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        Vec3::new(-sin_yaw * cos_pitch, sin_pitch, -cos_yaw * cos_pitch)
    }

    /// View from world.
    pub fn view(&self) -> Mat4 {
        look_to_mat4(self.position, self.forward(), Vec3::Y)
    }

    /// Turns and moves for `elapsed_s` seconds. Diagonals are not faster; up is the world's up.
    pub fn advance(&mut self, input: &FlightInput, elapsed_s: f32) {
        self.yaw = (self.yaw - input.look_px.x * LOOK_SPEED).rem_euclid(std::f32::consts::TAU);
        self.pitch = (self.pitch - input.look_px.y * LOOK_SPEED).clamp(-MAX_PITCH, MAX_PITCH);
        let forward = self.forward();
        let right = forward.cross(Vec3::Y).normalize_or_zero();
        let direction = right * input.direction.x + Vec3::Y * input.direction.y + forward * input.direction.z;
        let speed = self.speed * if input.fast { FAST } else { 1.0 };
        self.position += direction.clamp_length_max(1.0) * speed * elapsed_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> FreeFlight {
        FreeFlight { position: Vec3::new(1.0, 2.0, 3.0), yaw: 0.0, pitch: 0.0, speed: 2.0 }
    }

    fn moved(direction: Vec3, fast: bool) -> Vec3 {
        let mut flight = start();
        flight.advance(&FlightInput { direction, fast, ..Default::default() }, 0.5);
        flight.position - start().position
    }

    #[test]
    fn it_moves_where_it_is_told() {
        assert!(moved(Vec3::Z, false).abs_diff_eq(Vec3::new(0.0, 0.0, -1.0), 1e-6));
        assert!(moved(Vec3::X, false).abs_diff_eq(Vec3::X, 1e-6));
        assert!(moved(-Vec3::Y, false).abs_diff_eq(-Vec3::Y, 1e-6));
        assert!((moved(Vec3::ONE, false).length() - 1.0).abs() < 1e-6, "diagonals are not faster");
        assert!((moved(Vec3::Z, true).length() - FAST).abs() < 1e-5);
        assert_eq!(moved(Vec3::ZERO, true), Vec3::ZERO);
    }

    #[test]
    fn the_mouse_turns_the_view_and_cannot_flip_it() {
        let mut flight = start();
        flight.advance(&FlightInput { look_px: Vec2::new(100.0, -50.0), ..Default::default() }, 0.1);
        assert!(flight.forward().x > 0.0 && flight.forward().y > 0.0, "right and up");
        flight.advance(&FlightInput { look_px: Vec2::new(0.0, 1e6), ..Default::default() }, 0.1);
        assert!(flight.view().is_finite() && flight.pitch >= -MAX_PITCH);
    }

    #[test]
    fn it_starts_from_a_view_and_gives_it_back() {
        for (yaw, pitch) in [(0.3, 0.2), (4.0, -1.2), (2.0, 0.0)] {
            let view = FreeFlight { yaw, pitch, ..start() }.view();
            let again = FreeFlight::from_view(view, 1.0).view();
            assert!(again.abs_diff_eq(view, 1e-4), "yaw {yaw}, pitch {pitch}");
        }
    }
}
