//! Chains of limbs, shared by the compilation of constraints and of legs.

use populace_model::convert::u32_from;
use populace_model::{JointIndex, Skeleton};

use crate::Error;
use crate::control::path;
use crate::fault::ConstraintFault;
use crate::layout::{Float4, Link};

/// Refuses a constraint.
pub(super) fn bad<T>(fault: ConstraintFault) -> Result<T, Error> {
    Err(fault.into())
}

pub(super) fn float4([x, y, z]: [f32; 3], w: f32) -> Float4 {
    Float4([x, y, z, w])
}

/// Returns the chain of links from `from` to the end of a limb, and the link index of `middle`.
pub(super) fn limb_links(
    skeleton: &Skeleton,
    from: JointIndex,
    [first, middle, end]: [JointIndex; 3],
) -> Result<(Vec<Link>, u32), Error> {
    let joints = path(skeleton, from, end)?;
    let at = |joint: JointIndex| joints.iter().position(|j| *j == joint);
    let (Some(upper), Some(bends)) = (at(first), at(middle)) else {
        let [middle, end] = [middle, end].map(|joint| skeleton.name(joint).to_owned());
        return bad(ConstraintFault::NotBetween { middle, end });
    };
    if !(upper < bends && bends + 1 < joints.len()) {
        return bad(ConstraintFault::LimbOrder { end: skeleton.name(end).to_owned() });
    }
    Ok((joints.iter().map(|joint| Link { joint: joint.0, share: 0.0 }).collect(), u32_from(bends)))
}
