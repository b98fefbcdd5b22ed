//! Attachments: members that follow a joint of another, on the device and in the same frame.

use populace_device::layout::PHASES_MOST;
use populace_model::{JointIndex, Trs};

use super::{Crowd, MemberId};
use crate::Error;

/// The parent and the children of a member.
#[derive(Debug, Default)]
pub(crate) struct Attached {
    bearer: Option<Bearer>,
    props: Vec<MemberId>,
}

/// The joint that an attached member follows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bearer {
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
        prop: MemberId,
        to: MemberId,
        joint: JointIndex,
        offset: Trs,
    ) -> Result<(), Error> {
        self.check(prop)?;
        self.check_bearer(prop, to)?;
        let old = self.bearer(prop);
        let bearer = match old {
            Some(old) if (old.member, old.joint) == (to, joint) => old,
            _ => self.carry(to, joint)?,
        };
        let changed = self.change_controls(prop, |controls| {
            controls.attached = Some((bearer.watched, offset));
            Ok(())
        });
        if old == Some(bearer) {
            return changed;
        }
        if let Err(error) = changed {
            self.put_down(bearer)?;
            return Err(error);
        }
        self.let_go_of(prop)?;
        self.attachments.entry(prop.index).or_default().bearer = Some(bearer);
        self.attachments.entry(to.index).or_default().props.push(prop);
        self.bring_props(to)
    }

    pub(super) fn detach(&mut self, prop: MemberId) -> Result<(), Error> {
        self.check(prop)?;
        if self.bearer(prop).is_none() {
            return Ok(());
        }
        self.change_controls(prop, |controls| {
            controls.attached = None;
            Ok(())
        })?;
        self.let_go_of(prop)?;
        self.tables.set_phase(prop.index, 0)?;
        self.bring_props(prop)
    }

    pub(super) fn attached_to(&self, prop: MemberId) -> Option<(MemberId, JointIndex)> {
        self.bearer(prop).map(|bearer| (bearer.member, bearer.joint))
    }

    /// Detaches a member that is despawned, and all its children.
    pub(super) fn detach_all(&mut self, member: MemberId) -> Result<(), Error> {
        self.detach(member)?;
        while let Some(prop) = self.prop(member, 0) {
            self.detach(prop)?;
        }
        Ok(())
    }

    /// Refuses to place a member that is attached.
    pub(super) fn check_placeable(&self, member: MemberId) -> Result<(), Error> {
        match self.bearer(member) {
            None => Ok(()),
            Some(_) => refused(
                "an attached member has the placement of its parent; place the parent, or detach \
                 the member first",
            ),
        }
    }

    /// Gives all attachments of a member its placement and evaluates them after it.
    pub(super) fn bring_props(&mut self, bearer: MemberId) -> Result<(), Error> {
        let placement = self.members[bearer.index as usize].placement;
        let mut nth = 0;
        while let Some(prop) = self.prop(bearer, nth) {
            self.members[prop.index as usize].placement = placement;
            self.tables.set_phase(prop.index, self.phase(bearer) + 1)?;
            self.stand(prop)?;
            self.bring_props(prop)?;
            nth += 1;
        }
        Ok(())
    }

    fn bearer(&self, prop: MemberId) -> Option<Bearer> {
        self.attachments.get(&prop.index)?.bearer
    }

    /// Returns the index of the parent of the member at an index.
    pub(super) fn bearer_place(&self, place: u32) -> Option<u32> {
        Some(self.attachments.get(&place)?.bearer?.member.index)
    }

    fn prop(&self, bearer: MemberId, nth: usize) -> Option<MemberId> {
        self.attachments.get(&bearer.index)?.props.get(nth).copied()
    }

    fn phase(&self, member: MemberId) -> u32 {
        self.tables.members().as_slice()[member.index as usize].phase()
    }

    /// Returns the number of levels of attachments on a member.
    fn levels(&self, member: MemberId) -> u32 {
        let props =
            self.attachments.get(&member.index).into_iter().flat_map(|attached| &attached.props);
        props.map(|prop| 1 + self.levels(*prop)).max().unwrap_or(0)
    }

    fn check_bearer(&self, prop: MemberId, to: MemberId) -> Result<(), Error> {
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
            if member == prop {
                return refused(
                    "a member cannot be attached to itself or to its own attachments; detach those \
                     first",
                );
            }
            above = self.bearer(member).map(|bearer| bearer.member);
        }
        let (levels, most) = (self.phase(to) + 1 + self.levels(prop), PHASES_MOST - 1);
        if levels > most {
            return refused(format!(
                "attachments would be {levels} levels deep; at most {most} are possible, so attach \
                 this member nearer to the first of the chain"
            ));
        }
        Ok(())
    }

    /// Makes devices write a joint that attachments can follow.
    fn carry(&mut self, member: MemberId, joint: JointIndex) -> Result<Bearer, Error> {
        let watched = self.tables.add_watched();
        let changed = self.change_controls(member, |controls| {
            controls.carries.push((joint, watched));
            Ok(())
        });
        if let Err(error) = changed {
            self.tables.remove_watched(watched);
            return Err(error);
        }
        Ok(Bearer { member, joint, watched })
    }

    /// Ends the writing of a followed joint.
    fn put_down(&mut self, bearer: Bearer) -> Result<(), Error> {
        self.change_controls(bearer.member, |controls| {
            controls.carries.retain(|(_, watched)| *watched != bearer.watched);
            Ok(())
        })?;
        self.tables.remove_watched(bearer.watched);
        Ok(())
    }

    /// Removes the link between a member and its parent.
    fn let_go_of(&mut self, prop: MemberId) -> Result<(), Error> {
        let Some(bearer) = self.bearer(prop) else { return Ok(()) };
        self.put_down(bearer)?;
        if let Some(attached) = self.attachments.get_mut(&prop.index) {
            attached.bearer = None;
        }
        if let Some(attached) = self.attachments.get_mut(&bearer.member.index) {
            attached.props.retain(|other| *other != prop);
        }
        for place in [prop.index, bearer.member.index] {
            let is_done =
                |attached: &Attached| attached.bearer.is_none() && attached.props.is_empty();
            if self.attachments.get(&place).is_some_and(is_done) {
                self.attachments.remove(&place);
            }
        }
        Ok(())
    }
}
