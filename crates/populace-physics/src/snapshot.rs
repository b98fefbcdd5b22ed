//! Where a member's joints were in the world at one instant.

use populace::model::JointIndex;
use populace::{Affine, BackendError, Crowd, Member, Placement};

use crate::Error;
use crate::math::{Pose, Rotation, Vector, heading, local, origin, point, rotation_of};

/// Nothing that a clip or a placement does is as fast as this; what is, is a jump, and no speed.
pub(crate) const FASTEST_M_PER_SEC: f32 = 30.0;

#[derive(Clone, Debug)]
pub(crate) struct Snapshot {
    pub(crate) model_from_joints: Vec<Affine>,
    /// Rotations down the hierarchy, without what scales do to them, in model space.
    turns: Vec<Rotation>,
    pub(crate) place: Placement,
}

impl Snapshot {
    /// Reads a member's joints back, as the last update left them. `None` where no update has
    /// evaluated the member on the crowd's device.
    pub(crate) fn of(crowd: &mut Crowd, member: Member) -> Result<Option<Self>, Error> {
        let place = crowd.placement(member)?;
        let model_from_joints = match crowd.model_from_joints(member) {
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
        let skeleton = &crowd.character(crowd.character_of(member)?)?.skeleton;
        let mut turns: Vec<Rotation> = Vec::with_capacity(model_from_joints.len());
        for joint in skeleton.joints() {
            let parent = skeleton.parent(joint).map(JointIndex::index);
            let own =
                local(parent.map(|p| &model_from_joints[p]), &model_from_joints[joint.index()]);
            let turn = parent.map_or(Rotation::IDENTITY, |p| turns[p]) * rotation_of(&own);
            turns.push(turn.normalize());
        }
        Ok(Some(Self { model_from_joints, turns, place }))
    }

    /// This one as if it had stood where the next one does, if from the one to the other the member
    /// was moved faster than anything goes: that was a jump, and gives no speed.
    pub(crate) fn without_jump(mut self, next: &Self, dt_secs: f32) -> Self {
        let [from, to] = [&self, next].map(|s| Vector::from_array(s.place.position()));
        if from.distance(to) > FASTEST_M_PER_SEC * dt_secs {
            self.place = next.place;
        }
        self
    }

    /// A joint's rotation in the world.
    pub(crate) fn turn(&self, joint: usize) -> Rotation {
        heading(&self.place) * self.turns[joint]
    }

    /// A joint's rotation in model space.
    pub(crate) fn model_turn(&self, joint: usize) -> Rotation {
        self.turns[joint]
    }

    /// Where a joint is in the world, without its scale.
    pub(crate) fn pose(&self, joint: usize) -> Pose {
        let place = point(&self.place.world_from_model(), origin(&self.model_from_joints[joint]));
        Pose::from_parts(place, self.turn(joint))
    }

    /// A point of a joint's own space in the world.
    pub(crate) fn point(&self, joint: usize, p: Vector) -> Vector {
        point(&self.place.world_from_model(), point(&self.model_from_joints[joint], p))
    }
}
