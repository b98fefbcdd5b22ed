//! Where and how a body lies at the start of a get-up motion.

use populace::clip::Clip;
use populace::model::{JointIndex, Role, RoleMap, Skeleton};

use crate::math::Vector;

/// How a body lies at the start of a motion, in the member's model space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LyingPose {
    /// Position of the hips in metres; the height is 0.
    pub(crate) hips: Vector,
    /// Horizontal direction from the hips to the head.
    pub(crate) axis: Vector,
}

impl LyingPose {
    /// Returns the lying pose of a motion on a body with `skeleton`. Returns `None` if the motion's
    /// own skeleton has no known hips and head, or if the body is not stretched out.
    pub(crate) fn of(motion: &Clip, skeleton: &Skeleton) -> Option<Self> {
        let own = motion.skeleton();
        let roles = RoleMap::detect(own)?;
        let (hips, head) = (roles.joint(Role::Hips)?, roles.joint(Role::Head)?);
        let first = motion.row_poses(1).next()?;
        let position = |joint: JointIndex| {
            let mut model = *first.get(joint.index())?;
            let mut at = joint;
            while let Some(parent) = own.parent(at) {
                model = *first.get(parent.index())? * model;
                at = parent;
            }
            #[expect(clippy::cast_possible_truncation, reason = "metres, as in `Placement`")]
            let position = model.translation.to_array().map(|v| v as f32);
            Some(Vector::from_array(position))
        };
        let (from, to) = (position(hips)?, position(head)?);
        let flat = Vector::new(1.0, 0.0, 1.0);
        let scale = if motion.is_made_for(skeleton) {
            1.0
        } else {
            // Motions of other bodies are scaled with the height of the hips.
            let other = RoleMap::detect(skeleton).and_then(|roles| roles.joint(Role::Hips));
            let height = |skeleton: &Skeleton, joint| rest_height(skeleton, joint);
            other.map_or(1.0, |joint| height(skeleton, joint) / height(own, hips).max(1e-6))
        };
        let span = to - from;
        let axis = (span * flat).try_normalize()?;
        (span.y.abs() < 0.7 * span.length()).then_some(Self { hips: from * flat * scale, axis })
    }
}

/// Returns the height of a joint at rest in metres.
fn rest_height(skeleton: &Skeleton, joint: JointIndex) -> f32 {
    let mut model = populace::Affine::from_trs(skeleton.rest(joint));
    let mut at = joint;
    while let Some(parent) = skeleton.parent(at) {
        model = populace::Affine::from_trs(skeleton.rest(parent)).mul(&model);
        at = parent;
    }
    model.origin()[1]
}
