//! Humanoid roles: the body part of each joint, whatever its name.

mod detect;
mod names;
mod schemes;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt;

use crate::{Error, JointIndex, RoleFault, Skeleton};

/// A side of a body, as seen by the body itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// Towards +X for a body that faces +Z.
    Left,
    /// Towards -X.
    Right,
}

/// A finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Finger {
    /// The thumb.
    Thumb,
    /// The index finger.
    Index,
    /// The middle finger.
    Middle,
    /// The ring finger.
    Ring,
    /// The little finger.
    Little,
}

/// A joint of a finger, from the hand outwards. VRM calls those of the thumb metacarpal, proximal
/// and distal, those of other fingers proximal, intermediate and distal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phalanx {
    /// The joint at the hand.
    First,
    /// The joint in the middle.
    Second,
    /// The joint nearest to the tip.
    Third,
}

/// The function of a joint in a humanoid body: the bones of VRM 1.0 (specification, `humanoid`).
/// `Display` gives VRM's names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The common parent of legs and spine.
    Hips,
    /// The lowest joint of the back.
    Spine,
    /// The next joint of the back.
    Chest,
    /// The parent of neck and shoulders, if the back has three joints.
    UpperChest,
    /// The neck.
    Neck,
    /// The head.
    Head,
    /// The jaw.
    Jaw,
    /// An eye.
    Eye(Side),
    /// A collarbone.
    Shoulder(Side),
    /// The upper arm, from shoulder to elbow.
    UpperArm(Side),
    /// The lower arm, from elbow to wrist.
    LowerArm(Side),
    /// The hand, from the wrist.
    Hand(Side),
    /// The upper leg, from hip to knee.
    UpperLeg(Side),
    /// The lower leg, from knee to ankle.
    LowerLeg(Side),
    /// The foot, from the ankle.
    Foot(Side),
    /// The toes, from the ball of the foot.
    Toes(Side),
    /// A joint of a finger.
    Finger(Side, Finger, Phalanx),
}

impl Role {
    /// The same role on the given side. Roles without a side are unchanged.
    #[must_use]
    pub const fn on(self, side: Side) -> Self {
        match self {
            Self::Eye(_) => Self::Eye(side),
            Self::Shoulder(_) => Self::Shoulder(side),
            Self::UpperArm(_) => Self::UpperArm(side),
            Self::LowerArm(_) => Self::LowerArm(side),
            Self::Hand(_) => Self::Hand(side),
            Self::UpperLeg(_) => Self::UpperLeg(side),
            Self::LowerLeg(_) => Self::LowerLeg(side),
            Self::Foot(_) => Self::Foot(side),
            Self::Toes(_) => Self::Toes(side),
            Self::Finger(_, finger, phalanx) => Self::Finger(side, finger, phalanx),
            _ => self,
        }
    }

    /// The role's side; `None` for roles without one.
    #[must_use]
    pub const fn side(self) -> Option<Side> {
        match self {
            Self::Eye(side)
            | Self::Shoulder(side)
            | Self::UpperArm(side)
            | Self::LowerArm(side)
            | Self::Hand(side)
            | Self::UpperLeg(side)
            | Self::LowerLeg(side)
            | Self::Foot(side)
            | Self::Toes(side)
            | Self::Finger(side, ..) => Some(side),
            _ => None,
        }
    }

    /// The parent role in a body that has all roles; `None` for the hips.
    #[must_use]
    pub const fn parent(self) -> Option<Self> {
        Some(match self {
            Self::Hips => return None,
            Self::Spine | Self::UpperLeg(_) => Self::Hips,
            Self::Chest => Self::Spine,
            Self::UpperChest => Self::Chest,
            Self::Neck | Self::Shoulder(_) => Self::UpperChest,
            Self::Head => Self::Neck,
            Self::Jaw | Self::Eye(_) => Self::Head,
            Self::UpperArm(side) => Self::Shoulder(side),
            Self::LowerArm(side) => Self::UpperArm(side),
            Self::Hand(side) => Self::LowerArm(side),
            Self::LowerLeg(side) => Self::UpperLeg(side),
            Self::Foot(side) => Self::LowerLeg(side),
            Self::Toes(side) => Self::Foot(side),
            Self::Finger(side, _, Phalanx::First) => Self::Hand(side),
            Self::Finger(side, finger, Phalanx::Second) => {
                Self::Finger(side, finger, Phalanx::First)
            }
            Self::Finger(side, finger, Phalanx::Third) => {
                Self::Finger(side, finger, Phalanx::Second)
            }
        })
    }

    /// Returns whether joints of the role may be detached. Rigs whose feet are IK targets, and rigs
    /// with several bones in a palm, have them under another joint than the limb that they end.
    const fn may_be_detached(self) -> bool {
        matches!(self, Self::Foot(_) | Self::Toes(_) | Self::Hand(_) | Self::Finger(..))
    }
}

/// Returns all roles, parents first.
pub(crate) fn all_roles() -> impl Iterator<Item = Role> {
    let middle =
        [Role::Hips, Role::Spine, Role::Chest, Role::UpperChest, Role::Neck, Role::Head, Role::Jaw];
    let side = |side| {
        let limbs = [
            Role::Shoulder(side),
            Role::UpperArm(side),
            Role::LowerArm(side),
            Role::Hand(side),
            Role::UpperLeg(side),
            Role::LowerLeg(side),
            Role::Foot(side),
            Role::Toes(side),
            Role::Eye(side),
        ];
        let fingers = FINGERS.into_iter().flat_map(move |finger| {
            PHALANGES.into_iter().map(move |phalanx| Role::Finger(side, finger, phalanx))
        });
        limbs.into_iter().chain(fingers)
    };
    middle.into_iter().chain(side(Side::Left)).chain(side(Side::Right))
}

const FINGERS: [Finger; 5] =
    [Finger::Thumb, Finger::Index, Finger::Middle, Finger::Ring, Finger::Little];
const PHALANGES: [Phalanx; 3] = [Phalanx::First, Phalanx::Second, Phalanx::Third];

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = match self {
            Self::Hips => "hips".to_owned(),
            Self::Finger(_, finger, phalanx) => {
                let thumb = *finger == Finger::Thumb;
                let part = match (phalanx, thumb) {
                    (Phalanx::First, true) => "Metacarpal",
                    (Phalanx::First, false) | (Phalanx::Second, true) => "Proximal",
                    (Phalanx::Second, false) => "Intermediate",
                    (Phalanx::Third, _) => "Distal",
                };
                format!("{finger:?}{part}")
            }
            _ => {
                let name = format!("{self:?}");
                name.split('(').next().unwrap_or_default().to_owned()
            }
        };
        match self.side() {
            Some(side) => write!(f, "{}{part}", if side == Side::Left { "left" } else { "right" }),
            None => write!(f, "{}{}", part[..1].to_lowercase(), &part[1..]),
        }
    }
}

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
