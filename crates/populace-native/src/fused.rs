//! Fused schedule: a member's whole frame at once. Twin of `kernels/fused_wide.cl`.
//!
//! Members of one body with equal programs stand side by side; see [`abreast`](crate::abreast). Others
//! go alone: sixteen joints at a time from rows to local transforms, then joint by joint, parents
//! first, down the hierarchy and out to the palette.
//!
//! Reads all that [`joint`](crate::joint) and [`constraints`](crate::constraints) read, and
//! entries. Writes each palette entry of the frame's members once, and deferred states and watched
//! joints. Intermediate results stay in the core's caches.

use populace_device::layout::{Float4, NONE, PAGE_ENTRIES, PALETTE_BLOCK};
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
use crate::scratch::{Place, Scratch, ScratchPool};
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

/// Takes the palettes of at most [`ABREAST`] members. `places` must be in order of `palette`.
fn seats_of<'a>(places: &[Place], mut palettes: &'a mut [Float4]) -> [Seat<'a>; ABREAST] {
    let mut taken = 0;
    std::array::from_fn(|nth| {
        let Some(Place { member, palette: range, .. }) = places.get(nth) else {
            return Seat { member: NONE, palette: &mut [] };
        };
        let (_, rest) = std::mem::take(&mut palettes).split_at_mut(range.start - taken);
        let (palette, rest) = rest.split_at_mut(range.len());
        (palettes, taken) = (rest, range.end);
        Seat { member: *member, palette }
    })
}

/// Writes the palettes of members of one body with equal programs, side by side. Those that would
/// leave most lanes empty go one by one.
fn write_groups(
    inputs: &FrameInputs,
    registers: Dispatch,
    places: &[Place],
    palettes: &mut [Float4],
    scratch: &mut Scratch,
) {
    for places in places.chunks(ABREAST) {
        let mut seats = seats_of(places, palettes);
        let seats = &mut seats[..places.len()];
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
            let scratch = &mut *scratch.of_current_thread();
            let mut places = std::mem::take(&mut scratch.places);
            places.clear();
            places.extend(part.members().filter_map(|(member, palette)| {
                let own = &members[member as usize];
                let is_due = frame.evaluates(member) && frame.reaches(own);
                is_due.then_some(Place { kind: (own.posed, own.shape), member, palette })
            }));
            places.sort_unstable_by_key(|place| (place.kind, place.palette.start));
            let [palettes] = part.arrays;
            for places in places.chunk_by(|a, b| a.kind == b.kind) {
                write_groups(inputs, registers, places, palettes, scratch);
            }
            scratch.places = places;
        });
    }
}
