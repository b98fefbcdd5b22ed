//! Constraint programs of members: overrides, look-at, reach, planted feet, proportions.

mod humanoid;
mod limb;
mod targets;
mod watched;

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use populace_device::{BodyIndex, Chain, Constraint, Controls, Feet, JointOverride, Space};
use populace_model::{JointIndex, LARGEST_SCALE};
use populace_settings::parts::{Check, Parts, check_secs, device_target};

use super::MemberId;
use super::base::Base;
use super::by_member::ByMember;
use crate::{Allowed, Error, Gaze, Reach, Target, Weight};
use humanoid::limb_above;
use limb::limb_of;
use targets::{Goal, aim_at, forget_faded, gaze_of, goal_of, set_targets, targets_of};

/// The fraction of a limb's length within which it straightens softly.
const SOFT: f32 = 0.03;

/// Constraint programs of members, and the joints that they watch.
#[derive(Clone, Debug, Default)]
pub(super) struct Constraints {
    /// By member index.
    controls: ByMember<MemberControls>,
    /// Watched joints: index on the device and number of users.
    watches: HashMap<(MemberId, JointIndex), (u32, usize)>,
    /// Offsets on the device of the bone-length factors in use.
    proportions: HashMap<Factors, u32>,
    /// The factors at each offset, and the number of members that have them.
    users_of_proportions: HashMap<u32, (Factors, usize)>,
}

/// A body, and the bits of its joints' bone-length factors.
type Factors = (BodyIndex, Arc<[u32]>);

/// A member's constraint program and the joints that its targets watch.
#[derive(Clone, Debug, Default)]
struct MemberControls {
    controls: Controls,
    watching: Vec<(MemberId, JointIndex)>,
    /// The tick at which each constraint last received a target.
    aimed: Vec<(Goal, u64)>,
}

impl Constraints {
    pub(super) fn override_joints(
        &mut self,
        base: &mut Base,
        member: MemberId,
        overrides: &[JointOverride],
    ) -> Result<(), Error> {
        self.change(base, member, |controls| {
            for given in overrides {
                let same =
                    |o: &&mut JointOverride| o.joint == given.joint && o.space == given.space;
                match controls.overrides.iter_mut().find(same) {
                    Some(old) => *old = *given,
                    None => controls.overrides.push(*given),
                }
            }
        })
    }

    pub(super) fn release_joints(
        &mut self,
        base: &mut Base,
        member: MemberId,
        space: Space,
        joints: &[JointIndex],
    ) -> Result<(), Error> {
        self.change(base, member, |controls| {
            controls.overrides.retain(|o| o.space != space || !joints.contains(&o.joint));
        })
    }

    pub(super) fn release_all(&mut self, base: &mut Base, member: MemberId) -> Result<(), Error> {
        self.change(base, member, |controls| {
            controls.overrides.clear();
        })
    }

    pub(super) fn look_at_with(
        &mut self,
        base: &mut Base,
        member: MemberId,
        gaze: Gaze,
        target: Target,
        weight: Weight,
    ) -> Result<(), Error> {
        self.aim(base, member, target, weight, vec![gaze_of(gaze)])
    }

    pub(super) fn reach(
        &mut self,
        base: &mut Base,
        member: MemberId,
        reach: Reach,
        target: Target,
        weight: Weight,
    ) -> Result<(), Error> {
        let character = base.check(member)?;
        let state = base.character_state(character)?;
        let mut reach = reach.parts();
        reach.limb = reach.limb.or_else(|| limb_above(state.roles.as_ref(), reach.end));
        let limb = limb_of(&state.character.skeleton, &reach)?;
        self.aim(base, member, target, weight, vec![Constraint::Limb(limb)])
    }

    pub(super) fn reach_with_chain(
        &mut self,
        base: &mut Base,
        member: MemberId,
        [first, end]: [JointIndex; 2],
        target: Target,
        weight: Weight,
    ) -> Result<(), Error> {
        let chain = Chain { first, end, soft: SOFT, targets: Vec::new() };
        self.aim(base, member, target, weight, vec![Constraint::Chain(chain)])
    }

    pub(super) fn plant_with(
        &mut self,
        base: &mut Base,
        member: MemberId,
        feet: &Feet,
    ) -> Result<(), Error> {
        let feet = Constraint::Feet(feet.clone());
        let stays = matches!(&feet, Constraint::Feet(feet) if feet.weight > 0.0);
        self.change(base, member, |controls| {
            let all = &mut controls.constraints;
            // An existing constraint keeps its position among the others.
            match all.iter().position(|constraint| matches!(constraint, Constraint::Feet(_))) {
                Some(at) if stays => all[at] = feet,
                Some(at) => drop(all.remove(at)),
                None if stays => all.push(feet),
                None => {}
            }
        })
    }

    pub(super) fn set_proportions(
        &mut self,
        base: &mut Base,
        member: MemberId,
        factors: &[f32],
    ) -> Result<(), Error> {
        let character = base.check(member)?;
        let joints = base.character_state(character)?.character.skeleton.joint_count();
        check_factors(factors, joints)?;
        if factors.iter().all(|factor| *factor == 1.0) {
            return self.replace_proportions(base, member, None);
        }
        let bits = factors.iter().map(|factor| factor.to_bits()).collect();
        let key = (base.character_state(character)?.body, bits);
        let first = match self.proportions.get(&key) {
            Some(first) => *first,
            None => base.tables.add_joint_scales(factors)?,
        };
        // Counted first, so that factors that the member has already stay.
        self.proportions.insert(key.clone(), first);
        self.users_of_proportions.entry(first).or_insert((key, 0)).1 += 1;
        let changed = self.replace_proportions(base, member, Some(first));
        if changed.is_err() {
            self.release_proportions(base, Some(first));
        }
        changed
    }

    /// Sets the offset of a member's factors, and frees those that it had if nobody else has them.
    fn replace_proportions(
        &mut self,
        base: &mut Base,
        member: MemberId,
        first: Option<u32>,
    ) -> Result<(), Error> {
        let old = self.controls.get(member.number()).and_then(|state| state.controls.proportions);
        self.change(base, member, |controls| {
            controls.proportions = first;
        })?;
        self.release_proportions(base, old);
        Ok(())
    }

    /// Frees bone-length factors after their last user.
    fn release_proportions(&mut self, base: &mut Base, first: Option<u32>) {
        let Some(first) = first else { return };
        let Some((factors, users)) = self.users_of_proportions.get_mut(&first) else { return };
        *users -= 1;
        if *users == 0 {
            self.proportions.remove(factors);
            self.users_of_proportions.remove(&first);
            // They are in the tables as long as they have users.
            let _removed = base.tables.remove_joint_scales(first);
        }
    }

    /// Fades out and then removes the constraints that `which` selects.
    fn ease_out(
        &mut self,
        base: &mut Base,
        member: MemberId,
        secs: f32,
        which: impl Fn(&Constraint) -> bool,
    ) -> Result<(), Error> {
        check_secs("the time to come to a weight", secs)?;
        let tick = base.clock.tick;
        self.change(base, member, |controls| {
            for constraint in controls.constraints.iter_mut().filter(|c| which(c)) {
                for target in targets_of(constraint) {
                    *target = target.ramped_to(tick, 0.0, secs);
                }
            }
        })
    }

    pub(super) fn clear_look_at(
        &mut self,
        base: &mut Base,
        member: MemberId,
        over_secs: f32,
    ) -> Result<(), Error> {
        self.ease_out(base, member, over_secs, |constraint| {
            matches!(constraint, Constraint::Gaze(_))
        })
    }

    pub(super) fn clear_reach(
        &mut self,
        base: &mut Base,
        member: MemberId,
        end: JointIndex,
        over_secs: f32,
    ) -> Result<(), Error> {
        self.ease_out(base, member, over_secs, |constraint| match constraint {
            Constraint::Limb(limb) => limb.end == end,
            Constraint::Chain(chain) => chain.end == end,
            Constraint::Gaze(_) | Constraint::Feet(_) => false,
        })
    }

    /// Adds a target to each of `all`, or to the existing constraints of the same identity.
    fn aim(
        &mut self,
        base: &mut Base,
        member: MemberId,
        target: Target,
        weight: Weight,
        all: Vec<Constraint>,
    ) -> Result<(), Error> {
        target.check()?;
        weight.check()?;
        base.check(member)?;
        let watched = match target {
            Target::Joint { member: other, joint } => self.watch_for(base, member, other, joint)?,
            _ => 0,
        };
        let (tick, goals) = (base.clock.tick, all.iter().map(goal_of).collect::<Vec<_>>());
        let (target, weight) = (device_target(&target, watched), weight.parts());
        let follows = |goal: &Goal| {
            !weight.eases_over && self.was_aimed_within(base, member, *goal, weight.secs)
        };
        let follow: Vec<bool> = goals.iter().map(follows).collect();
        let changed = self.change(base, member, |controls| {
            for ((mut constraint, goal), follows) in all.into_iter().zip(&goals).zip(follow) {
                let known = &mut controls.constraints;
                let at = known.iter().position(|constraint| goal_of(constraint) == *goal);
                let mut targets =
                    at.map_or_else(Vec::new, |at| targets_of(&mut known[at]).to_vec());
                aim_at(&mut targets, target, tick, weight, follows);
                set_targets(&mut constraint, targets);
                match at {
                    Some(at) => known[at] = constraint,
                    None => known.push(constraint),
                }
            }
        });
        if changed.is_err() {
            self.forget_unused(base, member);
            return changed;
        }
        if let Some(MemberControls { aimed, .. }) = self.controls.get_mut(member.number()) {
            aimed.retain(|(other, _)| !goals.contains(other));
            aimed.extend(goals.into_iter().map(|goal| (goal, tick)));
        }
        Ok(())
    }

    /// Returns whether a constraint received a target less than `secs` ago.
    fn was_aimed_within(&self, base: &Base, member: MemberId, goal: Goal, secs: f32) -> bool {
        let aimed = self.controls.get(member.number()).into_iter().flat_map(|state| &state.aimed);
        let mut of_goal = aimed.filter(|(other, _)| *other == goal);
        let ticks = populace_clip::ticks_from_secs(f64::from(secs));
        of_goal.any(|(_, tick)| (*tick..tick + ticks).contains(&base.clock.tick))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.controls.is_empty()
    }

    /// Returns the index of a watched joint on the device.
    pub(super) fn watched_index(&self, key: (MemberId, JointIndex)) -> Option<u32> {
        self.watches.get(&key).map(|(watched, _)| *watched)
    }

    #[cfg(test)]
    pub(super) fn watch_count(&self) -> usize {
        self.watches.len()
    }

    /// Returns the number of a member's root motion, if it has any.
    pub(super) fn motion(&self, member: MemberId) -> Option<u32> {
        self.controls.get(member.number())?.controls.motion
    }

    pub(super) fn plants_feet(&self, member: MemberId) -> bool {
        let feet = |constraint: &Constraint| matches!(constraint, Constraint::Feet(_));
        self.controls(member).is_some_and(|state| state.controls.constraints.iter().any(feet))
    }

    /// Returns whether a target of the member is a joint of another member.
    pub(super) fn watches_others(&self, member: MemberId) -> bool {
        self.controls(member).is_some_and(|state| !state.watching.is_empty())
    }

    pub(super) fn overrides_joints(&self, member: MemberId) -> bool {
        self.controls(member).is_some_and(|state| !state.controls.overrides.is_empty())
    }

    fn controls(&self, member: MemberId) -> Option<&MemberControls> {
        self.controls.get(member.number())
    }

    /// Returns the indices of the members that run a user stage, in ascending order.
    pub(super) fn users_of_stage(&self, number: u32) -> BTreeSet<u32> {
        let uses = |state: &MemberControls| state.controls.stages.iter().any(|u| u.stage == number);
        self.controls.iter().filter(|(_, state)| uses(state)).map(|(index, _)| index).collect()
    }

    /// Changes a member's constraint program. Nothing is changed on an error.
    pub(super) fn change(
        &mut self,
        base: &mut Base,
        member: MemberId,
        change: impl FnOnce(&mut Controls),
    ) -> Result<(), Error> {
        let character = base.check(member)?;
        let skeleton = &base.assets.characters[character.parts().index].character.skeleton;
        let none = Controls::default();
        let before = self.controls(member).map_or(&none, |state| &state.controls);
        let mut controls = before.clone();
        change(&mut controls);
        forget_faded(&mut controls, base.clock.tick);
        // A gaze that follows somebody has a new target in each frame.
        if !base.tables.set_targets(member.number(), before, &controls)? {
            base.tables.set_controls(member.number(), skeleton, &controls)?;
        }
        self.controls.get_or_default(member.number()).controls = controls;
        base.upload_placement(member)?;
        self.forget_unused(base, member);
        Ok(())
    }

    /// Removes the constraint program of a member that is despawned.
    pub(super) fn forget(&mut self, base: &mut Base, member: MemberId) {
        if let Some(state) = self.controls.remove(member.number()) {
            self.release_proportions(base, state.controls.proportions);
            for (other, joint) in state.watching {
                self.unwatch_joint(base, other, joint);
            }
        }
    }
}

/// Refuses bone-length factors that devices cannot take.
fn check_factors(factors: &[f32], joints: usize) -> Result<(), Error> {
    if factors.len() != joints {
        let (what, value) = ("the number of factors of proportions", factors.len() as f32);
        return Err(Error::BadValue { what, value, allowed: Allowed::Exactly(joints) });
    }
    let bad = factors.iter().find(|factor| !(**factor > 0.0 && **factor <= LARGEST_SCALE));
    let Some(&value) = bad else { return Ok(()) };
    let (what, allowed) = ("a factor of proportions", Allowed::AboveZero { most: LARGEST_SCALE });
    Err(Error::BadValue { what, value, allowed })
}
