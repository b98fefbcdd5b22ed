//! Results of a member, read from the device.

use populace_model::{Affine, JointIndex, Trs};

use super::super::Watch;
use super::MemberMut;
use crate::Error;

impl MemberMut<'_> {
    /// Returns the matrix palette after the last update: `model_from_bind` for each palette entry.
    /// Waits for the device.
    ///
    /// # Errors
    ///
    /// [`BackendError::NotEvaluated`](crate::BackendError::NotEvaluated) if the last update has not
    /// evaluated the member on this device, as where it [hid](crate::Crowd::set_view) the member,
    /// or a failing device.
    pub fn palette(&mut self) -> Result<Vec<Affine>, Error> {
        self.crowd.palette(self.id)
    }

    /// Returns the joints in model space after the last update, in level order, as they are drawn.
    /// Waits for the device.
    ///
    /// With a [view](crate::Crowd::set_view), joints that the member's level of detail leaves out,
    /// such as fingers, hang from the others as at rest. [Watched](Self::watch_joint) joints and
    /// those that constraints need are evaluated all the same, and so is the whole member in an
    /// update without a view.
    ///
    /// # Errors
    ///
    /// As for [`palette`](Self::palette).
    pub fn model_from_joints(&mut self) -> Result<Vec<Affine>, Error> {
        self.crowd.model_from_joints(self.id)
    }

    /// Returns the local transforms that the clips gave the joints in the last update, in level
    /// order. Waits for the device.
    ///
    /// Proportions, overrides in local space and stages after Pose are in them; what comes later is
    /// not: look-at, reach, planted feet, overrides in model space, stages after Transform, root
    /// motion and attachments. [`model_from_joints`](Self::model_from_joints) returns the joints
    /// after all of that. Joints that the member's level of detail leaves out are at rest.
    ///
    /// # Errors
    ///
    /// As for [`palette`](Self::palette).
    pub fn local_pose(&mut self) -> Result<Vec<Trs>, Error> {
        self.crowd.local_pose(self.id)
    }

    /// Copies a joint to the host after each frame from the next update on, without waiting for
    /// the device. [`Crowd::readback`](crate::Crowd::readback) returns the newest copy.
    ///
    /// # Errors
    ///
    /// A joint that does not exist.
    pub fn watch_joint(&mut self, joint: JointIndex) -> Result<Watch, Error> {
        self.crowd.state.watch(self.id, joint)
    }

    /// Removes a watch of this member. A joint with several watches is copied until all are
    /// removed. A stale watch and one of another member are ignored.
    pub fn unwatch_joint(&mut self, watch: Watch) {
        if watch.member == self.id {
            self.crowd.state.unwatch(watch);
        }
    }
}
