//! Skeletons in level order.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use crate::names::{UnknownName, nearest_names};
use crate::{Affine, Error, JointIndex, Trs, f64math};

/// A joint as listed by its source, in any order.
#[derive(Clone, Debug, PartialEq)]
pub struct JointSource {
    /// The joint's name, which clips bind to; must be unique in a skeleton.
    pub name: String,
    /// Index of the parent in the same list; `None` marks a root.
    pub parent: Option<usize>,
    /// Local transform when no clip plays.
    pub rest: Trs,
}

/// A hierarchy of joints, sorted breadth first.
///
/// A parent's index is below those of its children, and the joints of each depth form one
/// contiguous range, a *level* (level-order flattening: Lister & Day 2012, section 3.1, fig. 2).
/// There may be several roots. The order of the source, which vertex joint indices and files refer
/// to, is kept as a map. Clones share their data, so that every clip can keep the skeleton it was
/// made for.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    parts: Arc<Parts>,
}

#[derive(Clone, Debug, PartialEq)]
struct Parts {
    names: Vec<String>,
    by_name: HashMap<String, JointIndex>,
    parents: Vec<Option<JointIndex>>,
    rest: Vec<Trs>,
    levels: Vec<Range<usize>>,
    source_from_joint: Vec<usize>,
    joint_from_source: Vec<JointIndex>,
    size_m: f32,
    reach_m: Vec<f32>,
    soles: Vec<Vec<[f32; 3]>>,
    /// `None` if it is the rest.
    bind_pose: Option<Skeleton>,
}

/// Angle between a joint's rotations at rest and in the bind pose up to which they count as equal,
/// in radians.
const SAME_ROTATION_RAD: f64 = 0.05;

impl Skeleton {
    /// Sorts the joints into level order. Joints of one level keep the order of their parents, then
    /// of the source. Rest rotations are normalised.
    ///
    /// # Errors
    ///
    /// An error for the first joint that has a missing parent, is its own ancestor, has the name of
    /// another joint, or has a rest transform that is not finite or whose rotation has length zero.
    pub fn new(joints: &[JointSource]) -> Result<Self, Error> {
        check(joints)?;
        let (order, levels) = level_order(joints)?;
        let mut joint_from_source = vec![JointIndex(0); joints.len()];
        for (joint, &source) in order.iter().enumerate() {
            joint_from_source[source] = joint_index(joint)?;
        }
        let mut rest: Vec<Trs> = order.iter().map(|&s| joints[s].rest).collect();
        for trs in &mut rest {
            trs.rotation = f64math::normalized(trs.rotation);
        }
        let parents: Vec<_> =
            order.iter().map(|&s| joints[s].parent.map(|p| joint_from_source[p])).collect();
        let names: Vec<_> = order.iter().map(|&s| joints[s].name.clone()).collect();
        let by_name =
            names.iter().cloned().zip(order.iter().map(|&s| joint_from_source[s])).collect();
        let size_m = f64math::rest_extent(&parents, &rest);
        let (reach_m, soles) = (vec![0.0; joints.len()], vec![Vec::new(); joints.len()]);
        let parts = Parts {
            names,
            by_name,
            parents,
            rest,
            levels,
            source_from_joint: order,
            joint_from_source,
            size_m,
            reach_m,
            soles,
            bind_pose: None,
        };
        Ok(Self { parts: Arc::new(parts) })
    }

    /// Sets the distance in metres from each joint, in level order, to the farthest vertex that it
    /// moves, at rest. Clips are then stored so that these vertices stay within the error bound
    /// too. Missing, negative and non-finite values count as 0.
    #[must_use]
    pub fn with_reach(mut self, reach_m: &[f32]) -> Self {
        for (reach, given) in Arc::make_mut(&mut self.parts).reach_m.iter_mut().zip(reach_m) {
            *reach = if given.is_finite() { given.max(0.0) } else { 0.0 };
        }
        self
    }

    /// Sets the points of each joint, in level order, that may touch the ground
    /// (`sole_points` of populace-character): positions in the bind pose
    /// ([`in_bind_pose`](Self::in_bind_pose)) in model space, in metres. They
    /// keep the feet of retargeted clips above the ground
    /// (`Binding::retarget` of populace-retarget). Points that are not finite are ignored.
    #[must_use]
    pub fn with_soles(mut self, soles: &[Vec<[f32; 3]>]) -> Self {
        let parts = Arc::make_mut(&mut self.parts);
        for (own, given) in parts.soles.iter_mut().zip(soles) {
            *own =
                given.iter().copied().filter(|place| place.iter().all(|c| c.is_finite())).collect();
        }
        parts.bind_pose = parts.bind_pose.take().map(|pose| pose.with_soles(soles));
        self
    }

    /// Sets the pose in which meshes were bound to the joints, as the local transform of each
    /// joint, in level order. A file that was written in the middle of a movement has another rest.
    /// Missing transforms, and those that are not finite or whose rotation has length zero, are at
    /// rest. A pose without a joint that turns visibly from its rest counts as the rest.
    #[must_use]
    pub fn with_bind_pose(mut self, locals: &[Trs]) -> Self {
        let mut pose = self.clone();
        let parts = Arc::make_mut(&mut pose.parts);
        parts.bind_pose = None;
        for (own, given) in parts.rest.iter_mut().zip(locals) {
            let given = Trs { rotation: f64math::normalized(given.rotation), ..*given };
            if given.is_finite() {
                *own = given;
            }
        }
        let rotation = |of: &Trs| f64math::quat(of.rotation);
        let turns =
            |(a, b): (&Trs, &Trs)| rotation(a).angle_between(rotation(b)) > SAME_ROTATION_RAD;
        let differs = parts.rest.iter().zip(&self.parts.rest).any(turns);
        Arc::make_mut(&mut self.parts).bind_pose = differs.then_some(pose);
        self
    }

    /// The skeleton with its bind pose as its rest; the skeleton itself if both are the same.
    /// Bodies stand in it with flat soles.
    #[must_use]
    pub fn in_bind_pose(&self) -> &Self {
        self.parts.bind_pose.as_ref().unwrap_or(self)
    }

    /// Number of joints; at least one.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.parts.names.len()
    }

    /// All joint indices, parents first.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = JointIndex> + use<> {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "`new` refuses more joints than fit in 32 bits"
        )]
        let count = self.parts.names.len() as u32;
        (0..count).map(JointIndex)
    }

    /// The joint's name.
    #[must_use]
    pub fn name(&self, joint: JointIndex) -> &str {
        &self.parts.names[joint.index()]
    }

    /// The joint with this name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<JointIndex> {
        self.parts.by_name.get(name).copied()
    }

    /// The joints with these names, in the same order.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownJoints`] with the nearest names.
    pub fn find_all<N: AsRef<str>>(
        &self,
        names: impl IntoIterator<Item = N>,
    ) -> Result<Vec<JointIndex>, Error> {
        let (mut found, mut unknown) = (Vec::new(), Vec::new());
        for name in names {
            let name = name.as_ref();
            match self.find(name) {
                Some(joint) => found.push(joint),
                None => unknown.push(UnknownName {
                    name: name.to_owned(),
                    nearest: nearest_names(name, self.joints().map(|joint| self.name(joint))),
                }),
            }
        }
        if unknown.is_empty() { Ok(found) } else { Err(Error::UnknownJoints { joints: unknown }) }
    }

    /// The parent of a joint, `None` for a root.
    #[must_use]
    pub fn parent(&self, joint: JointIndex) -> Option<JointIndex> {
        self.parts.parents[joint.index()]
    }

    /// The parent of each joint, in level order; `None` for roots.
    #[must_use]
    pub fn parents(&self) -> &[Option<JointIndex>] {
        &self.parts.parents
    }

    /// Returns whether a joint is a descendant of another.
    #[must_use]
    pub fn is_below(&self, joint: JointIndex, above: JointIndex) -> bool {
        self.ancestors(joint).any(|ancestor| ancestor == above)
    }

    /// The ancestors of a joint, its parent first.
    pub fn ancestors(&self, joint: JointIndex) -> impl Iterator<Item = JointIndex> + '_ {
        std::iter::successors(self.parent(joint), |&joint| self.parent(joint))
    }

    /// The local transform of a joint when no clip plays.
    #[must_use]
    pub fn rest(&self, joint: JointIndex) -> &Trs {
        &self.parts.rest[joint.index()]
    }

    /// The model transform of a joint when no clip plays.
    #[must_use]
    pub fn rest_model(&self, joint: JointIndex) -> Affine {
        // Iterates from the root down instead of recursing: a chain may be too long for the stack.
        let mut chain: Vec<_> = std::iter::once(joint).chain(self.ancestors(joint)).collect();
        let root = chain.pop().map_or(Affine::IDENTITY, |root| Affine::from_trs(self.rest(root)));
        chain
            .iter()
            .rev()
            .fold(root, |model, joint| model.mul(&Affine::from_trs(self.rest(*joint))))
    }

    /// The place of a joint at rest, in metres of model space, in double precision.
    #[must_use]
    pub fn rest_place(&self, joint: JointIndex) -> glam::DVec3 {
        let mut chain: Vec<_> = std::iter::once(joint).chain(self.ancestors(joint)).collect();
        chain.reverse();
        let locals = chain.iter().map(|joint| f64math::affine(self.rest(*joint)));
        let model = locals.reduce(|model, local| model * local);
        model.map_or(glam::DVec3::ZERO, |model| model.translation)
    }

    /// `model_from_joint` of each joint at rest, in double precision.
    #[must_use]
    pub fn rest_models(&self) -> Vec<glam::DAffine3> {
        let locals = self.parts.rest.iter().map(f64math::affine);
        f64math::model_from_joints(&self.parts.parents, locals)
    }

    /// The range of joint indices of each depth, roots first.
    #[must_use]
    pub fn levels(&self) -> &[Range<usize>] {
        &self.parts.levels
    }

    /// Index of a joint in the source list.
    #[must_use]
    pub fn source_from_joint(&self, joint: JointIndex) -> usize {
        self.parts.source_from_joint[joint.index()]
    }

    /// Joint index of a joint of the source list.
    ///
    /// # Panics
    ///
    /// If `source` is not below the joint count.
    #[must_use]
    pub fn joint_from_source(&self, source: usize) -> JointIndex {
        self.parts.joint_from_source[source]
    }

    /// Distance in metres from each joint to the farthest vertex that it moves, at rest; 0 if
    /// unknown.
    #[must_use]
    pub fn reach_m(&self) -> &[f32] {
        &self.parts.reach_m
    }

    /// Points of a joint that may touch the ground, in the bind pose in model space; empty if
    /// unknown.
    #[must_use]
    pub fn soles(&self, joint: JointIndex) -> &[[f32; 3]] {
        &self.parts.soles[joint.index()]
    }

    /// The largest side of the box around the joints at rest, in metres; 1 if all joints coincide.
    /// Error bounds are proportional to it.
    #[must_use]
    pub fn size_m(&self) -> f32 {
        self.parts.size_m
    }
}

fn joint_index(index: usize) -> Result<JointIndex, Error> {
    const LIMIT: usize = 1 << 28; // bindings store three flags beside the index
    match u32::try_from(index) {
        Ok(value) if index < LIMIT => Ok(JointIndex(value)),
        _ => Err(Error::TooLarge { what: "a skeleton", count: index + 1, limit: LIMIT }),
    }
}

fn check(joints: &[JointSource]) -> Result<(), Error> {
    if joints.is_empty() {
        return Err(Error::NoJoints);
    }
    let mut names = HashMap::new();
    for (index, joint) in joints.iter().enumerate() {
        let name = || joint.name.clone();
        if let Some(parent) = joint.parent.filter(|&p| p >= joints.len()) {
            return Err(Error::ParentOutOfRange {
                joint: index,
                name: name(),
                parent,
                count: joints.len(),
            });
        }
        let bad_rest = |what| Err(Error::BadRest { joint: index, name: name(), what });
        if !joint.rest.is_finite() {
            return bad_rest("a value that is not a finite number");
        }
        if joint.rest.rotation.iter().all(|v| v.abs() < 1e-10) {
            return bad_rest("a rotation of length zero");
        }
        if let Some(first) = names.insert(joint.name.as_str(), index) {
            return Err(Error::DuplicateJointName { first, second: index, name: name() });
        }
    }
    Ok(())
}

fn level_order(joints: &[JointSource]) -> Result<(Vec<usize>, Vec<Range<usize>>), Error> {
    let mut children = vec![Vec::new(); joints.len()];
    let mut order = Vec::with_capacity(joints.len());
    for (index, joint) in joints.iter().enumerate() {
        match joint.parent {
            Some(parent) => children[parent].push(index),
            None => order.push(index),
        }
    }
    let mut levels = Vec::new();
    let mut level = 0..order.len();
    while !level.is_empty() {
        levels.push(level.clone());
        for at in level.clone() {
            order.extend_from_slice(&children[order[at]]);
        }
        level = level.end..order.len();
    }
    if order.len() < joints.len() {
        let mut reached = vec![false; joints.len()];
        order.iter().for_each(|&index| reached[index] = true);
        // Every unreached joint has a path of parents into a cycle. After `joints.len()` steps the
        // walk is on the cycle.
        let mut joint = reached.iter().position(|r| !r).unwrap_or(0);
        for _ in 0..joints.len() {
            joint = joints[joint].parent.unwrap_or(joint);
        }
        return Err(Error::Cycle { joint, name: joints[joint].name.clone() });
    }
    Ok((order, levels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn joint(name: &str, parent: Option<usize>) -> JointSource {
        JointSource { name: name.into(), parent, rest: Trs::IDENTITY }
    }

    #[test]
    fn roots_and_unordered_joints_are_sorted_by_level() {
        let skeleton = Skeleton::new(&[
            joint("hand", Some(3)),
            joint("hips", None),
            joint("prop", None),
            joint("arm", Some(1)),
            joint("tip", Some(2)),
        ])
        .unwrap();
        let names: Vec<_> = skeleton.joints().map(|j| skeleton.name(j)).collect();
        assert_eq!(names, ["hips", "prop", "arm", "tip", "hand"]);
        assert_eq!(skeleton.levels(), [0..2, 2..4, 4..5]);
    }

    #[test]
    fn cycle_next_to_a_valid_tree_is_reported() {
        let error = Skeleton::new(&[joint("root", None), joint("a", Some(2)), joint("b", Some(1))])
            .unwrap_err();
        assert!(matches!(error, Error::Cycle { joint: 1 | 2, .. }), "{error}");
    }

    #[test]
    fn invalid_joints_are_rejected_by_name() {
        assert_eq!(Skeleton::new(&[]).unwrap_err(), Error::NoJoints);
        let far = Skeleton::new(&[joint("far", Some(7))]).unwrap_err();
        assert_eq!(
            far,
            Error::ParentOutOfRange { joint: 0, name: "far".into(), parent: 7, count: 1 }
        );
        let twins = Skeleton::new(&[joint("twin", None), joint("twin", Some(0))]).unwrap_err();
        assert_eq!(twins, Error::DuplicateJointName { first: 0, second: 1, name: "twin".into() });
        let mut nan = joint("nan", None);
        nan.rest.scale[1] = f32::NAN;
        assert!(matches!(Skeleton::new(&[nan]).unwrap_err(), Error::BadRest { joint: 0, .. }));
    }

    #[test]
    fn rest_model_of_a_long_chain_does_not_overflow() {
        let up = Trs { translation: [0.0, 1.0, 0.0], ..Trs::IDENTITY };
        let link =
            |i: usize| JointSource { name: i.to_string(), parent: i.checked_sub(1), rest: up };
        let skeleton = Skeleton::new(&(0..200_000).map(link).collect::<Vec<_>>()).unwrap();
        assert_eq!(skeleton.rest_model(JointIndex(199_999)).origin(), [0.0, 200_000.0, 0.0]);
    }

    #[test]
    fn bind_pose_is_kept_beside_the_rest_where_it_differs() {
        // Of twice the unit length.
        let bent = |half_rad: f32| {
            let (x, w) = half_rad.sin_cos();
            Trs { rotation: [2.0 * x, 0.0, 0.0, 2.0 * w], ..Trs::IDENTITY }
        };
        let skeleton = Skeleton::new(&[joint("hips", None), joint("knee", Some(0))]).unwrap();
        let soles = [vec![], vec![[0.0, -1.0, 0.0]]];
        let same = skeleton.clone().with_bind_pose(&[Trs::IDENTITY, bent(0.01)]);
        assert_eq!(same, skeleton);
        let nan = Trs { scale: [f32::NAN; 3], ..Trs::IDENTITY };
        let none = Trs { rotation: [0.0; 4], ..Trs::IDENTITY };
        let rests = skeleton.clone().with_bind_pose(&[none, bent(0.5)]);
        assert_eq!(rests.in_bind_pose().rest(JointIndex(0)), &Trs::IDENTITY, "no rotation");
        let bound = skeleton.clone().with_bind_pose(&[nan, bent(0.5)]).with_soles(&soles);
        let pose = bound.in_bind_pose();
        assert_eq!(
            (bound.rest(JointIndex(1)), pose.rest(JointIndex(0))),
            (&Trs::IDENTITY, &Trs::IDENTITY)
        );
        let [x, _, _, w] = pose.rest(JointIndex(1)).rotation;
        let (own_x, own_w) = 0.5_f32.sin_cos();
        assert!((x - own_x).abs() < 1e-6 && (w - own_w).abs() < 1e-6);
        assert_eq!(pose.in_bind_pose(), pose);
        assert_eq!(
            (bound.soles(JointIndex(1)), pose.soles(JointIndex(1))),
            (&soles[1][..], &soles[1][..])
        );
    }

    proptest! {
        #[test]
        fn level_order_holds(
            parents in proptest::collection::vec(0usize..1000, 1..60),
            keep in 0usize..60,
        ) {
            // A random forest: joint i is a child of an earlier joint, or a root. Then the list is
            // rotated, so that parents come after their children in the source.
            let count = parents.len();
            let turn = keep % count;
            let place = |i: usize| (i + turn) % count;
            let mut sources = vec![joint("", None); count];
            for (i, &p) in parents.iter().enumerate() {
                let parent = p % (i + 2);
                let parent = (parent < i).then(|| place(parent));
                sources[place(i)] = joint(&format!("joint {i}"), parent);
            }
            let skeleton = Skeleton::new(&sources).unwrap();
            let joints: usize = skeleton.levels().iter().map(ExactSizeIterator::len).sum();
            prop_assert_eq!(joints, count);
            for (depth, level) in skeleton.levels().iter().enumerate() {
                for joint in level.clone().map(|j| skeleton.joints().nth(j).unwrap()) {
                    let source = skeleton.source_from_joint(joint);
                    prop_assert_eq!(skeleton.joint_from_source(source), joint);
                    prop_assert_eq!(skeleton.name(joint), &sources[source].name);
                    let parent = skeleton.parent(joint);
                    let parent_source = parent.map(|p| skeleton.source_from_joint(p));
                    prop_assert_eq!(parent_source, sources[source].parent);
                    match parent {
                        Some(p) => prop_assert!(skeleton.levels()[depth - 1].contains(&p.index())),
                        None => prop_assert_eq!(depth, 0),
                    }
                }
            }
        }
    }
}
