//! Reparenting of feet to their legs.

use populace_model::{
    JointIndex, JointSource, Role, RoleFault, RoleMap, Side, Skeleton, Trs, f64math,
};

use crate::Error;
use crate::character::{Character, CharacterSource, Level, PaletteEntry, SkinInstance};

impl Character {
    /// Returns the character with feet that are children of their lower legs, for rigs in which
    /// they are not. Constraints on legs, such as foot IK, then move the feet as well.
    ///
    /// Joints keep their names and their rest in model space, but not their indices. Clips keep
    /// their own skeleton and are bound by humanoid roles. Levels of detail stay; each evaluates at
    /// least the joints that it did. The character is unchanged if all feet are below their legs
    /// already.
    ///
    /// # Errors
    ///
    /// [`BadRole`](populace_model::Error::BadRole) for roles of another skeleton,
    /// [`BadRest`](populace_model::Error::BadRest) if the foot's rest would be sheared, and
    /// [`Cycle`](populace_model::Error::Cycle) for a leg below its own foot.
    pub fn with_feet_on_legs(&self, roles: &RoleMap) -> Result<Self, Error> {
        let old = &self.skeleton;
        if roles.joint_count() != old.joint_count() {
            let (wanted, joints) = (roles.joint_count(), old.joint_count());
            let fault = RoleFault::OtherSkeleton { wanted, joints };
            let role = Role::Foot(Side::Left);
            return Err(populace_model::Error::BadRole { role, fault }.into());
        }
        let place = |joint: JointIndex| old.source_from_joint(joint);
        let skeleton = Skeleton::new(&on_legs(old, roles)?)?;
        let standing = on_legs(old.in_bind_pose(), roles)?;
        let was = |joint: JointIndex| old.joint_from_source(skeleton.source_from_joint(joint));
        let reach: Vec<f32> =
            skeleton.joints().map(|joint| old.reach_m()[was(joint).index()]).collect();
        let soles: Vec<_> = skeleton.joints().map(|joint| old.soles(was(joint)).to_vec()).collect();
        let entry = |entry: &PaletteEntry| {
            let joint = skeleton.joint_from_source(place(entry.joint));
            PaletteEntry { joint, ..*entry }
        };
        let palette = self.palette.iter().map(entry).collect();
        let skin = |skin: &SkinInstance| SkinInstance {
            joints: skin.joints.iter().map(entry).collect(),
            ..skin.clone()
        };
        let skins = self.skins.iter().map(skin).collect();
        let bind_pose: Vec<Trs> = skeleton
            .joints()
            .map(|joint| standing[skeleton.source_from_joint(joint)].rest)
            .collect();
        // Feet are deeper in the hierarchy now, and come later among the joints.
        let level = |level: &Level| {
            let evaluated = |joint: &JointIndex| was(*joint).index() < level.joint_count;
            let last = skeleton.joints().filter(evaluated).last();
            let joint_count = last.map_or(1, |last| last.index() + 1);
            Level { joint_count, ..level.clone() }
        };
        let levels = self.levels().iter().map(level).collect();
        let skeleton =
            skeleton.clone().with_reach(&reach).with_bind_pose(&bind_pose).with_soles(&soles);
        let source = CharacterSource { skeleton, palette, skins, ..CharacterSource::clone(self) };
        Self::new(source)?.with_levels(levels)
    }
}

/// Returns the joints of a skeleton in the order of their source, with feet as children of their
/// lower legs. Joints keep their rest in model space.
fn on_legs(
    skeleton: &Skeleton,
    roles: &RoleMap,
) -> Result<Vec<JointSource>, populace_model::Error> {
    let place = |joint: JointIndex| skeleton.source_from_joint(joint);
    let source = |joint: JointIndex| JointSource {
        name: skeleton.name(joint).to_owned(),
        parent: skeleton.parent(joint).map(place),
        rest: *skeleton.rest(joint),
    };
    let mut joints: Vec<_> =
        (0..skeleton.joint_count()).map(|at| source(skeleton.joint_from_source(at))).collect();
    let models = skeleton.rest_models();
    for (shin, foot) in roles.loose_feet(skeleton) {
        let rest = models[shin.index()].inverse() * models[foot.index()];
        let Some(rest) = f64math::trs(rest) else {
            let (joint, name) = (place(foot), skeleton.name(foot).to_owned());
            let what = "a shear, once it hangs on its leg";
            return Err(populace_model::Error::BadRest { joint, name, what });
        };
        joints[place(foot)].rest = rest;
        joints[place(foot)].parent = Some(place(shin));
    }
    Ok(joints)
}

#[cfg(test)]
mod tests {
    use populace_model::Affine;

    use super::*;

    /// Hips and legs, and feet that hang on the root.
    fn loose() -> (Character, RoleMap) {
        let names = ["root", "hips", "thigh.l", "shin.l", "thigh.r", "shin.r", "foot.l", "foot.r"];
        let parents = [None, Some(0), Some(1), Some(2), Some(1), Some(4), Some(0), Some(0)];
        let joint = |(name, parent): (&str, Option<usize>)| JointSource {
            name: name.into(),
            parent,
            rest: Trs { translation: [0.0, 0.1, 0.0], ..Trs::IDENTITY },
        };
        let joints: Vec<_> = names.into_iter().zip(parents).map(joint).collect();
        let skeleton = Skeleton::new(&joints).unwrap();
        let leg = |side| [Role::UpperLeg(side), Role::LowerLeg(side)];
        let legs = [leg(Side::Left), leg(Side::Right)].concat();
        let mut roles = vec![(Role::Hips, "hips")];
        roles.extend(legs.into_iter().zip(names[2..6].iter().copied()));
        roles.extend([(Role::Foot(Side::Left), "foot.l"), (Role::Foot(Side::Right), "foot.r")]);
        let roles = RoleMap::from_names(&skeleton, &roles).unwrap();
        let entry = |joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY };
        let palette = skeleton.joints().map(entry).collect();
        let (parts, materials, images, skins, clips) = (vec![], vec![], vec![], vec![], vec![]);
        let name = "loose".into();
        let source =
            CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
        (Character::new(source).unwrap(), roles)
    }

    #[test]
    fn levels_of_detail_stay_and_evaluate_the_joints_that_they_did() {
        let (loose, roles) = loose();
        let level =
            |joint_count| Level { error_m: 1.0 / joint_count as f32, meshes: vec![], joint_count };
        let levels = [8, 4, 2].map(level).to_vec();
        let before = loose.with_levels(levels).unwrap();
        let after = before.with_feet_on_legs(&roles).unwrap();
        let evaluated = |character: &Character, level: &Level| {
            let joints = character.skeleton.joints().take(level.joint_count);
            joints.map(|joint| character.skeleton.name(joint).to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(after.levels().len(), before.levels().len());
        for (old, new) in before.levels().iter().zip(after.levels()) {
            assert_eq!((old.error_m, &old.meshes), (new.error_m, &new.meshes));
            let (wanted, found) = (evaluated(&before, old), evaluated(&after, new));
            assert!(wanted.iter().all(|name| found.contains(name)), "{wanted:?} {found:?}");
            let last = found.last().unwrap();
            assert!(wanted.contains(last), "{last} need not be evaluated");
        }
    }
}
