//! Reparenting of feet to their legs.

use populace_model::{
    JointIndex, JointSource, Role, RoleFault, RoleMap, Side, Skeleton, Trs, f64math,
};

use crate::Error;
use crate::character::{Character, CharacterSource, PaletteEntry, SkinInstance};

/// Tolerance: a transform that differs by more than this from its decomposition into translation,
/// rotation and scale counts as sheared.
const SHEARED: f64 = 1e-3;

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
        let source = |joint: JointIndex| JointSource {
            name: old.name(joint).to_owned(),
            parent: old.parent(joint).map(place),
            rest: *old.rest(joint),
        };
        let mut joints: Vec<_> =
            (0..old.joint_count()).map(|at| source(old.joint_from_source(at))).collect();
        let models = old.rest_models();
        for (shin, foot) in roles.loose_feet(old) {
            let rest = models[shin.index()].inverse() * models[foot.index()];
            let (scale, rotation, translation) = rest.to_scale_rotation_translation();
            let plain =
                glam::DAffine3::from_scale_rotation_translation(scale, rotation, translation);
            if !plain.abs_diff_eq(rest, SHEARED) {
                let (joint, name) = (place(foot), old.name(foot).to_owned());
                let what = "a shear, once it hangs on its leg";
                return Err(populace_model::Error::BadRest { joint, name, what }.into());
            }
            let (translation, scale) =
                (f64math::to_f32(translation.to_array()), f64math::to_f32(scale.to_array()));
            let rotation = f64math::to_f32(rotation.to_array());
            joints[place(foot)].rest = Trs { translation, rotation, scale };
            joints[place(foot)].parent = Some(place(shin));
        }
        let skeleton = Skeleton::new(&joints)?;
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
        let skeleton = skeleton.clone().with_reach(&reach).with_soles(&soles);
        Self::new(CharacterSource { skeleton, palette, skins, ..CharacterSource::clone(self) })
    }
}
