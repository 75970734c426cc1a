//! Keys and mouse: what they do to the view and to the free camera.

use super::free_flight::FlightInput;
use super::view_state::{ViewMode, ViewState};
use glam::{Vec2, Vec3};
use std::collections::HashSet;
use winit::keyboard::KeyCode;

/// What a key asks of the window itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    Quit,
    /// The mouse is captured, or let go, for looking around.
    ToggleMouseCapture,
}

/// Keys that are held, and the mouse's movement since the last frame.
#[derive(Debug, Default)]
pub struct Controls {
    held: HashSet<KeyCode>,
    /// Keys that went down since the last frame: one that is up again before a slow frame ends counts for that frame.
    tapped: HashSet<KeyCode>,
    look_px: Vec2,
    /// The right mouse button is held.
    pub looking: bool,
    /// The mouse is captured.
    pub captured: bool,
    /// The split line is being dragged.
    pub dragging_split: bool,
}

/// Keys that mean something here, so that the panel does not get them as well (Tab moves its focus).
pub fn is_ours(key: KeyCode) -> bool {
    use KeyCode::*;
    matches!(
        key,
        KeyW | KeyA
            | KeyS
            | KeyD
            | KeyQ
            | KeyE
            | KeyF
            | KeyN
            | KeyR
            | KeyC
            | KeyM
            | KeyH
            | KeyL
            | Tab
            | Space
            | Escape
            | Digit1
            | Digit2
            | Digit3
            | Digit4
            | Digit5
            | ShiftLeft
            | ShiftRight
    )
}

impl Controls {
    /// A key went down. Repeats by holding it only count for single steps.
    pub fn press(&mut self, key: KeyCode, repeat: bool, view: &mut ViewState) -> Option<Action> {
        self.held.insert(key);
        self.tapped.insert(key);
        if repeat && key != KeyCode::KeyN {
            return None;
        }
        let digits = [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3, KeyCode::Digit4, KeyCode::Digit5];
        match key {
            KeyCode::Escape => return Some(Action::Quit),
            KeyCode::KeyM => return Some(Action::ToggleMouseCapture),
            KeyCode::Space => view.paused = !view.paused,
            KeyCode::KeyN => (view.paused, view.step) = (true, true),
            KeyCode::KeyR => view.restart = true,
            KeyCode::KeyC => view.next_rival(),
            KeyCode::KeyL => view.toggle_signals(),
            KeyCode::KeyF => view.free_flight = !view.free_flight,
            KeyCode::Tab | KeyCode::KeyH => view.panel = !view.panel,
            _ => {
                if let Some(i) = digits.iter().position(|&digit| digit == key) {
                    view.mode = ViewMode::ALL[i];
                    view.debug = None;
                }
            }
        }
        None
    }

    pub fn release(&mut self, key: KeyCode) {
        self.held.remove(&key);
    }

    /// The mouse moved by so many pixels, +x right, +y down.
    pub fn mouse_moved(&mut self, delta_px: Vec2) {
        if self.looking || self.captured {
            self.look_px += delta_px;
        }
    }

    /// The window lost its focus: releases will not be reported.
    pub fn release_all(&mut self) {
        *self = Self::default();
    }

    /// Movement for this frame.
    pub fn take_flight_input(&mut self) -> FlightInput {
        let tapped = std::mem::take(&mut self.tapped);
        let down = |key| self.held.contains(&key) || tapped.contains(&key);
        let axis = |positive, negative| f32::from(down(positive)) - f32::from(down(negative));
        use KeyCode::{KeyA, KeyD, KeyE, KeyQ, KeyS, KeyW, ShiftLeft, ShiftRight};
        FlightInput {
            direction: Vec3::new(axis(KeyD, KeyA), axis(KeyE, KeyQ), axis(KeyW, KeyS)),
            fast: down(ShiftLeft) || down(ShiftRight),
            look_px: std::mem::take(&mut self.look_px),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gbuffer::Split;
    use crate::method::Method;

    #[test]
    fn keys_do_what_the_panel_says() {
        let (mut controls, mut view) = (Controls::default(), ViewState::default());
        let mut press = |key, view: &mut ViewState| controls.press(key, false, view);
        assert_eq!(press(KeyCode::Escape, &mut view), Some(Action::Quit));
        press(KeyCode::Digit5, &mut view);
        assert_eq!(view.mode, ViewMode::Split);
        press(KeyCode::KeyN, &mut view);
        assert!(view.paused && view.step);
        press(KeyCode::Space, &mut view);
        assert!(!view.paused);
        press(KeyCode::Tab, &mut view);
        assert!(!view.panel);
        press(KeyCode::KeyF, &mut view);
        assert!(view.free_flight);
        let [first, toggled, again] = [0; 3].map(|_| {
            press(KeyCode::KeyL, &mut view);
            view.signals
        });
        assert!(first != toggled && first == again && [first, toggled].contains(&Split::None));
        press(KeyCode::Digit2, &mut view);
        assert_eq!(view.mode, ViewMode::Rival);
        press(KeyCode::KeyC, &mut view);
        assert_eq!(view.rival, Method::Svgf);
    }

    #[test]
    fn held_keys_fly_until_released_or_the_focus_is_lost() {
        let (mut controls, mut view) = (Controls::default(), ViewState::default());
        controls.press(KeyCode::KeyW, false, &mut view);
        controls.press(KeyCode::KeyA, false, &mut view);
        controls.press(KeyCode::ShiftLeft, false, &mut view);
        let input = controls.take_flight_input();
        assert_eq!((input.direction, input.fast), (Vec3::new(-1.0, 0.0, 1.0), true));
        controls.release(KeyCode::KeyA);
        assert_eq!(controls.take_flight_input().direction, Vec3::Z);
        controls.release_all();
        assert_eq!(controls.take_flight_input(), FlightInput::default());
        controls.press(KeyCode::KeyD, false, &mut view);
        controls.release(KeyCode::KeyD);
        assert_eq!(controls.take_flight_input().direction, Vec3::X, "a tap within a frame counts for one");
        assert_eq!(controls.take_flight_input().direction, Vec3::ZERO);
        controls.mouse_moved(Vec2::ONE);
        assert_eq!(controls.take_flight_input().look_px, Vec2::ZERO, "the mouse looks only when asked to");
        controls.looking = true;
        controls.mouse_moved(Vec2::ONE);
        assert_eq!(controls.take_flight_input().look_px, Vec2::ONE);
        assert_eq!(controls.take_flight_input().look_px, Vec2::ZERO);
    }
}
