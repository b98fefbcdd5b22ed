//! Joint readbacks that do not wait for the device.

use std::collections::BTreeMap;

use populace_clip::{FIRST_TICK, TICKS_PER_SEC};
use populace_device::layout::{Float4, WATCHED_ELEMENTS};
use populace_model::{Affine, JointIndex};

use super::MemberId;
use super::base::Base;
use super::constraints::Constraints;
use crate::Error;

/// A handle to a joint that is copied to the host after each frame. It goes stale when it is
/// removed, even if another watch of the same joint remains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Watch {
    pub(super) member: MemberId,
    joint: JointIndex,
    pub(super) serial: u32,
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
    /// The member whose joint it is.
    #[must_use]
    pub const fn member(&self) -> MemberId {
        self.member
    }

    pub(super) fn key(self) -> (MemberId, JointIndex) {
        (self.member, self.joint)
    }

    /// Its place among the watches of all members.
    fn place(self) -> (u32, u32) {
        (self.member.number(), self.serial)
    }
}

/// Watches that copy joints to the host.
#[derive(Clone, Debug, Default)]
pub(super) struct Readbacks {
    /// By member index and serial number, with the number of updates before each began.
    readers: BTreeMap<(u32, u32), (Watch, u64)>,
    last_serial: u32,
}

impl Readbacks {
    pub(super) fn is_empty(&self) -> bool {
        self.readers.is_empty()
    }

    pub(super) fn watch(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        member: MemberId,
        joint: JointIndex,
    ) -> Result<Watch, Error> {
        constraints.watch_joint(base, member, joint)?;
        self.last_serial = self.last_serial.wrapping_add(1);
        let watch = Watch { member, joint, serial: self.last_serial };
        self.readers.insert(watch.place(), (watch, base.clock.frame));
        Ok(watch)
    }

    /// Removes a watch; ignores a stale one.
    pub(super) fn unwatch(&mut self, base: &mut Base, constraints: &mut Constraints, watch: Watch) {
        if self.watched_since(watch).is_some() {
            self.readers.remove(&watch.place());
            constraints.unwatch_joint(base, watch.member, watch.joint);
        }
    }

    /// Removes all watches of a member that is despawned.
    pub(super) fn forget(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        member: MemberId,
    ) {
        let of_member = (member.number(), 0)..=(member.number(), u32::MAX);
        let watches = self.readers.range(of_member).map(|(_, (watch, _))| *watch);
        for watch in watches.filter(|watch| watch.member == member).collect::<Vec<_>>() {
            self.unwatch(base, constraints, watch);
        }
    }

    /// Finds a watch among the watched joints of tick `tick`; `None` if they do not hold it.
    pub(super) fn find(
        &self,
        base: &Base,
        constraints: &Constraints,
        watch: Watch,
        (tick, elements): (u64, &[Float4]),
    ) -> Option<JointReadback> {
        // Earlier results may hold another joint at this offset.
        let frame = base.clock.frame_of(tick)?;
        self.watched_since(watch).filter(|since| frame > *since)?;
        let first = (constraints.watched_index(watch.key())? * WATCHED_ELEMENTS) as usize;
        let rows = elements.get(first..first + WATCHED_ELEMENTS as usize)?;
        let world_from_joint = Affine { rows: [rows[0].0, rows[1].0, rows[2].0] };
        // Rows that were never written are zero.
        let seen = world_from_joint.rows[0][..3].iter().any(|v| *v != 0.0);
        let at_secs = tick.saturating_sub(FIRST_TICK) as f64 / TICKS_PER_SEC as f64;
        seen.then_some(JointReadback { at_secs, world_from_joint })
    }

    /// The number of updates before a watch began; `None` if it is stale.
    fn watched_since(&self, watch: Watch) -> Option<u64> {
        let (_, since) = self.readers.get(&watch.place()).filter(|(known, _)| *known == watch)?;
        Some(*since)
    }
}
