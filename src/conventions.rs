//! How a renderer writes down what quell reads: depth, motion, normals, handedness.

use crate::gpu::{FrameUniforms, flags};
use crate::{Camera, FrameError};
use glam::{Mat4, Vec2, Vec4};

/// What the numbers in the caller's images mean. The default is quell's own convention: linear view depth, motion in UV towards
/// the previous frame and without jitter, normals of -1 to 1 in world space, a right-handed view space.
///
/// ```
/// use quell::{Conventions, DepthEncoding, MotionUnit};
/// let conventions = Conventions::default()
///     .with_depth(DepthEncoding::Hardware) // reverse-Z or not: the projection matrix tells
///     .with_motion_unit(MotionUnit::Pixels);
/// # let _ = conventions;
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Conventions {
    /// What the depth image holds.
    pub depth: DepthEncoding,
    /// Unit and axes of motion vectors.
    pub motion_unit: MotionUnit,
    /// Whether motion vectors point to the previous frame or come from it.
    pub motion_direction: MotionDirection,
    /// Whether motion is the difference of jittered positions, as where both matrices it was made with had the jitter in them.
    /// quell then takes the jitter out, by [`Camera::jitter_px`]. Default false.
    pub motion_is_jittered: bool,
    /// Whether z of a motion image with four channels is the change of view depth. Default true; false where it holds something
    /// else, or nothing.
    pub motion_has_depth: bool,
    /// How three numbers of -1 to 1 are stored.
    pub normal_encoding: NormalEncoding,
    /// Whether w of a normal image with four channels is roughness. Default true; false where it holds something else, or nothing:
    /// then roughness is 1 without an image of its own.
    pub normal_has_roughness: bool,
    /// The space that normals are in.
    pub normal_space: NormalSpace,
    /// Of the view space of [`Camera`].
    pub handedness: Handedness,
}

/// What the depth image holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum DepthEncoding {
    /// Distance from the eye's plane along the view direction, positive, in scene units.
    #[default]
    Linear,
    /// Distance from the eye along the ray, positive, in scene units; as ray tracers have it. With an orthographic camera the
    /// same as `Linear`.
    Distance,
    /// What a depth buffer holds, 0 to 1, made with [`Camera::clip_from_view`] (jitter does not matter). Reverse-Z, an infinite
    /// far plane, a finite one: the matrix tells. What was cleared, at the far end, is a miss.
    Hardware,
}

/// Unit and axes of motion vectors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum MotionUnit {
    /// Of the frame: 1 is its width or height; y down.
    #[default]
    Uv,
    /// Pixels of the frame, y down.
    Pixels,
    /// Normalised device coordinates: 2 is the frame's width or height; y up.
    Ndc,
    /// Anything else: x and y are multiplied by these to be in UV, y down. Finite.
    Scaled([f32; 2]),
}

/// Which way motion vectors point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MotionDirection {
    /// To where the surface was: previous position minus current one.
    #[default]
    ToPrevious,
    /// From where the surface was: current position minus previous one. Holds for the depth in z as well.
    FromPrevious,
}

/// How normals are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum NormalEncoding {
    /// x, y and z as they are, -1 to 1.
    #[default]
    Signed,
    /// x, y and z as `0.5 + 0.5 n`, 0 to 1.
    Unsigned,
    /// Octahedral, in x and y, -1 to 1. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
    /// JCGT 2014.
    Octahedral,
    /// Octahedral, in x and y as `0.5 + 0.5 e`, 0 to 1.
    OctahedralUnsigned,
}

/// The space that normals are in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum NormalSpace {
    /// World space.
    #[default]
    World,
    /// The view space of [`Camera::view_from_world`].
    View,
}

/// Which way the camera looks in its view space, whose x points right and y up. The world's handedness does not matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Handedness {
    /// Along -z.
    #[default]
    Right,
    /// Along +z.
    Left,
}

impl Default for Conventions {
    fn default() -> Self {
        Self {
            depth: DepthEncoding::default(),
            motion_unit: MotionUnit::default(),
            motion_direction: MotionDirection::default(),
            motion_is_jittered: false,
            motion_has_depth: true,
            normal_encoding: NormalEncoding::default(),
            normal_has_roughness: true,
            normal_space: NormalSpace::default(),
            handedness: Handedness::default(),
        }
    }
}

impl Conventions {
    /// Sets [`depth`](Self::depth).
    pub fn with_depth(self, depth: DepthEncoding) -> Self {
        Self { depth, ..self }
    }

    /// Sets [`motion_unit`](Self::motion_unit).
    pub fn with_motion_unit(self, motion_unit: MotionUnit) -> Self {
        Self { motion_unit, ..self }
    }

    /// Sets [`motion_direction`](Self::motion_direction).
    pub fn with_motion_direction(self, motion_direction: MotionDirection) -> Self {
        Self { motion_direction, ..self }
    }

    /// Sets [`motion_is_jittered`](Self::motion_is_jittered).
    pub fn with_motion_is_jittered(self, motion_is_jittered: bool) -> Self {
        Self { motion_is_jittered, ..self }
    }

    /// Sets [`motion_has_depth`](Self::motion_has_depth).
    pub fn with_motion_has_depth(self, motion_has_depth: bool) -> Self {
        Self { motion_has_depth, ..self }
    }

    /// Sets [`normal_encoding`](Self::normal_encoding).
    pub fn with_normal_encoding(self, normal_encoding: NormalEncoding) -> Self {
        Self { normal_encoding, ..self }
    }

    /// Sets [`normal_has_roughness`](Self::normal_has_roughness).
    pub fn with_normal_has_roughness(self, normal_has_roughness: bool) -> Self {
        Self { normal_has_roughness, ..self }
    }

    /// Sets [`normal_space`](Self::normal_space).
    pub fn with_normal_space(self, normal_space: NormalSpace) -> Self {
        Self { normal_space, ..self }
    }

    /// Sets [`handedness`](Self::handedness).
    pub fn with_handedness(self, handedness: Handedness) -> Self {
        Self { handedness, ..self }
    }

    pub(crate) fn check(&self) -> Result<(), FrameError> {
        match self.motion_unit {
            MotionUnit::Scaled(scale) if !Vec2::from(scale).is_finite() => Err(FrameError::Setting {
                setting: "conventions.motion_unit",
                expected: "Scaled with finite numbers",
                found: scale.into_iter().find(|s| !s.is_finite()).unwrap_or_default().into(),
            }),
            _ => Ok(()),
        }
    }

    /// Whether depth or normals need more than to be read.
    pub(crate) fn decodes(&self) -> bool {
        self.depth != DepthEncoding::Linear
            || self.normal_encoding != NormalEncoding::Signed
            || self.normal_space != NormalSpace::World
    }

    /// The same camera with a right-handed view space.
    pub(crate) fn right_handed(&self, camera: &Camera) -> Camera {
        let flip = match self.handedness {
            Handedness::Right => return *camera,
            Handedness::Left => Mat4::from_diagonal(Vec4::new(1.0, 1.0, -1.0, 1.0)),
        };
        Camera {
            view_from_world: flip * camera.view_from_world,
            clip_from_view: camera.clip_from_view * flip,
            ..*camera
        }
    }

    /// Tells the shaders, whose sizes and cameras are set.
    pub(crate) fn enter(&self, uniforms: &mut FrameUniforms, clip_from_view: Mat4) {
        let size = Vec2::from(uniforms.current.size);
        let scale = match self.motion_unit {
            MotionUnit::Uv => Vec2::ONE,
            MotionUnit::Pixels => size.recip(),
            MotionUnit::Ndc => Vec2::new(0.5, -0.5),
            MotionUnit::Scaled(scale) => scale.into(),
        };
        let direction = match self.motion_direction {
            MotionDirection::ToPrevious => 1.0,
            MotionDirection::FromPrevious => -1.0,
        };
        uniforms.motion_scale = (direction * scale).to_array();
        if self.motion_is_jittered {
            // Samples lie off the pixels' centres by the jitter, so what is seen moves the other way.
            let [now, before] = [&uniforms.current, &uniforms.previous]
                .map(|view| Vec2::from(view.jitter) / Vec2::from(view.size));
            uniforms.motion_offset = (before - now).to_array();
        }
        uniforms.unprojection = unprojection(clip_from_view).to_array();
        uniforms.flags |= self.flags(clip_from_view);
    }

    fn flags(&self, clip_from_view: Mat4) -> u32 {
        let depth = match self.depth {
            DepthEncoding::Linear => 0,
            DepthEncoding::Distance => flags::DEPTH_DISTANCE,
            DepthEncoding::Hardware if is_reversed(clip_from_view) => {
                flags::DEPTH_HARDWARE | flags::DEPTH_REVERSED
            }
            DepthEncoding::Hardware => flags::DEPTH_HARDWARE,
        };
        let motion = match self.motion_direction {
            MotionDirection::ToPrevious => 0,
            MotionDirection::FromPrevious => flags::MOTION_FROM_PREVIOUS,
        };
        let encoding = match self.normal_encoding {
            NormalEncoding::Signed => 0,
            NormalEncoding::Unsigned => flags::NORMAL_UNSIGNED,
            NormalEncoding::Octahedral => flags::NORMAL_OCTAHEDRAL,
            NormalEncoding::OctahedralUnsigned => flags::NORMAL_OCTAHEDRAL | flags::NORMAL_UNSIGNED,
        };
        let space = match (self.normal_space, self.handedness) {
            (NormalSpace::World, _) => 0,
            (NormalSpace::View, Handedness::Right) => flags::NORMAL_VIEW,
            (NormalSpace::View, Handedness::Left) => flags::NORMAL_VIEW | flags::NORMAL_MIRRORED,
        };
        let roughness = if self.normal_has_roughness { 0 } else { flags::NORMAL_ALONE };
        depth | motion | encoding | roughness | space
    }
}

/// Of `z_clip = a z + b`, `w = c z + d` and `stored = z_clip / w` follows view depth `-z = (-b + d stored) / (-a + c stored)`.
fn unprojection(clip: Mat4) -> Vec4 {
    let (a, b, c, d) = (clip.z_axis.z, clip.w_axis.z, clip.z_axis.w, clip.w_axis.w);
    Vec4::new(-b, d, -a, c)
}

/// Whether what is farther away has the lower depth.
fn is_reversed(clip: Mat4) -> bool {
    let at = |depth: f32| {
        let p = clip * Vec4::new(0.0, 0.0, -depth, 1.0);
        p.z / p.w
    };
    at(2.0) < at(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::camera::{lh, rh};

    /// Whatever the projection, what it stores tells the distance.
    #[test]
    fn depth_buffers_tell_distances() {
        let swap = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::NEG_Z, Vec4::new(0.0, 0.0, 1.0, 1.0));
        let right = [
            rh::proj::directx::perspective(1.0, 1.5, 0.1, 100.0),
            rh::proj::directx::perspective_infinite(1.0, 1.5, 0.1),
            rh::proj::directx::perspective_infinite_reverse(1.0, 1.5, 0.1),
            rh::proj::directx::orthographic(-2.0, 3.0, -1.0, 1.0, 0.1, 100.0),
        ];
        let left = [
            lh::proj::directx::perspective(1.0, 1.5, 0.1, 100.0),
            lh::proj::directx::perspective_infinite_reverse(1.0, 1.5, 0.1),
            lh::proj::directx::orthographic(-2.0, 3.0, -1.0, 1.0, 0.1, 100.0),
        ];
        let sides = [(Handedness::Right, -1.0, &right[..]), (Handedness::Left, 1.0, &left[..])];
        for (handedness, forwards, projections) in sides {
            let conventions = Conventions::default().with_handedness(handedness);
            for projection in projections.iter().flat_map(|&p| [p, swap * p]) {
                let stored = |depth: f32| {
                    let p = projection * Vec4::new(0.3, 0.2, forwards * depth, 1.0);
                    p.z / p.w
                };
                let clip = conventions.right_handed(&Camera::new(Mat4::IDENTITY, projection)).clip_from_view;
                assert_eq!(is_reversed(clip), stored(2.0) < stored(1.0), "{projection}");
                let c = unprojection(clip);
                for depth in [0.2, 1.0, 7.5, 60.0] {
                    let d = stored(depth);
                    let found = (c.x + c.y * d) / (c.z + c.w * d);
                    assert!(
                        (found / depth - 1.0).abs() < 1e-2,
                        "{handedness:?} {projection}: {found} for {depth}"
                    );
                }
            }
        }
    }
}
