//! What is suspected, in the order of the WGSL's votes.

use super::Mistake;

/// An interpretation of the inputs other than the one given.
#[derive(Debug, Clone, Copy)]
pub struct Suspicion {
    /// The constant in `shaders/include/check_geometry.wgsl` or `check_motion.wgsl`.
    pub name: &'static str,
    pub(crate) mistake: Mistake,
    pub(crate) input: &'static str,
    /// Completes "`input` seems to".
    pub(crate) seems: &'static str,
    /// What to do.
    pub(crate) advice: &'static str,
}

const fn suspicion(
    name: &'static str,
    mistake: Mistake,
    input: &'static str,
    seems: &'static str,
    advice: &'static str,
) -> Suspicion {
    Suspicion { name, mistake, input, seems, advice }
}

/// Of what normals and depth say about flat parts.
pub const GEOMETRY: [Suspicion; 13] = {
    use Mistake::{
        CameraTransposed, DepthAlongRay, DepthLinear, DepthNotLinear, DepthReversed, NormalEncoding,
        NormalsInViewSpace, NormalsInWorldSpace, NormalsInverted, NormalsMirrored,
    };
    const NORMAL: &str = "normal_roughness";
    const SPACE: &str = "set `conventions.normal_space`";
    const ENCODING: &str = "set `conventions.normal_encoding`";
    const HARDWARE: &str = "set `conventions.depth` to `Hardware` and give the projection it was made with";
    [
        suspicion(
            "NORMAL_VIEW_SPACE",
            NormalsInViewSpace,
            NORMAL,
            "hold normals in view space where world space was said",
            SPACE,
        ),
        suspicion(
            "NORMAL_WORLD_SPACE",
            NormalsInWorldSpace,
            NORMAL,
            "hold normals in world space where view space was said",
            SPACE,
        ),
        suspicion(
            "NORMAL_MIRRORED",
            NormalsMirrored,
            NORMAL,
            "hold normals in a view space of the other handedness",
            "set `conventions.handedness` and `conventions.normal_space`, or negate z",
        ),
        suspicion(
            "NORMAL_INVERTED",
            NormalsInverted,
            NORMAL,
            "hold normals that point into surfaces",
            "negate them",
        ),
        suspicion(
            "NORMAL_UNSIGNED",
            NormalEncoding,
            NORMAL,
            "hold normals mapped to 0..1 where signed ones were said",
            ENCODING,
        ),
        suspicion(
            "NORMAL_SIGNED",
            NormalEncoding,
            NORMAL,
            "hold signed normals where such mapped to 0..1 were said",
            ENCODING,
        ),
        suspicion("DEPTH_HARDWARE", DepthNotLinear, "depth", "hold what a depth buffer holds", HARDWARE),
        suspicion("DEPTH_INVERSE", DepthReversed, "depth", "hold inverse, reversed depth", HARDWARE),
        suspicion(
            "DEPTH_INVERSE_FAR",
            DepthNotLinear,
            "depth",
            "hold what a depth buffer holds, not that of this projection",
            HARDWARE,
        ),
        suspicion(
            "DEPTH_REVERSED",
            DepthReversed,
            "depth",
            "fall with the distance, from 1",
            "give linear view depth in scene units",
        ),
        suspicion(
            "DEPTH_ALONG_RAY",
            DepthAlongRay,
            "depth",
            "hold the distance along the ray",
            "set `conventions.depth` to `Distance`",
        ),
        suspicion(
            "DEPTH_LINEAR",
            DepthLinear,
            "depth",
            "be linear where something else was said",
            "set `conventions.depth` to `Linear`",
        ),
        suspicion(
            "NORMAL_CAMERA_TURNED",
            CameraTransposed,
            "camera",
            "have a transposed rotation",
            "check that `view_from_world` is not world from view, nor row by row",
        ),
    ]
};

/// Of what motion, depth and two cameras say about what stands still.
pub const MOTION: [Suspicion; 14] = {
    use Mistake::{CameraLate, CameraTransposed, JitterInMotion, MotionMissing, MotionScale, MotionSign};
    const DIRECTION: &str = "set `conventions.motion_direction`";
    const UNIT: &str = "set `conventions.motion_unit`";
    [
        suspicion("MOTION_BACKWARDS", MotionSign, "motion", "point the wrong way", DIRECTION),
        suspicion(
            "MOTION_BACKWARDS_X",
            MotionSign,
            "motion",
            "have the wrong sign in x",
            "negate x by `MotionUnit::Scaled`",
        ),
        suspicion(
            "MOTION_BACKWARDS_Y",
            MotionSign,
            "motion",
            "have the wrong sign in y (is it y up?)",
            "negate y by `MotionUnit::Scaled`, or say `MotionUnit::Ndc` if it is that",
        ),
        suspicion(
            "MOTION_IN_UV",
            MotionScale,
            "motion",
            "be too small by the size of the image, as UV taken for pixels is",
            UNIT,
        ),
        suspicion(
            "MOTION_IN_PIXELS",
            MotionScale,
            "motion",
            "be too large by the size of the image, as pixels taken for UV are",
            UNIT,
        ),
        suspicion("MOTION_HALF", MotionScale, "motion", "be half as long as it should", UNIT),
        suspicion("MOTION_DOUBLE", MotionScale, "motion", "be twice as long as it should", UNIT),
        suspicion(
            "MOTION_NDC",
            MotionScale,
            "motion",
            "be in normalized device coordinates, y up, twice as long as UV",
            "set `conventions.motion_unit` to `Ndc`",
        ),
        suspicion(
            "MOTION_JITTERED",
            JitterInMotion,
            "motion",
            "hold jitter",
            "set `conventions.motion_is_jittered`, or leave jitter out of it",
        ),
        suspicion(
            "MOTION_UNJITTERED",
            JitterInMotion,
            "motion",
            "lack the jitter that is taken out of it, or hold it with the wrong sign",
            "unset `conventions.motion_is_jittered`, or check the sign of `jitter_px`",
        ),
        suspicion(
            "CAMERA_LATE",
            CameraLate,
            "camera",
            "be that of the frame before",
            "give the camera that this frame's images were traced with",
        ),
        suspicion(
            "CAMERA_INVERSE",
            CameraTransposed,
            "camera",
            "hold world from view as `view_from_world`",
            "invert the matrix",
        ),
        suspicion(
            "CAMERA_TURNED",
            CameraTransposed,
            "camera",
            "have a transposed rotation",
            "check whether `view_from_world` is meant row by row",
        ),
        suspicion(
            "MOTION_MISSING",
            MotionMissing,
            "motion",
            "be missing",
            "it is 0 though the camera moves; give where each surface was in the frame before",
        ),
    ]
};

/// Names of the words that follow the votes, in order (`shaders/include/check_light.wgsl`).
pub const LIGHT: [&str; 15] = [
    "PIXELS",
    "DEPTH_NEGATIVE",
    "HITS",
    "ALBEDO_ONE",
    "ALBEDO_ZERO",
    "EMITTERS",
    "EMISSION_LACKING",
    "EMISSION_TWICE",
    "EMISSION_LESS",
    "IDS_FOUND",
    "IDS_SAME",
    "SLOPE",
    "SLOPE_WEIGHT",
    "DECODED_SLOPE",
    "DECODED_WEIGHT",
];

/// Words after those: see `shaders/include/check_reflection.wgsl`.
pub const RATIOS: usize = 97;
/// As `RATIOS`.
pub const REFLECTION_WORDS: usize = 2 + RATIOS;
/// A slope of 1 in the words.
pub const SLOPE_ONE: f64 = 32.0;

/// Words of a suspicion's votes.
pub const SUSPICION_WORDS: usize = 3;
/// All words of a frame.
pub const STATISTICS: usize =
    SUSPICION_WORDS * (GEOMETRY.len() + MOTION.len()) + LIGHT.len() + REFLECTION_WORDS;
