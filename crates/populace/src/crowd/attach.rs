//! Attachments: members that follow a joint of another, on the device and in the same frame.

use populace_device::layout::MAX_PHASES;
use populace_model::{JointIndex, Trs};

use super::{Crowd, MemberId};
use crate::Error;

/// The parent and the children of a member.
#[derive(Debug, Default)]
pub(crate) struct Attached {
    parent: Option<Parent>,
    children: Vec<MemberId>,
}

/// The joint that an attached member follows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Parent {
    member: MemberId,
    joint: JointIndex,
    /// Its index among the watched joints.
    watched: u32,
}

fn refused<T>(reason: impl Into<String>) -> Result<T, Error> {
    Err(Error::BadAttachment { reason: reason.into() })
}

impl Crowd {
    pub(super) fn attach(
        &mut self,
        child: MemberId,
        to: MemberId,
        joint: JointIndex,
        offset: Trs,
    ) -> Result<(), Error> {
        self.check(child)?;
        self.check_parent(child, to)?;
        let old = self.parent(child);
        let parent = match old {
            Some(old) if (old.member, old.joint) == (to, joint) => old,
            _ => self.follow_joint(to, joint)?,
        };
        let changed = self.change_controls(child, |controls| {
            controls.attached = Some((parent.watched, offset));
            Ok(())
        });
        if old == Some(parent) {
            return changed;
        }
        if let Err(error) = changed {
            self.unfollow_joint(parent)?;
            return Err(error);
        }
        self.unlink(child)?;
        self.attachments.entry(child.index).or_default().parent = Some(parent);
        self.attachments.entry(to.index).or_default().children.push(child);
        self.place_children(to)
    }

    pub(super) fn detach(&mut self, child: MemberId) -> Result<(), Error> {
        self.check(child)?;
        if self.parent(child).is_none() {
            return Ok(());
        }
        self.change_controls(child, |controls| {
            controls.attached = None;
            Ok(())
        })?;
        self.unlink(child)?;
        self.tables.set_phase(child.index, 0)?;
        self.place_children(child)
    }

    pub(super) fn attached_to(&self, child: MemberId) -> Option<(MemberId, JointIndex)> {
        self.parent(child).map(|parent| (parent.member, parent.joint))
    }

    /// Detaches a member that is despawned, and all its children.
    pub(super) fn detach_all(&mut self, member: MemberId) -> Result<(), Error> {
        self.detach(member)?;
        while let Some(child) = self.child(member, 0) {
            self.detach(child)?;
        }
        Ok(())
    }

    /// Refuses to place a member that is attached.
    pub(super) fn check_placeable(&self, member: MemberId) -> Result<(), Error> {
        match self.parent(member) {
            None => Ok(()),
            Some(_) => refused(
                "an attached member has the placement of its parent; place the parent, or detach \
                 the member first",
            ),
        }
    }

    /// Gives all attachments of a member its placement and evaluates them after it.
    pub(super) fn place_children(&mut self, parent: MemberId) -> Result<(), Error> {
        let placement = self.members[parent.index as usize].placement;
        let mut nth = 0;
        while let Some(child) = self.child(parent, nth) {
            self.members[child.index as usize].placement = placement;
            self.tables.set_phase(child.index, self.phase(parent) + 1)?;
            self.upload_placement(child)?;
            self.place_children(child)?;
            nth += 1;
        }
        Ok(())
    }

    fn parent(&self, child: MemberId) -> Option<Parent> {
        self.attachments.get(&child.index)?.parent
    }

    /// Returns the index of the parent of the member at an index.
    pub(super) fn parent_index(&self, place: u32) -> Option<u32> {
        Some(self.attachments.get(&place)?.parent?.member.index)
    }

    fn child(&self, parent: MemberId, nth: usize) -> Option<MemberId> {
        self.attachments.get(&parent.index)?.children.get(nth).copied()
    }

    fn phase(&self, member: MemberId) -> u32 {
        self.tables.members().as_slice()[member.index as usize].phase()
    }

    /// Returns the number of levels of attachments on a member.
    fn levels(&self, member: MemberId) -> u32 {
        let children =
            self.attachments.get(&member.index).into_iter().flat_map(|attached| &attached.children);
        children.map(|child| 1 + self.levels(*child)).max().unwrap_or(0)
    }

    fn check_parent(&self, child: MemberId, to: MemberId) -> Result<(), Error> {
        let character = self.character_state(self.check(to)?)?;
        // Fused schedules go by pages of palettes.
        if character.character.palette.is_empty() {
            let name = &character.character.name;
            return refused(format!(
                "nothing can be attached to a member of \"{name}\": it has no mesh, so devices do \
                 not evaluate it"
            ));
        }
        let mut above = Some(to);
        while let Some(member) = above {
            if member == child {
                return refused(
                    "a member cannot be attached to itself or to its own attachments; detach those \
                     first",
                );
            }
            above = self.parent(member).map(|parent| parent.member);
        }
        let (levels, most) = (self.phase(to) + 1 + self.levels(child), MAX_PHASES - 1);
        if levels > most {
            return refused(format!(
                "attachments would be {levels} levels deep; at most {most} are possible, so attach \
                 this member nearer to the first of the chain"
            ));
        }
        Ok(())
    }

    /// Makes devices write a joint that attachments can follow.
    fn follow_joint(&mut self, member: MemberId, joint: JointIndex) -> Result<Parent, Error> {
        let watched = self.tables.add_watched();
        let changed = self.change_controls(member, |controls| {
            controls.carries.push((joint, watched));
            Ok(())
        });
        if let Err(error) = changed {
            self.tables.remove_watched(watched);
            return Err(error);
        }
        Ok(Parent { member, joint, watched })
    }

    /// Ends the writing of a followed joint.
    fn unfollow_joint(&mut self, parent: Parent) -> Result<(), Error> {
        self.change_controls(parent.member, |controls| {
            controls.carries.retain(|(_, watched)| *watched != parent.watched);
            Ok(())
        })?;
        self.tables.remove_watched(parent.watched);
        Ok(())
    }

    /// Removes the link between a member and its parent.
    fn unlink(&mut self, child: MemberId) -> Result<(), Error> {
        let Some(parent) = self.parent(child) else { return Ok(()) };
        self.unfollow_joint(parent)?;
        if let Some(attached) = self.attachments.get_mut(&child.index) {
            attached.parent = None;
        }
        if let Some(attached) = self.attachments.get_mut(&parent.member.index) {
            attached.children.retain(|other| *other != child);
        }
        for place in [child.index, parent.member.index] {
            let is_done =
                |attached: &Attached| attached.parent.is_none() && attached.children.is_empty();
            if self.attachments.get(&place).is_some_and(is_done) {
                self.attachments.remove(&place);
            }
        }
        Ok(())
    }
}
