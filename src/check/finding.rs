//! What a check has to say.

use std::fmt;

/// What is wrong with an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Mistake {
    /// Motion points the other way, or one of its axes does.
    MotionSign,
    /// Motion is too large or too small by a factor: by the size of the image where pixels were taken for UV or the other way
    /// round, by two where it is in normalized device coordinates.
    MotionScale,
    /// Motion is 0 though the camera moves.
    MotionMissing,
    /// Motion holds the difference of the two frames' jitter, or this was taken out though it was not in it.
    JitterInMotion,
    /// Normals are in view space where world space was said.
    NormalsInViewSpace,
    /// Normals are in world space where view space was said.
    NormalsInWorldSpace,
    /// Normals are in a view space of the other handedness.
    NormalsMirrored,
    /// Normals point into surfaces.
    NormalsInverted,
    /// Normals are mapped to 0..1 where signed ones were said, or the other way round.
    NormalEncoding,
    /// Depth is not linear: it is hardware depth, or its inverse.
    DepthNotLinear,
    /// Depth falls with the distance.
    DepthReversed,
    /// Depth is measured along the view ray and not along the view's axis.
    DepthAlongRay,
    /// Depth is linear where the conventions say something else.
    DepthLinear,
    /// Depth is negative, as the z coordinate in view space is.
    DepthNegative,
    /// A matrix of the camera is transposed, or the inverse of what it should be.
    CameraTransposed,
    /// The camera is that of the frame before.
    CameraLate,
    /// The matrices of the camera hold jitter.
    JitterInMatrices,
    /// Albedo is 1 everywhere, or 0.
    AlbedoMissing,
    /// Albedo is encoded as sRGB.
    AlbedoNotLinear,
    /// The ids of surfaces change from frame to frame.
    IdsChange,
    /// Radiance holds emission twice.
    EmissionTwice,
    /// Radiance does not hold emission.
    EmissionLacking,
    /// Hit distances are not in the unit of the scene.
    HitDistanceUnit,
    /// Hit distances are measured from the eye.
    HitDistanceFromEye,
}

/// A mistake that an [`InputCheck`](crate::InputCheck) found. Displays as a sentence with its evidence and what to do.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Finding {
    /// The field of [`FrameInputs`](crate::FrameInputs) to look at.
    pub input: &'static str,
    /// What is wrong with it.
    pub mistake: Mistake,
    /// The sentence.
    pub(crate) sentence: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}

/// What an [`InputCheck`](crate::InputCheck) cannot judge yet. Displays as a sentence that says why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Untold {
    /// The field of [`FrameInputs`](crate::FrameInputs).
    pub input: &'static str,
    /// What could not be seen.
    pub(crate) reason: &'static str,
}

impl fmt::Display for Untold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}`: {}", self.input, self.reason)
    }
}
