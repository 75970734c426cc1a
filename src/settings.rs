//! What may change from frame to frame. Every default is meant to be left alone.

use crate::FrameError;

/// Per-frame settings. `Settings::default()` is what the measurements in the README use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Scale from the motion image to UV: `uv_prev = uv + motion.xy * motion_scale`. Finite.
    ///
    /// `[1, 1]` (default) where motion is stored in UV, `[1 / width, 1 / height]` where it is in pixels.
    pub motion_scale: [f32; 2],
    /// View depth at and beyond which a pixel is a miss, in scene units; above 0. Default: infinity.
    ///
    /// Misses are passed through untouched. Depth that is not finite or not positive is a miss as well.
    pub far: f32,
    /// Largest effective number of samples that history may count for; 1 to 1024, default 32.
    ///
    /// Higher keeps more detail and less noise; lower follows changes of the light sooner.
    pub max_history: f32,
    /// Half the width of a prediction window, in tiles of 4 pixels; 1 to 3, default 2.
    ///
    /// A window is `2 r + 1` tiles wide: 12, 20 or 28 pixels. Higher smooths more, lower keeps more structure.
    pub window_radius_tiles: u32,
    /// Whether the output mixes the models' prediction with the temporal mean by estimated error (default true).
    ///
    /// Off shows the prediction alone: smoother, but what no feature explains (a shadow's edge) is blurred.
    pub mix_temporal_mean: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            motion_scale: [1.0, 1.0],
            far: f32::INFINITY,
            max_history: 32.0,
            window_radius_tiles: 2,
            mix_temporal_mean: true,
        }
    }
}

impl Settings {
    pub(crate) fn check(&self) -> Result<(), FrameError> {
        let refuse = |setting, expected, found: f32| {
            Err(FrameError::Setting { setting, expected, found: f64::from(found) })
        };
        if let Some(&scale) = self.motion_scale.iter().find(|s| !s.is_finite()) {
            return refuse("motion_scale", "finite numbers", scale);
        }
        if self.far.is_nan() || self.far <= 0.0 {
            return refuse("far", "a depth above 0", self.far);
        }
        if !(1.0..=1024.0).contains(&self.max_history) {
            return refuse("max_history", "1 to 1024", self.max_history);
        }
        if !(1..=3).contains(&self.window_radius_tiles) {
            return refuse("window_radius_tiles", "1 to 3", self.window_radius_tiles as f32);
        }
        Ok(())
    }
}
