//! Root motion of a member, and the events of its clips.

use std::borrow::Borrow;

use super::super::state::State;
use super::{MemberMut, MemberView};
use crate::{Error, Placement};

impl<C: Borrow<State>> MemberView<C> {
    /// Returns whether root motion moves the member.
    #[must_use]
    pub fn has_root_motion(&self) -> bool {
        self.state().constraints.motion(self.id).is_some()
    }
}

impl MemberMut<'_> {
    /// Makes the root motion of its clips
    /// ([`Clip::with_root_motion`](populace_clip::Clip::with_root_motion)) move the member from its
    /// placement. A member with root motion continues.
    ///
    /// The device moves it, and the host does not wait: [`placement`](Self::placement) stays as
    /// set, while joints, palette, constraints and readbacks are where the member has moved.
    /// Targets, poles and overrides in model space refer to the placement. Root motion is mixed as
    /// poses are: by the weights of slots and layers, and by the mask at the first joint; additive
    /// layers add none. A clip that plays for a part of an update moves the member for that part,
    /// unless its slot is taken over within the same update. Fused schedules do not evaluate
    /// members without a mesh, so these do not move.
    ///
    /// The way is summed up with what rounding leaves out of it: after a run of 16 km in an hour,
    /// at 60 or 144 updates per second, the member is where it should be to within 4 mm.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn start_root_motion(&mut self) -> Result<(), Error> {
        self.crowd.state.start_motion(self.id)
    }

    /// Ends root motion and returns the member to its placement.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn stop_root_motion(&mut self) -> Result<(), Error> {
        self.crowd.state.stop_motion(self.id)
    }

    /// Returns the placement to which root motion has moved the member by the last update. The
    /// motion of a parent is not included. Waits for the device;
    /// [`watch_joint`](Self::watch_joint) on the root does not.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn moved_placement(&mut self) -> Result<Placement, Error> {
        self.crowd.moved_placement(self.id)
    }

    /// Sets the placement to which root motion has moved the member, and returns it. Root motion
    /// continues from there. Waits for the device. Update the crowd before the next draw: until
    /// then the palette still holds the way that the member has moved.
    ///
    /// Each call rounds the position to single precision, which the way from the placement is not:
    /// after a call per frame, a run at 100 km from the origin is 4 % too fast. Call it now and
    /// then.
    ///
    /// # Errors
    ///
    /// A failing device, or [`Error::BadAttachment`] if the member is attached to another.
    pub fn commit_root_motion(&mut self) -> Result<Placement, Error> {
        let placement = self.crowd.moved_placement(self.id)?;
        self.crowd.state.set_placement(self.id, placement)?;
        Ok(placement)
    }

    /// Reports the member's events in [`Crowd::events`](crate::Crowd::events) from the next update
    /// on.
    pub fn subscribe_events(&mut self) {
        self.crowd.state.events.subscribe(self.id);
    }

    /// Reports the member's events no longer.
    pub fn unsubscribe_events(&mut self) {
        self.crowd.state.events.unsubscribe(self.id);
    }
}
