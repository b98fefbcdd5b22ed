//! Limbs of two bones: their joints, and the direction in which they bend.

use populace_device::{ConstraintFault, Limb};
use populace_model::{JointIndex, Skeleton};
use populace_settings::parts::ReachParts;

use super::SOFT;
use crate::{Allowed, Error};

/// The distance of the middle joint from the straight line above which a rest pose counts as bent,
/// as a fraction of the limb's length.
const BENT: f32 = 0.01;

pub(super) fn limb_of(skeleton: &Skeleton, reach: &ReachParts) -> Result<Limb, Error> {
    let bad = || {
        let known = (reach.end.index() < skeleton.joint_count()).then(|| skeleton.name(reach.end));
        let (joint, name) = (reach.end.0, known.map(str::to_owned));
        Error::Tables(ConstraintFault::NoLimb { joint, name }.into())
    };
    let there =
        |joint: JointIndex| if joint.index() < skeleton.joint_count() { Some(joint) } else { None };
    let end = there(reach.end).ok_or_else(bad)?;
    let [first, middle] = match reach.limb {
        Some(limb) => limb,
        None => {
            let middle = skeleton.parent(end).ok_or_else(bad)?;
            [skeleton.parent(middle).ok_or_else(bad)?, middle]
        }
    };
    for joint in [first, middle] {
        there(joint).ok_or_else(bad)?;
    }
    let bend = reach.bend.unwrap_or_else(|| usual_bend(skeleton, [first, middle, end]));
    let ReachParts { pole, keeps_end, .. } = *reach;
    if pole == Some([0.0; 3]) {
        let (what, allowed) = ("the pole of a reach", Allowed::SomeLength);
        return Err(Error::BadValue { what, value: 0.0, allowed });
    }
    Ok(Limb { first, middle, end, bend, pole, keeps_end, soft: SOFT, targets: Vec::new() })
}

/// Returns the direction in which a limb bends: as at rest, else knees to the front and elbows to
/// the back.
pub(super) fn usual_bend(skeleton: &Skeleton, joints: [JointIndex; 3]) -> [f32; 3] {
    use populace_model::math::vec3;
    let [first, middle, end] = joints.map(|joint| skeleton.rest_model(joint).origin());
    let (whole, upper) = (vec3::sub(end, first), vec3::sub(middle, first));
    let along = vec3::unit_or(whole, [0.0, -1.0, 0.0]);
    let out = vec3::across(upper, along);
    if vec3::length(out) > BENT * vec3::length(whole) {
        return vec3::unit_or(out, [0.0, 0.0, 1.0]);
    }
    if along[0].abs() > along[1].abs() { [0.0, 0.0, -1.0] } else { [0.0, 0.0, 1.0] }
}
