//! Playback: slots, layers and state machines.

use super::*;

device_struct! {
    /// A clip playing on a member, in closed form: devices evaluate it from the clock and never
    /// write it.
    ///
    /// Fields by mode:
    ///
    /// | Field | Mode | Bits | Content |
    /// |---|---|---|---|
    /// | `start_tick` | all | 0 to 63 | clock tick at which the slot begins |
    /// | `phase_rate` | loop, once | 0 to 63 | phase per tick, 2^-64 cycles, two's complement |
    /// | | live | 0 to 63 | delay in ticks ([`Slot::delay_ticks`]) |
    /// | `start_phase` | loop | 0 to 31 | phase at `start_tick`, 2^-32 cycles |
    /// | | held | 0 to 31 | `f32`: time on the clip's own axis ([`Slot::held_secs`]) |
    /// | `bound_clip` | machine | 0 | which of the machine's two slots |
    /// | | machine | 1 to 31 | index into `machine_instances` ([`Slot::machine_instance`]) |
    /// | | others | 0 to 31 | index into `bound_clips` |
    /// | | all | 0 to 31 | [`NONE`]: the slot is empty |
    /// | `layer_and_mode` | all | 0 to 7 | mode ([`SLOT_MODE_BITS`]) |
    /// | | all | 8 to 31 | layer |
    ///
    /// Modes are [`SLOT_LOOP`], [`SLOT_ONCE`], [`SLOT_HELD`], [`SLOT_LIVE`], [`SLOT_MACHINE`] and
    /// [`SLOT_INERTIALIZATION`]. Fields not listed for a mode are 0. A slot of the last mode is
    /// read as an [`InertializationSlot`], which has the same bytes: see
    /// [`Slot::as_inertialization`]. It shares `start_tick`, `bound_clip` and `layer_and_mode` with
    /// this type.
    ///
    /// The phase is a 64-bit fraction of the cycle, `(start_phase << 32) + elapsed * phase_rate`,
    /// wrapping. It is exact for all time and equal on every device. [`SLOT_ONCE`] ends when
    /// `elapsed * |phase_rate|` reaches a cycle, that is when the upper half of the 128-bit product
    /// is not 0. It begins at the clip's start, or at its end if `phase_rate` is negative.
    pub struct Slot {
        /// Clock tick at which the slot begins.
        pub start_tick: u64,
        /// Phase per tick in 2^-64 of a cycle, two's complement; a negative rate plays backwards.
        /// Other modes: see the table above.
        pub phase_rate: u64,
        /// Clock tick at which the weight begins to change.
        pub weight_tick: u64,
        /// [`SLOT_LOOP`]: phase at `start_tick` in 2^-32 of a cycle. Other modes: see the table
        /// above.
        pub start_phase: u32,
        /// Index into `bound_clips`, or [`NONE`] for an empty slot. [`SLOT_MACHINE`]: see the table
        /// above. [`SLOT_INERTIALIZATION`]: the outgoing clip.
        pub bound_clip: u32,
        /// The `SLOT_` mode in the low [`SLOT_MODE_BITS`], the layer in the bits above.
        pub layer_and_mode: u32,
        /// Weight up to `weight_tick`.
        pub start_weight: f32,
        /// Change of the weight per second; 0 if the weight is `end_weight` from `weight_tick` on.
        pub weight_rate: f32,
        /// Weight at which the ramp ends.
        pub end_weight: f32,
    }
}

device_struct! {
    /// A [`Slot`] of [`SLOT_INERTIALIZATION`]: the difference between an outgoing clip and the clip
    /// that replaced it at once. The difference decays by itself over the duration.
    ///
    /// Bytes, and the field of [`Slot`] in the same place:
    ///
    /// | Bytes | Field | Field of `Slot` |
    /// |---|---|---|
    /// | 0 to 7 | `start_tick` | `start_tick`, with the same meaning |
    /// | 8 to 11 | `outgoing_row` | `phase_rate`, bits 0 to 31 |
    /// | 12 to 15 | `outgoing_pace` | `phase_rate`, bits 32 to 63 |
    /// | 16 to 19 | `incoming_row` | `weight_tick`, bits 0 to 31 |
    /// | 20 to 23 | `incoming_pace` | `weight_tick`, bits 32 to 63 |
    /// | 24 to 27 | `incoming_clip` | `start_phase` |
    /// | 28 to 31 | `outgoing_clip` | `bound_clip`, with the same meaning |
    /// | 32 to 35 | `layer_and_mode` | `layer_and_mode`, with the same meaning |
    /// | 36 to 39 | `share` | `start_weight` |
    /// | 40 to 43 | `share_change` | `weight_rate` |
    /// | 44 to 47 | `per_tick` | `end_weight` |
    ///
    /// `layer_and_mode` is the only packed word:
    ///
    /// | Bits | Content |
    /// |---|---|
    /// | 0 to 7 | [`SLOT_INERTIALIZATION`] ([`SLOT_MODE_BITS`]) |
    /// | 8 to 31 | layer |
    ///
    /// *Row* is fractional. *Pace* is the clip's motion over the duration of the inertialization,
    /// in multiples of the difference between that row and the far row
    /// ([`far_row`](crate::far_row)).
    pub struct InertializationSlot {
        /// Clock tick of the transition.
        pub start_tick: u64,
        /// Row of the outgoing clip at the transition.
        pub outgoing_row: f32,
        /// Pace of the outgoing clip at the transition.
        pub outgoing_pace: f32,
        /// Row of the incoming clip at the transition.
        pub incoming_row: f32,
        /// Pace of the incoming clip at the transition.
        pub incoming_pace: f32,
        /// The incoming clip: index into `bound_clips`.
        pub incoming_clip: u32,
        /// The outgoing clip: index into `bound_clips`, or [`NONE`] for an empty slot.
        pub outgoing_clip: u32,
        /// [`SLOT_INERTIALIZATION`] and the layer; see the table above.
        pub layer_and_mode: u32,
        /// Share of the outgoing clip in the layer's mix.
        pub share: f32,
        /// Change of that share over the duration.
        pub share_change: f32,
        /// 1 / duration in ticks.
        pub per_tick: f32,
    }
}

const _: () = {
    use std::mem::offset_of;
    assert!(size_of::<Slot>() == 48 && size_of::<InertializationSlot>() == 48);
    assert!(align_of::<Slot>() == align_of::<InertializationSlot>());
    assert!(offset_of!(Slot, start_tick) == offset_of!(InertializationSlot, start_tick));
    assert!(offset_of!(Slot, bound_clip) == offset_of!(InertializationSlot, outgoing_clip));
    assert!(offset_of!(Slot, layer_and_mode) == offset_of!(InertializationSlot, layer_and_mode));
};

device_struct! {
    /// A state of a state machine for members of one body: the part of a [`Slot`] that is the same
    /// each time the state is entered.
    pub struct MachineState {
        /// As [`Slot::phase_rate`].
        pub phase_rate: u64,
        /// As [`Slot::start_phase`].
        pub start_phase: u32,
        /// Index into `bound_clips`.
        pub bound_clip: u32,
        /// A `SLOT_` mode.
        pub mode: u32,
        /// Offset into `transitions`: the outgoing transitions. The first whose conditions hold is
        /// taken.
        pub transition_first: u32,
        /// Number of outgoing transitions.
        pub transition_count: u32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// A transition out of a state.
    pub struct Transition {
        /// Index into `machine_states`: the state entered.
        pub to: u32,
        /// Offset into `conditions`; all of them must hold.
        pub condition_first: u32,
        /// Number of conditions.
        pub condition_count: u32,
        /// Duration of the crossfade in ticks.
        pub fade_ticks: u32,
        /// Weight that the new state gains per second; 0 if `fade_ticks` is 0.
        pub fade_rate: f32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// A condition of a transition.
    pub struct Condition {
        /// [`CONDITION_AFTER`]: ticks since the state was entered.
        pub ticks: u64,
        /// A `CONDITION_` constant.
        pub kind: u32,
        /// Index of the machine's parameter.
        pub parameter: u32,
        /// Value that the parameter is compared with.
        pub value: f32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// A state machine that runs on a member.
    pub struct MachineInstance {
        /// Clock tick at which it began.
        pub start_tick: u64,
        /// Index into `machine_states`: the initial state, or [`NONE`] for an unused entry.
        pub state: u32,
        /// Identifies the owner; never 0. A [`Running`] with another epoch belongs to an earlier
        /// owner and is ignored.
        pub epoch: u32,
    }
}

device_struct! {
    /// The current state of a [`MachineInstance`], written by devices once per frame. It results
    /// from whole ticks and comparisons only, so it is the same on all devices.
    pub struct Running {
        /// Clock tick at which the current state was entered.
        pub entry_tick: u64,
        /// Clock tick at which the previous state was entered.
        pub previous_tick: u64,
        /// Index into `machine_states`: the current state.
        pub state: u32,
        /// Index into `machine_states`: the previous state, which fades out; [`NONE`] in the
        /// initial state.
        pub previous: u32,
        /// Which of the machine's two slots plays the current state, 0 or 1; the other slot plays
        /// the previous state.
        pub which: u32,
        /// Duration in ticks of the crossfade from the previous state.
        pub fade_ticks: u32,
        /// Weight that the current state gains per second.
        pub fade_rate: f32,
        /// [`MachineInstance::epoch`] at the time of writing. If it differs, the machine restarts.
        pub epoch: u32,
        /// Zero.
        pub unused0: u32,
        /// Zero.
        pub unused1: u32,
    }
}

device_struct! {
    /// One layer of a member.
    pub struct Layer {
        /// Weight from 0 to 1; ignored for layer 0.
        pub weight: f32,
        /// Bit 31: [`LAYER_ADDITIVE`]. Bits 0 to 30 ([`LAYER_MASK`]): offset into `masks` of a
        /// weight per joint; all bits set means all joints.
        pub mask_and_mode: u32,
    }
}

device_struct! {
    /// Result of the Evaluate stage for one slot: two neighbouring rows, the position between them,
    /// and the weight.
    pub struct SlotSample {
        /// Word offset into `rows`: the row at or before the time.
        pub row0: u32,
        /// Word offset into `rows`: the row after it.
        pub row1: u32,
        /// Position between the rows: 0 at `row0`, 1 at `row1`.
        pub between: f32,
        /// The slot's current weight; 0 if the slot is empty.
        pub weight: f32,
    }
}
