//! State machines that members run: their parameters and states.

use std::collections::HashMap;
use std::sync::Arc;

use populace_device::layout::{Float4, MACHINE_PARAMETERS, RUNNING_ELEMENTS, Running, Slot};
use populace_device::{BodyIndex, StageBuffer};

use super::scheduled::{Action, Start};
use super::slots::{Plan, Started, faded_out};
use super::{CharacterId, Crowd, MemberId, PlaybackId, u32_from};
use crate::error::bounded;
use crate::machine::{Compiled, bad, find};
use crate::playback::{Playback, check_layer};
use crate::{Error, StateMachine};

/// A state machine of a crowd. Members of any character can run it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MachineId {
    crowd: u32,
    index: u32,
}

/// The state machines of a crowd.
#[derive(Default)]
pub(super) struct Machines {
    all: Vec<Compiled>,
    /// The first state row on the device of each machine bound to a body.
    bound: HashMap<(BodyIndex, u32), u32>,
    /// The machine whose states begin at a row.
    by_state: HashMap<u32, u32>,
}

impl Machines {
    /// Forgets the bindings of machines, after the roles of a body have changed.
    pub(super) fn unbind(&mut self) {
        self.bound.clear();
    }

    /// Returns the machine whose states begin at a row.
    fn of_state(&self, state: u32) -> Option<&Compiled> {
        self.all.get(*self.by_state.get(&state)? as usize)
    }
}

impl Crowd {
    /// Adds a state machine. Members of any character can run it.
    ///
    /// # Errors
    ///
    /// [`Error::BadStateMachine`] for a machine without states, with more than 8 parameters, with a
    /// duplicate or unknown name, or with a condition on the end of a clip that has none; a clip of
    /// another crowd; a number that is not finite; a live clip that is not played as one.
    pub fn add_machine(&mut self, machine: &StateMachine) -> Result<MachineId, Error> {
        let compiled = machine.compile(|clip, mode| {
            self.check_crowd("clip", clip.crowd, clip.index.0)?;
            self.check_mode(clip, mode)?;
            let known = self.clips.get(clip.index);
            Ok(known.ok_or(Error::UnknownId { what: "clip", index: clip.index.0 })?.duration_secs())
        })?;
        let id = MachineId { crowd: self.number, index: u32_from(self.machines.all.len()) };
        self.machines.all.push(compiled);
        Ok(id)
    }

    pub(super) fn run_machine(
        &mut self,
        member: MemberId,
        machine: MachineId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let character = self.check(member)?;
        self.check_crowd("state machine", machine.crowd, machine.index)?;
        play.check()?;
        if self.tables.slots_per_member() < 2 {
            return Err(bad(
                "takes 2 slots, but members have 1; see CrowdBuilder::slots_per_member",
            ));
        }
        let state = self.bind_machine(character, machine.index)?;
        let mut parameters = [0.0; MACHINE_PARAMETERS as usize];
        let initial = self.machines.all[machine.index as usize].parameters.iter();
        parameters.iter_mut().zip(initial).for_each(|(own, (_, value))| *own = *value);
        self.scheduled.retain(member.index, |start| start.play.layer != play.layer);
        let action = Action::Machine { state, parameters };
        let start = Start { serial: self.next_serial(), action, play, follows_after: None };
        self.begin_after(member, start, play.after_secs)
    }

    pub(super) fn set_parameter(
        &mut self,
        member: MemberId,
        name: &str,
        value: f32,
    ) -> Result<(), Error> {
        self.check(member)?;
        bounded("a parameter of a state machine", &[value])?;
        let (tick, place) = (self.clock.tick, member.index);
        let mut is_found = false;
        for index in self.tables.slot_range(place) {
            let slot = self.tables.slots().as_slice()[index];
            let Some(machine_instance) =
                slot.machine_instance().filter(|_| !faded_out(&slot, tick))
            else {
                continue;
            };
            let machine =
                self.machines.of_state(self.tables.machine_instance(machine_instance)?.state);
            if let Some(parameter) = machine.and_then(|machine| machine.parameter(name)) {
                self.tables.set_machine_parameter(machine_instance, u32_from(parameter), value)?;
                is_found = true;
            }
        }
        let Self { scheduled, machines, .. } = self;
        scheduled.change(place, |_, start| {
            if let Action::Machine { state, parameters } = &mut start.action
                && let Some(parameter) = machines.of_state(*state).and_then(|m| m.parameter(name))
            {
                parameters[parameter] = value;
                is_found = true;
            }
        });
        if is_found { Ok(()) } else { Err(self.no_parameter(place, name)) }
    }

    fn no_parameter(&self, place: u32, name: &str) -> Error {
        let running = self.slots(place).iter().filter(|slot| !faded_out(slot, self.clock.tick));
        let machine_instances = running.filter_map(Slot::machine_instance);
        let states = machine_instances.filter_map(|machine_instance| {
            Some(self.tables.machine_instance(machine_instance).ok()?.state)
        });
        let all = states.chain(self.scheduled.of(place).filter_map(|(_, start)| start.machine()));
        let machines: Vec<_> = all.filter_map(|state| self.machines.of_state(state)).collect();
        let names =
            machines.iter().flat_map(|machine| machine.parameters.iter().map(|p| p.0.as_str()));
        match find("parameter", name, names) {
            Err(error) if !machines.is_empty() => error,
            _ => bad("parameter cannot be set: the member runs no state machine; start one with \
                      play_machine"),
        }
    }

    pub(super) fn state_of(&mut self, member: MemberId, layer: usize) -> Result<Arc<str>, Error> {
        self.check(member)?;
        check_layer(layer)?;
        let (tick, place) = (self.clock.tick, member.index);
        let slots = self.slots(place).iter().enumerate();
        let running =
            slots.filter(|(_, slot)| slot.layer() as usize == layer && !faded_out(slot, tick));
        let machine_instances =
            running.filter_map(|(index, slot)| Some((index, slot.machine_instance()?)));
        let newest = machine_instances.max_by_key(|(index, _)| self.started(place, *index).serial);
        let none =
            || bad(&format!("of layer {layer} has no state: the layer runs no state machine"));
        let waits = |start: &Start| start.play.layer == layer && start.machine().is_some();
        if newest.is_none() && self.scheduled.of(place).any(|(_, start)| waits(start)) {
            return Err(bad(&format!(
                "of layer {layer} has not started yet; ask for its state after the update in \
                 which it starts"
            )));
        }
        let (_, index) = newest.ok_or_else(none)?;
        let (machine_instance, at) = (self.tables.machine_instance(index)?, self.running(index)?);
        // An instance that no frame has run is in its first state.
        let state = if at.epoch == machine_instance.epoch {
            at.state.wrapping_sub(machine_instance.state)
        } else {
            0
        };
        let machine = self.machines.of_state(machine_instance.state).ok_or_else(none)?;
        Ok(Arc::clone(&machine.states.get(state as usize).ok_or_else(none)?.name))
    }

    /// Returns the state of a machine instance after the last update.
    fn running(&mut self, machine_instance: u32) -> Result<Running, Error> {
        if let Some(kept) = &self.kept {
            return Ok(kept.running(machine_instance));
        }
        let mut elements = [Float4::default(); RUNNING_ELEMENTS as usize];
        if (machine_instance as usize) < self.tables.machine_instances().tail().start {
            let first = machine_instance as usize * elements.len();
            self.opened.backend_mut().read(
                &self.tables,
                StageBuffer::Running,
                first,
                &mut elements,
            )?;
        }
        Ok(Running::from_elements(elements))
    }

    fn bind_machine(&mut self, character: CharacterId, index: u32) -> Result<u32, Error> {
        let body = self.character_state(character)?.body;
        if let Some(&state) = self.machines.bound.get(&(body, index)) {
            return Ok(state);
        }
        let unknown = Error::UnknownId { what: "state machine", index };
        let states = &self.machines.all.get(index as usize).ok_or(unknown)?.states;
        let states: Vec<_> =
            states.iter().map(|state| (state.clip, state.partial, state.rows.clone())).collect();
        let mut rows = Vec::with_capacity(states.len());
        for (clip, partial, mut row) in states {
            row.slot.bound_clip = self.bind(character, clip, partial)?;
            rows.push(row);
        }
        let state = self.tables.add_states(body, &rows)?;
        self.machines.bound.insert((body, index), state);
        self.machines.by_state.insert(state, index);
        Ok(state)
    }

    pub(super) fn begin_machine(
        &mut self,
        place: u32,
        start: &Start,
        (state, parameters): (u32, [f32; MACHINE_PARAMETERS as usize]),
        tick: u64,
    ) -> Result<(), Error> {
        let Playback { layer, fade_in_secs: secs, weight, .. } = start.play;
        if secs <= 0.0 {
            self.fade_out(place, layer, 0.0, tick)?;
        }
        let plan = |slot: &Slot, _| {
            if slot.layer() as usize == layer { Plan::Leaves } else { Plan::Apart }
        };
        if let Some(due) = self.free_slots(place, 2, secs, tick, plan)? {
            self.scheduled.push(place, due, start.at_its_time());
            return Ok(());
        }
        let secs = if self.is_first(place, layer, tick) { 0.0 } else { secs };
        self.fade_out(place, layer, secs, tick)?;
        self.forget_space(place, layer);
        let machine_instance = self.tables.add_machine_instance(state, tick, parameters)?;
        let started = Started { serial: start.serial, sample: None, once: false };
        for which in 0..2 {
            let mut slot = Slot::machine(machine_instance, which, tick).on_layer(u32_from(layer));
            slot.ramp_weight(tick, 0.0, 0.5 * weight, secs);
            self.fill_slot(place, slot, started, tick)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use populace_device::layout::NONE;
    use populace_testkit::Rng;

    use super::*;
    use crate::{
        ClipId, ClipPlayback, Device, MachinePlayback, Placement, StateMachine, StatePlayback,
    };

    /// Runs random starts of clips and machines and calls `look` after each frame.
    fn run(slots: usize, mut look: impl FnMut(&Crowd, u32)) {
        let builder = Crowd::builder().device(Device::native()).slots_per_member(slots);
        let mut crowd = builder.build().unwrap();
        let lift = crowd.add_character(super::super::tests::lift()).unwrap();
        let clip: ClipId = crowd.clips(lift).unwrap()[0].0;
        let machine = StateMachine::new().state("lifts", clip, StatePlayback::looping());
        let machine = crowd.add_machine(&machine).unwrap();
        let member = crowd.spawn(lift, Placement::at([0.0; 3])).unwrap();
        crowd.member_mut(member).unwrap().play(clip, ClipPlayback::looping()).unwrap();
        let mut random = Rng::new(slots as u64);
        for _ in 0..6000 {
            let secs =
                u8::try_from(2 + random.below(4)).map_or(0.2, |tenths| f32::from(tenths) / 10.0);
            let play = ClipPlayback::looping().fade_in_secs(secs);
            match random.below(20) {
                0 => drop(crowd.member_mut(member).unwrap().play(clip, play).unwrap()),
                1 => drop(
                    crowd
                        .member_mut(member)
                        .unwrap()
                        .play_machine(machine, MachinePlayback::new().fade_in_secs(secs))
                        .unwrap(),
                ),
                _ => {}
            }
            crowd.update(0.01).unwrap();
            look(&crowd, member.index);
        }
    }

    #[test]
    fn machine_slots_have_equal_weights_and_layers_keep_their_sum() {
        for slots in [4, 5, 8] {
            let mut most = 0;
            run(slots, |crowd, place| {
                let tick = crowd.clock.tick;
                let ramp = |s: &Slot| (s.weight_tick, s.start_weight, s.weight_rate, s.end_weight);
                // Slots of lower weight count as free, one at a time.
                let taken = |slot: &&Slot| slot.bound_clip != NONE && slot.weight_at(tick) > 2e-3;
                let all = crowd.slots(place);
                for slot in
                    all.iter().filter(taken).filter(|slot| slot.machine_instance().is_some())
                {
                    let is_mate = |other: &&Slot| {
                        other.machine_instance() == slot.machine_instance()
                            && other.bound_clip != slot.bound_clip
                    };
                    assert_eq!(
                        all.iter().find(is_mate).map(ramp),
                        Some(ramp(slot)),
                        "{slots} slots: {all:?}"
                    );
                }
                let total: f32 = all.iter().filter(taken).map(|slot| slot.weight_at(tick)).sum();
                // The sum is lower when a start cuts a fade short.
                assert!(total > 0.7 && total < 1.03, "{total} of {slots} slots: {all:?}");
                most = most.max(all.iter().filter(taken).count());
            });
            assert!(most >= slots.min(5), "{most} of {slots} slots were taken at once");
        }
    }
}
