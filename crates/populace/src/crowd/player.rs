//! The player: what members play in their slots, and what is scheduled.

pub(super) mod blend_spaces;
mod eviction;
mod inertialization;
mod machines;
mod playback;
mod queue;
pub(super) mod scheduled;
pub(super) mod slots;
mod starts;

use populace_clip::ticks_from_secs;
use populace_device::layout::Slot;

use super::MemberId;
use super::by_member::ByMember;
use super::slab::Slab;
use blend_spaces::{ActiveSpace, Space};
use machines::Machines;
use scheduled::ScheduledStarts;
use slots::Started;

/// Playback of all members: clips, blend spaces and state machines. The slots themselves are in
/// the tables.
#[derive(Clone, Default)]
pub(super) struct Player {
    /// The start that each slot of the tables belongs to.
    pub(super) started: Vec<Started>,
    pub(super) scheduled: ScheduledStarts,
    last_serial: u64,
    pub(super) spaces: Slab<Space>,
    /// The blend space that a member plays.
    pub(super) active_space: ByMember<ActiveSpace>,
    pub(super) machines: Machines,
    /// Slots that ended during an update: member index, slot and tick.
    pub(super) left: Vec<(u32, Slot, u64)>,
}

impl Player {
    /// Makes room for what is started in `slots` slots.
    pub(super) fn set_slot_count(&mut self, slots: usize) {
        self.started.resize(self.started.len().max(slots), Started::default());
    }

    /// Forgets what a despawned member plays.
    pub(super) fn forget(&mut self, member: MemberId) {
        self.scheduled.retain(member.number(), |_| false);
        self.active_space.remove(member.number());
    }

    /// Returns a number that no other start has.
    pub(super) fn next_serial(&mut self) -> u64 {
        self.last_serial += 1;
        self.last_serial
    }

    /// Takes the slots that ended since the last call.
    pub(super) fn take_left(&mut self) -> Vec<(u32, Slot, u64)> {
        std::mem::take(&mut self.left)
    }
}

/// Returns the tick that is `secs` after another.
fn tick_after(tick: u64, secs: f32) -> u64 {
    // Rounding is slow, and most starts are not delayed.
    if secs == 0.0 {
        return tick;
    }
    tick.saturating_add(ticks_from_secs(f64::from(secs)))
}

#[cfg(test)]
mod tests {
    use crate::{ClipPlayback, Crowd, Device, Placement};

    #[test]
    fn ids_of_playbacks_are_not_used_again_after_four_thousand_million() {
        let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
        let lift = crowd.add_character(crate::crowd::tests::lift()).unwrap();
        let member = crowd.spawn(lift, Placement::at([0.0; 3])).unwrap();
        let clip = crowd.clip(lift, "Lift").unwrap();
        let play =
            |crowd: &mut Crowd| crowd.member_mut(member).unwrap().play(clip, ClipPlayback::once());
        let first = play(&mut crowd).unwrap();
        let player = &mut crowd.state.player;
        player.last_serial = player.last_serial.wrapping_add(u32::MAX.into());
        let last = play(&mut crowd).unwrap();
        assert_ne!(first, last);
    }
}
