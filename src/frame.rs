//! How a frame is asked for, and what comes of it, besides images.

/// Whether a frame continues the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HistoryMode {
    /// The frame follows the previous one; history is reprojected.
    #[default]
    Continue,
    /// A cut or a teleport, or the denoiser was left out for some frames: history is dropped and the frame is denoised on its
    /// own.
    Restart,
}

/// What a debug view shows. All are linear colours in 0 to 1 unless stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u32)]
pub enum DebugView {
    /// The models' prediction before it is mixed with the temporal mean (radiance, demodulated).
    Prediction = 1,
    /// The temporal mean that the models are fitted to (radiance, demodulated).
    TemporalMean = 2,
    /// Effective sample count over `max_history`: nearly black where history was just lost.
    HistoryLength = 3,
    /// Estimated standard error of the temporal mean over the mean.
    StandardError = 4,
    /// Weight of the temporal mean in the output: white trusts history, black the models.
    MixWeight = 5,
    /// World-space normal, mapped from -1..1 to 0..1.
    Normal = 6,
    /// View depth as `1 / (1 + depth)`.
    Depth = 7,
    /// Motion: hue is the direction, brightness the length (full at 16 pixels a frame).
    Motion = 8,
    /// A colour per surface id.
    SurfaceId = 9,
    /// Where models are and how large their windows: a bright dot per centre; windows of five tiles red, 3x3 green, 5x5 blue,
    /// mixed where models overlap.
    Windows = 10,
    /// How many models' windows hold the pixel; white at 16.
    Coverage = 11,
    /// Predicted error of the models' prediction, before it is mixed with the temporal mean: the square root of the mean
    /// squared error of its luminance, demodulated.
    PredictedError = 12,
    /// Expected error of the output: the root of the mean squared error of its luminance.
    OutputError = 13,
}

impl DebugView {
    /// Every view, in the order of its value.
    pub const ALL: [Self; 13] = [
        Self::Prediction,
        Self::TemporalMean,
        Self::HistoryLength,
        Self::StandardError,
        Self::MixWeight,
        Self::Normal,
        Self::Depth,
        Self::Motion,
        Self::SurfaceId,
        Self::Windows,
        Self::Coverage,
        Self::PredictedError,
        Self::OutputError,
    ];
}

/// What a frame was recorded with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct FrameOutputs {
    /// Whether the frame started without history: by `HistoryMode::Restart`, because it is the first, or because `specular`
    /// came or went.
    pub restarted: bool,
    /// What the caller should know, once.
    pub notice: Option<Notice>,
}

/// What keeps a setting from working as it is meant to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Notice {
    /// A budget in milliseconds was set, but for eight frames nothing told how long they take: the number of models
    /// and what is saved stay as they are. Said once in a denoiser's life.
    NoTimestamps,
}
