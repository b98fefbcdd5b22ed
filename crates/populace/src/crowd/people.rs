//! What bodies do without being told with which joints: those whose humanoid roles are known look,
//! reach and stand.

use std::f32::consts::PI;

use populace_device::{Feet, Foot, Gaze, GazeLimits};
use populace_model::{JointIndex, Role, RoleMap, Side, Skeleton};

use super::{CharacterId, Crowd, Member};
use crate::{Error, Target, Weight};

/// How trunk and head share a turn: what each has of it, of those that a body has.
const SHARES: [(Role, f32); 5] = [
    (Role::Spine, 0.1),
    (Role::Chest, 0.1),
    (Role::UpperChest, 0.1),
    (Role::Neck, 0.25),
    (Role::Head, 0.45),
];
/// How far a head faces away from the hips' front at most, the trunk's part included.
const HEAD: GazeLimits = GazeLimits {
    yaw_rad: 85.0 / 180.0 * PI,
    up_rad: 45.0 / 180.0 * PI,
    down_rad: 50.0 / 180.0 * PI,
};
/// How far eyes look away from the head's front.
const EYES: GazeLimits = GazeLimits {
    yaw_rad: 30.0 / 180.0 * PI,
    up_rad: 20.0 / 180.0 * PI,
    down_rad: 30.0 / 180.0 * PI,
};

impl Crowd {
    /// Lets a member look at something, from now on and in place of what it looked at before:
    /// spine, neck, head and eyes share the turn, as far as the character has them, and the gaze
    /// eases over, or follows where calls move its target ([`Weight`]). Beyond 85 degrees to either
    /// side, 45 up and 50 down it is followed no further, and while it passes behind the gaze comes
    /// back to the front.
    ///
    /// A character without humanoid roles looks with its joint that is called head.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a character whose head is not known (see
    /// [`set_roles`](Self::set_roles) and [`look_with`](Self::look_with)), or a target or weight
    /// that is out of its range.
    pub fn look_at(
        &mut self,
        member: Member,
        target: impl Into<Target>,
        weight: Weight,
    ) -> Result<(), Error> {
        let character = self.check(member)?;
        let target = target.into();
        for gaze in self.usual_gaze(character)? {
            self.look_with(member, &gaze, target, weight)?;
        }
        Ok(())
    }

    /// Lets a member's feet keep to the ground, both legs by the character's humanoid roles; no
    /// longer for a weight of 0. How long it takes to come to the weight does not count here.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a character whose legs are not known (see
    /// [`set_roles`](Self::set_roles) and [`plant_with`](Self::plant_with)) or whose feet hang
    /// elsewhere (see
    /// [`Character::with_feet_on_legs`](populace_character::Character::with_feet_on_legs)), or a weight
    /// that is not from 0 to 1.
    pub fn plant_feet(&mut self, member: Member, weight: Weight) -> Result<(), Error> {
        weight.check()?;
        let character = self.check(member)?;
        let roles = self.roles(character)?.ok_or_else(|| self.no_roles(character, "legs"))?;
        let foot = |side: Side| {
            let of = |role: Role| roles.joint(role);
            Some(Foot {
                hip: of(Role::UpperLeg(side))?,
                knee: of(Role::LowerLeg(side))?,
                ankle: of(Role::Foot(side))?,
            })
        };
        let legs: Vec<Foot> = [Side::Left, Side::Right].into_iter().filter_map(foot).collect();
        let own = &self.character_state(character)?.character;
        if let Some((shin, foot)) = roles.loose_feet(&own.skeleton).next() {
            let [shin, foot] = [shin, foot].map(|joint| own.skeleton.name(joint));
            let what = format!(
                "the foot \"{foot}\" of \"{}\" does not hang on its leg \"{shin}\", so it would \
                 stay behind; add the character that Character::with_feet_on_legs makes of it",
                own.name
            );
            return Err(populace_device::Error::BadConstraint { what }.into());
        }
        // Legs may hang on a joint beside the hips: what carries both sinks.
        let carries =
            |joint: &JointIndex| legs.iter().all(|leg| own.skeleton.is_below(leg.hip, *joint));
        let above = roles
            .joint(Role::Hips)
            .into_iter()
            .flat_map(|hips| std::iter::once(hips).chain(own.skeleton.ancestors(hips)));
        let pelvis = above.filter(|_| !legs.is_empty()).find(carries);
        let pelvis = pelvis.ok_or_else(|| self.no_roles(character, "legs"))?;
        self.plant_with(member, &Feet { pelvis, feet: legs, weight: weight.value })
    }

    /// What a character looks with: trunk and head, then each eye.
    fn usual_gaze(&self, character: CharacterId) -> Result<Vec<Gaze>, Error> {
        let skeleton = &self.character_state(character)?.character.skeleton;
        let gaze = |chain: Vec<(JointIndex, f32)>, limits| Gaze {
            chain,
            facing: [0.0, 0.0, 1.0],
            limits,
            targets: Vec::new(),
        };
        let Some(roles) = self.roles(character)? else {
            let head = head_by_name(skeleton).ok_or_else(|| self.no_roles(character, "head"))?;
            return Ok(vec![gaze(vec![(head, 1.0)], HEAD)]);
        };
        let trunk = SHARES.iter().filter_map(|(role, share)| Some((roles.joint(*role)?, *share)));
        let eyes =
            [Side::Left, Side::Right].into_iter().filter_map(|side| roles.joint(Role::Eye(side)));
        let eyes = eyes.map(|eye| gaze(vec![(eye, 1.0)], EYES));
        Ok([gaze(trunk.collect(), HEAD)].into_iter().chain(eyes).collect())
    }

    fn no_roles(&self, character: CharacterId, part: &str) -> Error {
        let name =
            self.character_state(character).map_or("", |state| state.character.name.as_str());
        let what = format!(
            "which joints of \"{name}\" are its {part} is not known by their names; say so by \
             Crowd::set_roles, or name the joints themselves"
        );
        populace_device::Error::BadConstraint { what }.into()
    }
}

/// The first joint from the root on whose name speaks of a head.
fn head_by_name(skeleton: &Skeleton) -> Option<JointIndex> {
    skeleton.joints().find(|joint| skeleton.name(*joint).to_lowercase().contains("head"))
}

/// The joints that turn and bend of the limb that ends in a joint, by roles: shoulder and elbow, or
/// hip and knee.
pub(super) fn limb_above(roles: Option<&RoleMap>, end: JointIndex) -> Option<[JointIndex; 2]> {
    let roles = roles?;
    let limbs = [Side::Left, Side::Right].into_iter().flat_map(|side| {
        [
            (Role::Hand(side), Role::UpperArm(side), Role::LowerArm(side)),
            (Role::Foot(side), Role::UpperLeg(side), Role::LowerLeg(side)),
        ]
    });
    let mut of_end = limbs.filter(|(last, _, _)| roles.joint(*last) == Some(end));
    let (_, first, middle) = of_end.next()?;
    Some([roles.joint(first)?, roles.joint(middle)?])
}
