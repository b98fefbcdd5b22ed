//! Soles: the points on which a foot rolls from heel to toes.

use glam::{DAffine3, DVec3};
use populace_device::Foot;
use populace_device::layout::MAX_SOLE_POINTS;
use populace_model::JointIndex;

use crate::oracle::noise::Noise;
use crate::oracle::transform::model_from_joints;
use crate::oracle::{Local, OracleMember};

/// The angle to the back and to the front of straight down, up to which the farthest points of a
/// sole are taken.
const MOST_RAD: f64 = 0.9 * std::f64::consts::FRAC_PI_2;

/// The points that an ankle and the joint at the front of the foot carry, each in its joint's
/// space.
pub(super) struct Sole {
    ankle: Vec<DVec3>,
    toes: Vec<DVec3>,
    /// The joint at the front; the ankle if nothing below it has a sole.
    pub(super) tip: JointIndex,
}

/// Returns the farthest points of a joint's sole, from the back to the front, in the middle of its
/// width.
fn outline(of: &OracleMember<'_>, joint: JointIndex) -> Vec<DVec3> {
    let points: Vec<DVec3> = of
        .skeleton
        .soles(joint)
        .iter()
        .map(|point| DVec3::from_array(point.map(f64::from)))
        .collect();
    let least = points.iter().fold(f64::INFINITY, |a, p| a.min(p.x));
    let most = points.iter().fold(f64::NEG_INFINITY, |a, p| a.max(p.x));
    let locals: Vec<Local> = (0..of.body.joints.len()).map(|joint| of.body.rest(joint)).collect();
    let model = model_from_joints(of.body, &locals)[of.source(joint)];
    let mut found: Vec<DVec3> = Vec::new();
    for nth in 0..if points.is_empty() { 0 } else { MAX_SOLE_POINTS } {
        let part = f64::from(nth) / f64::from(MAX_SOLE_POINTS - 1);
        let (forward, down) = ((2.0 * part - 1.0) * MOST_RAD).sin_cos();
        let far = |p: &DVec3| forward * p.z - down * p.y;
        let farthest = points.iter().max_by(|a, b| far(a).total_cmp(&far(b)));
        let farthest = farthest.expect("there is a point");
        let middle = DVec3::new(0.5 * (least + most), farthest.y, farthest.z);
        if !found.contains(&middle) {
            found.push(middle);
        }
    }
    found.into_iter().map(|point| model.inverse().transform_point3(point)).collect()
}

impl Sole {
    pub(super) fn of(of: &OracleMember<'_>, foot: &Foot) -> Self {
        let front = |joint: &JointIndex| {
            of.skeleton.soles(*joint).iter().fold(f32::NEG_INFINITY, |a, p| a.max(p[2]))
        };
        let below = of.skeleton.joints().filter(|joint| {
            of.skeleton.is_below(*joint, foot.ankle) && !of.skeleton.soles(*joint).is_empty()
        });
        let toes = below.max_by(|a, b| front(a).total_cmp(&front(b)));
        Self {
            ankle: outline(of, foot.ankle),
            toes: toes.map_or(Vec::new(), |toes| outline(of, toes)),
            tip: toes.unwrap_or(foot.ankle),
        }
    }

    /// Returns all points in model space; those of the ankle come first.
    pub(super) fn points(
        &self,
        ankle: &DAffine3,
        toes: &DAffine3,
        noise: &mut Noise,
    ) -> Vec<DVec3> {
        let of = |joint: &DAffine3, points: &[DVec3], noise: &mut Noise| {
            let place = |point: &DVec3| {
                let arm = joint.transform_vector3(*point);
                noise.sized(joint.translation + arm, joint.translation.length() + arm.length())
            };
            points.iter().map(place).collect::<Vec<_>>()
        };
        let mut all = of(ankle, &self.ankle, noise);
        all.extend(of(toes, &self.toes, noise));
        all
    }

    /// Returns the direction from heel to ball, if the ankle carries both.
    pub(super) fn along(&self, ankle: &DAffine3) -> Option<DVec3> {
        let [heel, .., ball] = self.ankle[..] else { return None };
        Some(ankle.transform_vector3(ball - heel))
    }
}
