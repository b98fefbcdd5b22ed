//! Members that frames do not evaluate, because nobody sees them.

use super::Tables;
use crate::layout::{
    MEMBER_HIDDEN, NONE, SLOT_LIVE, STEP_CARRY, STEP_CHAIN, STEP_FOOT, STEP_GAZE, STEP_MOTION,
    STEP_PELVIS, STEP_REACH, STEP_ROTATION, STEP_WATCH,
};

/// Returns whether a step rotates joints of its member, by nothing but its targets.
const fn is_own(kind: u32) -> bool {
    matches!(kind, STEP_ROTATION | STEP_GAZE | STEP_REACH | STEP_CHAIN | STEP_PELVIS | STEP_FOOT)
}

impl Tables {
    /// Returns whether a member's clips tell how far it reaches from its place. Those of members
    /// with overrides, user stages, proportions or live clips, and of attached ones, do not.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    #[must_use]
    pub fn is_bounded(&self, member_index: u32) -> bool {
        let bounded = |kind| is_own(kind) || [STEP_WATCH, STEP_CARRY, STEP_MOTION].contains(&kind);
        // Slots of many members take long to read.
        self.takes_only(member_index, bounded)
            && !(self.had_live_clips && self.plays_live(member_index))
    }

    fn plays_live(&self, member_index: u32) -> bool {
        let slots = &self.all.slots.as_slice()[self.slot_range(member_index)];
        slots.iter().any(|slot| slot.bound_clip != NONE && slot.mode() == SLOT_LIVE)
    }

    /// Returns whether a member can be [hidden](Self::set_hidden): nobody else needs its pose, and
    /// the next frames do not build on it. Members with root motion, and those that are watched or
    /// carry others, cannot.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    #[must_use]
    pub fn can_hide(&self, member_index: u32) -> bool {
        self.takes_only(member_index, is_own)
    }

    /// Returns whether a member's constraint program has only steps of certain kinds and changes
    /// nothing before Transform.
    fn takes_only(&self, member_index: u32, allowed: impl Fn(u32) -> bool) -> bool {
        let member = self.all.members.as_slice()[member_index as usize];
        if member.control == NONE {
            return true;
        }
        let control = self.all.controls.as_slice()[member.control as usize];
        let first = control.step_first as usize;
        let steps = &self.all.steps.as_slice()[first..first + control.step_count as usize];
        control.local_count == 0
            && control.pose_step_count == 0
            && control.scale_first == NONE
            && steps.iter().all(|step| allowed(step.kind))
    }

    /// Hides a member, so that frames do not evaluate it, or shows it again. Both make its states
    /// of earlier frames void.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    pub fn set_hidden(&mut self, member_index: u32, hidden: bool) {
        let mut member = self.all.members.as_slice()[member_index as usize];
        if member.is_hidden() == hidden {
            return;
        }
        member.layers_and_phase ^= MEMBER_HIDDEN;
        self.all.members.set(member_index as usize, member);
        // Frames write no states of hidden members, so the two buffers of states are left unequal.
        if member.control != NONE {
            self.renew_epoch(member.control);
        }
    }

    /// Returns whether [`set_hidden`](Self::set_hidden) and [`set_reduced`](Self::set_reduced)
    /// would change nothing.
    ///
    /// # Panics
    ///
    /// If there is no such member or reduced body.
    #[must_use]
    pub fn is_evaluated_as(&self, member_index: u32, hidden: bool, reduced: u32) -> bool {
        let member = &self.all.members.as_slice()[member_index as usize];
        member.is_hidden() == hidden && member.posed == self.reduced_body(member, reduced)
    }
}
