//! Fused schedule: a member's whole frame at once. Twin of `kernels/fused_wide.cl`.
//!
//! Members of one body with equal programs stand side by side; see [`abreast`](crate::abreast). Others
//! go alone: sixteen joints at a time from rows to local transforms, then joint by joint, parents
//! first, down the hierarchy and out to the palette.
//!
//! Reads all that [`joint`](crate::joint) and [`constraints`](crate::constraints) read, and
//! entries. Writes each palette entry of the frame's members once, and deferred states and watched
//! joints. Intermediate results stay in the core's caches.

use populace_device::layout::{Float4, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_model::Affine;
use populace_model::math::components;

use crate::abreast::{Group, Seat};
use crate::constraints::{Alone, Programs, step_rotations};
use crate::frame::FrameInputs;
use crate::hierarchy::Hierarchy;
use crate::lanes::{ABREAST, LANES, Lanes, Simd};
use crate::local::Local;
use crate::members::{body_of, parents_of};
use crate::pages::Pages;
use crate::playback::Play;
use crate::poses::{Block, COMPONENTS, PoseBlock};
use crate::processor::Dispatch;
use crate::rows::Joints;
use crate::scratch::{Scratch, ScratchPool};
use crate::split;

/// `Float4` elements of a palette block.
const BLOCK: usize = PALETTE_BLOCK as usize * 3;

const ZERO: Lanes = Simd([0.0; LANES]);

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

/// Computes a member's `model_from_joint` into the scratch. Passes the local transforms of each
/// block to `keep`, with the index of its first joint.
pub(crate) fn member_models(
    of: MemberInputs,
    scratch: &mut Scratch,
    keep: &mut dyn FnMut(usize, &Local<Lanes>),
) {
    let MemberInputs { inputs, member, dispatch } = of;
    let tables = inputs.tables;
    let body = body_of(tables, member);
    let padded = (body.joint_count as usize).next_multiple_of(LANES);
    scratch.models.resize(padded, Affine::IDENTITY);
    let play = Play::play_all(inputs, member);
    play.fetch_rows(tables);
    let plays = [Some(play)];
    for (block, matrices) in scratch.models.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let joints = Joints { tables, body, first: block * LANES, registers: dispatch };
        let mut posed = [ZERO; COMPONENTS];
        let block = Block { inputs, joints, plays: &plays, members: &[member] };
        dispatch.run(PoseBlock { block, posed: &mut posed, stride: 1, still: &mut 0 });
        let [tx, ty, tz, rx, ry, rz, rw, sx, sy, sz] = posed;
        let local = Local { t: [tx, ty, tz], r: [rx, ry, rz, rw], s: [sx, sy, sz] };
        keep(joints.first, &local);
        let m = components(local.t, local.r, local.s);
        for (lane, matrix) in matrices.iter_mut().enumerate() {
            let row = |row: usize| [0, 1, 2, 3].map(|column: usize| m[row * 4 + column].0[lane]);
            matrix.rows = [row(0), row(1), row(2)];
        }
    }
    let parents = parents_of(tables, body);
    let Scratch { models, rotations, writes, .. } = scratch;
    let rotations = step_rotations(rotations);
    let joints = &mut Alone(&mut InPlace(models));
    let (members, plays, registers, next) = (&[member], &plays, dispatch, 0);
    Programs { inputs, registers, members, plays, parents, joints, rotations, writes, next }
        .descend::<f32>();
}

/// Writes the palette of one member.
fn write_palette(inputs: &FrameInputs, dispatch: Dispatch, seat: &mut Seat, scratch: &mut Scratch) {
    let (tables, member) = (inputs.tables, seat.member);
    let body = body_of(tables, member);
    member_models(MemberInputs { inputs, member, dispatch }, scratch, &mut |_, _| {});
    let first = body.entry_first as usize;
    let entries = &tables.entries().as_slice()[first..first + body.entry_count as usize];
    for (entry, matrix) in entries.iter().zip(seat.palette.as_chunks_mut::<3>().0) {
        let joint_from_bind = Affine { rows: [entry.row0.0, entry.row1.0, entry.row2.0] };
        *matrix = scratch.models[entry.joint as usize].mul(&joint_from_bind).rows.map(Float4);
    }
}

/// Writes the palettes of members of one body with equal programs, side by side. Those that would
/// leave most lanes empty go one by one.
fn write_groups(
    inputs: &FrameInputs,
    registers: Dispatch,
    seats: &mut [Seat],
    scratch: &mut Scratch,
) {
    for seats in seats.chunks_mut(ABREAST) {
        if seats.len() * 4 < ABREAST {
            for seat in seats {
                write_palette(inputs, registers, seat, scratch);
            }
        } else {
            let body = body_of(inputs.tables, seats[0].member);
            registers.run(Group { inputs, registers, body, seats, scratch });
        }
    }
}

/// Writes the palettes of the frame's members.
pub(crate) fn fused(
    inputs: &FrameInputs,
    registers: Dispatch,
    scratch: &ScratchPool,
    pages: &mut Pages,
) {
    let FrameInputs { tables, frame, .. } = *inputs;
    let (all, members) = (tables.palette_blocks().as_slice(), tables.members().as_slice());
    for (page, palettes) in pages.iter_mut().enumerate() {
        let first = page * (PAGE_ENTRIES / PALETTE_BLOCK) as usize;
        let blocks = &all[first..first + palettes.len() / BLOCK];
        split::for_each_part::<BLOCK>(blocks, palettes, &|part| {
            let mut seats = Vec::new();
            part.for_each_member(|member, _, [palette]| {
                if frame.evaluates(member) && frame.reaches(&members[member as usize]) {
                    seats.push(Seat { member, palette });
                }
            });
            let kind = |seat: &Seat| {
                let member = &members[seat.member as usize];
                (member.posed, member.shape)
            };
            seats.sort_by_cached_key(|seat| (kind(seat), seat.member));
            let scratch = &mut scratch.of_current_thread();
            for seats in seats.chunk_by_mut(|a, b| kind(a) == kind(b)) {
                write_groups(inputs, registers, seats, scratch);
            }
        });
    }
}
