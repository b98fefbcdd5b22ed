//! Gamepads of the machine.

use gilrs::{Axis, Button, GamepadId, Gilrs};

use super::Sticks;

/// Seconds from one look at the sticks to the next while nothing else happens.
const LOOK_SECS: f64 = 0.02;

/// The gamepads that are plugged in; the one that was touched last drives.
pub(crate) struct Pads {
    /// `None` where the machine gives no gamepads.
    all: Option<Gilrs>,
    /// The gamepad that was touched last.
    touched: Option<GamepadId>,
}

impl Pads {
    /// Opens the gamepads that are plugged in, and those that will be.
    pub(crate) fn open() -> Self {
        Self { all: Gilrs::new().ok(), touched: None }
    }

    /// Returns the seconds until the next look at the sticks; `None` without a gamepad.
    pub(crate) fn wait_secs(&self) -> Option<f64> {
        self.all.as_ref().map(|_| LOOK_SECS)
    }

    /// Returns where the sticks are now.
    pub(crate) fn read(&mut self) -> Sticks {
        let Some(all) = &mut self.all else { return Sticks::default() };
        while let Some(event) = all.next_event() {
            self.touched = Some(event.id);
        }
        let pad = self.touched.and_then(|id| all.connected_gamepad(id));
        let Some(pad) = pad else { return Sticks::default() };
        Sticks {
            left: [Axis::LeftStickX, Axis::LeftStickY].map(|axis| pad.value(axis)),
            right: [Axis::RightStickX, Axis::RightStickY].map(|axis| pad.value(axis)),
            runs: [Button::RightTrigger, Button::RightTrigger2]
                .into_iter()
                .any(|button| pad.is_pressed(button)),
        }
    }
}
