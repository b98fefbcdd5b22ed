//! States of feet: what a frame leaves for the next; and where members stand. Twin of
//! `kernels/foot_state.cl`.

use populace_device::layout::{FOOT_STATE, FOOT_STATE_BITS, Float4};
use populace_model::math::Real;

use super::targets::{Solver, Standing};

/// The bits of a state that hold the pivot, after the lowest one.
const PIVOT: u32 = 15;
const PLANTED: u32 = 1;
const RELEASED: u32 = 32;
/// Numbers of a [`FootState`].
pub(super) const STATE: usize = 11;

/// Settings of a foot's constraint; see
/// [`Constraint`](populace_device::layout::Constraint).
#[derive(Clone, Copy)]
pub(super) struct Settings<R> {
    pub(super) axis: [R; 3],
    pub(super) up: [R; 4],
    pub(super) limits: [R; 4],
}

/// Numbers of [`Settings`].
pub(super) const SETTINGS: usize = 11;

impl<R: Copy> Settings<R> {
    /// Returns the settings from their numbers, in the order of the fields.
    #[inline(always)]
    pub(super) fn of_numbers([x, y, z, a, b, c, d, e, f, g, h]: [R; SETTINGS]) -> Self {
        Self { axis: [x, y, z], up: [a, b, c, d], limits: [e, f, g, h] }
    }
}

/// Place and stride of a member.
#[derive(Clone, Copy)]
pub(super) struct Stance<R> {
    pub(super) standing: Standing<R>,
    pub(super) stride: [R; 3],
}

/// Numbers of a [`Stance`].
pub(super) const STANCE: usize = 9;

impl<R: Copy> Stance<R> {
    /// Returns the stance from its numbers, in the order of the fields.
    #[inline(always)]
    pub(super) fn of_numbers([x, y, z, scale, sin, cos, a, b, c]: [R; STANCE]) -> Self {
        let standing = Standing { place: [x, y, z, scale], facing: [sin, cos] };
        Self { standing, stride: [a, b, c] }
    }
}

/// State of a foot in world space, of one member or of several in lanes.
#[derive(Clone, Copy)]
pub(super) struct FootState<R: Real> {
    /// Along X and Z: the pivot's position if planted, else the offset from where the clip has the
    /// foot.
    pub(super) vector: [R; 2],
    /// If planted, the unit direction from heel to toes along X and Z; else the tangent of half the
    /// angle by which the foot is turned from the clip, then 0.
    pub(super) direction: [R; 2],
    /// Height of the ground that the foot is shown on.
    pub(super) height: R,
    /// Height of the planted pivot above the true ground.
    pub(super) above: R,
    /// Speed at which the foot rises to the height of the ground, in metres per second.
    pub(super) climb: R,
    /// Index of the point of the sole that stands, if planted.
    pub(super) pivot: R,
    pub(super) planted: R::Choice,
    /// The lock was let go within a contact that has not ended.
    pub(super) released: R::Choice,
    /// False if the member had no such state in the frame before.
    pub(super) known: R::Choice,
}

impl<R: Real> FootState<R> {
    /// Returns a state from its numbers: those of the fields in order, 1 for true.
    #[inline(always)]
    pub(super) fn of_numbers(numbers: [R; STATE]) -> Self {
        let [x, z, along_x, along_z, height, above, climb, pivot, planted, released, known] =
            numbers;
        let half = R::splat(0.5);
        Self {
            vector: [x, z],
            direction: [along_x, along_z],
            height,
            above,
            climb,
            pivot,
            planted: half.less(planted),
            released: half.less(released),
            known: half.less(known),
        }
    }

    /// Returns the state's numbers.
    #[inline(always)]
    pub(super) fn numbers(&self) -> [R; STATE] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let ([x, z], [along_x, along_z]) = (self.vector, self.direction);
        let [planted, released, known] = [
            R::choose(self.planted, one, zero),
            R::choose(self.released, one, zero),
            R::choose(self.known, one, zero),
        ];
        let Self { height, above, climb, pivot, .. } = *self;
        [x, z, along_x, along_z, height, above, climb, pivot, planted, released, known]
    }
}

impl Solver<'_> {
    /// Returns the numbers of the state of the `nth` foot as of the frame before.
    #[inline(always)]
    pub(super) fn foot_state(&self, nth: u32) -> [f32; STATE] {
        let [x, height, z, bits] = self.state(FOOT_STATE + 2 * nth).0;
        let [along_x, along_z, above, climb] = self.state(FOOT_STATE + 2 * nth + 1).0;
        let bits = bits.to_bits();
        let known = bits >> FOOT_STATE_BITS == self.control.epoch;
        let [x, z, along_x, along_z] = if known { [x, z, along_x, along_z] } else { [0.0; 4] };
        let is = |flag: u32| if known && bits & flag != 0 { 1.0 } else { 0.0 };
        let pivot = (bits >> 1 & PIVOT) as f32;
        let (planted, released, known) = (is(PLANTED), is(RELEASED), f32::from(u8::from(known)));
        [x, z, along_x, along_z, height, above, climb, pivot, planted, released, known]
    }

    /// Returns the elements of a foot's state for the next frame.
    #[inline(always)]
    pub(super) fn next_state(&self, state: &FootState<f32>) -> [Float4; 2] {
        let planted = if state.planted { PLANTED } else { 0 };
        let released = if state.released { RELEASED } else { 0 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the index of one of few points"
        )]
        let pivot = state.pivot as u32;
        let bits = self.control.epoch << FOOT_STATE_BITS | released | planted | pivot << 1;
        let ([x, z], [along_x, along_z]) = (state.vector, state.direction);
        let place = Float4([x, state.height, z, f32::from_bits(bits)]);
        [place, Float4([along_x, along_z, state.above, state.climb])]
    }
}
