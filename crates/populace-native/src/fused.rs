//! Fused schedule: a member's whole frame at once. Sixteen joints at a time go from rows to local
//! transforms, then joint by joint, parents first, down the hierarchy and out to the palette. Twin
//! of `kernels/fused_wide.cl`.
//!
//! Reads all that [`joint`](crate::joint) and [`constraints`](crate::constraints) read, and
//! entries. Writes each palette entry of the frame's members once, and deferred states and watched
//! joints. Intermediate results stay in the core's caches.

use populace_device::MAX_SLOTS;
use populace_device::layout::{Float4, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_model::Affine;
use populace_model::math::components;

use crate::constraints::Solver;
use crate::dispatch::{Dispatch, Work};
use crate::frame::FrameInputs;
use crate::hierarchy::{Hierarchy, descend};
use crate::joint::Posing;
use crate::lanes::{LANES, Lanes};
use crate::local::Local;
use crate::machines::slot_now;
use crate::members::{body_of, control_of, member_layers, member_slots, parents_of};
use crate::pages::Pages;
use crate::playback::{Playing, inertialization_of};
use crate::rows::Joints;
use crate::scratch::{Scratch, ScratchPool};
use crate::slot::sample_of;
use crate::split;

/// `Float4` elements of a palette block.
const BLOCK: usize = PALETTE_BLOCK as usize * 3;

/// Inputs of one member.
#[derive(Clone, Copy)]
pub(crate) struct MemberInputs<'a> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    /// Index of the member.
    pub(crate) member: u32,
    /// Registers that sixteen joints are computed in.
    pub(crate) dispatch: Dispatch,
}

/// Transforms of a member in one array.
struct InPlace<'a>(&'a mut [Affine]);

impl Hierarchy for InPlace<'_> {
    #[inline(always)]
    fn model_of(&self, joint: usize) -> Affine {
        self.0[joint]
    }

    #[inline(always)]
    fn local_of(&self, joint: usize) -> Affine {
        self.0[joint]
    }

    #[inline(always)]
    fn keep_model(&mut self, joint: usize, model: Affine) {
        self.0[joint] = model;
    }
}

/// Collects the member's slots that have weight now, in order. Returns their number.
fn play_all(of: MemberInputs, playing: &mut [Playing; MAX_SLOTS]) -> usize {
    let FrameInputs { tables, frame, history, .. } = *of.inputs;
    let mut count = 0;
    for slot in member_slots(tables, of.member) {
        let slot = slot_now(tables, &history.running, slot, frame.tick);
        let at = sample_of(tables, &slot, frame.tick);
        if at.weight > 0.0 {
            playing[count] = Playing { at, bound_clip: slot.bound_clip, layer: slot.layer() };
            count += 1;
        }
    }
    count
}

/// Computes a member's `model_from_joint` into the scratch. Passes the local transforms of each
/// block to `keep`, with the index of its first joint.
#[inline(always)]
pub(crate) fn member_models(
    of: MemberInputs,
    scratch: &mut Scratch,
    mut keep: impl FnMut(usize, &Local<Lanes>),
) {
    let MemberInputs { inputs, member, dispatch } = of;
    let tables = inputs.tables;
    let body = body_of(tables, member);
    let padded = (body.joint_count as usize).next_multiple_of(LANES);
    scratch.models.resize(padded, Affine::IDENTITY);
    let mut playing = [Playing::default(); MAX_SLOTS];
    let count = play_all(of, &mut playing);
    let (playing, layers) = (&playing[..count], member_layers(tables, member));
    let inertialization = inertialization_of(tables, member, inputs.frame.tick);
    let control = control_of(tables, member);
    for (block, matrices) in scratch.models.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let joints = Joints { tables, body, first: block * LANES };
        let posing = Posing { inputs, joints, playing, inertialization, layers, control, dispatch };
        let local = posing.pose_joint::<Lanes>();
        keep(joints.first, &local);
        let m = components(local.t, local.r, local.s);
        for (lane, matrix) in matrices.iter_mut().enumerate() {
            let row = |row: usize| [0, 1, 2, 3].map(|column: usize| m[row * 4 + column].0[lane]);
            matrix.rows = [row(0), row(1), row(2)];
        }
    }
    let parents = parents_of(tables, body);
    let mut models = InPlace(&mut scratch.models);
    match Solver::new(inputs, member, &mut scratch.writes) {
        Some(mut solver) => solver.descend(&mut models, parents),
        None => descend(&mut models, parents),
    }
}

/// Writes one member's palette.
#[inline(always)]
fn write_palette(of: MemberInputs, scratch: &mut Scratch, palette: &mut [Float4]) {
    let tables = of.inputs.tables;
    let body = body_of(tables, of.member);
    member_models(of, scratch, |_, _| {});
    let first = body.entry_first as usize;
    let entries = &tables.entries().as_slice()[first..first + body.entry_count as usize];
    for (entry, matrix) in entries.iter().zip(palette.as_chunks_mut::<3>().0) {
        let joint_from_bind = Affine { rows: [entry.row0.0, entry.row1.0, entry.row2.0] };
        *matrix = scratch.models[entry.joint as usize].mul(&joint_from_bind).rows.map(Float4);
    }
}

/// Call of [`write_palette`].
struct WritePalette<'a> {
    of: MemberInputs<'a>,
    scratch: &'a mut Scratch,
    palette: &'a mut [Float4],
}

impl Work for WritePalette<'_> {
    #[inline(always)]
    fn run(self) {
        write_palette(self.of, self.scratch, self.palette);
    }
}

/// Writes the palettes of the frame's members.
pub(crate) fn fused(
    inputs: &FrameInputs,
    dispatch: Dispatch,
    scratch: &ScratchPool,
    pages: &mut Pages,
) {
    let FrameInputs { tables, frame, .. } = *inputs;
    let (all, members) = (tables.palette_blocks().as_slice(), tables.members().as_slice());
    for (page, palettes) in pages.iter_mut().enumerate() {
        let first = page * (PAGE_ENTRIES / PALETTE_BLOCK) as usize;
        let blocks = &all[first..first + palettes.len() / BLOCK];
        split::for_each_member::<BLOCK, 1>(blocks, [palettes], &|member, _, [palette]| {
            if frame.evaluates(member) && frame.reaches(&members[member as usize]) {
                let of = MemberInputs { inputs, member, dispatch };
                let scratch = &mut scratch.of_current_thread();
                dispatch.run(WritePalette { of, scratch, palette });
            }
        });
    }
}
