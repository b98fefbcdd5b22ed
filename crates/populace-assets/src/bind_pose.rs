//! The pose in which skins were bound to their joints (glTF 2.0, section 3.7.3.1).

use std::collections::HashMap;

use populace_character::{PaletteEntry, SkinInstance};
use populace_model::{JointIndex, Skeleton, Trs, f64math};

/// Returns the local transform of each joint, in level order, in the pose in which skins were bound
/// to them: in the first of `skins` with a bind matrix of the joint and one of its parent. Other
/// joints are at rest.
pub(crate) fn bind_pose(skeleton: &Skeleton, skins: &[SkinInstance]) -> Vec<Trs> {
    let mut bound: Vec<Option<Trs>> = vec![None; skeleton.joint_count()];
    for skin in skins {
        let mut entries: HashMap<JointIndex, &PaletteEntry> = HashMap::new();
        for entry in &skin.joints {
            entries.entry(entry.joint).or_insert(entry);
        }
        for (joint, entry) in &entries {
            let of_parent = || entries.get(&skeleton.parent(*joint)?);
            let bound = &mut bound[joint.index()];
            *bound = bound.or_else(|| between(of_parent()?, entry));
        }
    }
    let of = |joint: JointIndex| bound[joint.index()].unwrap_or(*skeleton.rest(joint));
    skeleton.joints().map(of).collect()
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
        let other = vec![bound(2, [0.0, 7.0, 0.0]), bound(1, [0.0, 6.0, 0.0])];
        let skins = [joints, other].map(|joints| SkinInstance { skin: 0, node: 0, joints });
        let pose = bind_pose(&skeleton, &skins);
        assert_eq!((pose[0], pose[1]), (up, up), "their parents have no bind matrix");
        assert_eq!(pose[2].translation, [0.0, 0.5, 2.0], "of the first skin that has both");
        assert_eq!(bind_pose(&skeleton, &[]), [up; 3]);
    }
}
