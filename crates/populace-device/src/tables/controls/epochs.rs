//! Epochs: numbers by which devices tell the history state of one owner from that of another.

use populace_model::convert::u32_from;

use super::compile::Program;
use super::{ControlSpaces, Tables};
use crate::layout::FOOT_STATE_BITS;

impl ControlSpaces {
    /// Returns the number of the last owner of history state.
    pub(in crate::tables) const fn last_epoch(&self) -> u32 {
        self.epoch
    }

    /// Gives the next owners numbers after this one.
    pub(in crate::tables) fn continue_after(&mut self, epoch: u32) {
        self.epoch = self.epoch.max(epoch);
    }

    /// Returns a number for the next owner of history state.
    pub(super) fn next_epoch(&mut self) -> u32 {
        self.epoch = self.epoch.wrapping_add(1) & (u32::MAX >> FOOT_STATE_BITS);
        self.epoch
    }
}

impl Tables {
    /// Makes devices ignore the history state of a constraint program.
    pub(in crate::tables) fn renew_epoch(&mut self, control: u32) {
        let epoch = self.control_spaces.next_epoch();
        let mut row = self.all.controls.as_slice()[control as usize];
        row.epoch = epoch;
        self.all.controls.set(control as usize, row);
    }

    /// Makes devices ignore what they know of feet, unless the program before had the same ones.
    /// States stay as they are while a program has no feet.
    pub(super) fn forget_feet_before(&mut self, control: usize, program: &Program) {
        let before = std::mem::replace(&mut self.control_spaces.runs[control].feet, program.feet);
        if program.feet.is_some() && program.feet != before {
            self.renew_epoch(u32_from(control));
        }
    }
}
