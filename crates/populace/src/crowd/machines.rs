//! State machines on members: who runs which, by what parameters, and in which state it is.

use std::collections::HashMap;
use std::sync::Arc;

use populace_device::layout::{Float4, MACHINE_PARAMETERS, RUNNING_ELEMENTS, Running, Slot};
use populace_device::{BodyIndex, StageBuffer};

use super::room::{Plan, Started, faded_out};
use super::waiting::{Action, Start};
use super::{CharacterId, Crowd, Member, PlayId, u32_from};
use crate::error::bounded;
use crate::machine::{Compiled, bad, find};
use crate::play::check_layer;
use crate::{Error, Play, StateMachine};

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
    /// Where devices have the states of a machine for a body.
    bound: HashMap<(BodyIndex, u32), u32>,
    /// Whose states begin there.
    by_state: HashMap<u32, u32>,
}

impl Machines {
    /// Lets machines be bound anew once somebody runs them: clips are to move bodies in another
    /// way.
    pub(super) fn unbind(&mut self) {
        self.bound.clear();
    }

    /// The machine whose states begin there.
    fn of_state(&self, state: u32) -> Option<&Compiled> {
        self.all.get(*self.by_state.get(&state)? as usize)
    }
}

impl Crowd {
    /// Adds a state machine for members to run.
    ///
    /// # Errors
    ///
    /// [`Error::BadStateMachine`] for one without states, with more than 8 parameters, with two of
    /// a name, with a state or parameter that is not there, or that waits for the end of a clip
    /// that has none; a clip of another crowd; a number that is not finite; a live clip that is not
    /// played as one.
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

    /// The layer runs a state machine from its first state on; what it played before fades out as
    /// this fades in. It is ended by whatever else the layer is given to play, and by
    /// [`stop`](Self::stop).
    ///
    /// It takes two slots. `play` tells layer, weight, fade and delay; speed and phase are the
    /// states' own. A member can run one in each layer. What it plays only the device knows:
    /// [`playing`](Self::playing) and [`events`](Self::events) tell nothing of it.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a machine of another crowd, a setting that is out of its range,
    /// [`Error::BadStateMachine`] for members of one slot and for a speed or phase, or a clip that
    /// can move nothing of the member's body.
    pub fn run_machine(
        &mut self,
        member: Member,
        machine: MachineId,
        play: Play,
    ) -> Result<PlayId, Error> {
        let character = self.check(member)?;
        self.check_crowd("state machine", machine.crowd, machine.index)?;
        play.check()?;
        let Play { mode, speed, phase, .. } = Play::looping();
        if play != (Play { mode, speed, phase, ..play }) {
            return Err(bad(
                "runs at its states' own speeds and phases; give it Play::looping() as it is",
            ));
        }
        if self.tables.slots_per_member() < 2 {
            return Err(bad("takes 2 slots, and members have 1: see slots_per_member"));
        }
        let state = self.bind_machine(character, machine.index)?;
        let mut parameters = [0.0; MACHINE_PARAMETERS as usize];
        let initial = self.machines.all[machine.index as usize].parameters.iter();
        parameters.iter_mut().zip(initial).for_each(|(own, (_, value))| *own = *value);
        self.waiting.retain(member.place, |waiting| waiting.play.layer != play.layer);
        let action = Action::Machine { state, parameters };
        let start = Start { serial: self.next_serial(), action, play, follows_after: None };
        self.begin_after(member, start, play.after_secs)
    }

    /// Sets a parameter of all state machines that the member runs, or is to run, and that have one
    /// of this name. It costs no more than its 4 bytes on their way to the device.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a value that is not finite, or [`Error::BadStateMachine`] where the
    /// member runs no machine with such a parameter.
    pub fn set_parameter(&mut self, member: Member, name: &str, value: f32) -> Result<(), Error> {
        self.check(member)?;
        bounded("a parameter of a state machine", &[value])?;
        let (tick, place) = (self.clock.tick, member.place);
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
        let Self { waiting, machines, .. } = self;
        waiting.change(place, |_, start| {
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
        let all = states.chain(self.waiting.of(place).filter_map(|(_, start)| start.machine()));
        let machines: Vec<_> = all.filter_map(|state| self.machines.of_state(state)).collect();
        let names =
            machines.iter().flat_map(|machine| machine.parameters.iter().map(|p| p.0.as_str()));
        match find("parameter", name, names) {
            Err(error) if !machines.is_empty() => error,
            _ => bad("to set a parameter of is not there: the member runs none; start one by \
                      run_machine"),
        }
    }

    /// The name of the state in which the machine of a layer was after the last update: while a
    /// transition fades, the state that it leads to. This waits for the device.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a layer that is not there, [`Error::BadStateMachine`] where the
    /// layer runs no machine, or one that has not begun, or a failing device.
    pub fn state_of(&mut self, member: Member, layer: usize) -> Result<Arc<str>, Error> {
        self.check(member)?;
        check_layer(layer)?;
        let (tick, place) = (self.clock.tick, member.place);
        let slots = self.slots(place).iter().enumerate();
        let running =
            slots.filter(|(_, slot)| slot.layer() as usize == layer && !faded_out(slot, tick));
        let machine_instances =
            running.filter_map(|(index, slot)| Some((index, slot.machine_instance()?)));
        let newest = machine_instances.max_by_key(|(index, _)| self.started(place, *index).serial);
        let none = || {
            bad(&format!(
                "to ask for the state of is not there: the member runs none in layer {layer}"
            ))
        };
        let waits = |start: &Start| start.play.layer == layer && start.machine().is_some();
        if newest.is_none() && self.waiting.of(place).any(|(_, start)| waits(start)) {
            return Err(bad(&format!(
                "of layer {layer} has not begun: it waits; ask for its state after the update in \
                 which it begins"
            )));
        }
        let (_, index) = newest.ok_or_else(none)?;
        let (machine_instance, at) = (self.tables.machine_instance(index)?, self.running(index)?);
        // One that no frame has run yet is where it begins.
        let state = if at.epoch == machine_instance.epoch {
            at.state.wrapping_sub(machine_instance.state)
        } else {
            0
        };
        let machine = self.machines.of_state(machine_instance.state).ok_or_else(none)?;
        Ok(Arc::clone(&machine.states.get(state as usize).ok_or_else(none)?.name))
    }

    /// Where a machine instance was after the last update.
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
        let Play { layer, fade_in_secs: secs, weight, .. } = start.play;
        if secs <= 0.0 {
            self.fade_out(place, layer, 0.0, tick)?;
        }
        let plan = |slot: &Slot, _| {
            if slot.layer() as usize == layer { Plan::Leaves } else { Plan::Apart }
        };
        if let Some(due) = self.make_room(place, 2, secs, tick, plan)? {
            self.waiting.push(place, due, start.at_its_time());
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
    use crate::{ClipId, Device, Placement, StateMachine};

    fn run(slots: usize, mut look: impl FnMut(&Crowd, u32)) {
        let builder = Crowd::builder().device(Device::native()).slots_per_member(slots);
        let mut crowd = builder.build().unwrap();
        let lift = crowd.add_character(super::super::tests::lift()).unwrap();
        let clip: ClipId = crowd.clips(lift).unwrap()[0].0;
        let machine = StateMachine::new().state("lifts", clip, Play::looping());
        let machine = crowd.add_machine(&machine).unwrap();
        let member = crowd.spawn(lift, Placement::at([0.0; 3])).unwrap();
        crowd.play(member, clip, Play::looping()).unwrap();
        let mut random = Rng::new(slots as u64);
        for _ in 0..6000 {
            let secs =
                u8::try_from(2 + random.below(4)).map_or(0.2, |tenths| f32::from(tenths) / 10.0);
            let play = Play::looping().fade_in_secs(secs);
            match random.below(20) {
                0 => drop(crowd.play(member, clip, play).unwrap()),
                1 => drop(crowd.run_machine(member, machine, play).unwrap()),
                _ => {}
            }
            crowd.update(0.01).unwrap();
            look(&crowd, member.place);
        }
    }

    #[test]
    fn both_slots_of_a_machine_weigh_the_same_and_all_of_a_layer_what_it_did() {
        for slots in [4, 5, 8] {
            let mut most = 0;
            run(slots, |crowd, place| {
                let tick = crowd.clock.tick;
                let ramp = |s: &Slot| (s.weight_tick, s.start_weight, s.weight_rate, s.end_weight);
                // What weighs as little is free, one slot at a time.
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
                // Fades that others cut short leave less.
                assert!(total > 0.7 && total < 1.03, "{total} of {slots} slots: {all:?}");
                most = most.max(all.iter().filter(taken).count());
            });
            assert!(most >= slots.min(5), "{most} of {slots} slots were taken at once");
        }
    }
}
