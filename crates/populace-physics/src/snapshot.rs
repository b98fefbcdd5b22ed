//! Snapshots of a member's joints in world space.

use populace::model::JointIndex;
use populace::{Affine, BackendError, Crowd, MemberId, Placement};

use crate::Error;
use crate::math::{Pose, Rotation, Vector, local, origin, point, rotation_of, yaw_rotation};

/// Largest plausible velocity of clips and placements. A faster change is treated as a jump that
/// causes no velocity.
pub(crate) const FASTEST_M_PER_SEC: f32 = 30.0;

/// Joints and placement of a member after an update.
#[derive(Clone, Debug)]
pub(crate) struct Snapshot {
    pub(crate) model_from_joints: Vec<Affine>,
    /// Rotations down the hierarchy in model space, without the effect of scales.
    rotations: Vec<Rotation>,
    pub(crate) placement: Placement,
}

impl Snapshot {
    /// Reads back a member's joints of the last update. Returns `None` if no update has evaluated
    /// the member on the crowd's device yet.
    pub(crate) fn of(crowd: &mut Crowd, member: MemberId) -> Result<Option<Self>, Error> {
        let placement = crowd.member(member)?.placement();
        let model_from_joints =
            match crowd.member_mut(member).and_then(|mut m| m.model_from_joints()) {
                Ok(joints) => joints,
                Err(populace::Error::Backend(BackendError::NotEvaluated)) => return Ok(None),
                Err(error) => return Err(error.into()),
            };
        if let Some(bad) =
            model_from_joints.iter().flat_map(|m| m.rows).flatten().find(|v| !v.is_finite())
        {
            return Err(Error::BadValue {
                what: "a joint of the member",
                value: bad,
                rule: "finite",
            });
        }
        let skeleton = &crowd.character(crowd.member(member)?.character())?.asset().skeleton;
        let mut rotations: Vec<Rotation> = Vec::with_capacity(model_from_joints.len());
        for joint in skeleton.joints() {
            let parent = skeleton.parent(joint).map(JointIndex::index);
            let own =
                local(parent.map(|p| &model_from_joints[p]), &model_from_joints[joint.index()]);
            let rotation = parent.map_or(Rotation::IDENTITY, |p| rotations[p]) * rotation_of(&own);
            rotations.push(rotation.normalize());
        }
        Ok(Some(Self { model_from_joints, rotations, placement }))
    }

    /// Returns this snapshot at the placement of `next` if the member moved there implausibly fast.
    /// Such a jump must not cause a velocity.
    pub(crate) fn without_jump(mut self, next: &Self, dt_secs: f32) -> Self {
        let [from, to] = [&self, next].map(|s| Vector::from_array(s.placement.position()));
        if from.distance(to) > FASTEST_M_PER_SEC * dt_secs {
            self.placement = next.placement;
        }
        self
    }

    /// Returns the rotation of a joint in world space.
    pub(crate) fn rotation(&self, joint: usize) -> Rotation {
        yaw_rotation(&self.placement) * self.rotations[joint]
    }

    /// Returns the rotation of a joint in model space.
    pub(crate) fn model_rotation(&self, joint: usize) -> Rotation {
        self.rotations[joint]
    }

    /// Returns position and rotation of a joint in world space, without scale.
    pub(crate) fn pose(&self, joint: usize) -> Pose {
        let position =
            point(&self.placement.world_from_model(), origin(&self.model_from_joints[joint]));
        Pose::from_parts(position, self.rotation(joint))
    }

    /// Transforms a point from the space of a joint to world space.
    pub(crate) fn point(&self, joint: usize, p: Vector) -> Vector {
        point(&self.placement.world_from_model(), point(&self.model_from_joints[joint], p))
    }
}
