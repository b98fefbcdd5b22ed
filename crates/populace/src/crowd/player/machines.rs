//! State machines that members run: their parameters and states.

use std::sync::Arc;

use populace_device::layout::{MACHINE_PARAMETERS, NONE, Running, Slot};
use populace_device::{BodyIndex, Tables};
use populace_settings::parts::{
    Check, Compiled, Key, ParameterParts, Parts, Playback, bounded, check_layer, compile, find,
};
use rustc_hash::FxHashMap;

use super::Player;
use super::eviction::Plan;
use super::scheduled::{Action, Start};
use super::slots::{Started, faded_out};
use crate::crowd::base::Base;
use crate::crowd::slab::Slab;
use crate::crowd::{
    CharacterId, ClipId, MachineId, MemberId, Parameter, ParameterId, PlaybackId, u32_from,
};
use crate::{Error, IdKind, MachineFault, MachinePart, StateMachine};

/// The state machines of a crowd.
#[derive(Clone, Default)]
pub(crate) struct Machines {
    all: Slab<Compiled>,
    /// The first state row on the device of each machine bound to a body.
    bound: FxHashMap<(BodyIndex, u32), u32>,
    /// The body and the machine of the states that begin at a row.
    by_state: FxHashMap<u32, (BodyIndex, u32)>,
}

impl Machines {
    /// Forgets the bindings of machines, after the roles of a body have changed.
    pub(crate) fn unbind(&mut self) {
        self.bound.clear();
    }

    /// Returns the index of the machine whose states begin at a row.
    pub(crate) fn index_of(&self, state: u32) -> Option<u32> {
        self.by_state.get(&state).map(|(_, index)| *index)
    }

    /// Returns the index of a parameter in the machine whose states begin at a row.
    fn index_in(&self, state: u32, parameter: Parameter<'_>) -> Option<u32> {
        let (_, machine) = self.by_state.get(&state)?;
        match parameter {
            Parameter::Name(name) => self.all.at(*machine)?.parameter(name).map(u32_from),
            Parameter::Id(id) => {
                let ParameterParts { machine: of, index } = id.parts();
                let of = of.parts();
                let is_it = of.index == *machine;
                (is_it && of.generation == self.all.generation(*machine)).then_some(index)
            }
        }
    }

    /// Returns whether a machine has a clip.
    pub(crate) fn uses_clip(&self, clip: ClipId) -> bool {
        self.all.iter().any(|(_, machine)| machine.states.iter().any(|s| s.clip == clip))
    }

    /// Removes the states that `which` selects by body and machine.
    pub(crate) fn remove_states(
        &mut self,
        tables: &mut Tables,
        which: impl Fn(BodyIndex, u32) -> bool,
    ) -> Result<(), Error> {
        let selected = self.by_state.extract_if(|_, (body, index)| which(*body, *index));
        let mut rows: Vec<u32> = selected.map(|(row, _)| row).collect();
        // Sorted, so that equal calls leave equal tables.
        rows.sort_unstable();
        rows.into_iter().try_for_each(|row| tables.remove_states(row))?;
        self.bound.retain(|(body, index), _| !which(*body, *index));
        Ok(())
    }

    pub(crate) fn remove(&mut self, id: MachineId) {
        self.all.remove(id.parts().index);
    }

    /// Returns the machine whose states begin at a row.
    fn of_state(&self, state: u32) -> Option<&Compiled> {
        self.all.at(self.by_state.get(&state)?.1)
    }
}

impl Player {
    pub(crate) fn add_machine(
        &mut self,
        base: &mut Base,
        machine: &StateMachine,
    ) -> Result<MachineId, Error> {
        let compiled = compile(machine, |clip, mode| {
            base.check_mode(clip, mode)?;
            Ok(base.known_clip(clip)?.duration_secs())
        })?;
        let (index, generation) = self.machines.all.insert(compiled);
        Ok(MachineId::from_parts(Key { crowd: base.number, index, generation }))
    }

    /// Returns a state machine, or an error if it was removed or belongs to another crowd.
    pub(crate) fn known_machine(&self, base: &Base, id: MachineId) -> Result<&Compiled, Error> {
        let Key { crowd, index, generation } = id.parts();
        base.check_crowd(IdKind::Machine, crowd, index)?;
        let unknown = Error::UnknownId { what: IdKind::Machine, index };
        self.machines.all.get((index, generation)).ok_or(unknown)
    }

    pub(crate) fn run_machine(
        &mut self,
        base: &mut Base,
        member: MemberId,
        machine: MachineId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let character = base.check(member)?;
        let known = self.known_machine(base, machine)?;
        let initial = known.parameters.clone();
        play.check()?;
        if base.tables.slots_per_member() < 2 {
            return Err(Error::BadStateMachine(MachineFault::Slots));
        }
        let state = self.bind_machine(base, character, machine.parts().index)?;
        let mut parameters = [0.0; MACHINE_PARAMETERS as usize];
        parameters.iter_mut().zip(&initial).for_each(|(own, (_, value))| *own = *value);
        self.scheduled.retain(member.number(), |start| start.play.layer != play.layer);
        let action = Action::Machine { state, parameters };
        let start = self.start_of(action, play);
        self.begin_after(base, member, &start, play.after_secs)
    }

    /// Returns the id of a parameter of a machine.
    pub(crate) fn parameter(
        &self,
        base: &Base,
        machine: MachineId,
        name: &str,
    ) -> Result<ParameterId, Error> {
        let known = self.known_machine(base, machine)?;
        let names = known.parameters.iter().map(|(own, _)| own.as_str());
        let index = u32_from(find(MachinePart::Parameter, name, names)?);
        Ok(ParameterId::from_parts(ParameterParts { machine, index }))
    }

    pub(crate) fn set_parameter(
        &mut self,
        base: &mut Base,
        member: MemberId,
        parameter: Parameter<'_>,
        value: f32,
    ) -> Result<(), Error> {
        base.check(member)?;
        bounded("a parameter of a state machine", &[value])?;
        if let Parameter::Id(id) = parameter {
            check_parameter(base, id)?;
        }
        if self.write_parameter(base, member.number(), parameter, value)? {
            return Ok(());
        }
        match parameter {
            Parameter::Name(name) => Err(self.no_parameter(base, member.number(), name)),
            Parameter::Id(_) => Err(Error::BadStateMachine(MachineFault::OtherMachine)),
        }
    }

    /// Sets a parameter wherever the member at an index has it, and returns whether it has.
    fn write_parameter(
        &mut self,
        base: &mut Base,
        member_index: u32,
        parameter: Parameter<'_>,
        value: f32,
    ) -> Result<bool, Error> {
        let Self { scheduled, machines, .. } = self;
        let index_in = |state| machines.index_in(state, parameter);
        let mut is_found = write_running(base, member_index, value, index_in)?;
        scheduled.change(member_index, |_, start| {
            if let Action::Machine { state, parameters } = &mut start.action
                && let Some(index) = machines.index_in(*state, parameter)
            {
                parameters[index as usize] = value;
                is_found = true;
            }
        });
        Ok(is_found)
    }

    /// Sets a parameter of many members, each wherever it has it.
    pub(crate) fn write_parameters(
        &mut self,
        base: &mut Base,
        parameter: ParameterId,
        values: &[(MemberId, f32)],
    ) -> Result<(), Error> {
        check_parameter(base, parameter)?;
        if !self.scheduled.is_empty() {
            for (member, value) in values {
                self.write_parameter(base, member.number(), Parameter::Id(parameter), *value)?;
            }
            return Ok(());
        }
        // Members of one body share their states, so the last answer is mostly the next.
        let mut last = (NONE, None);
        for (member, value) in values {
            let index_in = |state| {
                if state != last.0 {
                    last = (state, self.machines.index_in(state, Parameter::Id(parameter)));
                }
                last.1
            };
            write_running(base, member.number(), *value, index_in)?;
        }
        Ok(())
    }

    fn no_parameter(&self, base: &Base, member_index: u32, name: &str) -> Error {
        let running =
            base.slots(member_index).iter().filter(|slot| !faded_out(slot, base.clock.tick));
        let machine_instances = running.filter_map(Slot::machine_instance);
        let states = machine_instances.filter_map(|machine_instance| {
            Some(base.tables.machine_instance(machine_instance).ok()?.state)
        });
        let all =
            states.chain(self.scheduled.of(member_index).filter_map(|(_, start)| start.machine()));
        let machines: Vec<_> = all.filter_map(|state| self.machines.of_state(state)).collect();
        let names =
            machines.iter().flat_map(|machine| machine.parameters.iter().map(|p| p.0.as_str()));
        match find(MachinePart::Parameter, name, names) {
            Err(error) if !machines.is_empty() => error,
            _ => Error::BadStateMachine(MachineFault::NotRunning),
        }
    }

    /// Returns the newest machine instance of a layer.
    pub(crate) fn machine_on(
        &self,
        base: &Base,
        member: MemberId,
        layer: usize,
    ) -> Result<u32, Error> {
        check_layer(layer)?;
        let (tick, index) = (base.clock.tick, member.number());
        let slots = base.slots(index).iter().enumerate();
        let running =
            slots.filter(|(_, slot)| slot.layer() as usize == layer && !faded_out(slot, tick));
        let instances = running.filter_map(|(slot, s)| Some((slot, s.machine_instance()?)));
        let newest = instances.max_by_key(|(slot, _)| self.started(base, index, *slot).serial);
        let waits = |start: &Start| start.play.layer == layer && start.machine().is_some();
        if newest.is_none() && self.scheduled.of(index).any(|(_, start)| waits(start)) {
            return Err(Error::BadStateMachine(MachineFault::NotStarted { layer }));
        }
        newest.map(|(_, instance)| instance).ok_or_else(|| no_machine(layer))
    }

    /// Returns the name of the state that an instance on `layer` is in, after `running`.
    pub(crate) fn state_name(
        &self,
        base: &Base,
        layer: usize,
        instance: u32,
        running: Running,
    ) -> Result<Arc<str>, Error> {
        let row = base.tables.machine_instance(instance)?;
        // An instance that no frame has run is in its first state.
        let state =
            if running.epoch == row.epoch { running.state.wrapping_sub(row.state) } else { 0 };
        let machine = self.machines.of_state(row.state).ok_or_else(|| no_machine(layer))?;
        let state = machine.states.get(state as usize).ok_or_else(|| no_machine(layer))?;
        Ok(Arc::clone(&state.name))
    }

    fn bind_machine(
        &mut self,
        base: &mut Base,
        character: CharacterId,
        index: u32,
    ) -> Result<u32, Error> {
        let body = base.character_state(character)?.body;
        if let Some(&state) = self.machines.bound.get(&(body, index)) {
            return Ok(state);
        }
        let states = &self.machines.all[index].states;
        let states: Vec<_> =
            states.iter().map(|state| (state.clip, state.partial, state.rows.clone())).collect();
        let mut rows = Vec::with_capacity(states.len());
        for (clip, partial, mut row) in states {
            row.slot.bound_clip = base.bind(character, clip, partial)?;
            rows.push(row);
        }
        let state = base.tables.add_states(body, &rows)?;
        self.machines.bound.insert((body, index), state);
        self.machines.by_state.insert(state, (body, index));
        Ok(state)
    }

    pub(crate) fn begin_machine(
        &mut self,
        base: &mut Base,
        member_index: u32,
        start: &Start,
        (state, parameters): (u32, [f32; MACHINE_PARAMETERS as usize]),
        tick: u64,
    ) -> Result<(), Error> {
        let Playback { layer, fade_in_secs: secs, weight, .. } = start.play;
        if secs <= 0.0 {
            self.fade_out(base, member_index, layer, 0.0, tick)?;
        }
        let plan = |slot: &Slot, _| {
            if slot.layer() as usize == layer { Plan::Leaves } else { Plan::Apart }
        };
        if let Some(due) = self.free_slots(base, member_index, 2, secs, tick, plan)? {
            self.scheduled.push(member_index, due, start.at_its_time());
            return Ok(());
        }
        let secs = if self.is_first(base, member_index, layer, tick) { 0.0 } else { secs };
        self.fade_out(base, member_index, layer, secs, tick)?;
        self.forget_space(member_index, layer);
        let machine_instance = base.tables.add_machine_instance(state, tick, parameters)?;
        let started = Started { serial: start.serial, sample: None, once: false };
        let mut taken = None;
        for which in 0..2 {
            let mut slot = Slot::machine(machine_instance, which, tick).on_layer(u32_from(layer));
            slot.ramp_weight(tick, 0.0, 0.5 * weight, secs);
            // At weight 0 the first slot is free for others, but not for the second.
            let index = self.free_slot_beside(base, member_index, taken, tick).unwrap_or(0);
            self.put_slot(base, member_index, index, &slot, started, tick)?;
            taken = Some(index);
        }
        Ok(())
    }
}

/// Sets a parameter of the machines that a member runs. `index_in` finds it in the machine whose
/// states begin at a row. Returns whether any machine has it.
fn write_running(
    base: &mut Base,
    member_index: u32,
    value: f32,
    mut index_in: impl FnMut(u32) -> Option<u32>,
) -> Result<bool, Error> {
    let tick = base.clock.tick;
    let (mut is_found, mut before) = (false, None);
    for slot in base.tables.slot_range(member_index) {
        let slot = &base.tables.slots().as_slice()[slot];
        let Some(instance) = slot.machine_instance() else { continue };
        // Both slots of a machine name one instance.
        if before == Some(instance) || faded_out(slot, tick) {
            continue;
        }
        before = Some(instance);
        if let Some(index) = index_in(base.tables.machine_instance(instance)?.state) {
            base.tables.set_machine_parameter(instance, index, value)?;
            is_found = true;
        }
    }
    Ok(is_found)
}

/// Refuses a parameter of another crowd.
fn check_parameter(base: &Base, id: ParameterId) -> Result<(), Error> {
    let Key { crowd, index, .. } = id.parts().machine.parts();
    base.check_crowd(IdKind::Machine, crowd, index)
}

fn no_machine(layer: usize) -> Error {
    Error::BadStateMachine(MachineFault::NoMachine { layer })
}

#[cfg(test)]
mod tests;
