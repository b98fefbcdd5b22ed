//! How far feet would sink into the ground.

use glam::{DAffine3, DQuat, DVec3};

use super::Common;
use crate::humanoid::{Role, Side};
use crate::{JointIndex, f64math};

/// Feet may sink by this part of the body's size before the whole body is lifted, and it is lifted by no more than that:
/// who lies or swims is meant to.
const SINKS: f64 = 0.004;
const MOST: f64 = 0.02;

impl Common<'_> {
    /// Lifts the hips where the thighs of one body are longer against the shins than those of the other, so that feet would
    /// sink. `poses` are local transforms of the source's joints.
    pub(crate) fn keep_above_ground(&mut self, poses: impl Iterator<Item = Vec<DAffine3>>) {
        let parents: Vec<_> = self.source.skeleton.joints().map(|j| self.source.skeleton.parent(j)).collect();
        let mut deepest: f64 = 0.0;
        for pose in poses {
            let turns: Vec<DQuat> =
                f64math::turns(&parents, pose.iter().map(|local| local.to_scale_rotation_translation().1));
            let models = f64math::model_from_joints(&parents, pose.into_iter());
            for side in [Side::Left, Side::Right] {
                deepest = deepest.max(self.depth(side, &turns, &models));
            }
        }
        let size = f64::from(self.target.skeleton.size_m());
        self.lift += (deepest - SINKS * size).clamp(0.0, MOST * size);
    }

    /// Where the hips are, carried by the root where both bodies have one.
    fn hips_place(
        &self,
        hips: JointIndex,
        partner: JointIndex,
        turns: &[DQuat],
        models: &[DAffine3],
    ) -> DVec3 {
        let now = |joint: JointIndex| models[joint.index()].translation;
        let roots = self.target.root().and_then(|root| {
            self.pairs[root.index()].filter(|pair| pair.role.is_none()).map(|pair| (root, pair.source))
        });
        let Some((root, other)) = roots else {
            return self.place_of(hips) + self.scale * (now(partner) - self.source.place(partner));
        };
        let guide = turns[other.index()] * self.source.turn[other.index()].inverse();
        let own = now(partner) - now(other) - guide * (self.source.place(partner) - self.source.place(other));
        let root_place = self.place_of(root) + self.scale * (now(other) - self.source.place(other));
        root_place + guide * (self.place_of(hips) - self.place_of(root)) + self.scale * own
    }

    /// How far below their rest the foot or the toes of a side are.
    fn depth(&self, side: Side, turns: &[DQuat], models: &[DAffine3]) -> f64 {
        let roles =
            [Role::Hips, Role::UpperLeg(side), Role::LowerLeg(side), Role::Foot(side), Role::Toes(side)];
        let mut at: Option<(JointIndex, DVec3)> = None;
        let mut depth: f64 = 0.0;
        for role in roles {
            let Some((joint, partner)) =
                self.target.roles.joint(role).and_then(|joint| Some((joint, self.partner(joint)?)))
            else {
                continue;
            };
            let place = match at {
                None => self.hips_place(joint, partner, turns, models),
                Some((above, place)) => {
                    let guide = self.partner(above).map_or(DQuat::IDENTITY, |partner| {
                        turns[partner.index()] * self.source.turn[partner.index()].inverse()
                    });
                    place + guide * (self.place[joint.index()] - self.place[above.index()])
                }
            };
            if matches!(role, Role::Foot(_) | Role::Toes(_)) {
                depth = depth.max(self.target.place(joint).y - place.y);
            }
            at = Some((joint, place));
        }
        depth
    }
}
