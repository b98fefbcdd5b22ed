//! Root motion of members.

use populace_device::layout::{Float4, MOTION_STATE, NONE, STATES_PER_CONTROL, WATCHED_ELEMENTS};
use populace_device::{BackendError, StageBuffer};
use populace_model::JointIndex;

use super::{Crowd, MemberId, MemberState, Watch};
use crate::{Error, Placement};

/// The root motion of a member.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    /// The tick at which it began.
    since: u64,
    /// The readback of its root joint.
    watch: Watch,
    /// The root's offset from the placement when palettes were last acquired, in metres.
    pub(super) moved: [f32; 3],
}

impl Crowd {
    pub(super) fn move_by_clips(&mut self, member: MemberId, moves: bool) -> Result<(), Error> {
        self.check(member)?;
        if moves && self.motion_of(member).is_some() {
            return Ok(());
        }
        self.begin_or_end_motion(member, moves)
    }

    /// Starts or stops root motion from the member's placement.
    fn begin_or_end_motion(&mut self, member: MemberId, moves: bool) -> Result<(), Error> {
        let known = self.moving.get(&member.index).map(|moving| moving.watch);
        let watch = match known {
            None if moves => Some(self.watch(member, JointIndex(0))?),
            known => known,
        };
        let motion = moves.then(|| self.next_motion());
        let changed = self.change_controls(member, |controls| {
            controls.motion = motion;
            Ok(())
        });
        match watch {
            Some(watch) if moves && changed.is_ok() => self.note_moving(member, watch),
            Some(watch) if !moves || known.is_none() => {
                self.moving.remove(&member.index);
                self.unwatch(watch);
            }
            _ => {}
        }
        changed
    }

    fn note_moving(&mut self, member: MemberId, watch: Watch) {
        let moving = Moving { since: self.clock.tick, watch, moved: [0.0; 3] };
        self.moving.insert(member.index, moving);
    }

    /// Updates the cached root-motion offsets from the newest readback.
    pub(super) fn update_moved(&mut self) -> Result<(), BackendError> {
        if self.moving.is_empty() {
            return Ok(());
        }
        let Some((tick, elements)) = self.opened.backend_mut().fetched()? else { return Ok(()) };
        for (place, moving) in self.moving.iter_mut().filter(|(_, moving)| moving.since < tick) {
            let Some((watched, _)) = self.watches.0.get(&moving.watch.key()) else { continue };
            let first = (*watched * WATCHED_ELEMENTS) as usize;
            let MemberState { character, placement, .. } = self.members[*place as usize];
            let Some(character) = character else { continue };
            let skeleton = &self.characters[character.index()].character.skeleton;
            let rest = skeleton.rest(JointIndex(0)).translation;
            let placed = placement.world_from_model().transform_point(rest);
            if let Some(rows) = elements.get(first..first + WATCHED_ELEMENTS as usize) {
                moving.moved = std::array::from_fn(|axis| rows[axis].0[3] - placed[axis]);
            }
        }
        Ok(())
    }

    /// Returns the root-motion offset of a member, or of its parent, when palettes were last
    /// acquired.
    pub(super) fn shift_of(&self, mut place: u32) -> [f32; 3] {
        loop {
            if let Some(moving) = self.moving.get(&place) {
                return moving.moved;
            }
            match self.parent_index(place) {
                Some(parent) => place = parent,
                None => return [0.0; 3],
            }
        }
    }

    /// Ends the root motion of a member that is despawned.
    pub(super) fn forget_motion(&mut self, member: MemberId) {
        if let Some(moving) = self.moving.remove(&member.index) {
            self.unwatch(moving.watch);
        }
    }

    pub(super) fn moved(&mut self, member: MemberId) -> Result<Placement, Error> {
        let placement = self.members[member.index as usize].placement;
        let control = self.tables.members().as_slice()[member.index as usize].control;
        let begun =
            self.moving.get(&member.index).is_some_and(|moving| moving.since < self.clock.tick);
        let Some(motion) = self.motion_of(member).filter(|_| begun && control != NONE) else {
            return Ok(placement);
        };
        let first = control as usize * STATES_PER_CONTROL as usize + MOTION_STATE as usize;
        let mut state = [Float4::default(); 2];
        match &self.kept {
            Some(kept) => state = kept.states(first),
            None => self.opened.backend_mut().read(
                &self.tables,
                StageBuffer::States,
                first,
                &mut state,
            )?,
        }
        let [Float4([x, y, z, begun]), Float4([sin, cos, ..])] = state;
        if begun.to_bits() != motion {
            return Ok(placement);
        }
        let position = placement.world_from_model().transform_point([x, y, z]);
        Ok(Placement { position, yaw_rad: placement.yaw_rad + sin.atan2(cos), ..placement })
    }

    pub(super) fn place_where_moved(&mut self, member: MemberId) -> Result<Placement, Error> {
        let placement = self.moved(member)?;
        self.place(member, placement)?;
        Ok(placement)
    }

    /// Restarts root motion from a new placement, if the member has root motion.
    pub(super) fn restart_motion(&mut self, member: MemberId) -> Result<(), Error> {
        match self.motion_of(member) {
            Some(_) => self.begin_or_end_motion(member, true),
            None => Ok(()),
        }
    }

    pub(super) fn motion_of(&self, member: MemberId) -> Option<u32> {
        self.controls.get(&member.index)?.controls.motion
    }

    /// A number that no other motion has. Devices keep it as the bits of a number, 0 for none yet.
    fn next_motion(&mut self) -> u32 {
        self.motions = self.motions % (NONE - 1) + 1;
        self.motions
    }
}
