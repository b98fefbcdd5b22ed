//! Look-at, reach and planted feet of humanoids, whose roles name the joints.

use std::f32::consts::PI;

use populace_device::{ConstraintFault, Feet, Foot, GazeLimits};
use populace_model::{JointIndex, Role, RoleMap, Side, Skeleton};
use populace_settings::parts::check_weight;

use super::Constraints;
use super::targets::gaze_of;
use crate::crowd::base::Base;
use crate::crowd::{CharacterId, MemberId};
use crate::{Error, Gaze, Target, Weight};

/// The shares of the rotation of a gaze, among the joints that a body has.
const SHARES: [(Role, f32); 5] = [
    (Role::Spine, 0.1),
    (Role::Chest, 0.1),
    (Role::UpperChest, 0.1),
    (Role::Neck, 0.25),
    (Role::Head, 0.45),
];
/// The limits of the eyes' direction relative to the head.
const EYES: GazeLimits = GazeLimits {
    yaw_rad: 30.0 / 180.0 * PI,
    up_rad: 20.0 / 180.0 * PI,
    down_rad: 30.0 / 180.0 * PI,
};

impl Constraints {
    pub(crate) fn look_at(
        &mut self,
        base: &mut Base,
        member: MemberId,
        target: Target,
        weight: Weight,
    ) -> Result<(), Error> {
        let character = base.check(member)?;
        let gazes = usual_gaze(base, character)?.into_iter().map(gaze_of).collect();
        self.aim(base, member, target, weight, gazes)
    }

    pub(crate) fn plant_feet(
        &mut self,
        base: &mut Base,
        member: MemberId,
        weight: f32,
    ) -> Result<(), Error> {
        check_weight("the weight of planted feet", weight)?;
        let character = base.check(member)?;
        let roles = base.roles(character)?.ok_or_else(|| no_roles(base, character, "legs"))?;
        let foot = |side: Side| {
            let of = |role: Role| roles.joint(role);
            Some(Foot {
                hip: of(Role::UpperLeg(side))?,
                knee: of(Role::LowerLeg(side))?,
                ankle: of(Role::Foot(side))?,
            })
        };
        let legs: Vec<Foot> = [Side::Left, Side::Right].into_iter().filter_map(foot).collect();
        let own = &base.character_state(character)?.character;
        if let Some((shin, foot)) = roles.loose_feet(&own.skeleton).next() {
            let [shin, foot] = [shin, foot].map(|joint| own.skeleton.name(joint).to_owned());
            let fault = ConstraintFault::LooseFoot { character: own.name.clone(), shin, foot };
            return Err(Error::Tables(fault.into()));
        }
        // Legs may hang on a joint other than the hips: the joint above both is lowered.
        let carries =
            |joint: &JointIndex| legs.iter().all(|leg| own.skeleton.is_below(leg.hip, *joint));
        let above = roles
            .joint(Role::Hips)
            .into_iter()
            .flat_map(|hips| std::iter::once(hips).chain(own.skeleton.ancestors(hips)));
        let pelvis = above.filter(|_| !legs.is_empty()).find(carries);
        let pelvis = pelvis.ok_or_else(|| no_roles(base, character, "legs"))?;
        self.plant_with(base, member, &Feet { pelvis, feet: legs, weight })
    }
}

/// Returns the gazes of a character: spine and head, then each eye.
fn usual_gaze(base: &Base, character: CharacterId) -> Result<Vec<Gaze>, Error> {
    let skeleton = &base.character_state(character)?.character.skeleton;
    let gaze =
        |chain: Vec<(JointIndex, f32)>, limits| Gaze { chain, facing: [0.0, 0.0, 1.0], limits };
    let Some(roles) = base.roles(character)? else {
        let head = head_by_name(skeleton).ok_or_else(|| no_roles(base, character, "head"))?;
        return Ok(vec![gaze(vec![(head, 1.0)], GazeLimits::HEAD)]);
    };
    let trunk = SHARES.iter().filter_map(|(role, share)| Some((roles.joint(*role)?, *share)));
    let eyes =
        [Side::Left, Side::Right].into_iter().filter_map(|side| roles.joint(Role::Eye(side)));
    let eyes = eyes.map(|eye| gaze(vec![(eye, 1.0)], EYES));
    Ok([gaze(trunk.collect(), GazeLimits::HEAD)].into_iter().chain(eyes).collect())
}

fn no_roles(base: &Base, character: CharacterId, part: &'static str) -> Error {
    let state = base.character_state(character);
    let character = state.map_or_else(|_| String::new(), |state| state.character.name.clone());
    Error::Tables(ConstraintFault::UnknownRoles { character, part }.into())
}

/// Returns the first joint whose name contains "head".
fn head_by_name(skeleton: &Skeleton) -> Option<JointIndex> {
    skeleton.joints().find(|joint| skeleton.name(*joint).to_lowercase().contains("head"))
}

/// Returns the first and middle joint of the limb that ends in a joint, by roles: shoulder and
/// elbow, or hip and knee.
pub(crate) fn limb_above(roles: Option<&RoleMap>, end: JointIndex) -> Option<[JointIndex; 2]> {
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
