//! Joints that targets and readbacks watch.

use populace_device::layout::TARGET_WATCHED;
use populace_model::JointIndex;

use super::Constraints;
use super::targets::targets_of;
use crate::Error;
use crate::crowd::MemberId;
use crate::crowd::base::Base;

impl Constraints {
    /// Watches a joint for a target of `watcher` and returns its index on the device.
    pub(super) fn watch_for(
        &mut self,
        base: &mut Base,
        watcher: MemberId,
        other: MemberId,
        joint: JointIndex,
    ) -> Result<u32, Error> {
        let key = (other, joint);
        let watching =
            self.controls.get(watcher.number()).is_some_and(|state| state.watching.contains(&key));
        if let Some((watched, _)) = self.watches.get(&key).filter(|_| watching) {
            return Ok(*watched);
        }
        let watched = self.watch_joint(base, other, joint)?;
        self.controls.get_or_default(watcher.number()).watching.push(key);
        Ok(watched)
    }

    pub(crate) fn watch_joint(
        &mut self,
        base: &mut Base,
        other: MemberId,
        joint: JointIndex,
    ) -> Result<u32, Error> {
        base.check(other)?;
        if let Some((watched, count)) = self.watches.get_mut(&(other, joint)) {
            *count += 1;
            return Ok(*watched);
        }
        let watched = base.tables.add_watched();
        let changed = self.change(base, other, |controls| {
            controls.watches.push((joint, watched));
        });
        if let Err(error) = changed {
            base.tables.remove_watched(watched);
            return Err(error);
        }
        self.watches.insert((other, joint), (watched, 1));
        Ok(watched)
    }

    pub(crate) fn unwatch_joint(&mut self, base: &mut Base, other: MemberId, joint: JointIndex) {
        let Some((watched, count)) = self.watches.get_mut(&(other, joint)) else { return };
        *count -= 1;
        if *count > 0 {
            return;
        }
        let watched = *watched;
        self.watches.remove(&(other, joint));
        base.tables.remove_watched(watched);
        // If the other member is gone there is nothing to change.
        let _left = self.change(base, other, |controls| {
            controls.watches.retain(|(_, index)| *index != watched);
        });
    }

    /// Ends the watches of joints that no target of the member names any longer, and forgets a
    /// program that does nothing.
    pub(super) fn forget_unused(&mut self, base: &mut Base, member: MemberId) {
        for (other, joint) in self.take_unnamed_watches(member) {
            self.unwatch_joint(base, other, joint);
        }
        if self.controls(member).is_some_and(|state| state.controls.is_empty()) {
            self.controls.remove(member.number());
        }
    }

    /// Takes the joints that a member watches and that none of its targets names.
    fn take_unnamed_watches(&mut self, member: MemberId) -> Vec<(MemberId, JointIndex)> {
        let state = self.controls.get_mut(member.number());
        let Some(state) = state.filter(|state| !state.watching.is_empty()) else {
            return Vec::new();
        };
        let targets = state.controls.constraints.iter_mut().flat_map(targets_of);
        let named: Vec<u32> = targets
            .filter(|target| target.kind == TARGET_WATCHED)
            .map(|target| target.watched)
            .collect();
        let watches = &self.watches;
        let is_over = |key: &mut (MemberId, JointIndex)| {
            watches.get(key).is_none_or(|(watched, _)| !named.contains(watched))
        };
        state.watching.extract_if(.., is_over).collect()
    }
}
