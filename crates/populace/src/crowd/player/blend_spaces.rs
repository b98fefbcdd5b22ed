//! Blend spaces that members play: which they are, and where in them members are.

mod moves;

use populace_device::layout::Slot;
use populace_model::convert::single;
use populace_settings::parts::{Check, Key, Parts, Playback, check_secs, slots_needed};

use super::scheduled::{Action, Start};
use super::slots::{Started, faded_out};
use super::{Player, tick_after};
use crate::crowd::base::Base;
use crate::crowd::{BlendSpaceId, MemberId};
use crate::{BlendSpace, BlendSpaceFault, Error, IdKind, SpacePoint};

/// A cycle in the unit of phases.
const CYCLE: f64 = 18_446_744_073_709_551_616.0;

/// A blend space and the durations of its clips.
#[derive(Clone)]
pub(crate) struct Space {
    pub(crate) space: BlendSpace,
    durations_secs: Vec<f32>,
}

/// The blend space that a member plays, with its phase in closed form.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActiveSpace {
    serial: u64,
    pub(crate) space: u32,
    play: Playback,
    /// The position, or the one it moves to; `None` while it waits for a slot.
    at: Option<SpacePoint>,
    start_tick: u64,
    /// The phase at `start_tick`, in 2^-64 of a cycle.
    phase: u64,
    cycles_per_sec: f64,
    /// The tick at which its fade ends.
    faded_in_tick: u64,
}

impl ActiveSpace {
    /// Returns the phase at a tick, in 2^-64 of a cycle.
    fn phase_at(&self, tick: u64) -> u64 {
        let rate = Slot::in_phase(0, 0, 0, self.cycles_per_sec).phase_rate;
        self.phase.wrapping_add(tick.wrapping_sub(self.start_tick).wrapping_mul(rate))
    }

    /// Returns whether another slot of the layer fades out for the blend space. What started before
    /// it does, even if the slot holds its weight while others are evicted.
    fn replaces(&self, slot: &Slot, started: Started) -> bool {
        slot.end_weight <= 0.0 || started.serial < self.serial
    }
}

fn live_in_space(name: &str) -> Error {
    Error::BadBlendSpace(BlendSpaceFault::LiveClip(name.to_owned()))
}

impl Player {
    pub(crate) fn add_blend_space(
        &mut self,
        base: &mut Base,
        space: BlendSpace,
    ) -> Result<BlendSpaceId, Error> {
        let mut durations_secs = Vec::new();
        for clip in space.clips() {
            let known = base.known_clip(*clip)?;
            if known.ring().is_some() {
                return Err(live_in_space(known.name()));
            }
            durations_secs.push(known.duration_secs());
        }
        let (index, generation) = self.spaces.insert(Space { space, durations_secs });
        Ok(BlendSpaceId::from_parts(Key { crowd: base.number, index, generation }))
    }

    /// Returns a blend space, or an error if it was removed or belongs to another crowd.
    pub(crate) fn known_space(&self, base: &Base, id: BlendSpaceId) -> Result<&Space, Error> {
        let Key { crowd, index, generation } = id.parts();
        base.check_crowd(IdKind::BlendSpace, crowd, index)?;
        let unknown = Error::UnknownId { what: IdKind::BlendSpace, index };
        self.spaces.get((index, generation)).ok_or(unknown)
    }

    pub(crate) fn play_space(
        &mut self,
        base: &mut Base,
        member: MemberId,
        space: BlendSpaceId,
        at: SpacePoint,
        play: Playback,
    ) -> Result<(), Error> {
        let character = base.check(member)?;
        let known = self.known_space(base, space)?;
        play.check()?;
        at.check()?;
        let (needed, slots) = (slots_needed(&known.space), base.tables.slots_per_member());
        if needed > slots {
            return Err(Error::BadBlendSpace(BlendSpaceFault::Slots { needed, slots }));
        }
        // Bound now, so that a scheduled start cannot fail.
        for clip in known.space.clips().to_vec() {
            base.bind(character, clip, play.partial)?;
        }
        self.scheduled.retain(member.number(), |start| start.play.layer != play.layer);
        let action = Action::Space { index: space.parts().index, at };
        let start = self.start_of(action, play);
        let due = tick_after(base.clock.tick, play.after_secs);
        self.begin_or_wait(base, member.number(), due, &start)
    }

    pub(crate) fn set_blend_parameter(
        &mut self,
        base: &mut Base,
        member: MemberId,
        at: SpacePoint,
        over_secs: f32,
    ) -> Result<(), Error> {
        base.check(member)?;
        at.check()?;
        check_secs("the time to move in a blend space", over_secs)?;
        let mut waits = false;
        self.scheduled.change(member.number(), |_, start| {
            if let Action::Space { at: point, .. } = &mut start.action {
                *point = at;
                waits = true;
            }
        });
        let Some(active_space) = self.active_space.get(member.number()) else {
            let not_playing = Error::BadBlendSpace(BlendSpaceFault::NotPlaying);
            return if waits { Ok(()) } else { Err(not_playing) };
        };
        let (play, serial) = (active_space.play, active_space.serial);
        if active_space.at == Some(at) && self.scheduled.is_empty() {
            return Ok(());
        }
        self.scheduled
            .retain(member.number(), |start| !matches!(start.action, Action::Move { .. }));
        let action = Action::Move { at, over_secs };
        let start = Start { serial, action, play, follows_after: None };
        self.begin_move(base, member.number(), &start, (at, over_secs), base.clock.tick)
    }

    /// Returns the phase of the blend space that a member plays, 0 to 1.
    pub(crate) fn space_phase(&self, base: &Base, member: MemberId) -> Option<f32> {
        let active_space = self.active_space.get(member.number())?;
        Some(single(active_space.phase_at(base.clock.tick) as f64 / CYCLE))
    }

    /// Returns whether a slot of the active blend space of the member at an index has weight.
    pub(crate) fn is_heard(&self, base: &Base, index: u32, active: &ActiveSpace) -> bool {
        let tick = base.clock.tick;
        let slots = (0..).zip(base.slots(index));
        let mut own =
            slots.filter(|(slot, _)| self.started(base, index, *slot).serial == active.serial);
        own.any(|(_, slot)| !faded_out(slot, tick))
    }

    /// Forgets the blend space of a layer that something else takes over.
    pub(crate) fn forget_space(&mut self, member_index: u32, layer: usize) {
        if self
            .active_space
            .get(member_index)
            .is_some_and(|active_space| active_space.play.layer == layer)
        {
            self.active_space.remove(member_index);
        }
    }
}
