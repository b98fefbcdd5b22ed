//! State machines: where each goes in a frame, and what its two slots then play; the twin of
//! `kernels/machines.cl`.

use populace_device::Tables;
use populace_device::layout::{
    CONDITION_ABOVE, CONDITION_BELOW, Condition, Float4, MACHINE_PARAMETERS, MachineInstance, NONE,
    Running, SLOT_MACHINE, SLOT_MODE_BITS, Slot,
};
use rayon::prelude::*;

/// Lets every machine take a transition that holds, one at most.
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
            *at = next(tables, parameters, begun(machine_instance, at), tick)
        });
}

/// Where a machine instance is; another one's place is its own start.
fn begun(machine_instance: &MachineInstance, at: &Running) -> Running {
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

fn next(tables: &Tables, parameters: &[f32], at: Running, tick: u64) -> Running {
    let elapsed = tick.saturating_sub(at.entry_tick);
    if elapsed < u64::from(at.fade_ticks) {
        return at;
    }
    let state = &tables.machine_states().as_slice()[at.state as usize];
    let first = state.transition_first as usize;
    let mut ways =
        tables.transitions().as_slice()[first..first + state.transition_count as usize].iter();
    let taken = ways.find(|way| {
        let first = way.condition_first as usize;
        let conditions =
            &tables.conditions().as_slice()[first..first + way.condition_count as usize];
        conditions.iter().all(|condition| holds(condition, parameters, elapsed))
    });
    taken.map_or(at, |way| Running {
        entry_tick: tick,
        previous_tick: at.entry_tick,
        state: way.to,
        previous: at.state,
        which: 1 - at.which,
        fade_ticks: way.fade_ticks,
        fade_rate: way.fade_rate,
        ..at
    })
}

fn holds(condition: &Condition, parameters: &[f32], elapsed: u64) -> bool {
    match condition.kind {
        CONDITION_ABOVE => parameters[condition.parameter as usize] > condition.value,
        CONDITION_BELOW => parameters[condition.parameter as usize] < condition.value,
        _ => elapsed >= condition.ticks,
    }
}

/// A slot, or in place of a machine's the one that it stands for, with the product of both weights.
#[inline(always)]
pub(crate) fn slot_now(tables: &Tables, running: &[Float4], slot: &Slot, tick: u64) -> Slot {
    if slot.mode() == SLOT_MACHINE {
        machine_slot(tables, running, slot, slot.weight_at(tick))
    } else {
        *slot
    }
}

/// The slot that one of a machine stands for where that weighs so much.
#[inline(never)]
pub(crate) fn machine_slot(tables: &Tables, running: &[Float4], slot: &Slot, weight: f32) -> Slot {
    let index = (slot.bound_clip >> 1) as usize;
    let machine_instance = &tables.machine_instances().as_slice()[index];
    // One that no frame has run yet can be read all the same.
    let at = bytemuck::cast_slice::<_, Running>(running).get(index).copied().unwrap_or_default();
    let at = begun(machine_instance, &at);
    let is_current = slot.bound_clip & 1 == at.which;
    let (state, start_tick) =
        if is_current { (at.state, at.entry_tick) } else { (at.previous, at.previous_tick) };
    let Some(state) = tables.machine_states().as_slice().get(state as usize) else {
        return Slot { bound_clip: NONE, ..*slot };
    };
    // Each of the two has half the machine's weight.
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
