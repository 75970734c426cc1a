//! What may change from frame to frame. Every default is meant to be left alone.

use crate::{Conventions, FrameError};

/// What frames may do for less time, in the order of what the image loses for the time that is won. So many of them are taken, from the
/// first on: [`Settings::savings`], [`Settings::most_savings`].
///
/// | saving | what it does | shows as |
/// | --- | --- | --- |
/// | bilinear history | history is resampled by four taps, and nowhere by twelve cubic ones | blur while the camera moves; less noise |
/// | sparse moments | models see every other tile of 8x8 pixels; changes of the light are looked for every 32 pixels instead of 16 | more noise where models are small; changes of the light that are noticed later |
pub const SAVINGS: [&str; 2] = ["bilinear history", "sparse moments"];
/// Places of the savings.
pub(crate) const BILINEAR_HISTORY: u32 = 0;
pub(crate) const SPARSE_MOMENTS: u32 = 1;

/// How each model's window is chosen, among the tile of 8x8 pixels that is its centre with its four neighbours, 3x3 tiles, and,
/// in frames of at least 320 pixels each way, 5x5 tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Windows {
    /// Of the least and the widest, the one with the lower Mallows' Cp: the fit's own error and what fitting has made it too small
    /// by.
    #[default]
    MallowsCp,
    /// The one whose growth was predicted with the least error: each ring of tiles tests the model of the window inside it.
    /// Moon et al. 2015, section 4.2. Takes smaller windows, and more of them, where samples are noisy.
    RingError,
    /// All windows are the same: 1 (five tiles), 2 (3x3) or 3 (5x5).
    Fixed(u32),
}

/// Where models are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Centres {
    /// Coarse to fine: at each level where no model of the levels before covers well.
    #[default]
    Adaptive,
    /// At every so many tiles of 8 pixels in x and y: 1 (dense), 2 or 4; and where these leave a hole. With 4, windows are 5x5
    /// tiles whatever [`Windows`] say, so that they reach each other.
    Uniform(u32),
}

/// How many linear models a frame may fit, or how long it may take.
///
/// The coarsest level, a model for 32x32 pixels, is always fitted, so that every pixel is predicted. Finer models go where they
/// are expected to gain most: by the error of what would predict the tile otherwise, beyond noise and relative to its
/// brightness, times its pixels and the age of the model that it has. A tile that needs a model but gets none keeps the one
/// of an earlier frame while this predicts the tile's temporal means with at most twice the squared error that it expected,
/// noise included, and their mean within three standard errors, and is at most 16 frames old. A restart drops all of them.
///
/// Holds for [`Centres::Adaptive`]; uniform centres are always fitted all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Budget {
    /// As many models as the image needs.
    #[default]
    Unlimited,
    /// At most so many models, or those of the coarsest level where these are more; half as many for each of two signals.
    Models(u32),
    /// What keeps the frame's time on the GPU below so many milliseconds, above 0: first no more than one model for 256 pixels, then
    /// the first of the [`SAVINGS`], then fewer models, then the other savings, beside which no finer models are fitted; as far as
    /// [`Settings::most_savings`] allows. It is aimed at 95 % of it, which takes some thirty frames. What a frame takes with all of that
    /// is the floor: on a CPU driver about 60 % of the time without a budget. For less, render fewer pixels
    /// ([`FrameInputs::viewport`](crate::FrameInputs::viewport)). A restart and the three frames after it take longer, and are not
    /// counted unless restarts come over and over.
    ///
    /// Times are the denoiser's own timestamps where the device has `Features::TIMESTAMP_QUERY`, or
    /// [`FrameInputs::measured_ms`](crate::FrameInputs::measured_ms). Without either the number stays where it began, and
    /// [`Notice::NoTimestamps`](crate::Notice) says so.
    Milliseconds(f32),
}

/// Per-frame settings. Begin with one of the presets:
///
/// | preset | for |
/// | --- | --- |
/// | [`Settings::default`] | games at about one sample per pixel; what all measurements use |
/// | [`Settings::responsive`] | light that changes all the time: fire, muzzle flashes, discos |
/// | [`Settings::still`] | photo modes, editors, previews: a view that stands still should become perfect |
/// | [`Settings::fast`] | the least time |
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// What the numbers in the caller's images mean (default: quell's own conventions).
    pub conventions: Conventions,
    /// View depth at and beyond which a pixel is a miss, in scene units; above 0. Default: infinity.
    ///
    /// Misses are passed through untouched. Depth that is not finite or not positive is a miss as well.
    pub far: f32,
    /// How long history is, in frames of one sample per pixel; 1 to 1024, default 32.
    ///
    /// So many samples it keeps whole, whenever they were traced; of more it loses this share, one in `max_history`, per frame. So
    /// `k` samples per pixel and frame come to count for `k * max_history`.
    ///
    /// Higher keeps more detail and less noise; lower follows changes of the light sooner.
    pub max_history: f32,
    /// How the windows of the models are chosen (default: by Mallows' Cp).
    pub windows: Windows,
    /// Where the models are placed (default: adaptively).
    pub centres: Centres,
    /// Whether the change of the light is predicted and history relit by it (default true).
    ///
    /// Off, a light that was switched fades over `max_history` samples.
    pub innovation: bool,
    /// By how many standard errors of its neighbourhood's mean a single sample may move that mean, above 0; what is
    /// beyond is cut as a firefly. Default 1; infinity cuts nothing.
    ///
    /// Lower removes more fireflies and darkens what only rare bright samples light.
    pub firefly_limit: f32,
    /// Whether the output mixes the models' prediction with the temporal mean by estimated error (default true).
    ///
    /// Off shows the prediction alone: smoother, but what no feature explains (a shadow's edge) is blurred.
    pub mix_temporal_mean: bool,
    /// Whether debug views show the specular signal, where it is given, and not the rest (default false).
    pub debug_specular: bool,
    /// How many models may be fitted (default: as many as the image needs).
    pub budget: Budget,
    /// How many of the [`SAVINGS`] every frame takes, 0 to 2, default 0.
    pub savings: u32,
    /// How many of the [`SAVINGS`] a frame may take to keep a budget of time, 0 to 2, default 2. At least as many as
    /// [`savings`](Self::savings) says are taken.
    pub most_savings: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            conventions: Conventions::default(),
            far: f32::INFINITY,
            max_history: 32.0,
            windows: Windows::MallowsCp,
            centres: Centres::Adaptive,
            innovation: true,
            firefly_limit: 1.0,
            mix_temporal_mean: true,
            debug_specular: false,
            budget: Budget::Unlimited,
            savings: 0,
            most_savings: SAVINGS.len() as u32,
        }
    }
}

impl Settings {
    /// For light that changes all the time: history is [`max_history`](Self::max_history) of 8 samples long, a quarter of the
    /// default, so that what the innovation does not notice has faded in a quarter of the time. Noisier where light is steady.
    pub fn responsive() -> Self {
        Self { max_history: 8.0, ..Self::default() }
    }

    /// For views that stand still: history is as long as it can be (1024 samples), so that the image goes on improving. Slow to
    /// follow changes of the light that are small against the noise.
    pub fn still() -> Self {
        Self { max_history: 1024.0, ..Self::default() }
    }

    /// For the least time: one model for 32x32 pixels is fitted and no finer one, and all [`SAVINGS`] are taken. It shows as seams of
    /// tiles and as blur where the temporal mean has little to say, as after a cut.
    pub fn fast() -> Self {
        Self { budget: Budget::Models(0), savings: SAVINGS.len() as u32, ..Self::default() }
    }

    /// Sets [`conventions`](Self::conventions).
    pub fn with_conventions(self, conventions: Conventions) -> Self {
        Self { conventions, ..self }
    }

    /// Sets [`far`](Self::far).
    pub fn with_far(self, far: f32) -> Self {
        Self { far, ..self }
    }

    /// Sets [`max_history`](Self::max_history).
    pub fn with_max_history(self, max_history: f32) -> Self {
        Self { max_history, ..self }
    }

    /// Sets [`windows`](Self::windows).
    pub fn with_windows(self, windows: Windows) -> Self {
        Self { windows, ..self }
    }

    /// Sets [`centres`](Self::centres).
    pub fn with_centres(self, centres: Centres) -> Self {
        Self { centres, ..self }
    }

    /// Sets [`innovation`](Self::innovation).
    pub fn with_innovation(self, innovation: bool) -> Self {
        Self { innovation, ..self }
    }

    /// Sets [`firefly_limit`](Self::firefly_limit).
    pub fn with_firefly_limit(self, firefly_limit: f32) -> Self {
        Self { firefly_limit, ..self }
    }

    /// Sets [`mix_temporal_mean`](Self::mix_temporal_mean).
    pub fn with_mix_temporal_mean(self, mix_temporal_mean: bool) -> Self {
        Self { mix_temporal_mean, ..self }
    }

    /// Sets [`debug_specular`](Self::debug_specular).
    pub fn with_debug_specular(self, debug_specular: bool) -> Self {
        Self { debug_specular, ..self }
    }

    /// Sets [`savings`](Self::savings).
    pub fn with_savings(self, savings: u32) -> Self {
        Self { savings, ..self }
    }

    /// Sets [`most_savings`](Self::most_savings).
    pub fn with_most_savings(self, most_savings: u32) -> Self {
        Self { most_savings, ..self }
    }

    /// Sets [`budget`](Self::budget).
    pub fn with_budget(self, budget: Budget) -> Self {
        Self { budget, ..self }
    }

    pub(crate) fn check(&self) -> Result<(), FrameError> {
        let refuse = |setting, expected, found: f32| {
            Err(FrameError::Setting { setting, expected, found: f64::from(found) })
        };
        self.conventions.check()?;
        if self.far.is_nan() || self.far <= 0.0 {
            return refuse("far", "a depth above 0", self.far);
        }
        if !(1.0..=1024.0).contains(&self.max_history) {
            return refuse("max_history", "1 to 1024", self.max_history);
        }
        if let Windows::Fixed(radius) = self.windows
            && !(1..=3).contains(&radius)
        {
            return refuse("windows", "Fixed(1) to Fixed(3)", radius as f32);
        }
        if let Centres::Uniform(stride) = self.centres
            && ![1, 2, 4].contains(&stride)
        {
            return refuse("centres", "Uniform(1), Uniform(2) or Uniform(4)", stride as f32);
        }
        if self.firefly_limit.is_nan() || self.firefly_limit <= 0.0 {
            return refuse("firefly_limit", "a number above 0", self.firefly_limit);
        }
        for (setting, savings) in [("savings", self.savings), ("most_savings", self.most_savings)] {
            if savings > SAVINGS.len() as u32 {
                return refuse(setting, "0 to 2", savings as f32);
            }
        }
        if let Budget::Milliseconds(target) = self.budget
            && !(target.is_finite() && target > 0.0)
        {
            return refuse("budget", "Milliseconds of a finite number above 0", target);
        }
        Ok(())
    }
}
