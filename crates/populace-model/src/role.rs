//! The roles that joints have in a humanoid body.

use std::fmt;

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
    pub(crate) const fn may_be_detached(self) -> bool {
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

pub(crate) const FINGERS: [Finger; 5] =
    [Finger::Thumb, Finger::Index, Finger::Middle, Finger::Ring, Finger::Little];
pub(crate) const PHALANGES: [Phalanx; 3] = [Phalanx::First, Phalanx::Second, Phalanx::Third];

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
