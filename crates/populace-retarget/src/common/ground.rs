//! How feet of the target meet the ground: how far they would sink into it, and how fast they pass
//! over it.

use glam::{DAffine3, DQuat, DVec3};
use populace_model::humanoid::{Role, Side};
use populace_model::{JointIndex, f64math};

use super::feet::{SIDES, Stands};
use super::{Common, Soles};

/// Feet may sink by this part of the body's size before the whole body is lifted, and it is lifted
/// by no more than that: who lies or swims is meant to.
const SINKS: f64 = 0.004;
const MOST: f64 = 0.02;
/// A pace that is further from what the length of legs says is none.
const LIKELY: std::ops::Range<f64> = 0.4..2.5;

/// How far the ground passes under feet: each moment has the place of one or none for each side.
fn passed(moments: &[[Option<DVec3>; 2]]) -> f64 {
    let passes = moments.windows(2).map(|pair| {
        let both = pair[0].iter().zip(pair[1]).filter_map(|(before, now)| Some(((*before)?, now?)));
        let bears = both.min_by(|(a, b), (c, d)| (a.y + b.y).total_cmp(&(c.y + d.y)));
        bears.map_or(0.0, |(before, now)| before.z - now.z)
    });
    passes.sum()
}

impl Common<'_> {
    /// Lifts the hips where the thighs of one body are longer against the shins than those of the
    /// other, so that feet would sink. `poses` are local transforms of the source's joints, one
    /// after the other.
    pub(crate) fn keep_above_ground(&mut self, poses: &[Vec<DAffine3>]) {
        let depth = |pose: &Vec<DAffine3>| {
            let (turns, models) = self.source_models(pose);
            let feet = SIDES.into_iter().flat_map(|side| self.feet(side, &turns, &models));
            feet.map(|foot| self.target.place(foot.joint).y - foot.place.y).fold(0.0, f64::max)
        };
        let deepest = poses.iter().map(depth).fold(0.0, f64::max);
        let size = f64::from(self.target.skeleton.size_m());
        self.lift += (deepest - SINKS * size).clamp(0.0, MOST * size);
    }

    /// Lifts the whole body.
    pub(crate) fn lift_by(&mut self, height: f64) {
        self.lift += height;
    }

    /// How fast the ground passes under the target's feet, in parts of how fast it passes under the
    /// source's; as long as its legs are against the source's where nothing is planted.
    pub(crate) fn pace(&self, poses: &[Vec<DAffine3>], soles: Option<&Soles<'_>>) -> f32 {
        // The last of a leg bears it: toes where there are any.
        let last = |side| {
            let roles = &self.source.roles;
            roles.joint(Role::Toes(side)).or_else(|| roles.joint(Role::Foot(side)))
        };
        let (mut source, mut target) = (Vec::new(), Vec::new());
        for pose in poses {
            let (turns, models) = self.source_models(pose);
            let place = |joint: JointIndex| models[joint.index()].translation;
            source.push(SIDES.map(|side| last(side).map(place)));
            target.push(SIDES.map(|side| {
                let mut feet = self.feet(side, &turns, &models);
                if let Some(soles) = soles {
                    soles.stand(side, &mut feet, soles.depth(&turns, &models, side));
                }
                feet.pop().map(|foot| foot.place)
            }));
        }
        let (source, target) = (passed(&source), passed(&target));
        let pace = target / source;
        let likely = LIKELY.contains(&(pace / self.scale));
        f64math::to_f32([if likely { pace } else { self.scale }])[0]
    }

    /// How the source's joints are turned, and where they are, in model space.
    pub(super) fn source_models(&self, pose: &[DAffine3]) -> (Vec<DQuat>, Vec<DAffine3>) {
        let parents: Vec<_> =
            self.source.skeleton.joints().map(|j| self.source.skeleton.parent(j)).collect();
        let turns = pose.iter().map(|local| local.to_scale_rotation_translation().1);
        (
            f64math::turns(&parents, turns),
            f64math::model_from_joints(&parents, pose.iter().copied()),
        )
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
            self.pairs[root.index()]
                .filter(|pair| pair.role.is_none())
                .map(|pair| (root, pair.source))
        });
        let Some((root, other)) = roots else {
            return self.place_of(hips) + self.scale * (now(partner) - self.source.place(partner));
        };
        let guide = turns[other.index()] * self.source.turn[other.index()].inverse();
        let own = now(partner)
            - now(other)
            - guide * (self.source.place(partner) - self.source.place(other));
        let root_place = self.place_of(root) + self.scale * (now(other) - self.source.place(other));
        root_place + guide * (self.place_of(hips) - self.place_of(root)) + self.scale * own
    }

    /// The foot and the toes of a side.
    pub(super) fn feet(&self, side: Side, turns: &[DQuat], models: &[DAffine3]) -> Vec<Stands> {
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
                turns[partner.index()] * self.source.turn[partner.index()].inverse()
            };
            let place = match at {
                None => self.hips_place(joint, partner, turns, models),
                Some((above, place)) => {
                    let guide = self.partner(above).map_or(DQuat::IDENTITY, away);
                    place + guide * (self.place[joint.index()] - self.place[above.index()])
                }
            };
            if matches!(role, Role::Foot(_) | Role::Toes(_)) {
                let from_rest =
                    self.turn[joint.index()] * self.target.turn[joint.index()].inverse();
                feet.push(Stands { joint, place, turn: away(partner) * from_rest });
            }
            at = Some((joint, place));
        }
        feet
    }
}
