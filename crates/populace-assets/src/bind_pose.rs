//! The pose in which skins were bound to their joints (glTF 2.0, section 3.7.3.1).

use populace_character::{PaletteEntry, SkinInstance};
use populace_model::{JointIndex, Skeleton, Trs, f64math};

/// Returns the local transform of each joint, in level order, in the pose in which skins were bound
/// to them. A joint whose parent has no bind matrix in the same skin is at rest.
pub(crate) fn bind_pose(skeleton: &Skeleton, skins: &[SkinInstance]) -> Vec<Trs> {
    let bound = |joint: JointIndex| {
        let parent = skeleton.parent(joint)?;
        skins.iter().find_map(|skin| {
            let of = |joint| skin.joints.iter().find(|entry| entry.joint == joint);
            between(of(parent)?, of(joint)?)
        })
    };
    skeleton.joints().map(|joint| bound(joint).unwrap_or(*skeleton.rest(joint))).collect()
}

/// Returns the transform from a joint to its parent when both were bound.
fn between(parent: &PaletteEntry, joint: &PaletteEntry) -> Option<Trs> {
    let [parent, joint] = [parent, joint].map(|entry| f64math::affine_from(&entry.joint_from_bind));
    f64math::trs(parent * joint.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;
    use populace_model::{Affine, JointSource};

    #[test]
    fn joints_below_bound_parents_are_as_bound() {
        let up = Trs { translation: [0.0, 1.0, 0.0], ..Trs::IDENTITY };
        let joint = |name: &str, parent| JointSource { name: name.into(), parent, rest: up };
        let skeleton =
            Skeleton::new(&[joint("root", None), joint("knee", Some(0)), joint("foot", Some(1))])
                .unwrap();
        let bound = |nth: usize, at: [f32; 3]| {
            let mut joint_from_bind = Affine::IDENTITY;
            (0..3).for_each(|row| joint_from_bind.rows[row][3] = -at[row]);
            PaletteEntry { joint: skeleton.joint_from_source(nth), joint_from_bind }
        };
        let joints = vec![bound(1, [0.0, 5.0, 0.0]), bound(2, [0.0, 5.5, 2.0])];
        let skins = [SkinInstance { skin: 0, node: 0, joints }];
        let pose = bind_pose(&skeleton, &skins);
        assert_eq!((pose[0], pose[1]), (up, up), "their parents have no bind matrix");
        assert_eq!(pose[2].translation, [0.0, 0.5, 2.0]);
        assert_eq!(bind_pose(&skeleton, &[]), [up; 3]);
    }
}
