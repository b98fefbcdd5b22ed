//! Humanoid roles: which joint of a skeleton is whose upper arm, whatever it is called there.

mod detect;
mod names;
mod schemes;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt;

use crate::{Error, JointIndex, Skeleton};

/// A side of a body, seen from inside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// Towards +X of a body that faces +Z.
    Left,
    /// Towards -X.
    Right,
}

/// A finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Finger {
    /// The thumb.
    Thumb,
    /// Beside the thumb.
    Index,
    /// The middle one.
    Middle,
    /// Beside the little one.
    Ring,
    /// The little one.
    Little,
}

/// A joint of a finger, from the hand outwards. VRM calls those of a thumb metacarpal, proximal and
/// distal, those of other fingers proximal, intermediate and distal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phalanx {
    /// At the hand.
    First,
    /// In the middle.
    Second,
    /// The last.
    Third,
}

/// What a joint is to a humanoid body: the bones of VRM 1.0 (specification, `humanoid`). Displays
/// as VRM names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The joint that legs and spine hang on.
    Hips,
    /// The lowest joint of the back.
    Spine,
    /// The next one.
    Chest,
    /// The one that neck and shoulders hang on, where there are three.
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
    /// From shoulder to elbow.
    UpperArm(Side),
    /// From elbow to wrist.
    LowerArm(Side),
    /// From the wrist on.
    Hand(Side),
    /// From hip to knee.
    UpperLeg(Side),
    /// From knee to ankle.
    LowerLeg(Side),
    /// From the ankle on.
    Foot(Side),
    /// From the ball of the foot on.
    Toes(Side),
    /// A joint of a finger.
    Finger(Side, Finger, Phalanx),
}

impl Role {
    /// The same on the other side; those in the middle stay.
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

    /// Its side; `None` in the middle.
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

    /// The role that this one hangs on in a body that has all; `None` for the hips.
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

    /// Rigs whose feet are pulled by targets, and those with several bones in a palm, hang these on
    /// some other joint than the limb that they end.
    const fn may_hang_elsewhere(self) -> bool {
        matches!(self, Self::Foot(_) | Self::Toes(_) | Self::Hand(_) | Self::Finger(..))
    }
}

/// All roles, each after the one that it hangs on.
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

/// Which joints of one skeleton have which roles.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleMap {
    joints: BTreeMap<Role, JointIndex>,
    /// Further joints that move as those of their roles do: bones of one palm.
    followers: Vec<(Role, JointIndex)>,
    naming: &'static str,
    joint_count: usize,
}

/// Roles without which nothing can be retargeted: the scale comes from the legs.
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
    /// A user's own map, by the names of joints.
    ///
    /// # Errors
    ///
    /// [`Error::BadRole`] for a joint that is not there, a role or a joint named twice, a joint
    /// that does not hang where its role does, or a body without hips and legs.
    pub fn from_names(skeleton: &Skeleton, names: &[(Role, &str)]) -> Result<Self, Error> {
        let mut map = Self::empty(skeleton, "given");
        for &(role, name) in names {
            let bad = |what: String| Error::BadRole { role: role.to_string(), what };
            let joint = skeleton
                .find(name)
                .ok_or_else(|| bad(format!("the skeleton has no joint \"{name}\"")))?;
            if let Some((other, _)) = map.joints.iter().find(|(_, taken)| **taken == joint) {
                return Err(bad(format!(
                    "joint \"{name}\" is {other} already; a joint has one role"
                )));
            }
            if let Some(first) = map.joints.insert(role, joint) {
                let first = skeleton.name(first);
                return Err(bad(format!(
                    "both \"{first}\" and \"{name}\" are given; a role has one joint"
                )));
            }
        }
        for (&role, &joint) in &map.joints {
            map.check(skeleton, role, joint)?;
        }
        match NEEDED.into_iter().find(|role| !map.joints.contains_key(role)) {
            Some(role) => {
                let what = "no joint is given; hips, upper and lower legs and feet are needed, \
                            others are welcome";
                Err(Error::BadRole { role: role.to_string(), what: what.into() })
            }
            None => Ok(map),
        }
    }

    fn empty(skeleton: &Skeleton, naming: &'static str) -> Self {
        let joint_count = skeleton.joint_count();
        Self { joints: BTreeMap::new(), followers: Vec::new(), naming, joint_count }
    }

    /// Whether a joint hangs where its role does: beneath the joints of the roles above, or
    /// elsewhere, for ends of limbs, but never above any of them.
    fn check(&self, skeleton: &Skeleton, role: Role, joint: JointIndex) -> Result<(), Error> {
        let above = std::iter::successors(role.parent(), |role| role.parent());
        for (at, (parent, of)) in above.filter_map(|r| Some((r, *self.joints.get(&r)?))).enumerate()
        {
            let elsewhere =
                role.may_hang_elsewhere() && !skeleton.is_below(of, joint) && of != joint;
            if (at == 0 || skeleton.is_below(of, joint))
                && !skeleton.is_below(joint, of)
                && !elsewhere
            {
                let (name, of) = (skeleton.name(joint), skeleton.name(of));
                let what = format!("joint \"{name}\" does not hang on \"{of}\", which is {parent}");
                return Err(Error::BadRole { role: role.to_string(), what });
            }
        }
        Ok(())
    }

    /// The joint of a role.
    #[must_use]
    pub fn joint(&self, role: Role) -> Option<JointIndex> {
        self.joints.get(&role).copied()
    }

    /// All roles that have a joint, with it.
    pub fn iter(&self) -> impl Iterator<Item = (Role, JointIndex)> + '_ {
        self.joints.iter().map(|(role, joint)| (*role, *joint))
    }

    /// Further joints that move as those of their roles do.
    #[must_use]
    pub fn followers(&self) -> &[(Role, JointIndex)] {
        &self.followers
    }

    /// By which names the roles were found: "VRM", "Mixamo", "Unreal", "KayKit", "Rigify",
    /// "Quaternius", "CMU", "Populace", or "given" for a user's own.
    #[must_use]
    pub fn naming(&self) -> &'static str {
        self.naming
    }

    /// How many joints the skeleton has that the map is for.
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
