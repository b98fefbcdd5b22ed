//! Poses of members side by side, sixteen joints at a time. Twin of the first half of
//! `kernels/abreast.cl`, and of `kernels/layers.cl`.
//!
//! Slots are sampled with joints in lanes. Reads all that [`joint`](crate::joint) reads.

use populace_device::layout::{REST_SCALE, REST_TRANSLATION};
use populace_model::math::components;

use crate::dispatch::Work;
use crate::frame::FrameInputs;
use crate::joint::{Sum, mean_or_rest, rest_of};
use crate::lanes::{ABREAST, LANES, Lanes, Members};
use crate::local::Local;
use crate::matrices::MATRIX;
use crate::playback::Play;
use crate::rows::Joints;
use crate::widths::JointLanes;

/// Components of a local transform: translation, rotation, scale.
pub(crate) const COMPONENTS: usize = 10;

/// Sixteen joints of members side by side.
#[derive(Clone, Copy)]
pub(crate) struct Block<'a, 'b> {
    pub(crate) inputs: &'a FrameInputs<'b>,
    pub(crate) joints: Joints<'a>,
    /// Playing slots and layers of each member; `None` in lanes without a member.
    pub(crate) plays: &'a [Option<Play<'b>>],
    pub(crate) members: &'a [u32],
}

/// Poses a block.
///
/// Two passes, each short enough for a processor to have several members in flight: sums of slots,
/// and means. Rarely used changes follow.
pub(crate) struct PoseBlock<'a, 'b, 'c> {
    pub(crate) block: Block<'a, 'b>,
    /// The components of each member's pose, `stride` vectors apart.
    pub(crate) posed: &'c mut [Lanes],
    pub(crate) stride: usize,
    /// In: properties to leave out where no member moves them, of [`REST_TRANSLATION`] and
    /// [`REST_SCALE`]. Out: those that were left out.
    pub(crate) still: &'c mut u32,
}

impl Work for PoseBlock<'_, '_, '_> {
    #[inline(always)]
    fn run<J: JointLanes>(self) {
        let Self { block, posed, stride, still } = self;
        let Block { inputs, joints, plays, members } = block;
        let all = || {
            let plays = plays.iter().flatten().zip(members);
            plays.map(|(play, member)| play.posing(inputs, *member, joints)).enumerate()
        };
        let (mut totals, mut unweighted, mut at_rest) =
            ([0.0; ABREAST], [false; ABREAST], [0; ABREAST]);
        let rest = rest_of::<J>(&joints);
        for (lane, posing) in all() {
            let sum = posing.sum_layer(0, false, &rest);
            put_local(&sum.local, sum.at_rest, posed, stride, lane);
            (totals[lane], unweighted[lane], at_rest[lane]) =
                (sum.total, sum.unweighted, sum.at_rest);
            *still &= if posing.is_changed() { 0 } else { sum.at_rest };
        }
        for lane in 0..members.len() {
            let (total, unweighted) = (totals[lane], unweighted[lane]);
            let local = local_in(posed, stride, lane);
            let sum = Sum { local, total, unweighted, at_rest: at_rest[lane] };
            put_local(&mean_or_rest(&sum, &rest), *still, posed, stride, lane);
        }
        for (lane, posing) in all().filter(|(_, posing)| posing.is_changed()) {
            let pose = posing.change_pose(&rest.stored(), local_in::<Lanes>(posed, stride, lane));
            put_local(&pose, 0, posed, stride, lane);
        }
    }
}

/// Loads the pose in a lane.
#[inline(always)]
fn local_in<R: Members>(posed: &[Lanes], stride: usize, lane: usize) -> Local<R> {
    let part = |component: usize| R::load(&posed[component * stride + lane].0);
    Local {
        t: [part(0), part(1), part(2)],
        r: [part(3), part(4), part(5), part(6)],
        s: [part(7), part(8), part(9)],
    }
}

/// Stores the pose of a lane, except components that are left out.
#[inline(always)]
fn put_local<R: Members>(
    local: &Local<R>,
    still: u32,
    posed: &mut [Lanes],
    stride: usize,
    lane: usize,
) {
    let ([tx, ty, tz], [rx, ry, rz, rw], [sx, sy, sz]) = (local.t, local.r, local.s);
    for (component, value) in [tx, ty, tz, rx, ry, rz, rw, sx, sy, sz].into_iter().enumerate() {
        if !is_still(still, component) {
            value.store(&mut posed[component * stride + lane].0);
        }
    }
}

/// Returns whether a component is one of those that are left out.
#[inline(always)]
pub(crate) fn is_still(still: u32, component: usize) -> bool {
    still & REST_TRANSLATION != 0 && component < 3 || still & REST_SCALE != 0 && component >= 7
}

/// Poses of a block of joints, in lanes of members.
pub(crate) struct Posed<'a> {
    /// For each component and joint, a number for each member.
    pub(crate) locals: &'a [Lanes],
    /// Components that are left out are at rest.
    pub(crate) still: u32,
    /// Planes of the block's rest poses.
    pub(crate) rest: &'a [f32],
}

impl Posed<'_> {
    /// Returns the matrices of a joint's local transforms, for members from `first` on.
    #[inline(always)]
    pub(crate) fn matrices<R: Members>(&self, at: usize, first: usize) -> [R; MATRIX] {
        let mut parts = [R::splat(0.0); COMPONENTS];
        for (component, part) in parts.iter_mut().enumerate() {
            *part = if is_still(self.still, component) {
                // Planes of rotations come first.
                let plane = if component < 3 { component + 4 } else { component };
                R::splat(self.rest[plane * LANES + at])
            } else {
                R::load(&self.locals[component * LANES + at].0[first..])
            };
        }
        let [tx, ty, tz, rx, ry, rz, rw, sx, sy, sz] = parts;
        components([tx, ty, tz], [rx, ry, rz, rw], [sx, sy, sz])
    }
}
