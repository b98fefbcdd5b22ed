//! The fused schedule: a member's whole frame at once, sixteen joints at a time from rows to local
//! transforms, then parents first down the hierarchy and out to the palette; the twin of
//! `kernels/fused_wide.cl`. Nothing between clip and palette leaves the core's caches.

use std::sync::{Mutex, MutexGuard, PoisonError};

use populace_device::layout::{Body, Float4, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_device::{Frame, MAX_SLOTS, Tables};
use populace_model::Affine;
use populace_model::math::components;

use crate::controls::{self, Clock, Keeping, Left, Models, Steering, control_of};
use crate::dispatch::Dispatch;
use crate::evaluate::evaluate;
use crate::inertialize::inertialization_slots;
use crate::joint::{Playing, Posing};
use crate::lanes::{LANES, Lanes};
use crate::machines::slot_now;
use crate::pages::Pages;
use crate::pose::member_layers;
use crate::rows::Local;
use crate::split;
use crate::stages::Stages;

/// Elements of a palette block.
const BLOCK: usize = PALETTE_BLOCK as usize * 3;

/// What one thread works in.
pub(crate) type Scratch = Mutex<Desk>;

/// What lies before a thread.
#[derive(Default)]
pub(crate) struct Desk {
    /// `model_from_joint` of the member that it is at.
    pub(crate) models: Vec<Affine>,
    /// What the members of a phase leave behind.
    pub(crate) left: Left,
}

/// The calling thread's own; there is one for each.
pub(crate) fn scratch_of(scratch: &[Scratch]) -> MutexGuard<'_, Desk> {
    let own = &scratch[rayon::current_thread_index().unwrap_or(0) % scratch.len()];
    own.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A member at a time.
#[derive(Clone, Copy)]
pub(crate) struct Evaluation<'a> {
    pub(crate) tables: &'a Tables,
    pub(crate) place: u32,
    pub(crate) clock: Clock<'a>,
    pub(crate) keeping: &'a Keeping,
    /// The registers that sixteen joints are computed in.
    pub(crate) dispatch: Dispatch,
}

/// Writes the palettes of the frame's members.
pub(crate) fn run(
    tables: &Tables,
    frame: Frame,
    (stages, keeping): (&Stages, &Keeping),
    dispatch: Dispatch,
    scratch: &[Scratch],
    pages: &mut Pages,
) {
    let (all, members) = (tables.palette_blocks().as_slice(), tables.members().as_slice());
    for (page, palettes) in pages.iter_mut().enumerate() {
        let first = page * (PAGE_ENTRIES / PALETTE_BLOCK) as usize;
        let blocks = &all[first..first + palettes.len() / BLOCK];
        split::for_each_member::<BLOCK, 1>(blocks, [palettes], &|place, _, [palette]| {
            if frame.evaluates(place) && frame.reaches(&members[place as usize]) {
                let member = Evaluation {
                    tables,
                    place,
                    clock: Clock::of(frame, stages),
                    keeping,
                    dispatch,
                };
                dispatch.write_palette(member, &mut scratch_of(scratch), palette);
            }
        });
    }
}

/// One member's palette.
#[inline(always)]
pub(crate) fn write_palette(member: Evaluation, desk: &mut Desk, palette: &mut [Float4]) {
    let tables = member.tables;
    let body = body_of(tables, member.place);
    member_matrices(member, desk, |_, _| {});
    let first = body.entry_first as usize;
    let entries = &tables.entries().as_slice()[first..first + body.entry_count as usize];
    for (entry, matrix) in entries.iter().zip(palette.as_chunks_mut::<3>().0) {
        let joint_from_bind = Affine { rows: [entry.row0.0, entry.row1.0, entry.row2.0] };
        *matrix = desk.models[entry.joint as usize].mul(&joint_from_bind).rows.map(Float4);
    }
}

/// Matrices of which each is local until it is set.
struct InPlace<'a>(&'a mut [Affine]);

impl Models for InPlace<'_> {
    #[inline(always)]
    fn model(&self, joint: usize) -> Affine {
        self.0[joint]
    }

    #[inline(always)]
    fn local(&self, joint: usize) -> Affine {
        self.0[joint]
    }

    #[inline(always)]
    fn set(&mut self, joint: usize, model: Affine) {
        self.0[joint] = model;
    }
}

/// A member's `model_from_joint`, and its local transforms to `keep`, by first joint.
#[inline(always)]
pub(crate) fn member_matrices(
    member: Evaluation,
    desk: &mut Desk,
    mut keep: impl FnMut(usize, &Local<Lanes>),
) {
    let Evaluation { tables, place, clock, keeping, dispatch } = member;
    let (body, control) = (body_of(tables, place), control_of(tables, place));
    desk.models.resize(body.padded_count as usize, Affine::IDENTITY);
    let mut playing = [Playing::default(); MAX_SLOTS];
    let count = play(member, &mut playing);
    let (playing, layers) = (&playing[..count], member_layers(tables, place));
    let inertialization = inertialization_slots(tables, place, clock.tick);
    for (block, matrices) in desk.models.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let joint = block * LANES;
        let posing = Posing {
            tables,
            playing,
            inertialization,
            layers,
            body,
            control,
            joint,
            clock,
            dispatch,
        };
        let local = posing.pose::<Lanes>();
        keep(joint, &local);
        let m = components(local.t, local.r, local.s);
        for (lane, matrix) in matrices.iter_mut().enumerate() {
            let row = |row: usize| [0, 1, 2, 3].map(|column: usize| m[row * 4 + column].0[lane]);
            matrix.rows = [row(0), row(1), row(2)];
        }
    }
    let first = body.joint_first as usize;
    let parents = &tables.parents().as_slice()[first..first + body.joint_count as usize];
    let mut models = InPlace(&mut desk.models);
    match Steering::new(tables, place, clock, keeping, &mut desk.left) {
        Some(mut steering) => steering.descend(&mut models, parents),
        None => controls::descend(&mut models, parents),
    }
}

pub(crate) fn body_of(tables: &Tables, place: u32) -> &Body {
    &tables.bodies().as_slice()[tables.members().as_slice()[place as usize].body as usize]
}

/// The member's slots that weigh anything now, in order; returns how many.
fn play(member: Evaluation, playing: &mut [Playing; MAX_SLOTS]) -> usize {
    let Evaluation { tables, keeping, .. } = member;
    let (tick, mut count) = (member.clock.tick, 0);
    for slot in &tables.slots().as_slice()[tables.slot_range(member.place)] {
        let slot = slot_now(tables, &keeping.running, slot, tick);
        let at = evaluate(tables, &slot, tick);
        if at.weight > 0.0 {
            playing[count] = Playing { at, bound_clip: slot.bound_clip, layer: slot.layer() };
            count += 1;
        }
    }
    count
}
