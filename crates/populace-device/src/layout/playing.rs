//! What members play: slots, layers and state machines.

use super::*;

device_struct! {
    /// One playing clip of a member, in closed form: devices evaluate it from the clock and never
    /// write it.
    ///
    /// The phase is a 64-bit fraction of the clip's cycle, `start_phase + elapsed * phase_rate`,
    /// wrapping: exact for all time, and equal on every device. [`SLOT_ONCE`] is at its end when
    /// `elapsed * |phase_rate|` fills a cycle, which the upper half of the 128-bit product tells.
    pub struct Slot {
        /// The clock when the slot began.
        pub start_tick: u64,
        /// Phase per tick, in 2^-64 of the clip's length, two's complement: negative plays
        /// backwards. [`SLOT_LIVE`]: how many ticks ago is shown. [`SLOT_INERTIALIZATION`]: how the
        /// clip stood when it was left, two floats: in the lower half where in its rows, in the
        /// upper how many times the way to the far row ([`far_row`](crate::far_row)) it would have
        /// gone while the slot inertializes.
        pub phase_rate: u64,
        /// The clock when the weight began to move. [`SLOT_INERTIALIZATION`]: how the clip stood
        /// that took this one's place, alike.
        pub weight_tick: u64,
        /// [`SLOT_LOOP`]: the phase at `start_tick`, in 2^-32 of the clip's length. [`SLOT_HELD`]: the bits of the
        /// time that the slot stands at, a single-precision number of seconds on the clip's own
        /// axis. [`SLOT_ONCE`] begins at the clip's start, or at its end where it plays backwards,
        /// and has zero here.
        /// [`SLOT_INERTIALIZATION`]: into `bound_clips`, the clip that took this one's place.
        pub start_phase: u32,
        /// Into `bound_clips`, or [`NONE`] for an empty slot.
        pub bound_clip: u32,
        /// The `SLOT_` mode in the lower [`SLOT_MODE_BITS`], above them the layer that the slot is
        /// mixed in.
        pub layer_and_mode: u32,
        /// Weight up to `weight_tick`. [`SLOT_INERTIALIZATION`]: the clip's part of what the layer
        /// showed.
        pub start_weight: f32,
        /// Weight per second; 0 where it is at its end from `weight_tick` on.
        /// [`SLOT_INERTIALIZATION`]: by how much that part would have changed while the slot
        /// inertializes.
        pub weight_rate: f32,
        /// Where the weight stops. [`SLOT_INERTIALIZATION`]: 1 divided by the ticks that it
        /// inertializes in.
        pub end_weight: f32,
    }
}

device_struct! {
    /// A state of a machine, for members of one body: what of a [`Slot`] is the same whenever the
    /// state is entered.
    pub struct MachineState {
        /// As [`Slot::phase_rate`].
        pub phase_rate: u64,
        /// As [`Slot::start_phase`].
        pub start_phase: u32,
        /// Into `bound_clips`.
        pub bound_clip: u32,
        /// A `SLOT_` mode.
        pub mode: u32,
        /// Into `transitions`: those that lead out of the state, the first that holds is taken.
        pub transition_first: u32,
        /// How many those are.
        pub transition_count: u32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// A way out of a state.
    pub struct Transition {
        /// Into `machine_states`.
        pub to: u32,
        /// Into `conditions`: all must hold.
        pub condition_first: u32,
        /// How many those are.
        pub condition_count: u32,
        /// Ticks that the crossfade takes.
        pub fade_ticks: u32,
        /// What the new state's weight rises by in a second; 0 where `fade_ticks` is.
        pub fade_rate: f32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// What must hold for a transition to be taken.
    pub struct Condition {
        /// [`CONDITION_AFTER`]: ticks since the state was entered.
        pub ticks: u64,
        /// A `CONDITION_` kind.
        pub kind: u32,
        /// Which of the machine's parameters.
        pub parameter: u32,
        /// What it is compared with.
        pub value: f32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// A state machine that a member runs.
    pub struct MachineInstance {
        /// The clock when it began.
        pub start_tick: u64,
        /// Into `machine_states`: the state that it begins in, or [`NONE`] for a free place.
        pub state: u32,
        /// Changes with whose machine instance this is, so that nobody goes on in another's state;
        /// never 0.
        pub epoch: u32,
    }
}

device_struct! {
    /// Where a [`MachineInstance`] is: written by devices once a frame, and as whole ticks and
    /// comparisons alone lead there, the same on all of them.
    pub struct Running {
        /// The clock when the state was entered.
        pub entry_tick: u64,
        /// The clock when the state before was.
        pub previous_tick: u64,
        /// Into `machine_states`.
        pub state: u32,
        /// The state before, which fades out; [`NONE`] in the first.
        pub previous: u32,
        /// Which of the machine instance's two slots plays the state, 0 or 1; the other plays the
        /// one before.
        pub which: u32,
        /// Ticks that the crossfade from the one before takes.
        pub fade_ticks: u32,
        /// What the state's weight rises by in a second.
        pub fade_rate: f32,
        /// That of the machine instance when this was written; another one's starts anew.
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
        /// From 0 to 1; not looked at in layer 0.
        pub weight: f32,
        /// [`LAYER_ADDITIVE`] or not, and in the bits of [`LAYER_MASK`] where in `masks` a weight
        /// per joint stands, or all of them for all joints.
        pub mask_and_mode: u32,
    }
}

device_struct! {
    /// What the evaluate stage finds for one slot: two neighbouring rows, how far between them, and
    /// the weight.
    pub struct SlotSample {
        /// Into `rows`, in words.
        pub row0: u32,
        /// Into `rows`, in words.
        pub row1: u32,
        /// 0 at `row0`, 1 at `row1`.
        pub between: f32,
        /// The slot's weight now; 0 where the slot is empty.
        pub weight: f32,
    }
}
