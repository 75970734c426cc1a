//! What the cameras of a sequence say by themselves.

use crate::{Camera, Conventions};
use glam::{Mat4, Vec2};

/// Sums over the cameras of consecutive frames.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Cameras {
    /// Where the axis of view met the image in the last frame, and in what step it came there, in pixels.
    last: Option<(Vec2, Option<Vec2>)>,
    steps: u32,
    moved: u32,
    largest_px: f32,
    squares: f64,
    turns: u32,
    turn_squares: f64,
    turned_squares: f64,
    pub transposed: Transposed,
    pub declared_jitter: bool,
}

/// Frames whose camera can only be used with a matrix transposed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Transposed {
    pub view: u32,
    pub projection: u32,
}

/// Frames of evidence.
const LEAST_STEPS: u32 = 4;
/// Jitter stays within a pixel, so its steps within two; a view that shifts on purpose goes further, or smoothly.
const JITTER_STEP_PX: f32 = 2.0;
/// Squared change of the step over squared steps: 3 for independent places, 0 for what moves evenly.
const LEAST_TURN: f64 = 0.75;

impl Cameras {
    /// Adds a usable frame's camera.
    pub fn add(&mut self, camera: &Camera, size: [u32; 2], restarts: bool) {
        let clip = camera.clip_from_view;
        let perspective = clip.z_axis.w != 0.0;
        let centre = if perspective { -clip.z_axis.truncate() } else { clip.w_axis.truncate() };
        let centre = centre.truncate() * Vec2::new(size[0] as f32, size[1] as f32) / 2.0;
        let before = self.last.filter(|_| !restarts);
        let step = before.map(|(last, _)| centre - last);
        if let Some(step) = step {
            self.steps += 1;
            // A millionth of the width is what rounding may do.
            self.moved += u32::from(step.length() > 1e-3);
            self.largest_px = self.largest_px.max(step.length());
            self.squares += f64::from(step.length_squared());
            if let Some((_, Some(last))) = before {
                self.turns += 1;
                self.turn_squares += f64::from((step - last).length_squared());
                self.turned_squares += f64::from(step.length_squared());
            }
        }
        self.last = Some((centre, step));
        self.declared_jitter |= camera.jitter_px != Vec2::ZERO;
    }

    /// Notes why a frame's camera was refused; whether one of its matrices is just transposed.
    pub fn is_transposed(&mut self, camera: &Camera, conventions: &Conventions) -> bool {
        let turned = |view: bool, projection: bool| {
            let of = |matrix: Mat4, is_turned: bool| if is_turned { matrix.transpose() } else { matrix };
            let view_from_world = of(camera.view_from_world, view);
            let clip_from_view = of(camera.clip_from_view, projection);
            Camera { view_from_world, clip_from_view, ..*camera }.check(conventions).is_ok()
        };
        let tries = [(true, false), (false, true), (true, true)];
        let Some((view, projection)) = tries.into_iter().find(|&(view, projection)| turned(view, projection))
        else {
            return false;
        };
        self.transposed.view += u32::from(view);
        self.transposed.projection += u32::from(projection);
        true
    }

    /// The mean step of the image's centre in pixels, where it steps as jitter does.
    pub fn jitter(&self) -> Option<f64> {
        let often = self.steps >= LEAST_STEPS && 2 * self.moved >= self.steps;
        let restless = self.turn_squares >= LEAST_TURN * self.turned_squares;
        let steps_like_jitter = often && restless && self.largest_px <= JITTER_STEP_PX;
        steps_like_jitter.then(|| (self.squares / f64::from(self.steps)).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::camera::rh::proj::directx;

    /// Whether jitter is seen where the axis of view meets the image at these places, in pixels.
    fn is_jitter(places: impl Fn(f32) -> Vec2) -> bool {
        let mut cameras = Cameras::default();
        for i in 0..8 {
            let mut clip = directx::perspective(1.0, 1.5, 0.1, 100.0);
            let place = places(i as f32) * 2.0 / Vec2::new(300.0, 200.0);
            (clip.z_axis.x, clip.z_axis.y) = (-place.x, -place.y);
            cameras.add(&Camera::new(Mat4::IDENTITY, clip), [300, 200], i == 0);
        }
        cameras.jitter().is_some()
    }

    #[test]
    fn jitter_is_told_from_views_that_shift() {
        assert!(is_jitter(|i| Vec2::new(0.4 * (2.4 * i).sin(), 0.4 * (1.7 * i).cos())));
        assert!(!is_jitter(|_| Vec2::ZERO), "centred");
        assert!(!is_jitter(|_| Vec2::new(40.0, 3.0)), "off centre");
        assert!(!is_jitter(|i| Vec2::new(0.5 * i, 0.02 * i * i)), "smoothly");
        assert!(!is_jitter(|i| Vec2::new(20.0 * (2.4 * i).sin(), 0.0)), "far");
    }
}
