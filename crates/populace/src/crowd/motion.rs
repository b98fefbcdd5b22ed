//! Members that their clips move over the ground.

use populace_device::layout::{Float4, MOTION_STATE, NONE, STATES_PER_CONTROL, WATCHED_ELEMENTS};
use populace_device::{BackendError, StageBuffer};
use populace_model::JointIndex;

use super::{Crowd, Member, MemberState, Watch};
use crate::{Error, Placement};

/// A member that its clips move.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    /// The clock when it began.
    since: u64,
    /// Its root, brought to the host.
    watch: Watch,
    /// How far that was from the member's placement when palettes were last taken.
    pub(super) moved: [f32; 3],
}

impl Crowd {
    /// Lets the root motion of its clips
    /// ([`Clip::with_root_motion`](populace_clip::Clip::with_root_motion)) move a member from where
    /// it was placed, from now on, or no longer: it then stands where it was placed.
    ///
    /// The device moves it, and nobody waits for that: [`placement`](Self::placement) still tells
    /// where it was placed, and its joints and palette where it is. Constraints and watches see it
    /// there; what is told in model space (targets, poles, overrides) counts from the placement.
    /// Motion is mixed as poses are, by the weights of slots and layers and what masks let through
    /// at the first joint; layers that add move nobody. What plays for a part of an update moves it
    /// for that part, unless something else took its slot, or a blend space that waited for one
    /// went on, within the same update. Fused schedules move those who have a mesh: others are not
    /// evaluated.
    ///
    /// A member that its clips move already goes on from where they have moved it.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn move_by_clips(&mut self, member: Member, moves: bool) -> Result<(), Error> {
        self.check(member)?;
        if moves && self.motion_of(member).is_some() {
            return Ok(());
        }
        self.begin_or_end_motion(member, moves)
    }

    /// Lets clips move a member from its placement, or no longer.
    fn begin_or_end_motion(&mut self, member: Member, moves: bool) -> Result<(), Error> {
        let known = self.moving.get(&member.place).map(|moving| moving.watch);
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
                self.moving.remove(&member.place);
                self.unwatch(watch);
            }
            _ => {}
        }
        changed
    }

    fn note_moving(&mut self, member: Member, watch: Watch) {
        let moving = Moving { since: self.clock.tick, watch, moved: [0.0; 3] };
        self.moving.insert(member.place, moving);
    }

    /// Takes over where members were when what last came to the host was so.
    pub(super) fn look_where_moved(&mut self) -> Result<(), BackendError> {
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

    /// How far a member, or what it is attached to, was moved by its clips when palettes were last
    /// taken.
    pub(super) fn shift_of(&self, mut place: u32) -> [f32; 3] {
        loop {
            if let Some(moving) = self.moving.get(&place) {
                return moving.moved;
            }
            match self.bearer_place(place) {
                Some(bearer) => place = bearer,
                None => return [0.0; 3],
            }
        }
    }

    /// Lets go of what is known of the motion of a member that leaves.
    pub(super) fn forget_motion(&mut self, member: Member) {
        if let Some(moving) = self.moving.remove(&member.place) {
            self.unwatch(moving.watch);
        }
    }

    /// Whether the root motion of its clips moves a member.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn is_moved_by_clips(&self, member: Member) -> Result<bool, Error> {
        self.check(member)?;
        Ok(self.motion_of(member).is_some())
    }

    /// Where a member stands after the last update, moved there from its placement by its clips;
    /// what it is attached to is not looked at. Waits for the device; a [`watch`](Self::watch) on
    /// its root does not.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a failing device.
    pub fn moved(&mut self, member: Member) -> Result<Placement, Error> {
        let placement = self.placement(member)?;
        let control = self.tables.members().as_slice()[member.place as usize].control;
        let begun =
            self.moving.get(&member.place).is_some_and(|moving| moving.since < self.clock.tick);
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

    /// Places a member where its clips have moved it, from where they move it on. Waits as
    /// [`moved`](Self::moved) does.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a failing device.
    pub fn place_where_moved(&mut self, member: Member) -> Result<Placement, Error> {
        let placement = self.moved(member)?;
        self.place(member, placement)?;
        Ok(placement)
    }

    /// Lets clips move a member from its placement again, if they move it.
    pub(super) fn begin_motion_anew(&mut self, member: Member) -> Result<(), Error> {
        match self.motion_of(member) {
            Some(_) => self.begin_or_end_motion(member, true),
            None => Ok(()),
        }
    }

    fn motion_of(&self, member: Member) -> Option<u32> {
        self.controls.get(&member.place)?.controls.motion
    }

    /// A number that no other motion has. Devices keep it as the bits of a number, 0 for none yet.
    fn next_motion(&mut self) -> u32 {
        self.motions = self.motions % (NONE - 1) + 1;
        self.motions
    }
}
