//! Members that their clips move over the ground.

use populace_core::StageBuffer;
use populace_core::layout::{Float4, MOTION_STATE, NONE, STATES_PER_CONTROL};

use super::controls::MemberControls;
use super::{Crowd, Member};
use crate::{Error, Placement};

impl Crowd {
    /// Lets the root motion of its clips ([`Clip::with_root_motion`](populace_core::Clip::with_root_motion)) move a member
    /// from where it was placed, from now on, or no longer: it then stands where it was placed.
    ///
    /// The device moves it, and nothing comes to the host: [`placement`](Self::placement) and [`instances`](Self::instances)
    /// still tell where it was placed, and its joints and palette where it is. Constraints, gazes and watches see it where it
    /// is. Motion is mixed as poses are, by the weights of slots and layers and what masks let through at the first joint;
    /// layers that add move nobody.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn move_by_clips(&mut self, member: Member, moves: bool) -> Result<(), Error> {
        let motion = moves.then(|| self.next_motion());
        self.change_controls(member, |controls| {
            controls.motion = motion;
            Ok(())
        })?;
        self.controls.entry(member.place).or_default().motion_tick = self.clock.tick;
        Ok(())
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

    /// Where a member stands after the last update, moved there from its placement by its clips. Waits for the device; a
    /// [`watch`](Self::watch) on its root does not.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a failing device.
    pub fn moved(&mut self, member: Member) -> Result<Placement, Error> {
        let placement = self.placement(member)?;
        let control = self.tables.members().as_slice()[member.place as usize].control;
        let has_moved = |state: &&MemberControls| state.motion_tick < self.clock.tick && control != NONE;
        let Some(motion) = self.controls.get(&member.place).filter(has_moved).and_then(|s| s.controls.motion)
        else {
            return Ok(placement);
        };
        let mut state = [Float4::default(); 2];
        let first = control as usize * STATES_PER_CONTROL as usize + MOTION_STATE as usize;
        self.opened.backend_mut().read(&self.tables, StageBuffer::States, first, &mut state)?;
        let [Float4([x, y, z, begun]), Float4([sin, cos, ..])] = state;
        if begun.to_bits() != motion {
            return Ok(placement);
        }
        let position = placement.world_from_model().transform_point([x, y, z]);
        Ok(Placement { position, yaw_rad: placement.yaw_rad + sin.atan2(cos), ..placement })
    }

    /// Places a member where its clips have moved it, from where they move it on. Waits as [`moved`](Self::moved) does.
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
            Some(_) => self.move_by_clips(member, true),
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
