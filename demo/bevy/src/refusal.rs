//! Why a view is not denoised.

use quell::{CreateError, FrameError};
use thiserror::Error;

/// Why a view is not denoised: it stays noisy until this is mended.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Refusal {
    /// A component that [`Quell`](crate::Quell) brought was removed, so that an image is missing.
    #[error(
        "the camera has no `{0}`, which `Quell` reads; it came with `Quell` and was removed since: add it again"
    )]
    Prepass(&'static str),
    /// A view target that holds no light.
    #[error("the camera's view target is {0}, expected Rgba16Float: give the camera `Hdr`")]
    NotHdr(String),
    /// An image that is not there, or not yet.
    #[error("`QuellImages::{0}` is not an image on the GPU (not loaded yet, or its asset was dropped)")]
    Image(&'static str),
    /// No denoiser could be made.
    #[error(transparent)]
    Create(#[from] CreateError),
    /// The frame does not keep quell's contract.
    #[error(transparent)]
    Frame(#[from] FrameError),
}
