//! Members of one body side by side, each in a lane of its own: a whole frame of as many members as
//! the processor's registers have lanes.
//!
//! Sixteen joints go through short passes: poses of each member with joints in lanes, transposed;
//! matrices; the hierarchy. The palettes follow, four entries at a time, which are whole lines of
//! the cache. Each number takes the same arithmetic as that of a member alone.
//!
//! Reads all that [`joint`](crate::joint) reads, and parents and entries. Writes the members'
//! palettes, with zeros for the padding of the last block.

use populace_device::MAX_SLOTS;
use populace_device::layout::{Body, Entry, Float4, Layer, NONE, PALETTE_BLOCK};
use populace_model::math::{Real, components};

use crate::corrections::JointLanes;
use crate::dispatch::{Dispatch, Work};
use crate::frame::FrameInputs;
use crate::joint::Posing;
use crate::lanes::{LANES, Lanes, Line, Simd};
use crate::machines::slot_now;
use crate::members::{control_of, member_layers, member_slots, parents_of};
use crate::playback::{Inertialization, Playing, inertialization_of};
use crate::rows::Joints;
use crate::slot::sample_of;
use crate::transposition::Square;

/// Components of a local transform: translation, rotation, scale.
pub(crate) const COMPONENTS: usize = 10;
/// Elements of a matrix.
const MATRIX: usize = 12;
/// Numbers of the palette entries of a block.
const BLOCK: usize = PALETTE_BLOCK as usize * MATRIX;

/// A member, and where its palette goes.
pub(crate) struct Seat<'a> {
    /// Index of the member.
    pub(crate) member: u32,
    pub(crate) palette: &'a mut [Float4],
}

/// What a member plays now.
pub(crate) struct Play<'a> {
    playing: [Playing; MAX_SLOTS],
    count: usize,
    inertialization: Inertialization<'a>,
    layers: &'a [Layer],
}

impl<'a> Play<'a> {
    /// Collects the member's slots that have weight now, in order.
    pub(crate) fn play_all(inputs: &FrameInputs<'a>, member: u32) -> Self {
        let FrameInputs { tables, frame, history, .. } = *inputs;
        let (mut playing, mut count) = ([Playing::default(); MAX_SLOTS], 0);
        for slot in member_slots(tables, member) {
            let slot = slot_now(tables, &history.running, slot, frame.tick);
            let at = sample_of(tables, &slot, frame.tick);
            if at.weight > 0.0 {
                playing[count] = Playing { at, bound_clip: slot.bound_clip, layer: slot.layer() };
                count += 1;
            }
        }
        let inertialization = inertialization_of(tables, member, frame.tick);
        Self { playing, count, inertialization, layers: member_layers(tables, member) }
    }

    /// Returns the inputs of the poses of joints.
    #[inline(always)]
    pub(crate) fn posing(
        &'a self,
        inputs: &'a FrameInputs<'a>,
        member: u32,
        joints: Joints<'a>,
        registers: Dispatch,
    ) -> Posing<'a> {
        Posing {
            inputs,
            joints,
            playing: &self.playing[..self.count],
            inertialization: self.inertialization,
            layers: self.layers,
            control: control_of(inputs.tables, member),
            dispatch: registers,
        }
    }
}

/// Buffers of a group of members in work.
#[derive(Default)]
pub(crate) struct Desk {
    /// Poses of a block of joints: for each component and member, a number for each joint.
    posed: Vec<Line>,
    /// The same transposed: for each component and joint, a number for each member.
    locals: Vec<Line>,
    /// `model_from_joint` of each joint: for each element, a number for each member.
    models: Vec<Line>,
    /// A block of the palettes: for each entry and element, a number for each member.
    palettes: Vec<Line>,
}

/// Returns a buffer of at least `count` vectors.
fn vectors<const COUNT: usize>(lines: &mut Vec<Line>, count: usize) -> &mut [Simd<COUNT>] {
    let needed = count * COUNT / LANES;
    if lines.len() < needed {
        lines.resize(needed, Line::default());
    }
    &mut bytemuck::cast_slice_mut(lines)[..count]
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

/// Returns the product of two transforms, in the order of operations of `Affine::mul`.
#[inline(always)]
fn product<R: Real>(a: &[R; MATRIX], b: &[R; MATRIX]) -> [R; MATRIX] {
    let mut result = [R::splat(0.0); MATRIX];
    for row in 0..3 {
        let [x, y, z, w] = [a[row * 4], a[row * 4 + 1], a[row * 4 + 2], a[row * 4 + 3]];
        for column in 0..3 {
            result[row * 4 + column] = x * b[column] + y * b[4 + column] + z * b[8 + column];
        }
        result[row * 4 + 3] = x * b[3] + y * b[7] + z * b[11] + w;
    }
    result
}

/// Computes the matrices of a block of joints from their local transforms, and then takes them down
/// the hierarchy.
#[inline(always)]
fn descend<const COUNT: usize>(
    locals: &[Simd<COUNT>],
    first: usize,
    parents: &[u32],
    models: &mut [[Simd<COUNT>; MATRIX]],
) {
    let end = parents.len().min(first + LANES);
    for (at, matrix) in models[first..end].iter_mut().enumerate() {
        let of = |component: usize| locals[component * LANES + at];
        *matrix =
            components([of(0), of(1), of(2)], [of(3), of(4), of(5), of(6)], [of(7), of(8), of(9)]);
    }
    for joint in first..end {
        if parents[joint] != NONE {
            models[joint] = product(&models[parents[joint] as usize], &models[joint]);
        }
    }
}

/// Writes the palettes of a block of entries.
#[inline(always)]
fn write_block<const COUNT: usize>(
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
        let mut bind = [Simd::splat(0.0); MATRIX];
        for (value, element) in bind.iter_mut().zip(rows.as_flattened()) {
            *value = Simd::splat(*element);
        }
        *matrix = product(&models[entry.joint as usize], &bind);
    }
    for padding in matrices_of.iter_mut().skip(entries.len()) {
        *padding = [Simd::splat(0.0); MATRIX];
    }
    for (piece, square) in matrices.as_chunks::<COUNT>().0.iter().enumerate() {
        let rows = Square::transposed(square, registers);
        for (row, seat) in rows.iter().zip(seats.iter_mut()) {
            let numbers: &mut [f32] = bytemuck::cast_slice_mut(seat.palette);
            numbers[block * BLOCK + piece * COUNT..][..COUNT].copy_from_slice(&row.0);
        }
    }
}

/// Members of one body that only clips move, at most one for each lane.
pub(crate) struct Group<'a, 'b, const COUNT: usize> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    pub(crate) registers: Dispatch,
    pub(crate) body: &'a Body,
    pub(crate) seats: &'a mut [Seat<'b>],
    pub(crate) desk: &'a mut Desk,
}

impl<const COUNT: usize> Work for Group<'_, '_, COUNT>
where
    Simd<COUNT>: Square<COUNT>,
{
    const LANES: Option<usize> = Some(COUNT);

    /// Writes the members' palettes.
    #[inline(always)]
    fn run<J: JointLanes>(self) {
        let Self { inputs, registers, body, seats, desk } = self;
        let tables = inputs.tables;
        let plays: [Option<Play>; COUNT] = std::array::from_fn(|lane| {
            seats.get(lane).map(|seat| Play::play_all(inputs, seat.member))
        });
        let posed = vectors::<LANES>(&mut desk.posed, COMPONENTS * COUNT);
        let locals = vectors::<COUNT>(&mut desk.locals, COMPONENTS * LANES);
        let parents = parents_of(tables, body);
        let models = vectors::<COUNT>(&mut desk.models, parents.len() * MATRIX);
        let models = models.as_chunks_mut::<MATRIX>().0;
        for first in (0..parents.len()).step_by(LANES) {
            for (lane, (play, seat)) in plays.iter().flatten().zip(seats.iter()).enumerate() {
                let joints = Joints { tables, body, first };
                let posing = play.posing(inputs, seat.member, joints, registers);
                registers.run(PoseBlock { posing, posed: &mut posed[lane..], stride: COUNT });
            }
            transpose(posed, locals, registers);
            descend(locals, first, parents, models);
        }
        let first = body.entry_first as usize;
        let entries = &tables.entries().as_slice()[first..first + body.entry_count as usize];
        let matrices = vectors::<COUNT>(&mut desk.palettes, BLOCK);
        for (block, entries) in entries.chunks(PALETTE_BLOCK as usize).enumerate() {
            write_block(entries, models, matrices, registers, block, seats);
        }
    }
}
