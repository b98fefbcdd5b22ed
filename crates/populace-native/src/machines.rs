//! State machines: the transitions that they take, and the clips that their slots play. Twin of
//! `kernels/machines.cl`.
//!
//! [`advance`] reads machine instances, their parameters, machine states, transitions and
//! conditions, and writes the state of each instance (`running`). [`slot_now`] reads that state.

use populace_device::Tables;
use populace_device::layout::{
    CONDITION_ABOVE, CONDITION_BELOW, Condition, Float4, MACHINE_PARAMETERS, MachineInstance, NONE,
    Running, SLOT_MACHINE, SLOT_MODE_BITS, Slot,
};
use rayon::prelude::*;

/// Returns an instance's state; its start state if the stored one belongs to an earlier instance.
pub(crate) fn started(machine_instance: &MachineInstance, at: &Running) -> Running {
    if at.epoch == machine_instance.epoch {
        return *at;
    }
    let (entry_tick, state) = (machine_instance.start_tick, machine_instance.state);
    Running {
        entry_tick,
        state,
        previous: NONE,
        epoch: machine_instance.epoch,
        ..Running::default()
    }
}

/// Returns the slot that plays in place of a machine's slot, for a machine slot of this weight.
#[inline(never)]
pub(crate) fn machine_slot(tables: &Tables, running: &[Float4], slot: &Slot, weight: f32) -> Slot {
    let index = (slot.bound_clip >> 1) as usize;
    let machine_instance = &tables.machine_instances().as_slice()[index];
    // An instance may be read before its first frame.
    let at = bytemuck::cast_slice::<_, Running>(running).get(index).copied().unwrap_or_default();
    let at = started(machine_instance, &at);
    let is_current = slot.bound_clip & 1 == at.which;
    let (state, start_tick) =
        if is_current { (at.state, at.entry_tick) } else { (at.previous, at.previous_tick) };
    let Some(state) = tables.machine_states().as_slice().get(state as usize) else {
        return Slot { bound_clip: NONE, ..*slot };
    };
    // Each of the two slots has half of the machine's weight.
    let whole = 2.0 * weight;
    let rate = whole * at.fade_rate;
    Slot {
        start_tick,
        phase_rate: state.phase_rate,
        weight_tick: at.entry_tick,
        start_phase: state.start_phase,
        bound_clip: state.bound_clip,
        layer_and_mode: slot.layer() << SLOT_MODE_BITS | state.mode,
        start_weight: if is_current && rate > 0.0 { 0.0 } else { whole },
        weight_rate: if is_current { rate } else { -rate },
        end_weight: if is_current { whole } else { 0.0 },
    }
}

/// Returns the slot as it is, or for a machine's slot the one that plays in its place.
#[inline(always)]
pub(crate) fn slot_now(tables: &Tables, running: &[Float4], slot: &Slot, tick: u64) -> Slot {
    if slot.mode() == SLOT_MACHINE {
        machine_slot(tables, running, slot, slot.weight_at(tick))
    } else {
        *slot
    }
}

/// Returns whether a condition holds, `elapsed` ticks after the state was entered.
fn condition_holds(condition: &Condition, parameters: &[f32], elapsed: u64) -> bool {
    match condition.kind {
        CONDITION_ABOVE => parameters[condition.parameter as usize] > condition.value,
        CONDITION_BELOW => parameters[condition.parameter as usize] < condition.value,
        _ => elapsed >= condition.ticks,
    }
}

/// Takes the first transition of each machine whose conditions all hold.
pub(crate) fn advance(tables: &Tables, tick: u64, running: &mut [Float4]) {
    let parameters =
        tables.machine_parameters().as_slice().as_chunks::<{ MACHINE_PARAMETERS as usize }>().0;
    bytemuck::cast_slice_mut::<_, Running>(running)
        .par_iter_mut()
        .zip(tables.machine_instances().as_slice())
        .zip(parameters)
        .with_min_len(1024)
        .filter(|((_, machine_instance), _)| machine_instance.state != NONE)
        .for_each(|((at, machine_instance), parameters)| {
            *at = next(tables, parameters, started(machine_instance, at), tick)
        });
}

/// Returns an instance's state after this frame. During a crossfade it takes no other transition.
fn next(tables: &Tables, parameters: &[f32], at: Running, tick: u64) -> Running {
    let elapsed = tick.saturating_sub(at.entry_tick);
    if elapsed < u64::from(at.fade_ticks) {
        return at;
    }
    let state = &tables.machine_states().as_slice()[at.state as usize];
    let first = state.transition_first as usize;
    let mut transitions =
        tables.transitions().as_slice()[first..first + state.transition_count as usize].iter();
    let taken = transitions.find(|transition| {
        let first = transition.condition_first as usize;
        let conditions =
            &tables.conditions().as_slice()[first..first + transition.condition_count as usize];
        conditions.iter().all(|condition| condition_holds(condition, parameters, elapsed))
    });
    taken.map_or(at, |transition| Running {
        entry_tick: tick,
        previous_tick: at.entry_tick,
        state: transition.to,
        previous: at.state,
        which: 1 - at.which,
        fade_ticks: transition.fade_ticks,
        fade_rate: transition.fade_rate,
        ..at
    })
}
