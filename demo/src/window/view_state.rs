//! What the window shows, and what its user has set.

use crate::gbuffer::Split;
use crate::method::Method;
use crate::tracer::Sampling;
use quell::{DebugView, Settings};

/// Which image is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewMode {
    /// The path tracer's output.
    Noisy,
    /// The output of the method that the denoiser is compared with, [`ViewState::rival`].
    Rival,
    /// The denoiser's output.
    Denoised,
    /// The converging path trace.
    Reference,
    /// Two of them, left and right of a line.
    Split,
}

impl ViewMode {
    /// In the order of their keys, 1 to 5.
    pub const ALL: [Self; 5] = [Self::Noisy, Self::Rival, Self::Denoised, Self::Reference, Self::Split];
    /// Those that are one image.
    pub const IMAGES: [Self; 4] = [Self::Noisy, Self::Rival, Self::Denoised, Self::Reference];

    pub fn name(self) -> &'static str {
        match self {
            Self::Noisy => "Noisy",
            Self::Rival => "Rival",
            Self::Denoised => "Denoised",
            Self::Reference => "Reference",
            Self::Split => "Split",
        }
    }
}

/// Methods that the denoiser can be compared with, in the order that their key goes through.
pub const RIVALS: [Method; 3] = [Method::Accumulate, Method::Svgf, Method::Bmfr];

/// As the panel names it.
pub fn rival_name(rival: Method) -> &'static str {
    match rival {
        Method::Svgf => "SVGF",
        Method::Bmfr => "BMFR",
        Method::Accumulate => "Accumulated",
        other => other.name(),
    }
}

/// Everything that the panel and the keys change.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewState {
    pub mode: ViewMode,
    /// One of `RIVALS`.
    pub rival: Method,
    /// The images left and right in [`ViewMode::Split`]; each one of [`ViewMode::IMAGES`].
    pub split_sides: [ViewMode; 2],
    /// Where the line is, as a part of the image's width.
    pub split: f32,
    /// Shown instead of the mode's image, where set.
    pub debug: Option<DebugView>,
    /// Time stands still.
    pub paused: bool,
    /// While paused: advance by one frame, then stand still again. Cleared once it is done.
    pub step: bool,
    /// Drop all history with the next frame. Cleared once it is done.
    pub restart: bool,
    /// Samples per pixel and frame, in the mean.
    pub spp: f32,
    /// Which pixels get them.
    pub sampling: Sampling,
    /// What the denoiser gets apart.
    pub signals: Split,
    /// Of the denoiser. `far` and `conventions` are the source's business.
    pub settings: Settings,
    /// Exposure in stops; 0 shows radiance as measured.
    pub exposure_ev: f32,
    /// The camera is the user's, not the path's.
    pub free_flight: bool,
    /// Whether the panel is shown.
    pub panel: bool,
}

impl Default for ViewState {
    fn default() -> Self {
        Self {
            mode: ViewMode::Denoised,
            rival: RIVALS[0],
            split_sides: [ViewMode::Noisy, ViewMode::Denoised],
            split: 0.5,
            debug: None,
            paused: false,
            step: false,
            restart: false,
            spp: 1.0,
            sampling: Sampling::Uniform,
            signals: Split::default(),
            settings: Settings::default(),
            exposure_ev: 0.0,
            free_flight: false,
            panel: true,
        }
    }
}

impl ViewState {
    /// Whether an image is on screen, so that a source need not make those that are not.
    pub fn shows(&self, image: ViewMode) -> bool {
        match self.mode {
            _ if self.debug.is_some() => false,
            ViewMode::Split => self.split_sides.contains(&image),
            mode => mode == image,
        }
    }

    /// What an image is called.
    pub fn name(&self, image: ViewMode) -> &'static str {
        match image {
            ViewMode::Rival => rival_name(self.rival),
            image => image.name(),
        }
    }

    /// Goes on to the next rival, and shows it where none is on screen: in a split in the place of what is not
    /// denoised.
    pub fn next_rival(&mut self) {
        let shown = self.shows(ViewMode::Rival);
        if shown {
            let at = RIVALS.iter().position(|&rival| rival == self.rival).map_or(0, |at| at + 1);
            self.rival = RIVALS[at % RIVALS.len()];
        } else if self.mode == ViewMode::Split {
            let side = usize::from(self.split_sides[0] == ViewMode::Denoised);
            self.split_sides[side] = ViewMode::Rival;
        } else {
            self.mode = ViewMode::Rival;
        }
        self.debug = None;
    }

    /// Combined radiance, or again split.
    pub fn toggle_signals(&mut self) {
        self.signals = if self.signals == Split::None { Split::Full } else { Split::None };
    }

    /// How far scene time moves with this frame, given the time since the last one. Ends a single step.
    pub fn take_time_step(&mut self, elapsed_s: f32) -> f32 {
        let step = std::mem::take(&mut self.step);
        match (self.paused, step) {
            (false, _) => elapsed_s.min(LONGEST_STEP_S),
            (true, true) => SINGLE_STEP_S,
            (true, false) => 0.0,
        }
    }
}

/// A stall (a resize, a debugger) must not become a jump of the camera.
const LONGEST_STEP_S: f32 = 0.1;
/// One frame at 60 Hz.
const SINGLE_STEP_S: f32 = 1.0 / 60.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pause_and_single_steps() {
        let mut view = ViewState::default();
        assert_eq!(view.take_time_step(0.02), 0.02);
        assert_eq!(view.take_time_step(5.0), LONGEST_STEP_S);
        view.paused = true;
        assert_eq!(view.take_time_step(0.02), 0.0);
        view.step = true;
        assert_eq!(view.take_time_step(0.5), SINGLE_STEP_S);
        assert_eq!(view.take_time_step(0.5), 0.0);
    }

    #[test]
    fn the_first_press_shows_the_rival_and_others_change_it() {
        let mut view = ViewState::default();
        view.next_rival();
        assert_eq!((view.mode, view.rival), (ViewMode::Rival, Method::Accumulate));
        let names = [0; 4].map(|_| {
            view.next_rival();
            view.name(ViewMode::Rival)
        });
        assert_eq!(names, ["SVGF", "BMFR", "Accumulated", "SVGF"]);
        view.mode = ViewMode::Split;
        view.next_rival();
        assert_eq!(view.split_sides, [ViewMode::Rival, ViewMode::Denoised]);
        assert_eq!(view.rival, Method::Svgf);
        view.next_rival();
        assert_eq!(view.rival, Method::Bmfr);
    }

    #[test]
    fn only_what_is_on_screen_is_asked_for() {
        let mut view = ViewState { mode: ViewMode::Split, ..ViewState::default() };
        assert!(view.shows(ViewMode::Noisy) && view.shows(ViewMode::Denoised));
        assert!(!view.shows(ViewMode::Reference));
        view.debug = Some(DebugView::Normal);
        assert!(!view.shows(ViewMode::Noisy));
    }
}
