//! Members of one body side by side, each in a lane of its own: a whole frame of as many members as
//! the processor's registers have lanes.
//!
//! Sixteen joints go through short passes: poses of each member with joints in lanes, transposed;
//! matrices; the hierarchy, unless constraint programs lead members down it after all blocks. The
//! palettes follow, four entries at a time, which are whole lines of
//! the cache. Each number takes the same arithmetic as that of a member alone.
//!
//! Reads all that [`joint`](crate::joint) reads, and parents and entries. Writes the members'
//! palettes, with zeros for the padding of the last block.

use populace_device::layout::{Body, Entry, Float4, NONE, PALETTE_BLOCK};
use populace_model::Affine;
use populace_model::math::components;

use crate::constraints::{Company, Programs, step_rotations};
use crate::dispatch::{Dispatch, Work};
use crate::frame::FrameInputs;
use crate::hierarchy::Hierarchy;
use crate::joint::Posing;
use crate::lanes::{LANES, Lanes, Members, Simd, lane_of, load, store, vectors};
use crate::matrices::{MATRIX, product, rotated};
use crate::members::{parents_of, steps_of};
use crate::playback::Play;
use crate::rows::Joints;
use crate::scratch::Scratch;
use crate::transposition::Square;
use crate::widths::JointLanes;

/// Components of a local transform: translation, rotation, scale.
pub(crate) const COMPONENTS: usize = 10;
/// Numbers of the palette entries of a block.
const BLOCK: usize = PALETTE_BLOCK as usize * MATRIX;

/// A member, and where its palette goes.
pub(crate) struct Seat<'a> {
    /// Index of the member.
    pub(crate) member: u32,
    pub(crate) palette: &'a mut [Float4],
}

/// Call of [`Posing::pose_block`] for the joints of a block.
pub(crate) struct PoseBlock<'a> {
    pub(crate) posing: Posing<'a>,
    /// The first component of the pose, and the others `stride` vectors apart.
    pub(crate) posed: &'a mut [Lanes],
    pub(crate) stride: usize,
}

impl Work for PoseBlock<'_> {
    #[inline(always)]
    fn run<J: JointLanes>(self) {
        let local = self.posing.pose_block::<J>();
        let ([tx, ty, tz], [rx, ry, rz, rw], [sx, sy, sz]) = (local.t, local.r, local.s);
        let all = [tx, ty, tz, rx, ry, rz, rw, sx, sy, sz];
        for (to, value) in self.posed.iter_mut().step_by(self.stride).zip(all) {
            *to = value;
        }
    }
}

/// Transposes what each member's joints hold to what each joint's members hold.
#[inline(always)]
fn transpose<const COUNT: usize>(posed: &[Lanes], locals: &mut [Simd<COUNT>], registers: Dispatch)
where
    Simd<COUNT>: Square<COUNT>,
{
    let components = posed.chunks_exact(COUNT).zip(locals.chunks_exact_mut(LANES));
    for (members, joints) in components {
        for (piece, joints) in joints.as_chunks_mut::<COUNT>().0.iter_mut().enumerate() {
            let mut rows = [Simd([0.0; COUNT]); COUNT];
            for (row, member) in rows.iter_mut().zip(members) {
                row.0.copy_from_slice(&member.0[piece * COUNT..][..COUNT]);
            }
            *joints = Square::transposed(&rows, registers);
        }
    }
}

/// Transforms of each joint of members side by side.
struct SideBySide<'a, const COUNT: usize>(&'a mut [[Simd<COUNT>; MATRIX]]);

/// Transforms of one of the members side by side.
struct InLane<'a, const COUNT: usize> {
    joints: &'a mut [[Simd<COUNT>; MATRIX]],
    lane: usize,
}

impl<const COUNT: usize> InLane<'_, COUNT> {
    #[inline(always)]
    fn transform(&self, joint: usize) -> Affine {
        let mut transform = Affine::IDENTITY;
        let numbers = lane_of(&self.joints[joint], self.lane);
        transform.rows.as_flattened_mut().copy_from_slice(&numbers);
        transform
    }
}

impl<const COUNT: usize> Hierarchy for InLane<'_, COUNT> {
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

impl<const COUNT: usize> Company<COUNT> for SideBySide<'_, COUNT> {
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
        for lane in (0..COUNT).step_by(R::COUNT) {
            let local: [R; MATRIX] = load(&self.0[joint], lane);
            let model = product(&load(&self.0[parent], lane), &local);
            store(&model, &mut self.0[joint], lane);
        }
    }

    #[inline(always)]
    fn rotate<R: Members>(&mut self, joint: usize, rotations: &[Simd<COUNT>; 4]) {
        for lane in (0..COUNT).step_by(R::COUNT) {
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
    fn lower(&mut self, joint: usize, drops: &Simd<COUNT>) {
        for (height, drop) in self.0[joint][7].0.iter_mut().zip(drops.0) {
            *height -= drop;
        }
    }
}

/// Computes the matrices of a block of joints from their local transforms.
#[inline(always)]
fn compose<R: Members, const COUNT: usize>(
    locals: &[Simd<COUNT>],
    block: &mut [[Simd<COUNT>; MATRIX]],
) {
    for (at, matrix) in block.iter_mut().enumerate() {
        let mut all = [Simd([0.0; COUNT]); COMPONENTS];
        for (component, vector) in all.iter_mut().enumerate() {
            *vector = locals[component * LANES + at];
        }
        let [tx, ty, tz, rx, ry, rz, rw, sx, sy, sz]: [R; COMPONENTS] = load(&all, 0);
        let composed = components([tx, ty, tz], [rx, ry, rz, rw], [sx, sy, sz]);
        store(&composed, matrix, 0);
    }
}

/// Writes the palettes of a block of entries.
#[inline(always)]
fn write_block<R: Members, const COUNT: usize>(
    entries: &[Entry],
    models: &[[Simd<COUNT>; MATRIX]],
    matrices: &mut [Simd<COUNT>],
    registers: Dispatch,
    block: usize,
    seats: &mut [Seat],
) where
    Simd<COUNT>: Square<COUNT>,
{
    let matrices_of = matrices.as_chunks_mut::<MATRIX>().0;
    for (entry, matrix) in entries.iter().zip(matrices_of.iter_mut()) {
        let rows = [entry.row0.0, entry.row1.0, entry.row2.0];
        let mut bind = [R::splat(0.0); MATRIX];
        for (value, element) in bind.iter_mut().zip(rows.as_flattened()) {
            *value = R::splat(*element);
        }
        let model: [R; MATRIX] = load(&models[entry.joint as usize], 0);
        store(&product(&model, &bind), matrix, 0);
    }
    for padding in matrices_of.iter_mut().skip(entries.len()) {
        *padding = [Simd([0.0; COUNT]); MATRIX];
    }
    for (piece, square) in matrices.as_chunks::<COUNT>().0.iter().enumerate() {
        let rows = Square::transposed(square, registers);
        for (row, seat) in rows.iter().zip(seats.iter_mut()) {
            let numbers: &mut [f32] = bytemuck::cast_slice_mut(seat.palette);
            numbers[block * BLOCK + piece * COUNT..][..COUNT].copy_from_slice(&row.0);
        }
    }
}

/// Members of one body whose programs are alike, at most one for each lane.
pub(crate) struct Group<'a, 'b, const COUNT: usize> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    pub(crate) registers: Dispatch,
    pub(crate) body: &'a Body,
    pub(crate) seats: &'a mut [Seat<'b>],
    pub(crate) scratch: &'a mut Scratch,
}

impl<const COUNT: usize> Work for Group<'_, '_, COUNT>
where
    Simd<COUNT>: Square<COUNT>,
{
    const LANES: Option<usize> = Some(COUNT);

    #[inline(always)]
    fn run<J: JointLanes>(self) {
        if J::Members::COUNT == COUNT {
            self.write_palettes::<J::Members>();
        } else {
            self.write_palettes::<Simd<COUNT>>();
        }
    }
}

impl<const COUNT: usize> Group<'_, '_, COUNT>
where
    Simd<COUNT>: Square<COUNT>,
{
    /// Writes the members' palettes. `R` holds a number for each member.
    #[inline(always)]
    fn write_palettes<R: Members>(self) {
        let Self { inputs, registers, body, seats, scratch } = self;
        let Scratch { desk, rotations, writes, .. } = scratch;
        let rotations = step_rotations(rotations);
        let tables = inputs.tables;
        let plays: [Option<Play>; COUNT] = std::array::from_fn(|lane| {
            seats.get(lane).map(|seat| Play::play_all(inputs, seat.member))
        });
        let posed = vectors::<LANES>(&mut desk.posed, COMPONENTS * COUNT);
        let locals = vectors::<COUNT>(&mut desk.locals, COMPONENTS * LANES);
        let parents = parents_of(tables, body);
        let models = vectors::<COUNT>(&mut desk.models, parents.len() * MATRIX);
        let models = models.as_chunks_mut::<MATRIX>().0;
        let is_led = !steps_of(tables, seats[0].member).is_empty();
        for first in (0..parents.len()).step_by(LANES) {
            let end = parents.len().min(first + LANES);
            for (lane, (play, seat)) in plays.iter().flatten().zip(seats.iter()).enumerate() {
                let joints = Joints { tables, body, first };
                let posing = play.posing(inputs, seat.member, joints, registers);
                registers.run(PoseBlock { posing, posed: &mut posed[lane..], stride: COUNT });
            }
            transpose(posed, locals, registers);
            compose::<R, COUNT>(locals, &mut models[first..end]);
            if !is_led {
                let mut joints = SideBySide(&mut *models);
                for joint in first..end {
                    joints.descend_to::<R>(parents, joint);
                }
            }
        }
        if is_led {
            let mut members = [0; COUNT];
            for (member, seat) in members.iter_mut().zip(seats.iter()) {
                *member = seat.member;
            }
            let members = &members[..seats.len()];
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
        let matrices = vectors::<COUNT>(&mut desk.palettes, BLOCK);
        for (block, entries) in entries.chunks(PALETTE_BLOCK as usize).enumerate() {
            write_block::<R, COUNT>(entries, models, matrices, registers, block, seats);
        }
    }
}
