//! Attachments: members that follow a joint of another, on the device and in the same frame.

use populace_device::layout::MAX_PHASES;
use populace_model::{JointIndex, Trs};

use super::MemberId;
use super::base::Base;
use super::by_member::ByMember;
use super::constraints::Constraints;
use crate::{AttachmentFault, Error};

/// Attachments of members, by member index.
#[derive(Clone, Debug, Default)]
pub(super) struct Attachments {
    by_member: ByMember<Attached>,
}

/// The parent and the children of a member.
#[derive(Clone, Debug, Default)]
struct Attached {
    parent: Option<Parent>,
    children: Vec<MemberId>,
    /// The joints that children follow.
    followed: Vec<Followed>,
}

/// A joint that devices write once for all children that follow it.
#[derive(Clone, Copy, Debug)]
struct Followed {
    joint: JointIndex,
    /// Its index among the watched joints.
    watched: u32,
    /// The number of children that follow it.
    children: usize,
}

/// The joint that an attached member follows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Parent {
    member: MemberId,
    joint: JointIndex,
    /// Its index among the watched joints.
    watched: u32,
}

/// Returns the phase of the frame in which devices evaluate a member.
fn phase(base: &Base, member: MemberId) -> u32 {
    base.tables.members().as_slice()[member.number() as usize].phase()
}

fn refused<T>(fault: AttachmentFault) -> Result<T, Error> {
    Err(Error::BadAttachment(fault))
}

impl Attachments {
    pub(super) fn is_empty(&self) -> bool {
        self.by_member.is_empty()
    }

    pub(super) fn attach(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        child: MemberId,
        to: MemberId,
        joint: JointIndex,
        offset: Trs,
    ) -> Result<(), Error> {
        base.check(child)?;
        self.check_parent(base, child, to)?;
        let old = self.parent(child);
        let parent = match old {
            Some(old) if (old.member, old.joint) == (to, joint) => old,
            _ => self.follow_joint(base, constraints, to, joint)?,
        };
        let changed = constraints.change(base, child, |controls| {
            controls.attached = Some((parent.watched, offset));
        });
        if old == Some(parent) {
            return changed;
        }
        if let Err(error) = changed {
            self.unfollow_joint(base, constraints, parent)?;
            return Err(error);
        }
        self.unlink(base, constraints, child)?;
        self.by_member.get_or_default(child.number()).parent = Some(parent);
        self.by_member.get_or_default(to.number()).children.push(child);
        self.place_child(base, to, child)
    }

    pub(super) fn detach(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        child: MemberId,
    ) -> Result<(), Error> {
        base.check(child)?;
        if self.parent(child).is_none() {
            return Ok(());
        }
        constraints.change(base, child, |controls| {
            controls.attached = None;
        })?;
        self.unlink(base, constraints, child)?;
        base.tables.set_phase(child.number(), 0)?;
        self.place_children(base, child)
    }

    pub(super) fn attached_to(&self, child: MemberId) -> Option<(MemberId, JointIndex)> {
        self.parent(child).map(|parent| (parent.member, parent.joint))
    }

    /// Detaches a member that is despawned, and all its children.
    pub(super) fn detach_all(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        member: MemberId,
    ) -> Result<(), Error> {
        self.detach(base, constraints, member)?;
        while let Some(child) = self.child(member, 0) {
            self.detach(base, constraints, child)?;
        }
        Ok(())
    }

    /// Refuses to place a member that is attached.
    pub(super) fn check_placeable(&self, member: MemberId) -> Result<(), Error> {
        match self.parent(member) {
            None => Ok(()),
            Some(_) => refused(AttachmentFault::Placed),
        }
    }

    /// Gives all attachments of a member its placement and evaluates them after it.
    pub(super) fn place_children(&self, base: &mut Base, parent: MemberId) -> Result<(), Error> {
        let mut nth = 0;
        while let Some(child) = self.child(parent, nth) {
            self.place_child(base, parent, child)?;
            nth += 1;
        }
        Ok(())
    }

    /// Gives an attachment of a member its placement and evaluates it after that member.
    fn place_child(&self, base: &mut Base, parent: MemberId, child: MemberId) -> Result<(), Error> {
        let placement = base.members.all[parent.number() as usize].placement;
        base.members.all[child.number() as usize].placement = placement;
        base.tables.set_phase(child.number(), phase(base, parent) + 1)?;
        base.upload_placement(child)?;
        self.place_children(base, child)
    }

    fn parent(&self, child: MemberId) -> Option<Parent> {
        self.by_member.get(child.number())?.parent
    }

    /// Returns the index of the parent of the member at an index.
    pub(super) fn parent_index(&self, member_index: u32) -> Option<u32> {
        Some(self.by_member.get(member_index)?.parent?.member.number())
    }

    fn child(&self, parent: MemberId, nth: usize) -> Option<MemberId> {
        self.by_member.get(parent.number())?.children.get(nth).copied()
    }

    /// Returns the number of levels of attachments on a member.
    fn levels(&self, member: MemberId) -> u32 {
        let own = self.by_member.get(member.number()).into_iter();
        let children = own.flat_map(|attached| &attached.children);
        children.map(|child| 1 + self.levels(*child)).max().unwrap_or(0)
    }

    fn check_parent(&self, base: &Base, child: MemberId, to: MemberId) -> Result<(), Error> {
        let character = base.character_state(base.check(to)?)?;
        // Fused schedules go by pages of palettes.
        if character.character.palette.is_empty() {
            let character = character.character.name.clone();
            return refused(AttachmentFault::NoMesh { character });
        }
        let mut above = Some(to);
        while let Some(member) = above {
            if member == child {
                return refused(AttachmentFault::Circle);
            }
            above = self.parent(member).map(|parent| parent.member);
        }
        let (levels, most) = (phase(base, to) + 1 + self.levels(child), MAX_PHASES - 1);
        if levels > most {
            return refused(AttachmentFault::TooDeep { levels, most });
        }
        Ok(())
    }

    /// Removes the link between a member and its parent.
    fn unlink(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        child: MemberId,
    ) -> Result<(), Error> {
        let Some(parent) = self.parent(child) else { return Ok(()) };
        self.unfollow_joint(base, constraints, parent)?;
        if let Some(attached) = self.by_member.get_mut(child.number()) {
            attached.parent = None;
        }
        if let Some(attached) = self.by_member.get_mut(parent.member.number())
            && let Some(at) = attached.children.iter().position(|other| *other == child)
        {
            // Their order means nothing.
            attached.children.swap_remove(at);
        }
        self.forget_if_free(child);
        self.forget_if_free(parent.member);
        Ok(())
    }

    /// Forgets a member that is not attached and carries nobody.
    fn forget_if_free(&mut self, member: MemberId) {
        let is_free = |attached: &Attached| {
            let Attached { parent, children, followed } = attached;
            parent.is_none() && children.is_empty() && followed.is_empty()
        };
        if self.by_member.get(member.number()).is_some_and(is_free) {
            self.by_member.remove(member.number());
        }
    }

    /// Makes devices write a joint that one more attachment can follow.
    fn follow_joint(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        member: MemberId,
        joint: JointIndex,
    ) -> Result<Parent, Error> {
        let mut followed =
            self.by_member.get_mut(member.number()).into_iter().flat_map(|a| &mut a.followed);
        if let Some(known) = followed.find(|followed| followed.joint == joint) {
            known.children += 1;
            return Ok(Parent { member, joint, watched: known.watched });
        }
        let watched = base.tables.add_watched();
        let changed = constraints.change(base, member, |controls| {
            controls.carries.push((joint, watched));
        });
        if let Err(error) = changed {
            base.tables.remove_watched(watched);
            return Err(error);
        }
        let followed = Followed { joint, watched, children: 1 };
        self.by_member.get_or_default(member.number()).followed.push(followed);
        Ok(Parent { member, joint, watched })
    }

    /// Takes an attachment from a followed joint, and ends its writing with the last one.
    fn unfollow_joint(
        &mut self,
        base: &mut Base,
        constraints: &mut Constraints,
        parent: Parent,
    ) -> Result<(), Error> {
        let Parent { member, joint, watched } = parent;
        let Some(attached) = self.by_member.get_mut(member.number()) else { return Ok(()) };
        let Some(at) = attached.followed.iter().position(|f| f.joint == joint) else {
            return Ok(());
        };
        if attached.followed[at].children > 1 {
            attached.followed[at].children -= 1;
            return Ok(());
        }
        constraints.change(base, member, |controls| {
            controls.carries.retain(|(_, other)| *other != watched);
        })?;
        attached.followed.swap_remove(at);
        base.tables.remove_watched(watched);
        self.forget_if_free(member);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use populace_device::layout::WATCHED_ELEMENTS;

    use super::*;
    use crate::{Crowd, Device, Placement};

    #[test]
    fn a_joint_is_written_once_for_all_who_follow_it() {
        let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
        let lift = crowd.add_character(crate::crowd::tests::lift()).unwrap();
        let all = crowd.spawn_many(lift, &[Placement::at([0.0; 3]); 5]).unwrap();
        let (carrier, riders) = all.split_first().unwrap();
        let written = |crowd: &Crowd| crowd.state.base.tables.watched_elements();
        let one = WATCHED_ELEMENTS as usize;
        let attach = |crowd: &mut Crowd, rider: MemberId| {
            let mut rider = crowd.member_mut(rider).unwrap();
            rider.attach_to(*carrier, JointIndex(0), Trs::IDENTITY).unwrap();
        };
        for rider in riders {
            attach(&mut crowd, *rider);
            assert_eq!(written(&crowd), one);
        }
        attach(&mut crowd, riders[0]);
        for rider in &riders[1..] {
            crowd.member_mut(*rider).unwrap().detach().unwrap();
            assert_eq!(written(&crowd), one, "the first follows it");
        }
        let beyond = JointIndex(9);
        let refused =
            crowd.member_mut(riders[1]).unwrap().attach_to(*carrier, beyond, Trs::IDENTITY);
        refused.unwrap_err();
        crowd.member_mut(riders[0]).unwrap().detach().unwrap();
        assert_eq!(written(&crowd), 0);
        assert!(crowd.state.attachments.is_empty());
        riders.iter().for_each(|rider| attach(&mut crowd, *rider));
        crowd.despawn(*carrier).unwrap();
        assert_eq!(written(&crowd), 0);
        assert!(crowd.state.attachments.is_empty());
    }
}
