//! Changes of poses that few members have, such as layers and inertialization.

use crate::dispatch::Work;
use crate::lanes::{Lanes, Width};
use crate::local::Local;
use crate::processor::Dispatch;
use crate::widths::{JointLanes, SampleWidth};

/// A width in memory, in which few members' changes are applied. They are compiled apart from the
/// path of all members, so that it does not pay for their registers.
pub(crate) trait PoseWidth: SampleWidth<Stored = Self> + Width {
    /// Applies a change to a pose.
    fn apply<C: Change>(change: &C, dispatch: Dispatch, rest: &Local<Self>, pose: &mut Local<Self>);
}

/// A change of a pose.
pub(crate) trait Change {
    /// Returns the changed pose. Must be `#[inline(always)]`, as [`Work::run`] must be.
    fn changed<R: SampleWidth<Stored: PoseWidth>>(
        &self,
        rest: &Local<R>,
        pose: Local<R>,
    ) -> Local<R>;
}

impl PoseWidth for f32 {
    #[inline(never)]
    fn apply<C: Change>(change: &C, _: Dispatch, rest: &Local<Self>, pose: &mut Local<Self>) {
        *pose = change.changed(rest, *pose);
    }
}

impl PoseWidth for Lanes {
    #[inline(always)]
    fn apply<C: Change>(
        change: &C,
        dispatch: Dispatch,
        rest: &Local<Self>,
        pose: &mut Local<Self>,
    ) {
        dispatch.run(ChangeJoints { change, rest, pose });
    }
}

/// A [`Change`] of sixteen joints.
struct ChangeJoints<'a, C> {
    change: &'a C,
    rest: &'a Local<Lanes>,
    pose: &'a mut Local<Lanes>,
}

impl<C: Change> Work for ChangeJoints<'_, C> {
    #[inline(always)]
    fn run<J: JointLanes>(self) {
        let (rest, pose) = (Local::<J>::loaded(*self.rest), Local::loaded(*self.pose));
        *self.pose = self.change.changed(&rest, pose).stored();
    }
}
