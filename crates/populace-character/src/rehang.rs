//! Reparenting of feet to their legs.

use populace_model::{
    JointIndex, JointSource, Role, RoleFault, RoleMap, Side, Skeleton, Trs, f64math,
};

use crate::Error;
use crate::character::{Character, CharacterSource, PaletteEntry, SkinInstance};

impl Character {
    /// Returns the character with feet that are children of their lower legs, for rigs in which
    /// they are not. Constraints on legs, such as foot IK, then move the feet as well.
    ///
    /// Joints keep their names and their rest in model space, but not their indices. Clips keep
    /// their own skeleton and are bound by humanoid roles. The character is unchanged if all feet
    /// are below their legs already.
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
        let skeleton =
            skeleton.clone().with_reach(&reach).with_bind_pose(&bind_pose).with_soles(&soles);
        Self::new(CharacterSource { skeleton, palette, skins, ..CharacterSource::clone(self) })
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
