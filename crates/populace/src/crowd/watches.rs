//! Joints that are read back without waiting.

use populace_clip::TICKS_PER_SEC;
use populace_device::layout::WATCHED_ELEMENTS;
use populace_model::{Affine, JointIndex};

use super::{Crowd, FIRST_TICK, Member};
use crate::Error;

/// A joint that is brought to the host after each frame. It goes stale once it is let go of,
/// whoever else watches the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Watch {
    member: Member,
    joint: JointIndex,
    serial: u32,
}

/// A joint as it was a little while ago.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The crowd's clock then, from its beginning on.
    pub at_secs: f64,
    /// Where it was in the world.
    pub world_from_joint: Affine,
}

impl Watch {
    pub(super) fn key(self) -> (Member, JointIndex) {
        (self.member, self.joint)
    }
}

impl Crowd {
    /// Lets a member's joint be brought to the host after each frame from the next on, without
    /// anyone waiting for it.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a joint that is not there.
    pub fn watch(&mut self, member: Member, joint: JointIndex) -> Result<Watch, Error> {
        self.watch_joint(member, joint)?;
        let watch = Watch { member, joint, serial: self.next_serial() };
        self.readers.insert(watch.serial, (watch, self.clock.tick));
        Ok(watch)
    }

    /// Lets go of a joint that was watched; one that is watched twice is until both are let go of.
    /// A watch that was let go of before, and one of another crowd, does nothing.
    pub fn unwatch(&mut self, watch: Watch) {
        if self.watched_since(watch).is_some() {
            self.readers.remove(&watch.serial);
            self.unwatch_joint(watch.member, watch.joint);
        }
    }

    /// The clock when a watch began, where it goes on.
    fn watched_since(&self, watch: Watch) -> Option<u64> {
        let (_, since) = self.readers.get(&watch.serial).filter(|(known, _)| *known == watch)?;
        Some(*since)
    }

    /// Lets go of all that is watched of a member that leaves.
    pub(super) fn forget_watches(&mut self, member: Member) {
        let watches = self.readers.values().map(|(watch, _)| *watch);
        for watch in watches.filter(|watch| watch.member == member).collect::<Vec<_>>() {
            self.unwatch(watch);
        }
    }

    /// The newest that has come to the host of a joint that is watched: as of the last update on
    /// the native device, some frames ago on others. `None` until an update has moved the clock on
    /// since the watch began and its result has come, and once the watch was let go of or the
    /// member has left.
    ///
    /// # Errors
    ///
    /// A watch of another crowd, or a failing device.
    pub fn sighting(&mut self, watch: Watch) -> Result<Option<Sighting>, Error> {
        self.check_crowd("watch", watch.member.crowd, watch.serial)?;
        let Some(since) = self.watched_since(watch) else { return Ok(None) };
        let Some((watched, _)) = self.watches.0.get(&watch.key()) else { return Ok(None) };
        let first = (*watched * WATCHED_ELEMENTS) as usize;
        let fetched = self.opened.backend_mut().fetched()?;
        // Before that another joint may have had its place.
        let Some((tick, elements)) = fetched.filter(|(tick, _)| *tick > since) else {
            return Ok(None);
        };
        let Some(rows) = elements.get(first..first + WATCHED_ELEMENTS as usize) else {
            return Ok(None);
        };
        let world_from_joint = Affine { rows: [rows[0].0, rows[1].0, rows[2].0] };
        // What was never written is all zeros.
        let seen = world_from_joint.rows[0][..3].iter().any(|v| *v != 0.0);
        let at_secs = tick.saturating_sub(FIRST_TICK) as f64 / TICKS_PER_SEC as f64;
        Ok(seen.then_some(Sighting { at_secs, world_from_joint }))
    }

    /// How often the host has waited for a device of the kind in use since the process began.
    /// [`update`](Self::update) does not make it wait on one device; reading back does, but for
    /// [`sighting`](Self::sighting).
    #[must_use]
    pub fn waits(&self) -> u64 {
        self.opened.backend().waits()
    }
}
