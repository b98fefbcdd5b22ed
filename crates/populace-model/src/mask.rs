//! Masks: the weight of each joint in a layer.

use crate::humanoid::{Role, RoleMap};
use crate::{Error, JointIndex, RoleFault, Skeleton};

/// A weight per joint of one skeleton: 1 for affected, 0 for unaffected joints.
///
/// ```
/// use populace_model::{JointSource, Mask, Skeleton, Trs};
///
/// let joint = |name: &str, parent| JointSource { name: name.into(), parent, rest: Trs::IDENTITY };
/// let skeleton = Skeleton::new(&[
///     joint("hips", None),
///     joint("spine", Some(0)),
///     joint("chest", Some(1)),
///     joint("head", Some(2)),
/// ])?;
/// let upper = Mask::of_subtrees(&skeleton, ["spine"])?.with_falloff(&skeleton, 2)?;
/// assert_eq!(upper.weights(), [0.0, 0.5, 1.0, 1.0]);
/// let head = Mask::of_joints(&skeleton, ["head"])?;
/// assert_eq!(upper.without(&head)?.weights(), [0.0, 0.5, 1.0, 0.0]);
///
/// let error = Mask::of_joints(&skeleton, ["haed"]).unwrap_err();
/// let message = "there is no joint \"haed\"; did you mean \"head\" or \"chest\"?";
/// assert_eq!(error.to_string(), message);
/// # Ok::<(), populace_model::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    weights: Vec<f32>,
}

impl Mask {
    /// Creates a mask from one weight per joint, in level order.
    ///
    /// # Errors
    ///
    /// [`Error::BadMask`] if the number of weights is not the number of joints, or a weight is not
    /// from 0 to 1.
    pub fn new(skeleton: &Skeleton, weights: Vec<f32>) -> Result<Self, Error> {
        let good = weights.len() == skeleton.joint_count()
            && weights.iter().all(|w| (0.0..=1.0).contains(w));
        if good {
            Ok(Self { weights })
        } else {
            Err(Error::BadMask { weights: weights.len(), joints: skeleton.joint_count() })
        }
    }

    /// Creates a mask with weight 1 for a joint and its descendants, 0 for the others.
    #[must_use]
    pub fn subtree(skeleton: &Skeleton, root: JointIndex) -> Self {
        Self::subtrees(skeleton, &[root])
    }

    /// Creates a mask with weight 1 for the named joints and their descendants, 0 for the others.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownJoints`] with the nearest names.
    pub fn of_subtrees<N: AsRef<str>>(
        skeleton: &Skeleton,
        names: impl IntoIterator<Item = N>,
    ) -> Result<Self, Error> {
        Ok(Self::subtrees(skeleton, &skeleton.find_all(names)?))
    }

    /// Creates a mask with weight 1 for exactly the named joints, 0 for the others, including their
    /// descendants.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownJoints`] with the nearest names.
    pub fn of_joints<N: AsRef<str>>(
        skeleton: &Skeleton,
        names: impl IntoIterator<Item = N>,
    ) -> Result<Self, Error> {
        let mut weights = vec![0.0; skeleton.joint_count()];
        for joint in skeleton.find_all(names)? {
            weights[joint.index()] = 1.0;
        }
        Ok(Self { weights })
    }

    /// Creates a mask with weight 1 for the joints of these humanoid roles, 0 for those of other
    /// roles. A joint without a role has the weight of its nearest ancestor with a role.
    ///
    /// # Errors
    ///
    /// [`Error::BadRole`] for a role that the body has no joint for, [`Error::BadMask`] if `map`
    /// belongs to another skeleton.
    pub fn of_roles(
        skeleton: &Skeleton,
        map: &RoleMap,
        roles: impl IntoIterator<Item = Role>,
    ) -> Result<Self, Error> {
        if map.joint_count() != skeleton.joint_count() {
            return Err(Error::BadMask {
                weights: map.joint_count(),
                joints: skeleton.joint_count(),
            });
        }
        let mut own = vec![None; skeleton.joint_count()];
        map.iter().for_each(|(_, joint)| own[joint.index()] = Some(0.0));
        for role in roles {
            let missing = || Error::BadRole { role, fault: RoleFault::NotOnBody };
            own[map.joint(role).ok_or_else(missing)?.index()] = Some(1.0);
        }
        let mut weights = vec![0.0; skeleton.joint_count()];
        for joint in skeleton.joints() {
            let inherited = skeleton.parent(joint).map_or(0.0, |p| weights[p.index()]);
            weights[joint.index()] = own[joint.index()].unwrap_or(inherited);
        }
        Ok(Self { weights })
    }

    fn subtrees(skeleton: &Skeleton, roots: &[JointIndex]) -> Self {
        let mut weights = vec![0.0; skeleton.joint_count()];
        for joint in skeleton.joints() {
            let inherited = skeleton.parent(joint).map_or(0.0, |p| weights[p.index()]);
            weights[joint.index()] = if roots.contains(&joint) { 1.0 } else { inherited };
        }
        Self { weights }
    }

    /// Ramps the weights up down the hierarchy over `joints` joints, so that no seam shows where
    /// the mask begins. A joint whose parent has weight 0 is the first, its children are the
    /// second, and so on. The `n`th keeps `n / joints` of its weight; the last one and all below it
    /// keep their full weight. 3 gives 1/3, 2/3, 1, 1; 0 and 1 change nothing.
    ///
    /// # Errors
    ///
    /// [`Error::BadMask`] if the mask belongs to another skeleton.
    pub fn with_falloff(mut self, skeleton: &Skeleton, joints: u32) -> Result<Self, Error> {
        if self.weights.len() != skeleton.joint_count() {
            return Err(Error::BadMask {
                weights: self.weights.len(),
                joints: skeleton.joint_count(),
            });
        }
        let mut depths = vec![0_u32; self.weights.len()];
        for joint in skeleton.joints().filter(|_| joints > 1) {
            let index = joint.index();
            if self.weights[index] > 0.0 {
                depths[index] = 1 + skeleton.parent(joint).map_or(0, |p| depths[p.index()]);
                self.weights[index] *= depths[index].min(joints) as f32 / joints as f32;
            }
        }
        Ok(self)
    }

    /// Combines two masks: each joint gets the larger weight.
    ///
    /// # Errors
    ///
    /// [`Error::BadMask`] if the mask belongs to another skeleton.
    pub fn and(self, other: &Self) -> Result<Self, Error> {
        self.with_each(other, f32::max)
    }

    /// Subtracts a mask: each weight is multiplied by 1 minus the other's.
    ///
    /// # Errors
    ///
    /// [`Error::BadMask`] if the mask belongs to another skeleton.
    pub fn without(self, other: &Self) -> Result<Self, Error> {
        self.with_each(other, |own, other| own * (1.0 - other))
    }

    /// Inverts the mask: each weight becomes 1 minus itself.
    #[must_use]
    pub fn inverted(mut self) -> Self {
        self.weights.iter_mut().for_each(|weight| *weight = 1.0 - *weight);
        self
    }

    fn with_each(mut self, other: &Self, merge: impl Fn(f32, f32) -> f32) -> Result<Self, Error> {
        if self.weights.len() != other.weights.len() {
            return Err(Error::BadMask {
                weights: other.weights.len(),
                joints: self.weights.len(),
            });
        }
        self.weights
            .iter_mut()
            .zip(&other.weights)
            .for_each(|(own, other)| *own = merge(*own, *other));
        Ok(self)
    }

    /// The weight of each joint, in level order.
    #[must_use]
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{JointSource, Trs};

    /// hips - spine - chest - (head, arm - hand), a leg below the hips, and a separate prop.
    fn skeleton() -> Skeleton {
        let joint =
            |name: &str, parent| JointSource { name: name.into(), parent, rest: Trs::IDENTITY };
        let joints = [
            joint("hips", None),
            joint("spine", Some(0)),
            joint("chest", Some(1)),
            joint("head", Some(2)),
            joint("arm", Some(2)),
            joint("hand", Some(4)),
            joint("leg", Some(0)),
            joint("prop", None),
        ];
        Skeleton::new(&joints).unwrap()
    }

    #[track_caller]
    fn assert_weights(mask: &Mask, wanted: &[(&str, f32)]) {
        let skeleton = skeleton();
        for joint in skeleton.joints() {
            let name = skeleton.name(joint);
            let want = wanted.iter().find(|(n, _)| *n == name).map_or(0.0, |(_, w)| *w);
            let found = mask.weights()[joint.index()];
            assert!((found - want).abs() < 1e-6, "{name} weighs {found}, not {want}");
        }
    }

    #[test]
    fn masks_are_built_from_joint_names() {
        let s = skeleton();
        assert_weights(
            &Mask::of_joints(&s, ["spine", "hand"]).unwrap(),
            &[("spine", 1.0), ("hand", 1.0)],
        );
        let trees = Mask::of_subtrees(&s, ["arm", "leg"]).unwrap();
        assert_weights(&trees, &[("arm", 1.0), ("hand", 1.0), ("leg", 1.0)]);
        assert_weights(&Mask::of_subtrees::<&str>(&s, []).unwrap(), &[]);
        let arm = Mask::subtree(&s, s.find("arm").unwrap());
        assert_eq!(arm.and(&Mask::of_joints(&s, ["leg"]).unwrap()).unwrap(), trees);
        assert_weights(&Mask::subtree(&s, JointIndex(99)), &[]);
    }

    #[test]
    fn masks_are_built_from_roles() {
        use crate::humanoid::Side::{Left, Right};
        let joint =
            |name: &str, parent| JointSource { name: name.into(), parent, rest: Trs::IDENTITY };
        let names =
            ["hips", "spine", "head", "hat", "leftUpperArm", "twist", "leftLowerArm", "leftHand"];
        let parents = [None, Some(0), Some(1), Some(2), Some(1), Some(4), Some(5), Some(6)];
        let mut joints: Vec<_> =
            names.into_iter().zip(parents).map(|(name, parent)| joint(name, parent)).collect();
        for side in ["left", "right"] {
            for (part, parent) in
                [("UpperLeg", 0), ("LowerLeg", joints.len()), ("Foot", joints.len() + 1)]
            {
                joints.push(joint(&format!("{side}{part}"), Some(parent)));
            }
        }
        let s = Skeleton::new(&joints).unwrap();
        let mut roles = vec![(Role::Hips, "hips"), (Role::Spine, "spine"), (Role::Head, "head")];
        roles.extend([
            (Role::UpperArm(Left), "leftUpperArm"),
            (Role::LowerArm(Left), "leftLowerArm"),
            (Role::Hand(Left), "leftHand"),
        ]);
        roles.extend([
            (Role::UpperLeg(Left), "leftUpperLeg"),
            (Role::LowerLeg(Left), "leftLowerLeg"),
            (Role::Foot(Left), "leftFoot"),
        ]);
        roles.extend([
            (Role::UpperLeg(Right), "rightUpperLeg"),
            (Role::LowerLeg(Right), "rightLowerLeg"),
            (Role::Foot(Right), "rightFoot"),
        ]);
        let map = RoleMap::from_names(&s, &roles).unwrap();
        let weigh = |mask: Mask| -> Vec<String> {
            let joints = s.joints().filter(|joint| mask.weights()[joint.index()] == 1.0);
            joints.map(|joint| s.name(joint).to_owned()).collect()
        };
        // Joints without a role follow their ancestor.
        assert_eq!(weigh(Mask::of_roles(&s, &map, [Role::Head]).unwrap()), ["head", "hat"]);
        let arm = Mask::of_roles(&s, &map, [Role::UpperArm(Left), Role::Hand(Left)]).unwrap();
        assert_eq!(weigh(arm), ["leftUpperArm", "twist", "leftHand"]);
        let missing = Mask::of_roles(&s, &map, [Role::Hand(Right)]).unwrap_err().to_string();
        assert!(missing.contains("the body has no joint with this role"), "{missing}");
        assert!(matches!(Mask::of_roles(&skeleton(), &map, []), Err(Error::BadMask { .. })));
    }

    #[test]
    fn unknown_joints_are_all_listed_with_suggestions() {
        let error = Mask::of_subtrees(&skeleton(), ["arm", "haed", "zzz"]).unwrap_err();
        let wanted = "there is no joint \"haed\"; did you mean \"head\", \"hand\" or \
                      \"chest\"?\nthere is no joint \"zzz\"";
        assert_eq!(error.to_string(), wanted);
    }

    #[test]
    fn falloff_ramps_weights_down_the_hierarchy() {
        let s = skeleton();
        let third = 1.0 / 3.0;
        let spine = Mask::of_subtrees(&s, ["spine"]).unwrap();
        let wanted =
            [("spine", third), ("chest", 2.0 * third), ("head", 1.0), ("arm", 1.0), ("hand", 1.0)];
        assert_weights(&spine.clone().with_falloff(&s, 3).unwrap(), &wanted);
        for none in [0, 1] {
            assert_eq!(spine.clone().with_falloff(&s, none).unwrap(), spine);
        }
        // Each part of a mask ramps separately and keeps the ratio of its weights.
        let mut weights = spine.weights().to_vec();
        weights[s.find("chest").unwrap().index()] = 0.0;
        weights[s.find("hand").unwrap().index()] = 0.5;
        let parts = Mask::new(&s, weights).unwrap().with_falloff(&s, 4).unwrap();
        assert_weights(&parts, &[("spine", 0.25), ("head", 0.25), ("arm", 0.25), ("hand", 0.25)]);
        let all = spine.with_falloff(&s, u32::MAX).unwrap();
        assert!(all.weights().iter().all(|w| (0.0..1e-8).contains(w)));
    }

    #[test]
    fn masks_can_be_subtracted_and_inverted() {
        let s = skeleton();
        let upper = Mask::of_subtrees(&s, ["spine"]).unwrap().with_falloff(&s, 2).unwrap();
        let arm = Mask::of_subtrees(&s, ["arm"]).unwrap();
        let rest = upper.without(&arm).unwrap();
        assert_weights(&rest, &[("spine", 0.5), ("chest", 1.0), ("head", 1.0)]);
        let wanted = [
            ("hips", 1.0),
            ("spine", 0.5),
            ("arm", 1.0),
            ("hand", 1.0),
            ("leg", 1.0),
            ("prop", 1.0),
        ];
        assert_weights(&rest.inverted(), &wanted);
    }

    #[test]
    fn foreign_masks_and_bad_weights_are_rejected() {
        let s = skeleton();
        let one =
            Skeleton::new(&[JointSource { name: "a".into(), parent: None, rest: Trs::IDENTITY }])
                .unwrap();
        let (mask, other) =
            (Mask::of_joints(&s, ["arm"]).unwrap(), Mask::of_joints(&one, ["a"]).unwrap());
        let is_bad = |result: Result<Mask, Error>| matches!(result, Err(Error::BadMask { .. }));
        assert!(is_bad(mask.clone().and(&other)) && is_bad(mask.clone().without(&other)));
        assert!(is_bad(other.with_falloff(&s, 2)));
        for bad in [f32::NAN, -0.1, 1.5, f32::INFINITY] {
            assert!(is_bad(Mask::new(&s, vec![bad; 8])), "{bad}");
        }
    }
}
