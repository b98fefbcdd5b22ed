//! Props: members that follow a joint of another one, on the device and in the same frame.

use populace_device::layout::PHASES_MOST;
use populace_model::{JointIndex, Trs};

use super::{Crowd, Member};
use crate::Error;

/// What a member is attached to, and what is attached to it.
#[derive(Debug, Default)]
pub(crate) struct Attached {
    bearer: Option<Bearer>,
    props: Vec<Member>,
}

/// The joint that a prop follows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bearer {
    member: Member,
    joint: JointIndex,
    /// Where devices find it, among what is watched.
    watched: u32,
}

fn refused<T>(reason: impl Into<String>) -> Result<T, Error> {
    Err(Error::BadAttachment { reason: reason.into() })
}

impl Crowd {
    /// Attaches a member to a joint of another, in place of what it was attached to: its model
    /// space then lies at that joint times `offset`, scale included, where the same frame draws the
    /// joint, after all that moves it. The host reads nothing for that. Members can be attached to
    /// attached ones, four levels deep.
    ///
    /// The prop's placement is its bearer's from now on, and follows it. Its joints in model space,
    /// and what it is told in model space (targets, overrides, stages), count from that placement,
    /// not from the joint.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a joint that is not there, an offset that is not finite or whose
    /// rotation is not of length 1, or [`Error::BadAttachment`] for a member attached to itself or
    /// to its own props, past four levels, and to one that is never drawn; all is then as it was.
    pub fn attach(
        &mut self,
        prop: Member,
        to: Member,
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
        self.attachments.entry(prop.place).or_default().bearer = Some(bearer);
        self.attachments.entry(to.place).or_default().props.push(prop);
        self.bring_props(to)
    }

    /// Lets a member that is attached fall off; it stays at the placement that it has of its
    /// bearer, wherever clips have moved that one ([`place_where_moved`](Self::place_where_moved)
    /// makes placements follow). Nothing happens to one that is not attached.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn detach(&mut self, prop: Member) -> Result<(), Error> {
        self.check(prop)?;
        if self.bearer(prop).is_none() {
            return Ok(());
        }
        self.change_controls(prop, |controls| {
            controls.attached = None;
            Ok(())
        })?;
        self.let_go_of(prop)?;
        self.tables.set_phase(prop.place, 0)?;
        self.bring_props(prop)
    }

    /// The member and the joint that a member is attached to, if it is.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn attached_to(&self, prop: Member) -> Result<Option<(Member, JointIndex)>, Error> {
        self.check(prop)?;
        Ok(self.bearer(prop).map(|bearer| (bearer.member, bearer.joint)))
    }

    /// Detaches a member that leaves, and all its props.
    pub(super) fn detach_all(&mut self, member: Member) -> Result<(), Error> {
        self.detach(member)?;
        while let Some(prop) = self.prop(member, 0) {
            self.detach(prop)?;
        }
        Ok(())
    }

    /// Refuses to place a member whose bearer does.
    pub(super) fn check_placeable(&self, member: Member) -> Result<(), Error> {
        match self.bearer(member) {
            None => Ok(()),
            Some(_) => refused(
                "an attached member stands where its bearer does; place that one, or detach the \
                 member first",
            ),
        }
    }

    /// Lets the props of a member, and theirs, stand where it does and be evaluated after it.
    pub(super) fn bring_props(&mut self, bearer: Member) -> Result<(), Error> {
        let placement = self.members[bearer.place as usize].placement;
        let mut nth = 0;
        while let Some(prop) = self.prop(bearer, nth) {
            self.members[prop.place as usize].placement = placement;
            self.tables.set_phase(prop.place, self.phase(bearer) + 1)?;
            self.stand(prop)?;
            self.bring_props(prop)?;
            nth += 1;
        }
        Ok(())
    }

    fn bearer(&self, prop: Member) -> Option<Bearer> {
        self.attachments.get(&prop.place)?.bearer
    }

    /// The place of what the member of a place is attached to.
    pub(super) fn bearer_place(&self, place: u32) -> Option<u32> {
        Some(self.attachments.get(&place)?.bearer?.member.place)
    }

    fn prop(&self, bearer: Member, nth: usize) -> Option<Member> {
        self.attachments.get(&bearer.place)?.props.get(nth).copied()
    }

    fn phase(&self, member: Member) -> u32 {
        self.tables.members().as_slice()[member.place as usize].phase()
    }

    /// Levels of props on a member.
    fn levels(&self, member: Member) -> u32 {
        let props =
            self.attachments.get(&member.place).into_iter().flat_map(|attached| &attached.props);
        props.map(|prop| 1 + self.levels(*prop)).max().unwrap_or(0)
    }

    fn check_bearer(&self, prop: Member, to: Member) -> Result<(), Error> {
        let character = self.character_state(self.check(to)?)?;
        // Fused schedules go by pages of palettes.
        if character.character.palette.is_empty() {
            let name = &character.character.name;
            return refused(format!(
                "nothing can be attached to a member of \"{name}\": it has no mesh, so devices \
                 never evaluate it"
            ));
        }
        let mut above = Some(to);
        while let Some(member) = above {
            if member == prop {
                return refused(
                    "a member cannot be attached to itself or to what is attached to it; detach \
                     that first",
                );
            }
            above = self.bearer(member).map(|bearer| bearer.member);
        }
        let (levels, most) = (self.phase(to) + 1 + self.levels(prop), PHASES_MOST - 1);
        if levels > most {
            return refused(format!(
                "members would be attached to each other {levels} levels deep; {most} at most can \
                 be, so attach this one nearer to where the chain begins"
            ));
        }
        Ok(())
    }

    /// Lets a joint be written for a prop to follow.
    fn carry(&mut self, member: Member, joint: JointIndex) -> Result<Bearer, Error> {
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

    /// Lets it be written no longer.
    fn put_down(&mut self, bearer: Bearer) -> Result<(), Error> {
        self.change_controls(bearer.member, |controls| {
            controls.carries.retain(|(_, watched)| *watched != bearer.watched);
            Ok(())
        })?;
        self.tables.remove_watched(bearer.watched);
        Ok(())
    }

    /// Forgets what a prop was attached to.
    fn let_go_of(&mut self, prop: Member) -> Result<(), Error> {
        let Some(bearer) = self.bearer(prop) else { return Ok(()) };
        self.put_down(bearer)?;
        if let Some(attached) = self.attachments.get_mut(&prop.place) {
            attached.bearer = None;
        }
        if let Some(attached) = self.attachments.get_mut(&bearer.member.place) {
            attached.props.retain(|other| *other != prop);
        }
        for place in [prop.place, bearer.member.place] {
            let is_done =
                |attached: &Attached| attached.bearer.is_none() && attached.props.is_empty();
            if self.attachments.get(&place).is_some_and(is_done) {
                self.attachments.remove(&place);
            }
        }
        Ok(())
    }
}
