//! The state of a crowd on the host: subsystems, and the operations that concern several.

use populace_model::{JointIndex, Trs};
use populace_settings::parts::Check;

use super::attach::Attachments;
use super::base::Base;
use super::constraints::Constraints;
use super::events::Events;
use super::live::LiveClips;
use super::motion::RootMotion;
use super::player::Player;
use super::stages::{StageId, UserStages};
use super::watches::Readbacks;
use super::{MemberId, Watch};
use crate::{Error, Placement, StageUse};

/// All that the host knows of a crowd: the base, and the subsystems that work on it. Each
/// subsystem owns its state; what concerns several is done here.
#[derive(Clone)]
pub struct State {
    pub(super) base: Base,
    pub(super) player: Player,
    pub(super) constraints: Constraints,
    pub(super) attachments: Attachments,
    pub(super) motion: RootMotion,
    pub(super) readbacks: Readbacks,
    pub(super) events: Events,
    pub(super) live: LiveClips,
    pub(super) stages: UserStages,
}

impl State {
    pub(super) fn new(base: Base) -> Self {
        Self {
            base,
            player: Player::default(),
            constraints: Constraints::default(),
            attachments: Attachments::default(),
            motion: RootMotion::default(),
            readbacks: Readbacks::default(),
            events: Events::default(),
            live: LiveClips::default(),
            stages: UserStages::default(),
        }
    }

    pub(super) fn player(&mut self) -> (&mut Player, &mut Base) {
        (&mut self.player, &mut self.base)
    }

    pub(super) fn constraints(&mut self) -> (&mut Constraints, &mut Base) {
        (&mut self.constraints, &mut self.base)
    }

    /// Starts what is scheduled by `tick`, and checks the tables for an evaluation.
    pub(super) fn begin_due(&mut self, tick: u64) -> Result<(), Error> {
        self.player.begin_due(&mut self.base, tick)?;
        Ok(self.base.tables.check_ranges()?)
    }

    /// Collects the events of a frame that was evaluated, and sets the clock.
    pub(super) fn end_frame(&mut self, tick: u64, left_over: f64) {
        let Self { base, player, events, .. } = self;
        // After a jump back, no time has passed in which anything could happen.
        events.find(base, player.take_left(), (base.clock.tick.min(tick), tick));
        base.clock.end_frame(tick, left_over);
    }

    pub(super) fn despawn(&mut self, member: MemberId) -> Result<(), Error> {
        let Self { base, player, constraints, attachments, motion, readbacks, .. } = self;
        base.check(member)?;
        attachments.detach_all(base, constraints, member)?;
        readbacks.forget(base, constraints, member);
        motion.forget(base, constraints, readbacks, member);
        constraints.forget(base, member);
        player.forget(member);
        base.remove_member(member);
        Ok(())
    }

    pub(super) fn set_placement(
        &mut self,
        member: MemberId,
        placement: Placement,
    ) -> Result<(), Error> {
        self.base.check(member)?;
        placement.check()?;
        self.attachments.check_placeable(member)?;
        self.place(member, placement)
    }

    /// Sets a placement that was checked.
    pub(super) fn place(&mut self, member: MemberId, placement: Placement) -> Result<(), Error> {
        let Self { base, constraints, motion, readbacks, .. } = self;
        if constraints.motion(member).is_some() {
            motion.start(base, constraints, readbacks, member)?;
        }
        base.members.all[member.number() as usize].placement = placement;
        base.upload_placement(member)?;
        self.attachments.place_children(base, member)
    }

    pub(super) fn attach(
        &mut self,
        child: MemberId,
        to: MemberId,
        joint: JointIndex,
        offset: Trs,
    ) -> Result<(), Error> {
        let Self { base, constraints, attachments, .. } = self;
        attachments.attach(base, constraints, child, to, joint, offset)
    }

    pub(super) fn detach(&mut self, child: MemberId) -> Result<(), Error> {
        let Self { base, constraints, attachments, .. } = self;
        attachments.detach(base, constraints, child)
    }

    pub(super) fn start_motion(&mut self, member: MemberId) -> Result<(), Error> {
        let Self { base, constraints, motion, readbacks, .. } = self;
        match constraints.motion(member) {
            Some(_) => Ok(()),
            None => motion.start(base, constraints, readbacks, member),
        }
    }

    pub(super) fn stop_motion(&mut self, member: MemberId) -> Result<(), Error> {
        let Self { base, constraints, motion, readbacks, .. } = self;
        motion.stop(base, constraints, readbacks, member)
    }

    pub(super) fn watch(&mut self, member: MemberId, joint: JointIndex) -> Result<Watch, Error> {
        self.readbacks.watch(&mut self.base, &mut self.constraints, member, joint)
    }

    pub(super) fn unwatch(&mut self, watch: Watch) {
        self.readbacks.unwatch(&mut self.base, &mut self.constraints, watch);
    }

    /// Returns the root-motion offset of a member, or of its parent, as last known.
    pub(super) fn offset_of(&self, index: u32) -> [f32; 3] {
        offset(&self.motion, &self.attachments, index)
    }

    pub(super) fn set_stage(
        &mut self,
        member: MemberId,
        id: StageId,
        usage: StageUse,
    ) -> Result<(), Error> {
        self.stages.set(&mut self.base, &mut self.constraints, member, id, usage)
    }

    pub(super) fn clear_stage(&mut self, member: MemberId, id: StageId) -> Result<(), Error> {
        self.stages.clear(&mut self.base, &mut self.constraints, member, id)
    }
}

/// See [`State::offset_of`].
pub(super) fn offset(motion: &RootMotion, attachments: &Attachments, mut index: u32) -> [f32; 3] {
    if motion.is_empty() {
        return [0.0; 3];
    }
    loop {
        if let Some(offset) = motion.offset(index) {
            return offset;
        }
        match attachments.parent_index(index) {
            Some(parent) => index = parent,
            None => return [0.0; 3],
        }
    }
}
