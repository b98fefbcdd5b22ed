//! State machines: states, transitions, and the machines that run on members.

use populace_clip::ticks_from_secs;
use populace_model::convert::u32_from;

use super::runs::{Asset, Runs};
use super::{BodyIndex, Space, Tables};
use crate::Error;
use crate::layout::{
    self, CONDITION_ABOVE, CONDITION_AFTER, CONDITION_BELOW, Float4, MACHINE_PARAMETERS,
    MachineInstance, Member, NONE, RUNNING_ELEMENTS, Running, Slot,
};

const PARAMETERS: usize = MACHINE_PARAMETERS as usize;
/// Maximum number of machine instances. A slot stores `2 * instance + which`, which must not equal
/// [`NONE`].
const MAX_INSTANCES: usize = (NONE / 2) as usize;
const FREE: MachineInstance = MachineInstance { start_tick: 0, state: NONE, epoch: 0 };

impl Running {
    /// Reads the struct from its elements in a device buffer.
    #[must_use]
    pub fn from_elements(elements: [Float4; RUNNING_ELEMENTS as usize]) -> Self {
        bytemuck::cast(elements)
    }
}

/// A state of a machine, for members of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineState {
    /// Playback of the state's bound clip. The slot's start tick, weight and layer are ignored.
    pub slot: Slot,
    /// Outgoing transitions; the first whose conditions hold is taken.
    pub transitions: Vec<Transition>,
}

/// A transition out of a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Transition {
    /// Index of the machine's state that it leads to.
    pub to: usize,
    /// Duration of the crossfade in seconds; less than one tick is a cut.
    pub fade_secs: f32,
    /// Conditions, all of which must hold.
    pub conditions: Vec<Condition>,
}

/// A condition of a transition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// The parameter of this index is above the value.
    Above(u32, f32),
    /// The parameter of this index is below the value.
    Below(u32, f32),
    /// At least this many ticks have passed since the state was entered.
    After(u64),
}

impl Condition {
    fn row(self) -> layout::Condition {
        let row = layout::Condition::default();
        match self {
            Self::Above(parameter, value) => {
                layout::Condition { kind: CONDITION_ABOVE, parameter, value, ..row }
            }
            Self::Below(parameter, value) => {
                layout::Condition { kind: CONDITION_BELOW, parameter, value, ..row }
            }
            Self::After(ticks) => layout::Condition { kind: CONDITION_AFTER, ticks, ..row },
        }
    }
}

/// Allocation of machine instances.
#[derive(Clone, Debug)]
pub(super) struct InstanceSpace {
    space: Space,
    /// Number of slots that refer to each machine instance.
    uses: Vec<u32>,
    epoch: u32,
}

impl InstanceSpace {
    pub(super) fn new() -> Self {
        Self { space: Space::new(usize::MAX), uses: Vec::new(), epoch: 0 }
    }

    /// Returns the number of the last instance.
    pub(super) const fn last_epoch(&self) -> u32 {
        self.epoch
    }

    /// Gives the next instances numbers after this one.
    pub(super) fn continue_after(&mut self, epoch: u32) {
        self.epoch = self.epoch.max(epoch);
    }
}

fn bad(what: &'static str, value: u32) -> Error {
    Error::BadPlayback { what, value }
}

impl Tables {
    /// Adds the states of a machine for members of `body` and returns the index of the first.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if a clip is not bound to the body or does not allow its playback
    /// mode, or if a transition names a missing state or parameter; [`Error::TooLarge`] if offsets
    /// exceed 32 bits.
    pub fn add_states(&mut self, body: BodyIndex, states: &[MachineState]) -> Result<u32, Error> {
        let of_body = Member { body: body.0, ..Member::default() };
        for state in states {
            if state.slot.bound_clip == NONE {
                return Err(bad("bound clip", NONE));
            }
            self.check_bound(&state.slot, &of_body)?;
            for transition in &state.transitions {
                check_transition(transition, states.len())?;
            }
        }
        self.add_asset(Asset::States, |tables, runs| {
            let free = layout::MachineState { bound_clip: NONE, ..Default::default() };
            let first = runs.add(&mut tables.all.machine_states, vec![free; states.len()])?;
            for (index, state) in (first as usize..).zip(states) {
                let transitions = state.transitions.iter();
                let transitions: Result<Vec<_>, _> =
                    transitions.map(|t| tables.transition_row(first, t, runs)).collect();
                let transition_first = runs.add(&mut tables.all.transitions, transitions?)?;
                let row = layout::MachineState {
                    phase_rate: state.slot.phase_rate,
                    start_phase: state.slot.start_phase,
                    bound_clip: state.slot.bound_clip,
                    mode: state.slot.mode(),
                    transition_first,
                    transition_count: u32_from(state.transitions.len()),
                    unused: 0,
                };
                tables.all.machine_states.set(index, row);
            }
            Ok(first)
        })
    }

    fn transition_row(
        &mut self,
        state_first: u32,
        transition: &Transition,
        runs: &mut Runs,
    ) -> Result<layout::Transition, Error> {
        let rows = transition.conditions.iter().map(|condition| condition.row());
        let condition_first = runs.add(&mut self.all.conditions, rows)?;
        let ticks = ticks_from_secs(f64::from(transition.fade_secs));
        Ok(layout::Transition {
            to: state_first + u32_from(transition.to),
            condition_first,
            condition_count: u32_from(transition.conditions.len()),
            fade_ticks: u32::try_from(ticks).unwrap_or(u32::MAX),
            fade_rate: if ticks > 0 { 1.0 / transition.fade_secs } else { 0.0 },
            unused: 0,
        })
    }

    /// Allocates a machine instance that begins in `state` at `tick`. Two slots must then refer to
    /// it (see [`Slot::machine`]). It is freed when no slot refers to it any more.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the state does not exist; [`Error::TooLarge`] if offsets exceed 31
    /// bits.
    pub fn add_machine_instance(
        &mut self,
        state: u32,
        tick: u64,
        parameters: [f32; PARAMETERS],
    ) -> Result<u32, Error> {
        if state as usize >= self.all.machine_states.len() {
            return Err(bad("state", state));
        }
        let InstanceSpace { space, uses, epoch } = &mut self.instance_space;
        let count = space.end_with(1);
        if count > MAX_INSTANCES {
            return Err(Error::TooLarge {
                what: "the state machines",
                count,
                limit: MAX_INSTANCES,
            });
        }
        let (index, _) = space.take(1);
        uses.resize(uses.len().max(index + 1), 0);
        *epoch = epoch.wrapping_add(1).max(1);
        let machine_instance = MachineInstance { start_tick: tick, state, epoch: *epoch };
        self.all.machine_instances.grow(index + 1, FREE);
        self.all.machine_instances.set(index, machine_instance);
        self.all.machine_parameters.grow((index + 1) * PARAMETERS, 0.0);
        self.all.machine_parameters.set_run(index * PARAMETERS, &parameters);
        Ok(u32_from(index))
    }

    /// Sets one parameter of a machine instance.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the machine instance or the parameter does not exist.
    pub fn set_machine_parameter(
        &mut self,
        machine_instance: u32,
        parameter: u32,
        value: f32,
    ) -> Result<(), Error> {
        self.machine_instance(machine_instance)?;
        if parameter >= MACHINE_PARAMETERS {
            return Err(bad("parameter", parameter));
        }
        let index = machine_instance as usize * PARAMETERS + parameter as usize;
        if self.all.machine_parameters.as_slice()[index].to_bits() != value.to_bits() {
            self.all.machine_parameters.set(index, value);
        }
        Ok(())
    }

    /// Returns a state machine that runs on a member.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the machine instance does not exist.
    pub fn machine_instance(&self, machine_instance: u32) -> Result<MachineInstance, Error> {
        let found = self
            .all
            .machine_instances
            .as_slice()
            .get(machine_instance as usize)
            .filter(|found| found.state != NONE);
        found.copied().ok_or_else(|| bad("state machine", machine_instance))
    }

    /// Elements of [`StageBuffer::Running`](crate::StageBuffer::Running), up to the last one in
    /// use.
    #[must_use]
    pub fn running_elements(&self) -> usize {
        self.all.machine_instances.len() * RUNNING_ELEMENTS as usize
    }

    /// Checks that a slot refers to an existing machine instance of the member's body.
    pub(super) fn check_machine_instance(&self, slot: &Slot, member: &Member) -> Result<(), Error> {
        let index = slot.bound_clip >> 1;
        let state = self.machine_instance(index)?.state as usize;
        let clip = self.all.machine_states.as_slice()[state].bound_clip as usize;
        let body = self.all.bound_clips.as_slice()[clip].body;
        if body == member.body { Ok(()) } else { Err(bad("state machine", index)) }
    }

    /// Updates use counts when a slot changes its machine instance from `before` to `now`, and
    /// frees an instance without uses.
    pub(super) fn update_instance_uses(&mut self, before: Option<u32>, now: Option<u32>) {
        if before == now {
            return;
        }
        let InstanceSpace { space, uses, .. } = &mut self.instance_space;
        if let Some(machine_instance) = now {
            uses[machine_instance as usize] += 1;
        }
        if let Some(machine_instance) = before.map(|machine_instance| machine_instance as usize) {
            uses[machine_instance] -= 1;
            if uses[machine_instance] == 0 {
                space.release((machine_instance, 1));
                self.all.machine_instances.set(machine_instance, FREE);
                self.all.machine_instances.truncate(space.end());
                self.all.machine_parameters.truncate(space.end() * PARAMETERS);
            }
        }
    }
}

fn check_transition(transition: &Transition, states: usize) -> Result<(), Error> {
    if transition.to >= states {
        return Err(bad("state", u32::try_from(transition.to).unwrap_or(NONE)));
    }
    for condition in &transition.conditions {
        if let Condition::Above(parameter, _) | Condition::Below(parameter, _) = *condition
            && parameter >= MACHINE_PARAMETERS
        {
            return Err(bad("parameter", parameter));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use populace_clip::Clip;
    use populace_model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track, Trs};
    use populace_retarget::Binding;

    /// Two bodies with one member each, and for the first body a machine with one looping state.
    fn tables() -> (Tables, [u32; 2], u32) {
        let joint = JointSource { name: "hips".into(), parent: None, rest: Trs::IDENTITY };
        let skeleton = Skeleton::new(&[joint]).unwrap();
        let track = Track {
            joint: "hips".into(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0],
            values: vec![0.0; 6],
        };
        let source = ClipSource { name: "stand".into(), tracks: vec![track] };
        let clip = Clip::new(source, &skeleton).unwrap();
        let mut tables = Tables::new(4);
        let bodies = [(); 2].map(|()| tables.add_body(&skeleton, &[]).unwrap());
        let clip_index = tables.add_clip(&clip).unwrap();
        let binding = Binding::new(&clip, &skeleton);
        let bound = tables.add_bound_clip(clip_index, bodies[0], &binding).unwrap();
        let slot = Slot::looping(bound, 0, 1.0, 0.0, 1.0);
        let states =
            tables.add_states(bodies[0], &[MachineState { slot, transitions: vec![] }]).unwrap();
        let members = bodies.map(|body| tables.add_member(body).unwrap());
        (tables, members, states)
    }

    #[test]
    fn machine_instance_is_freed_with_its_last_slot() {
        let (mut tables, [member, other], state) = tables();
        let machine_instance = tables.add_machine_instance(state, 9, [0.5; PARAMETERS]).unwrap();
        for which in [0, 1] {
            tables
                .set_slot(member, which, &Slot::machine(machine_instance, u32_from(which), 9))
                .unwrap();
        }
        // A machine of another body.
        tables.set_slot(other, 0, &Slot::machine(machine_instance, 0, 9)).unwrap_err();
        tables.set_slot(member, 0, &Slot::machine(machine_instance + 1, 0, 9)).unwrap_err();
        let epoch = tables.machine_instance(machine_instance).unwrap().epoch;
        tables
            .set_slot(member, 0, &Slot::machine(machine_instance, 0, 9).with_weight(0.2))
            .unwrap();
        tables.set_slot(member, 1, &Slot { bound_clip: NONE, ..Slot::default() }).unwrap();
        assert_eq!(tables.running_elements(), 3, "one slot refers to it");
        tables.remove_member(member);
        assert_eq!((tables.running_elements(), tables.machine_parameters().len()), (0, 0));
        tables.set_machine_parameter(machine_instance, 0, 1.0).unwrap_err();
        assert_eq!(tables.add_machine_instance(state, 10, [0.0; PARAMETERS]), Ok(machine_instance));
        assert_ne!(
            tables.machine_instance(machine_instance).unwrap().epoch,
            epoch,
            "its index has another owner"
        );
    }

    #[test]
    fn parameters_change_alone_and_indices_are_checked() {
        let (mut tables, _, state) = tables();
        let machine_instance = tables.add_machine_instance(state, 9, [0.0; PARAMETERS]).unwrap();
        tables.mark_clean();
        tables.set_machine_parameter(machine_instance, 3, 0.5).unwrap();
        tables.set_machine_parameter(machine_instance, 4, 0.0).unwrap();
        assert_eq!(tables.machine_parameters().changed().collect::<Vec<_>>(), [3]);
        assert_eq!(tables.machine_instances().changed().count(), 0);
        tables.set_machine_parameter(machine_instance, MACHINE_PARAMETERS, 0.5).unwrap_err();
        tables.add_machine_instance(state + 1, 9, [0.0; PARAMETERS]).unwrap_err();
        let slot = Slot::looping(0, 0, 1.0, 0.0, 1.0);
        let with = |slot, to, condition| {
            let transition = Transition { to, fade_secs: 0.1, conditions: vec![condition] };
            [MachineState { slot, transitions: vec![transition] }]
        };
        let unbound = Slot { bound_clip: NONE, ..slot };
        for states in [
            with(unbound, 0, Condition::After(1)),
            with(slot, 1, Condition::After(1)),
            with(slot, 0, Condition::Above(MACHINE_PARAMETERS, 0.0)),
        ] {
            tables.add_states(BodyIndex(0), &states).unwrap_err();
        }
        tables.add_states(BodyIndex(1), &with(slot, 0, Condition::After(1))).unwrap_err();
        tables.add_states(BodyIndex(0), &with(slot, 0, Condition::After(1))).unwrap();
    }
}
