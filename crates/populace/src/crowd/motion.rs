//! Root motion of members.

use populace_device::layout::{Float4, MOTION_STATE, NONE, STATES_PER_CONTROL, WATCHED_ELEMENTS};
use populace_model::JointIndex;
use populace_settings::parts::Parts;

use super::base::{Base, MemberState};
use super::by_member::ByMember;
use super::constraints::Constraints;
use super::watches::Readbacks;
use super::{MemberId, Watch};
use crate::{Error, Placement};

/// The members with root motion.
#[derive(Clone, Debug, Default)]
pub(super) struct RootMotion {
    /// By member index.
    moving: ByMember<Moving>,
    /// The crowd's frame, and the tick of the watched joints, at the last update of the offsets.
    updated_at: Option<(u64, u64)>,
    /// The number of times that root motion has begun.
    begun: u32,
}

/// The root motion of a member.
#[derive(Clone, Copy, Debug)]
struct Moving {
    /// The number of updates before it began. A jump back in time does not undo it.
    since: u64,
    /// The readback of its root joint.
    watch: Watch,
    /// The root's offset from the placement as last known, in metres.
    moved: [f32; 3],
}

/// Elements of a device's history that hold the root motion of a member.
pub(super) struct MotionState {
    /// The number of the motion, as [`RootMotion`] counts them.
    motion: u32,
    pub(super) first: usize,
}

impl RootMotion {
    pub(super) fn is_empty(&self) -> bool {
        self.moving.is_empty()
    }

    /// Starts root motion from the member's placement; restarts it if it has begun.
    pub(super) fn start(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        readbacks: &mut Readbacks,
        member: MemberId,
    ) -> Result<(), Error> {
        let known = self.moving.get(member.number()).map(|moving| moving.watch);
        let watch = match known {
            Some(watch) => watch,
            None => readbacks.watch(base, constraints, member, JointIndex(0))?,
        };
        let motion = self.next_number();
        let changed = constraints.change(base, member, |controls| {
            controls.motion = Some(motion);
        });
        if changed.is_ok() {
            let moving = Moving { since: base.clock.frame, watch, moved: [0.0; 3] };
            self.moving.insert(member.number(), moving);
            base.members.all[member.number() as usize].moves = true;
        } else if known.is_none() {
            readbacks.unwatch(base, constraints, watch);
        }
        changed
    }

    /// Ends root motion; the member is back at its placement.
    pub(super) fn stop(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        readbacks: &mut Readbacks,
        member: MemberId,
    ) -> Result<(), Error> {
        self.forget(base, constraints, readbacks, member);
        constraints.change(base, member, |controls| {
            controls.motion = None;
        })
    }

    /// Forgets the root motion of a member, such as of one that is despawned.
    pub(super) fn forget(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        readbacks: &mut Readbacks,
        member: MemberId,
    ) {
        if let Some(moving) = self.moving.remove(member.number()) {
            base.members.all[member.number() as usize].moves = false;
            readbacks.unwatch(base, constraints, moving.watch);
        }
    }

    /// Updates the cached root-motion offsets from the watched joints of tick `tick`.
    pub(super) fn update_offsets(
        &mut self,
        base: &Base,
        constraints: &Constraints,
        tick: u64,
        elements: &[Float4],
    ) {
        // Each page that is read asks for offsets.
        let now = (base.clock.frame, tick);
        if self.updated_at.replace(now) == Some(now) {
            return;
        }
        let Some(frame) = base.clock.frame_of(tick) else { return };
        for (index, moving) in self.moving.iter_mut().filter(|(_, moving)| moving.since < frame) {
            let Some(watched) = constraints.watched_index(moving.watch.key()) else { continue };
            let first = (watched * WATCHED_ELEMENTS) as usize;
            let MemberState { character, placement, .. } = base.members.all[index as usize];
            let Some(character) = character else { continue };
            let skeleton = &base.assets.characters[character.parts().index].character.skeleton;
            let rest = skeleton.rest(JointIndex(0)).translation;
            let placed = placement.world_from_model().transform_point(rest);
            if let Some(rows) = elements.get(first..first + WATCHED_ELEMENTS as usize) {
                moving.moved = std::array::from_fn(|axis| rows[axis].0[3] - placed[axis]);
            }
        }
    }

    /// Returns the root-motion offset of the member at an index, as last known.
    pub(super) fn offset(&self, index: u32) -> Option<[f32; 3]> {
        self.moving.get(index).map(|moving| moving.moved)
    }

    /// Returns the elements of the history that hold a member's motion; `None` if it has not moved.
    pub(super) fn state_of(
        &self,
        base: &Base,
        constraints: &Constraints,
        member: MemberId,
    ) -> Option<MotionState> {
        let moving = self.moving.get(member.number())?;
        let control = base.tables.members().as_slice()[member.number() as usize].control;
        let motion = constraints.motion(member)?;
        let has_moved = moving.since < base.clock.frame && control != NONE;
        let first = control as usize * STATES_PER_CONTROL as usize + MOTION_STATE as usize;
        has_moved.then_some(MotionState { motion, first })
    }

    /// The number of the last motion that has begun.
    pub(super) fn last_number(&self) -> u32 {
        self.begun
    }

    /// Gives the next motions numbers after this one.
    pub(super) fn continue_after(&mut self, number: u32) {
        self.begun = self.begun.max(number);
    }

    /// A number that no other motion has. Devices keep it as the bits of a number, 0 for none yet.
    fn next_number(&mut self) -> u32 {
        self.begun = self.begun % (NONE - 1) + 1;
        self.begun
    }
}

impl MotionState {
    /// Returns where the motion has taken a member from its placement.
    pub(super) fn moved(&self, placement: Placement, elements: [Float4; 2]) -> Placement {
        let [Float4([x, y, z, begun]), Float4([sin, cos, ..])] = elements;
        if begun.to_bits() != self.motion {
            return placement;
        }
        let position = placement.world_from_model().transform_point([x, y, z]);
        let yaw_rad = placement.yaw_rad() + sin.atan2(cos);
        Placement::at(position).facing(yaw_rad).scaled(placement.scale())
    }
}
