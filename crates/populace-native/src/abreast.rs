//! Members of one body side by side, each in a lane of its own: a whole frame of up to sixteen
//! members. As many are computed at once as the processor's registers have lanes.
//!
//! Sixteen joints at a time are [posed](crate::poses) and transposed, and become model transforms,
//! unless constraint programs lead members down the hierarchy after all blocks. The palettes follow,
//! four entries at a time, which are whole lines of the cache. Each number takes the same arithmetic
//! as that of a member alone. Twin of the second half of `kernels/abreast.cl` and of
//! `kernels/fused_wide.cl`.
//!
//! Reads all that [`joint`](crate::joint) reads, and parents and entries. Writes the members'
//! palettes, with zeros for the padding of the last block.

use populace_device::layout::{
    Body, Entry, Float4, NONE, PALETTE_BLOCK, POSE_PLANES, REST_SCALE, REST_TRANSLATION,
};
use populace_model::Affine;

use crate::cache::{finish_lines, write_line};
use crate::constraints::{Company, Programs, step_rotations};
use crate::dispatch::Work;
use crate::frame::FrameInputs;
use crate::hierarchy::Hierarchy;
use crate::lanes::{ABREAST, LANES, Lanes, Members, Simd, lane_of, load, store, vectors};
use crate::matrices::{MATRIX, product, rotated};
use crate::members::{parents_of, steps_of};
use crate::playback::Play;
use crate::poses::{Block, COMPONENTS, PoseBlock, Posed, is_still};
use crate::processor::Dispatch;
use crate::rows::Joints;
use crate::scratch::Scratch;
use crate::transposition::transpose;
use crate::widths::JointLanes;

/// Numbers of the palette entries of a block.
const BLOCK: usize = PALETTE_BLOCK as usize * MATRIX;

/// A member, and where its palette goes.
pub(crate) struct Seat<'a> {
    /// Index of the member.
    pub(crate) member: u32,
    pub(crate) palette: &'a mut [Float4],
}

/// Transforms of each joint of members side by side.
struct SideBySide<'a>(&'a mut [[Lanes; MATRIX]]);

/// Transforms of one of the members side by side.
struct InLane<'a> {
    joints: &'a mut [[Lanes; MATRIX]],
    lane: usize,
}

impl InLane<'_> {
    #[inline(always)]
    fn transform(&self, joint: usize) -> Affine {
        let mut transform = Affine::IDENTITY;
        let numbers = lane_of(&self.joints[joint], self.lane);
        transform.rows.as_flattened_mut().copy_from_slice(&numbers);
        transform
    }
}

impl Hierarchy for InLane<'_> {
    #[inline(always)]
    fn model_of(&self, joint: usize) -> Affine {
        self.transform(joint)
    }

    #[inline(always)]
    fn local_of(&self, joint: usize) -> Affine {
        self.transform(joint)
    }

    #[inline(always)]
    fn keep_model(&mut self, joint: usize, model: Affine) {
        for (element, number) in self.joints[joint].iter_mut().zip(model.rows.as_flattened()) {
            element.0[self.lane] = *number;
        }
    }
}

impl SideBySide<'_> {
    /// Computes the transforms of a joint from its poses: model transforms if there is a parent,
    /// else local ones.
    #[inline(always)]
    fn place<R: Members>(&mut self, posed: &Posed, at: usize, joint: usize, parent: u32) {
        for lane in (0..ABREAST).step_by(R::COUNT) {
            let local: [R; MATRIX] = posed.matrices(at, lane);
            let model = if parent == NONE {
                local
            } else {
                product(&load(&self.0[parent as usize], lane), &local)
            };
            store(&model, &mut self.0[joint], lane);
        }
    }
}

impl Company<ABREAST> for SideBySide<'_> {
    type Members<J: JointLanes> = J::Members;

    #[inline(always)]
    fn member(&mut self, lane: usize) -> impl Hierarchy {
        InLane { joints: &mut *self.0, lane }
    }

    #[inline(always)]
    fn descend_to<R: Members>(&mut self, parents: &[u32], joint: usize) {
        if parents[joint] == NONE {
            return;
        }
        let parent = parents[joint] as usize;
        for lane in (0..ABREAST).step_by(R::COUNT) {
            let local: [R; MATRIX] = load(&self.0[joint], lane);
            let model = product(&load(&self.0[parent], lane), &local);
            store(&model, &mut self.0[joint], lane);
        }
    }

    #[inline(always)]
    fn rotate<R: Members>(&mut self, joint: usize, rotations: &[Lanes; 4]) {
        for lane in (0..ABREAST).step_by(R::COUNT) {
            let model: [R; MATRIX] = load(&self.0[joint], lane);
            store(&rotated(&model, load(rotations, lane)), &mut self.0[joint], lane);
        }
    }

    #[inline(always)]
    fn models_of<R: Members>(&self, joint: usize, lane: usize) -> [R; MATRIX] {
        load(&self.0[joint], lane)
    }

    #[inline(always)]
    fn locals_of<R: Members>(&self, joint: usize, lane: usize) -> [R; MATRIX] {
        load(&self.0[joint], lane)
    }

    #[inline(always)]
    fn lower(&mut self, joint: usize, drops: &Lanes) {
        for (height, drop) in self.0[joint][7].0.iter_mut().zip(drops.0) {
            *height -= drop;
        }
    }
}

/// Computes the model transforms of a block of joints, or local ones if there are no `parents`.
#[inline(always)]
fn place_block<R: Members>(
    block: Block,
    posed: &mut [Lanes],
    locals: &mut [Lanes],
    parents: Option<&[u32]>,
    models: &mut [[Lanes; MATRIX]],
) {
    let (joints, registers) = (block.joints, block.joints.registers);
    let (stride, mut still) = (ABREAST, REST_TRANSLATION | REST_SCALE);
    registers.run(PoseBlock { block, posed, stride, still: &mut still });
    let components = posed.as_chunks().0.iter().zip(locals.as_chunks_mut().0);
    for (component, (of_members, of_joints)) in components.enumerate() {
        if !is_still(still, component) {
            transpose(of_members, of_joints, registers);
        }
    }
    let (body, first) = (joints.body, joints.first);
    let rest = joints.stored(body.rest_first, POSE_PLANES);
    let (posed, mut models) = (Posed { locals, still, rest }, SideBySide(models));
    for joint in first..models.0.len().min(first + LANES) {
        let parent = parents.map_or(NONE, |parents| parents[joint]);
        models.place::<R>(&posed, joint - first, joint, parent);
    }
}

/// Writes the palettes of a block of entries.
#[inline(always)]
fn write_block<R: Members>(
    entries: &[Entry],
    models: &[[Lanes; MATRIX]],
    matrices: &mut [Lanes],
    registers: Dispatch,
    block: usize,
    seats: &mut [Seat],
) {
    let matrices_of = matrices.as_chunks_mut::<MATRIX>().0;
    for (entry, matrix) in entries.iter().zip(matrices_of.iter_mut()) {
        let rows = [entry.row0.0, entry.row1.0, entry.row2.0];
        let mut bind = [R::splat(0.0); MATRIX];
        for (value, element) in bind.iter_mut().zip(rows.as_flattened()) {
            *value = R::splat(*element);
        }
        for first in (0..ABREAST).step_by(R::COUNT) {
            let model: [R; MATRIX] = load(&models[entry.joint as usize], first);
            store(&product(&model, &bind), matrix, first);
        }
    }
    for padding in matrices_of.iter_mut().skip(entries.len()) {
        *padding = [Simd([0.0; ABREAST]); MATRIX];
    }
    let mut rows = [Simd([0.0; ABREAST]); ABREAST];
    for (piece, square) in matrices.as_chunks::<ABREAST>().0.iter().enumerate() {
        transpose(square, &mut rows, registers);
        for (row, seat) in rows.iter().zip(seats.iter_mut()) {
            let numbers: &mut [f32] = bytemuck::cast_slice_mut(seat.palette);
            let line = &mut numbers[block * BLOCK + piece * ABREAST..];
            if let Some(line) = line.first_chunk_mut() {
                write_line(&row.0, line);
            }
        }
    }
}

/// At most [`ABREAST`] members of one body whose programs are alike.
pub(crate) struct Group<'a, 'b> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    pub(crate) registers: Dispatch,
    pub(crate) body: &'a Body,
    pub(crate) seats: &'a mut [Seat<'b>],
    pub(crate) scratch: &'a mut Scratch,
}

impl Work for Group<'_, '_> {
    #[inline(always)]
    fn run<J: JointLanes>(self) {
        self.write_palettes::<J::Members>();
    }
}

impl Group<'_, '_> {
    /// Writes the members' palettes. `R` is the register that they are computed in.
    #[inline(always)]
    fn write_palettes<R: Members>(self) {
        let Self { inputs, registers, body, seats, scratch } = self;
        let Scratch { desk, rotations, writes, .. } = scratch;
        let rotations = step_rotations(rotations);
        let tables = inputs.tables;
        let plays: [Option<Play>; ABREAST] = std::array::from_fn(|lane| {
            seats.get(lane).map(|seat| Play::play_all(inputs, seat.member))
        });
        plays.iter().flatten().for_each(|play| play.fetch_rows(tables));
        let posed = vectors::<LANES>(&mut desk.posed, COMPONENTS * ABREAST);
        let locals = vectors::<ABREAST>(&mut desk.locals, COMPONENTS * LANES);
        let parents = parents_of(tables, body);
        let models = vectors::<ABREAST>(&mut desk.models, parents.len() * MATRIX);
        let models = models.as_chunks_mut::<MATRIX>().0;
        let is_led = !steps_of(tables, seats[0].member).is_empty();
        let mut members = [0; ABREAST];
        for (member, seat) in members.iter_mut().zip(seats.iter()) {
            *member = seat.member;
        }
        let members = &members[..seats.len()];
        for first in (0..parents.len()).step_by(LANES) {
            let joints = Joints { tables, body, first, registers };
            let block = Block { inputs, joints, plays: &plays, members };
            let parents = (!is_led).then_some(parents);
            place_block::<R>(block, posed, locals, parents, models);
        }
        if is_led {
            let joints = &mut SideBySide(models);
            let (plays, next) = (&plays, 0);
            Programs {
                inputs,
                registers,
                members,
                plays,
                parents,
                joints,
                rotations,
                writes,
                next,
            }
            .descend::<R>();
        }
        let first = body.entry_first as usize;
        let entries = &tables.entries().as_slice()[first..first + body.entry_count as usize];
        let matrices = vectors::<ABREAST>(&mut desk.palettes, BLOCK);
        for (block, entries) in entries.chunks(PALETTE_BLOCK as usize).enumerate() {
            write_block::<R>(entries, models, matrices, registers, block, seats);
        }
        finish_lines();
    }
}
