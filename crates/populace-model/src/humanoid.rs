//! Humanoid roles: the body part of each joint, whatever its name.

mod detect;
mod names;
mod schemes;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::{Error, JointIndex, RoleFault, Skeleton};

pub use crate::role::{Finger, Phalanx, Role, Side};
pub use names::name_words;

/// The joints of one skeleton by humanoid role.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleMap {
    joints: BTreeMap<Role, JointIndex>,
    /// Further joints that follow the joint of their role: bones of one palm.
    followers: Vec<(Role, JointIndex)>,
    naming: &'static str,
    joint_count: usize,
}

/// Roles that retargeting needs: the scale comes from the legs.
const NEEDED: [Role; 7] = [
    Role::Hips,
    Role::UpperLeg(Side::Left),
    Role::LowerLeg(Side::Left),
    Role::Foot(Side::Left),
    Role::UpperLeg(Side::Right),
    Role::LowerLeg(Side::Right),
    Role::Foot(Side::Right),
];

impl RoleMap {
    /// Creates a map from roles and joint names.
    ///
    /// # Errors
    ///
    /// [`Error::BadRole`] for a missing joint, a role or joint that is given twice, a joint that is
    /// not a descendant of the joints of its parent roles, or a body without hips and legs.
    pub fn from_names(skeleton: &Skeleton, names: &[(Role, &str)]) -> Result<Self, Error> {
        let mut map = Self::empty(skeleton, "given");
        for &(role, name) in names {
            let bad = |fault| Error::BadRole { role, fault };
            let given = || name.to_owned();
            let joint = skeleton
                .find(name)
                .ok_or_else(|| bad(RoleFault::UnknownJoint { joint: given() }))?;
            if let Some((&other, _)) = map.joints.iter().find(|(_, taken)| **taken == joint) {
                return Err(bad(RoleFault::JointTaken { joint: given(), other }));
            }
            if let Some(first) = map.joints.insert(role, joint) {
                let first = skeleton.name(first).to_owned();
                return Err(bad(RoleFault::TwoJoints { first, second: given() }));
            }
        }
        for (&role, &joint) in &map.joints {
            map.check(skeleton, role, joint)?;
        }
        match NEEDED.into_iter().find(|role| !map.joints.contains_key(role)) {
            Some(role) => Err(Error::BadRole { role, fault: RoleFault::NoJoint }),
            None => Ok(map),
        }
    }

    fn empty(skeleton: &Skeleton, naming: &'static str) -> Self {
        let joint_count = skeleton.joint_count();
        Self { joints: BTreeMap::new(), followers: Vec::new(), naming, joint_count }
    }

    /// Checks the position of a joint in the hierarchy. It must be a descendant of the joints of
    /// its parent roles. Ends of limbs may be detached, but must not be ancestors of those joints.
    fn check(&self, skeleton: &Skeleton, role: Role, joint: JointIndex) -> Result<(), Error> {
        let above = std::iter::successors(role.parent(), |role| role.parent());
        for (at, (parent, of)) in above.filter_map(|r| Some((r, *self.joints.get(&r)?))).enumerate()
        {
            let elsewhere = role.may_be_detached() && !skeleton.is_below(of, joint) && of != joint;
            if (at == 0 || skeleton.is_below(of, joint))
                && !skeleton.is_below(joint, of)
                && !elsewhere
            {
                let [joint, above] = [joint, of].map(|joint| skeleton.name(joint).to_owned());
                return Err(Error::BadRole {
                    role,
                    fault: RoleFault::NotBelow { joint, above, parent },
                });
            }
        }
        Ok(())
    }

    /// The joint of a role.
    #[must_use]
    pub fn joint(&self, role: Role) -> Option<JointIndex> {
        self.joints.get(&role).copied()
    }

    /// All roles with a joint, and their joints.
    pub fn iter(&self) -> impl Iterator<Item = (Role, JointIndex)> + '_ {
        self.joints.iter().map(|(role, joint)| (*role, *joint))
    }

    /// Further joints that follow the joint of their role.
    #[must_use]
    pub fn followers(&self) -> &[(Role, JointIndex)] {
        &self.followers
    }

    /// The naming by which the roles were found: "VRM", "Mixamo", "Unreal", "KayKit", "Rigify",
    /// "Quaternius", "CMU", "Populace", or "given" for a map from [`from_names`](Self::from_names).
    #[must_use]
    pub fn naming(&self) -> &'static str {
        self.naming
    }

    /// Number of joints of the map's skeleton.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.joint_count
    }

    /// The lower legs and feet of which the foot does not hang on the leg, as in rigs whose feet
    /// are targets for legs to reach.
    pub fn loose_feet(
        &self,
        skeleton: &Skeleton,
    ) -> impl Iterator<Item = (JointIndex, JointIndex)> {
        let leg = |side| Some((self.joint(Role::LowerLeg(side))?, self.joint(Role::Foot(side))?));
        let legs = [Side::Left, Side::Right].into_iter().filter_map(leg);
        legs.filter(|(shin, foot)| !skeleton.is_below(*foot, *shin))
    }
}
