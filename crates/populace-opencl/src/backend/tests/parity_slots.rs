//! The functions of a slot give the same bits on the device and on the host, over random slots and
//! extremes. They are the leaf functions of `kernels/slot.cl`, and those of `kernels/inertialize.cl`
//! that read no table.

use populace_device::layout::{
    InertializationSlot, NONE, SLOT_HELD, SLOT_INERTIALIZATION, SLOT_LIVE, SLOT_LOOP, SLOT_MACHINE,
    SLOT_ONCE, Slot,
};
use populace_device::{SampledState, far_row, row_before};
use populace_testkit::Rng;

use super::*;
use crate::launch::WorkSize;

const ITEMS: usize = 65_536;
/// Words of the arguments besides the slot: two ticks, start and duration of the clip, a fractional
/// row and the last row.
const ARGUMENTS: usize = 8;
/// Words of the results.
const RESULTS: usize = 20;

/// What the functions take besides the slot.
#[derive(Clone, Copy, Debug)]
struct Arguments {
    from: u64,
    to: u64,
    start_secs: f32,
    duration_secs: f32,
    row: f32,
    last: u32,
}

const PROBE: &str = r"
__kernel void probe(__global const Slot *slots, __global const uint *arguments,
                    __global uint *results)
{
    const Slot slot = slots[get_global_id(0)];
    __global const uint *in = arguments + get_global_id(0) * 8;
    __global uint *out = results + get_global_id(0) * 20;
    const ulong from = ((ulong)in[1] << 32) | in[0], to = ((ulong)in[3] << 32) | in[2];
    ClipRows clip;
    clip.start_secs = as_float(in[4]);
    clip.duration_secs = as_float(in[5]);
    *out++ = slot_mode(slot);
    *out++ = slot_layer(slot);
    *out++ = as_uint(slot_held_secs(slot));
    *out++ = (uint)slot_delay_ticks(slot);
    *out++ = (uint)(slot_delay_ticks(slot) >> 32);
    *out++ = as_uint(slot_weight(slot, from));
    *out++ = as_uint(slot_weight(slot, to));
    *out++ = as_uint(slot_mean_weight(slot, from, to));
    *out++ = as_uint(slot_time(slot, from, clip));
    const ulong cycles = slot_cycles(slot, from, to);
    *out++ = (uint)cycles;
    *out++ = (uint)(cycles >> 32);
    *out++ = slot_inertializes(slot, from) ? 1 : 0;
    *out++ = far_row(as_float(in[6]), in[7]);
    *out++ = row_before(as_float(in[6]), in[7]);
    const InertializationSlot same = as_inertialization(slot);
    const SampledState outgoing = outgoing_state(same), incoming = incoming_state(same);
    *out++ = as_uint(inertialized_at(same, from));
    *out++ = outgoing.bound_clip;
    *out++ = as_uint(outgoing.row) ^ as_uint(outgoing.pace);
    *out++ = incoming.bound_clip;
    *out++ = as_uint(incoming.row) ^ as_uint(incoming.pace);
    *out++ = inertializes_in(slot, 3, from) ? 1 : 0;
}
";

fn low(bits: u64) -> u32 {
    u32::try_from(bits & 0xffff_ffff).unwrap()
}

/// Draws a tick: any, a small one, or one of the first.
fn tick(rng: &mut Rng) -> u64 {
    match rng.below(4) {
        0 => rng.bits(),
        1 => rng.bits() >> 24,
        2 => rng.bits() >> 44,
        _ => rng.bits() >> 62,
    }
}

/// Draws a number: plain, any bits, or an extreme.
fn number(rng: &mut Rng) -> f32 {
    const EDGES: [f32; 9] =
        [0.0, -0.0, 1.0, -1.0, 1e-30, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    match rng.below(4) {
        0 => f32::from_bits(low(rng.bits())),
        1 => EDGES[rng.below(EDGES.len())],
        _ => 2.0 * rng.signed(),
    }
}

fn slot(rng: &mut Rng) -> Slot {
    const MODES: [u32; 6] =
        [SLOT_LOOP, SLOT_ONCE, SLOT_HELD, SLOT_LIVE, SLOT_MACHINE, SLOT_INERTIALIZATION];
    let rate = tick(rng);
    let slot = Slot {
        start_tick: tick(rng) >> 1,
        phase_rate: if rng.chance(0.5) { rate } else { rate.wrapping_neg() },
        weight_tick: tick(rng) >> 1,
        start_phase: low(rng.bits()),
        bound_clip: if rng.chance(0.1) { NONE } else { low(rng.bits()) },
        layer_and_mode: MODES[rng.below(MODES.len())],
        start_weight: number(rng),
        weight_rate: number(rng),
        end_weight: number(rng),
    };
    slot.on_layer(low(rng.bits() >> 56) % 5)
}

/// Draws arguments within the functions' contracts: the later tick is not before the earlier one,
/// nor that before the slot's start, and rows are whole numbers that fit.
fn arguments(rng: &mut Rng, slot: &Slot) -> Arguments {
    let from = slot.start_tick.saturating_add(tick(rng) >> 1);
    let last = low(rng.bits()) >> rng.below(30);
    Arguments {
        from,
        to: from.saturating_add(1 + (tick(rng) >> 2)),
        start_secs: number(rng),
        duration_secs: number(rng),
        row: rng.signed().abs() * if rng.chance(0.5) { 8.0 } else { 70_000.0 },
        last: last.min(1 << 20),
    }
}

fn wanted(slot: &Slot, by: &Arguments) -> [u32; RESULTS] {
    let same: &InertializationSlot = bytemuck::must_cast_ref(slot);
    let cycles = slot.cycles_between(by.from, by.to);
    let state =
        |state: SampledState| [state.bound_clip, state.row.to_bits() ^ state.pace.to_bits()];
    let [outgoing, incoming] = [same.outgoing_state(), same.incoming_state()].map(state);
    let inertializes = slot.inertializes(by.from);
    [
        slot.mode(),
        slot.layer(),
        slot.held_secs().to_bits(),
        low(slot.delay_ticks()),
        low(slot.delay_ticks() >> 32),
        slot.weight_at(by.from).to_bits(),
        slot.weight_at(by.to).to_bits(),
        slot.mean_weight(by.from, by.to).to_bits(),
        slot.time_at(by.from, by.start_secs, by.duration_secs).to_bits(),
        low(cycles),
        low(cycles >> 32),
        u32::from(inertializes),
        far_row(by.row, by.last),
        row_before(by.row, by.last),
        same.inertialized_at(by.from).to_bits(),
        outgoing[0],
        outgoing[1],
        incoming[0],
        incoming[1],
        u32::from(inertializes && slot.layer() == 3),
    ]
}

/// Places of results that are numbers: NaN equals NaN there.
const NUMBERS: [usize; 6] = [2, 5, 6, 7, 8, 14];

fn same(at: usize, a: u32, b: u32) -> bool {
    a == b || NUMBERS.contains(&at) && f32::from_bits(a).is_nan() && f32::from_bits(b).is_nan()
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn slot_functions_give_equal_bits() {
    let mut rng = Rng::new(18);
    let slots: Vec<Slot> = (0..ITEMS).map(|_| slot(&mut rng)).collect();
    let given: Vec<Arguments> = slots.iter().map(|slot| arguments(&mut rng, slot)).collect();
    let words = given.iter().flat_map(|by| {
        let [from, to] = [by.from, by.to].map(|tick| [low(tick), low(tick >> 32)]);
        let numbers = [by.start_secs, by.duration_secs, by.row].map(f32::to_bits);
        [&from[..], &to, &numbers, &[by.last]].concat()
    });
    let words: Vec<u32> = words.collect();
    assert_eq!(words.len(), ITEMS * ARGUMENTS);

    let device = device();
    let program = device.build(&(Form::Staged.source("") + PROBE)).unwrap();
    let (kernel, queue) = (Kernel::create(&program, "probe").unwrap(), device.queue().unwrap());
    let mut of_slots = crate::buffer::Buffer::new(&device, ITEMS, "slots").unwrap();
    let mut of_words = crate::buffer::Buffer::new(&device, words.len(), "arguments").unwrap();
    let out = crate::buffer::Buffer::<u32>::new(&device, ITEMS * RESULTS, "results").unwrap();
    of_slots.write(&queue, 0, &slots).unwrap();
    of_words.write(&queue, 0, &words).unwrap();
    Launch::of(&kernel)
        .buffer("slots", &of_slots)
        .buffer("arguments", &of_words)
        .buffer("results", &out)
        .run(&queue, WorkSize::of(ITEMS, 16))
        .unwrap();
    let mut found = vec![0; ITEMS * RESULTS];
    out.read(&queue, 0, &mut found).unwrap();
    for ((slot, by), found) in slots.iter().zip(&given).zip(found.chunks(RESULTS)) {
        let wanted = wanted(slot, by);
        let differs = (0..RESULTS).find(|at| !same(*at, wanted[*at], found[*at]));
        assert_eq!(differs, None, "{slot:?} {by:?}: {wanted:?} and {found:?}");
    }
}
