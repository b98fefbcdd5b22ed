//! Ground contact of the target's feet: how deep they would sink, and how fast they pass over the
//! ground.

use glam::{DAffine3, DQuat, DVec3};
use populace_model::humanoid::{Role, Side};
use populace_model::{JointIndex, f64math};

use super::feet::{SIDES, Stands};
use super::{Common, Soles};

/// Depth, as a fraction of the body's size, to which feet may sink before the whole body is lifted,
/// and the maximum lift. Bodies that lie or swim are below the ground on purpose.
const SINK_TOLERANCE: f64 = 0.004;
const MAX_LIFT: f64 = 0.02;
/// Plausible ratios of the measured pace to that expected from leg lengths; others are ignored.
const PLAUSIBLE_RATIO: std::ops::Range<f64> = 0.4..2.5;

/// Returns the distance that the ground moves under the feet. Each moment has the position of one
/// foot per side, or none.
fn ground_distance(moments: &[[Option<DVec3>; 2]]) -> f64 {
    let passes = moments.windows(2).map(|pair| {
        let both = pair[0].iter().zip(pair[1]).filter_map(|(before, now)| Some(((*before)?, now?)));
        let bears = both.min_by(|(a, b), (c, d)| (a.y + b.y).total_cmp(&(c.y + d.y)));
        bears.map_or(0.0, |(before, now)| before.z - now.z)
    });
    passes.sum()
}

impl Common<'_> {
    /// Lifts the hips if the feet would sink because the ratio of thigh to shin differs between the
    /// bodies. `poses` are local transforms of the source's joints.
    pub(crate) fn keep_above_ground(&mut self, poses: &[Vec<DAffine3>]) {
        let depth = |pose: &Vec<DAffine3>| {
            let (rotations, models) = self.source_models(pose);
            let feet = SIDES.into_iter().flat_map(|side| self.feet(side, &rotations, &models));
            feet.map(|foot| self.target.position(foot.joint).y - foot.position.y)
                .fold(0.0, f64::max)
        };
        let deepest = poses.iter().map(depth).fold(0.0, f64::max);
        let size = f64::from(self.target.skeleton.size_m());
        self.lift += (deepest - SINK_TOLERANCE * size).clamp(0.0, MAX_LIFT * size);
    }

    /// Raises the whole body by `height`.
    pub(crate) fn lift_by(&mut self, height: f64) {
        self.lift += height;
    }

    /// Returns the speed of the ground under the target's feet divided by that under the source's
    /// feet. If nothing is planted it is the ratio of leg lengths.
    pub(crate) fn ground_speed_ratio(
        &self,
        poses: &[Vec<DAffine3>],
        soles: Option<&Soles<'_>>,
    ) -> f32 {
        // The last joint of a leg carries it: the toes if there are any.
        let last = |side| {
            let roles = &self.source.roles;
            roles.joint(Role::Toes(side)).or_else(|| roles.joint(Role::Foot(side)))
        };
        let (mut source, mut target) = (Vec::new(), Vec::new());
        for pose in poses {
            let (rotations, models) = self.source_models(pose);
            let position = |joint: JointIndex| models[joint.index()].translation;
            source.push(SIDES.map(|side| last(side).map(position)));
            target.push(SIDES.map(|side| {
                let mut feet = self.feet(side, &rotations, &models);
                if let Some(soles) = soles {
                    soles.roll_feet(side, &mut feet, soles.depth(&rotations, &models, side));
                }
                feet.pop().map(|foot| foot.position)
            }));
        }
        let (source, target) = (ground_distance(&source), ground_distance(&target));
        let pace = target / source;
        let likely = PLAUSIBLE_RATIO.contains(&(pace / self.scale));
        f64math::to_f32([if likely { pace } else { self.scale }])[0]
    }

    /// Returns the model-space rotations and transforms of the source's joints.
    pub(super) fn source_models(&self, pose: &[DAffine3]) -> (Vec<DQuat>, Vec<DAffine3>) {
        let parents: Vec<_> =
            self.source.skeleton.joints().map(|j| self.source.skeleton.parent(j)).collect();
        let rotations = pose.iter().map(|local| local.to_scale_rotation_translation().1);
        (
            f64math::model_rotations(&parents, rotations),
            f64math::model_from_joints(&parents, pose.iter().copied()),
        )
    }

    /// Returns the position of the hips, carried by the root if both bodies have one.
    fn hips_position(
        &self,
        hips: JointIndex,
        partner: JointIndex,
        rotations: &[DQuat],
        models: &[DAffine3],
    ) -> DVec3 {
        let now = |joint: JointIndex| models[joint.index()].translation;
        let roots = self.target.root().and_then(|root| {
            self.pairs[root.index()]
                .filter(|pair| pair.role.is_none())
                .map(|pair| (root, pair.source))
        });
        let Some((root, other)) = roots else {
            return self.raised_position(hips)
                + self.scale * (now(partner) - self.source.position(partner));
        };
        let guide = rotations[other.index()] * self.source.rotation[other.index()].inverse();
        let own = now(partner)
            - now(other)
            - guide * (self.source.position(partner) - self.source.position(other));
        let root_position =
            self.raised_position(root) + self.scale * (now(other) - self.source.position(other));
        root_position
            + guide * (self.raised_position(hips) - self.raised_position(root))
            + self.scale * own
    }

    /// Returns the foot and the toes of a side.
    pub(super) fn feet(&self, side: Side, rotations: &[DQuat], models: &[DAffine3]) -> Vec<Stands> {
        let roles = [
            Role::Hips,
            Role::UpperLeg(side),
            Role::LowerLeg(side),
            Role::Foot(side),
            Role::Toes(side),
        ];
        let mut at: Option<(JointIndex, DVec3)> = None;
        let mut feet = Vec::new();
        for role in roles {
            let Some((joint, partner)) =
                self.target.roles.joint(role).and_then(|joint| Some((joint, self.partner(joint)?)))
            else {
                continue;
            };
            let away = |partner: JointIndex| {
                rotations[partner.index()] * self.source.rotation[partner.index()].inverse()
            };
            let position = match at {
                None => self.hips_position(joint, partner, rotations, models),
                Some((above, position)) => {
                    let guide = self.partner(above).map_or(DQuat::IDENTITY, away);
                    position + guide * (self.position[joint.index()] - self.position[above.index()])
                }
            };
            if matches!(role, Role::Foot(_) | Role::Toes(_)) {
                let from_rest =
                    self.rotation[joint.index()] * self.target.rotation[joint.index()].inverse();
                feet.push(Stands { joint, position, rotation: away(partner) * from_rest });
            }
            at = Some((joint, position));
        }
        feet
    }
}
