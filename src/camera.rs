//! The camera a frame was traced with, and what it must be.

use crate::{Conventions, DepthEncoding, FrameError, Handedness};
use glam::{Mat4, Vec2};

/// The camera a frame was traced with. Matrices are for column vectors, unjittered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// World to view space: a rotation and a translation, no scale. In view space x points right and y up; it is right-handed,
    /// looking down -z, unless [`Conventions::handedness`](crate::Conventions::handedness) says otherwise.
    pub view_from_world: Mat4,
    /// View to clip space, perspective or orthographic, without shear. NDC x points right, y up, as of glam's
    /// `camera::rh::proj::directx`. Its third row (z) is used only with [`DepthEncoding::Hardware`](crate::DepthEncoding::Hardware).
    pub clip_from_view: Mat4,
    /// Where this frame's samples lie relative to pixel centres, in pixels; +x right, +y down. 0 without jitter.
    pub jitter_px: Vec2,
}

/// What inverses and products of matrices may be off by.
const ROUNDING: f32 = 1e-4;

impl Camera {
    /// A camera without jitter.
    pub fn new(view_from_world: Mat4, clip_from_view: Mat4) -> Self {
        Self { view_from_world, clip_from_view, jitter_px: Vec2::ZERO }
    }

    /// The same camera with [`jitter_px`](Self::jitter_px).
    pub fn with_jitter(self, jitter_px: Vec2) -> Self {
        Self { jitter_px, ..self }
    }

    pub(crate) fn check(&self, conventions: &Conventions) -> Result<(), FrameError> {
        let refuse = |field, reason| Err(FrameError::Camera { field, reason });
        let view = self.view_from_world;
        if !view.is_finite() {
            return refuse("view_from_world", "has an entry that is not finite");
        }
        if !view.row(3).abs_diff_eq(glam::Vec4::W, ROUNDING) {
            return refuse("view_from_world", "has a last row other than 0 0 0 1 (is it transposed?)");
        }
        let rotation = glam::Mat3::from_mat4(view);
        if !(rotation * rotation.transpose()).abs_diff_eq(glam::Mat3::IDENTITY, 1e-2) {
            return refuse("view_from_world", "is not a rotation and a translation (has scale or shear)");
        }
        let p = self.clip_from_view;
        // An infinite far plane is fine; it never reaches x, y or w.
        let used =
            [p.x_axis.x, p.y_axis.y, p.z_axis.x, p.z_axis.y, p.z_axis.w, p.w_axis.x, p.w_axis.y, p.w_axis.w];
        if used.iter().any(|v| !v.is_finite()) {
            return refuse("clip_from_view", "has an entry that is not finite");
        }
        if p.x_axis.x == 0.0 || p.y_axis.y == 0.0 {
            return refuse("clip_from_view", "is singular (x or y scale is 0)");
        }
        let is_near = |a: f32, b: f32| (a - b).abs() < ROUNDING;
        let off_axes = [p.x_axis.y / p.y_axis.y, p.y_axis.x / p.x_axis.x, p.x_axis.w, p.y_axis.w];
        if !off_axes.into_iter().all(|entry| is_near(entry, 0.0)) {
            return refuse("clip_from_view", "has shear, expected a perspective or orthographic projection");
        }
        let looks_along = |z: f32| is_near(p.z_axis.w, z) && is_near(p.w_axis.w, 0.0);
        let is_orthographic = is_near(p.z_axis.w, 0.0) && is_near(p.w_axis.w, 1.0);
        match conventions.handedness {
            _ if is_orthographic => {}
            Handedness::Right if looks_along(-1.0) => {}
            Handedness::Left if looks_along(1.0) => {}
            Handedness::Right if looks_along(1.0) => {
                return refuse(
                    "clip_from_view",
                    "looks along +z (w = z), expected -z; is the view space left-handed? See `Conventions::handedness`",
                );
            }
            Handedness::Left if looks_along(-1.0) => {
                return refuse(
                    "clip_from_view",
                    "looks along -z (w = -z), expected +z; is the view space right-handed? See `Conventions::handedness`",
                );
            }
            _ => {
                return refuse(
                    "clip_from_view",
                    "is neither perspective (w = z or -z) nor orthographic (w = 1)",
                );
            }
        }
        if conventions.depth == DepthEncoding::Hardware && [p.x_axis.z, p.y_axis.z] != [0.0; 2] {
            return refuse(
                "clip_from_view",
                "has an oblique near plane, of which `DepthEncoding::Hardware` cannot tell distances; give linear depth",
            );
        }
        // Depth must tell distances apart.
        let (a, b, c, d) = (p.z_axis.z, p.w_axis.z, p.z_axis.w, p.w_axis.w);
        if conventions.depth == DepthEncoding::Hardware
            && !((b * c - a * d).abs() > 0.0 && a.is_finite() && b.is_finite())
        {
            return refuse(
                "clip_from_view",
                "has no third row that depth could come from, which `DepthEncoding::Hardware` needs",
            );
        }
        if !self.jitter_px.is_finite() {
            return refuse("jitter_px", "is not finite");
        }
        Ok(())
    }
}
