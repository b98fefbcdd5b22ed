//! Starts that are due, and those of clips.

use populace_device::layout::{SLOT_ONCE, Slot};
use populace_settings::parts::Playback;

use super::eviction::Plan;
use super::playback::playback_id;
use super::scheduled::{Action, Start};
use super::slots::{Started, weighing};
use super::{Player, tick_after};
use crate::Error;
use crate::crowd::base::Base;
use crate::crowd::{MemberId, PlaybackId, u32_from};

impl Player {
    /// Returns a new start.
    pub(crate) fn start_of(&mut self, action: Action, play: Playback) -> Start {
        Start { serial: self.next_serial(), action, play, follows_after: None }
    }

    pub(crate) fn begin_after(
        &mut self,
        base: &mut Base,
        member: MemberId,
        start: &Start,
        secs: f32,
    ) -> Result<PlaybackId, Error> {
        let due = tick_after(base.clock.tick, secs);
        self.begin_or_wait(base, member.number(), due, start)?;
        Ok(playback_id(member, start.serial))
    }

    pub(crate) fn begin_or_wait(
        &mut self,
        base: &mut Base,
        member_index: u32,
        due: u64,
        start: &Start,
    ) -> Result<(), Error> {
        if due > base.clock.tick {
            self.scheduled.push(member_index, due, *start);
            return Ok(());
        }
        self.begin(base, member_index, start, base.clock.tick)
    }

    /// Executes all starts that are due at or before `tick`, each as of its own tick.
    pub(crate) fn begin_due(&mut self, base: &mut Base, tick: u64) -> Result<(), Error> {
        while let Some((due, member_index, start)) = self.scheduled.take_due(tick) {
            self.begin(base, member_index, &start, due)?;
        }
        Ok(())
    }

    fn begin(
        &mut self,
        base: &mut Base,
        member_index: u32,
        start: &Start,
        tick: u64,
    ) -> Result<(), Error> {
        match start.action {
            Action::Clip { bound, alone } => {
                self.begin_clip(base, member_index, start, (bound, alone), tick)
            }
            Action::Space { index, at } => {
                self.begin_space(base, member_index, start, (index, at), tick)
            }
            Action::Machine { state, parameters } => {
                self.begin_machine(base, member_index, start, (state, parameters), tick)
            }
            Action::Move { at, over_secs } => {
                self.begin_move(base, member_index, start, (at, over_secs), tick)
            }
        }
    }

    fn begin_clip(
        &mut self,
        base: &mut Base,
        member_index: u32,
        start: &Start,
        (bound, alone): (u32, bool),
        tick: u64,
    ) -> Result<(), Error> {
        let Playback { layer, fade_in_secs: secs, .. } = start.play;
        if alone && secs <= 0.0 {
            self.fade_out(base, member_index, layer, 0.0, tick)?;
        }
        let slot = start.play.slot(bound, tick, base.duration_secs(bound));
        let mut slot = slot.on_layer(u32_from(layer));
        let inertializes = alone
            && start.play.inertializes
            && secs > 0.0
            && self.can_inertialize(base, member_index, &slot, tick);
        let role = |slot: &Slot, _| {
            if alone && slot.layer() as usize == layer { Plan::Leaves } else { Plan::Apart }
        };
        let needed = usize::from(
            !inertializes || self.unevaluated(base, member_index, slot.layer(), tick).is_empty(),
        );
        // Fading others out leaves a vacant slot vacant, but inertialization may take it.
        let vacant = self.vacant_slot(base, member_index, None, tick).filter(|_| !inertializes);
        if vacant.is_none()
            && let Some(due) = self.free_slots(base, member_index, needed, secs, tick, role)?
        {
            self.scheduled.push(member_index, due, start.at_its_time());
            return Ok(());
        }
        let (weight, nothing_fades) = if inertializes {
            (self.inertialize(base, member_index, &slot, secs, tick)?, true)
        } else if alone {
            (0.0, !self.fade_out(base, member_index, layer, secs, tick)?)
        } else {
            (0.0, self.is_first(base, member_index, layer, tick))
        };
        if alone {
            self.forget_space(member_index, layer);
        }
        let at_once = nothing_fades && layer == 0;
        slot.ramp_weight(tick, weight, start.play.weight, if at_once { 0.0 } else { secs });
        let once = slot.mode() == SLOT_ONCE;
        let started = Started { serial: start.serial, sample: None, once };
        match vacant {
            Some(index) => self.put_slot(base, member_index, index, &slot, started, tick),
            None => self.fill_slot(base, member_index, &slot, started, tick),
        }
    }

    /// Returns whether a start is the first of layer 0. It then has its full weight at once, so
    /// that the rest pose never shows by accident.
    pub(crate) fn is_first(&self, base: &Base, member_index: u32, layer: usize, tick: u64) -> bool {
        layer == 0 && weighing(base.slots(member_index), 0, tick).is_empty()
    }
}
