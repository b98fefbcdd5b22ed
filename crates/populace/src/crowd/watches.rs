//! Joint readbacks that do not wait for the device.

use populace_clip::TICKS_PER_SEC;
use populace_device::layout::WATCHED_ELEMENTS;
use populace_model::{Affine, JointIndex};

use super::{Crowd, FIRST_TICK, MemberId};
use crate::Error;

/// A handle to a joint that is copied to the host after each frame. It goes stale when it is
/// removed, even if another watch of the same joint remains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Watch {
    member: MemberId,
    joint: JointIndex,
    serial: u32,
}

/// A joint as of a recent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointReadback {
    /// The time of that frame, in seconds since the crowd was built.
    pub at_secs: f64,
    /// The joint in world space.
    pub world_from_joint: Affine,
}

impl Watch {
    pub(super) fn key(self) -> (MemberId, JointIndex) {
        (self.member, self.joint)
    }
}

impl Crowd {
    pub(super) fn watch(&mut self, member: MemberId, joint: JointIndex) -> Result<Watch, Error> {
        self.watch_joint(member, joint)?;
        let watch = Watch { member, joint, serial: self.next_serial() };
        self.readers.insert(watch.serial, (watch, self.clock.tick));
        Ok(watch)
    }

    /// Removes a watch. A joint with several watches is copied until all are removed. A stale watch
    /// and one of another crowd are ignored.
    pub fn unwatch(&mut self, watch: Watch) {
        if self.watched_since(watch).is_some() {
            self.readers.remove(&watch.serial);
            self.unwatch_joint(watch.member, watch.joint);
        }
    }

    /// The tick at which a watch began; `None` if it is stale.
    fn watched_since(&self, watch: Watch) -> Option<u64> {
        let (_, since) = self.readers.get(&watch.serial).filter(|(known, _)| *known == watch)?;
        Some(*since)
    }

    /// Removes all watches of a member that is despawned.
    pub(super) fn forget_watches(&mut self, member: MemberId) {
        let watches = self.readers.values().map(|(watch, _)| *watch);
        for watch in watches.filter(|watch| watch.member == member).collect::<Vec<_>>() {
            self.unwatch(watch);
        }
    }

    /// Returns the newest copy of a watched joint that has reached the host: of the last update on
    /// the native device, some frames old on others. `None` until an update has advanced the clock
    /// since the watch began and its result has arrived, and after the watch or the member was
    /// removed.
    ///
    /// # Errors
    ///
    /// A watch of another crowd, or a failing device.
    pub fn readback(&mut self, watch: Watch) -> Result<Option<JointReadback>, Error> {
        self.check_crowd("watch", watch.member.crowd, watch.serial)?;
        let Some(since) = self.watched_since(watch) else { return Ok(None) };
        let Some((watched, _)) = self.watches.0.get(&watch.key()) else { return Ok(None) };
        let first = (*watched * WATCHED_ELEMENTS) as usize;
        let fetched = self.opened.backend_mut().fetched()?;
        // Earlier results may hold another joint at this offset.
        let Some((tick, elements)) = fetched.filter(|(tick, _)| *tick > since) else {
            return Ok(None);
        };
        let Some(rows) = elements.get(first..first + WATCHED_ELEMENTS as usize) else {
            return Ok(None);
        };
        let world_from_joint = Affine { rows: [rows[0].0, rows[1].0, rows[2].0] };
        // Rows that were never written are zero.
        let seen = world_from_joint.rows[0][..3].iter().any(|v| *v != 0.0);
        let at_secs = tick.saturating_sub(FIRST_TICK) as f64 / TICKS_PER_SEC as f64;
        Ok(seen.then_some(JointReadback { at_secs, world_from_joint }))
    }

    /// The number of times that the host has waited for a device of the kind in use since the
    /// process began. [`update`](Self::update) on one device does not wait. Reading results does,
    /// except for [`readback`](Self::readback).
    #[must_use]
    pub fn host_waits(&self) -> u64 {
        self.opened.backend().waits()
    }
}
