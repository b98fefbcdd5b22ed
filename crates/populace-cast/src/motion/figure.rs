//! A rigged body whose surface touches the ground: joint positions, and heights of parts.

use glam::{DQuat, DVec3};

use crate::anatomy::{Body, Limb, NECK, PELVIS, SEGMENTS, SPINE, Segment, Side};
use crate::motion::Pose;
use crate::rig::Joints;
use crate::surface::{Surface, Wardrobe};

/// Directions in which the outermost points of each part are kept: cosines of faces, edges and
/// corners of a cube.
const STEPS: [f64; 3] = [-1.0, 0.0, 1.0];

/// Extent of the rump below the hip joints, as a fraction of the body's height.
const RUMP: f64 = 0.09;

/// A point of the surface with its joints and weights.
struct Point {
    rest: DVec3,
    weights: Vec<(usize, f64)>,
}

/// A body on its rig, with the outermost points of its parts.
pub(super) struct Figure<'a> {
    pub(super) body: &'a Body,
    joints: &'a Joints,
    /// Points of trunk, head, upper arms and thighs.
    trunk: Vec<Point>,
    /// Points of the pelvis and of the upper ends of the thighs.
    rump: Vec<Point>,
    /// Points of pelvis and back.
    back: Vec<Point>,
    /// Points of each hand and of each foot, which move with the wrist or the ankle.
    hands: [Vec<Point>; 2],
    feet: [Vec<Point>; 2],
    /// Distances in metres before the model's origin at rest: of a skirt above the thighs, of the
    /// belly, and of the breast.
    pub(super) lap: f64,
    pub(super) belly: f64,
    pub(super) front: f64,
    /// Distances of the surface from the joints of elbow and knee in metres.
    pub(super) elbow: f64,
    pub(super) knee: f64,
}

impl<'a> Figure<'a> {
    pub(super) fn new(body: &'a Body, joints: &'a Joints, surface: &Surface) -> Self {
        let outermost = |segments: &[Segment]| outermost(joints, surface, segments);
        let mut trunk = vec![PELVIS];
        trunk.extend(SPINE.iter().chain(&NECK).chain([&crate::anatomy::HEAD]));
        for side in Side::BOTH {
            trunk.extend([Limb::Clavicle, Limb::UpperArm, Limb::Thigh].map(|l| l.of(side)));
        }
        let hand = |side: Side| {
            let fingers = (0..5).flat_map(|f| (0..3).map(move |j| Limb::Finger(f, j).of(side)));
            outermost(&fingers.chain([Limb::Hand.of(side)]).collect::<Vec<_>>())
        };
        let foot = |side: Side| outermost(&[Limb::Foot, Limb::Toes].map(|l| l.of(side)));
        let mut rump =
            outermost(&[PELVIS, Limb::Thigh.of(Side::Left), Limb::Thigh.of(Side::Right)]);
        rump.retain(|point| point.rest.y > body.hip_y - RUMP * body.height);
        let [hip, knee] = [Limb::Thigh, Limb::Shin].map(|limb| body.joint(limb, Side::Left));
        let lap_y = hip.lerp(knee, 0.65).y;
        Self {
            body,
            joints,
            trunk: outermost(&trunk),
            rump,
            back: outermost(&trunk[..=SPINE.len()]),
            hands: Side::BOTH.map(hand),
            feet: Side::BOTH.map(foot),
            lap: Wardrobe::lap(body, lap_y),
            belly: foremost(body, surface, [0.05, 0.5]),
            front: foremost(body, surface, [0.3, 0.9]),
            elbow: girth(body, surface, [Limb::UpperArm, Limb::Forearm]),
            knee: girth(body, surface, [Limb::Thigh, Limb::Shin]),
        }
    }

    /// Returns the positions of the rig's joints for a pose.
    pub(super) fn positions(&self, pose: &Pose) -> Vec<DVec3> {
        let mut positions: Vec<DVec3> = Vec::with_capacity(self.joints.len());
        for joint in 0..self.joints.len() {
            let rest = self.joints.position(joint);
            positions.push(match self.joints.parent(joint) {
                Some(parent) => {
                    let step = rest - self.joints.position(parent);
                    positions[parent] + pose.rotations[self.joints.driver(parent)] * step
                }
                None => rest + pose.pelvis_offset,
            });
        }
        positions
    }

    /// Returns the position of a limb's joint among those of [`positions`](Self::positions).
    pub(super) fn joint(&self, positions: &[DVec3], limb: Limb, side: Side) -> DVec3 {
        positions[usize::from(self.joints.of_segment[limb.of(side)])]
    }

    /// Returns a segment's place: of the joint that moves it, posed and at rest.
    pub(super) fn place(&self, positions: &[DVec3], segment: Segment) -> (DVec3, DVec3) {
        let joint = usize::from(self.joints.of_segment[segment]);
        (positions[joint], self.joints.position(joint))
    }

    /// Returns the height of the lowest point of trunk, head, upper arms and thighs.
    pub(super) fn trunk_low(&self, pose: &Pose) -> f64 {
        self.low(&self.trunk, pose, DVec3::Y)
    }

    /// Returns the height of a hand's lowest point above the wrist, a negative number.
    pub(super) fn hand_low(&self, side: Side, rotations: &[DQuat; SEGMENTS]) -> f64 {
        self.low_from(&self.hands[side.index()], Limb::Hand, side, rotations)
    }

    /// Returns the height of a foot's lowest point above the ankle, a negative number.
    pub(super) fn foot_low(&self, side: Side, rotations: &[DQuat; SEGMENTS]) -> f64 {
        self.low_from(&self.feet[side.index()], Limb::Foot, side, rotations)
    }

    /// Returns how far pelvis and back are behind the model's origin.
    pub(super) fn back(&self, pose: &Pose) -> f64 {
        -self.low(&self.back, pose, DVec3::Z)
    }

    /// Returns the height of the lowest point of the rump: what a seat touches.
    pub(super) fn rump_low(&self, pose: &Pose) -> f64 {
        self.low(&self.rump, pose, DVec3::Y)
    }

    /// Returns the height of the lowest point relative to a limb's joint, which carries it rigidly
    /// with the joints behind.
    fn low_from(
        &self,
        points: &[Point],
        limb: Limb,
        side: Side,
        rotations: &[DQuat; SEGMENTS],
    ) -> f64 {
        let first = usize::from(self.joints.of_segment[limb.of(side)]);
        let mut positions = vec![DVec3::ZERO; self.joints.len()];
        for joint in first + 1..self.joints.len() {
            if let Some(parent) = self.joints.parent(joint).filter(|&p| p >= first) {
                let step = self.joints.position(joint) - self.joints.position(parent);
                positions[joint] = positions[parent] + rotations[self.joints.driver(parent)] * step;
            }
        }
        // Weights of the limb before, at the seam, count as those of the limb's own joint.
        let behind = |joint: usize| if joint < first { first } else { joint };
        let height = |point: &Point| -> f64 {
            point
                .weights
                .iter()
                .map(|&(joint, weight)| {
                    let joint = behind(joint);
                    let offset = point.rest - self.joints.position(joint);
                    weight
                        * (positions[joint].y + (rotations[self.joints.driver(joint)] * offset).y)
                })
                .sum()
        };
        points.iter().map(height).fold(f64::MAX, f64::min)
    }

    /// Returns the least distance of points in the direction `up`.
    fn low(&self, points: &[Point], pose: &Pose, up: DVec3) -> f64 {
        let positions = self.positions(pose);
        let height = |point: &Point| -> f64 {
            point
                .weights
                .iter()
                .map(|&(joint, weight)| {
                    let offset = point.rest - self.joints.position(joint);
                    let turned = pose.rotations[self.joints.driver(joint)] * offset;
                    weight * (positions[joint] + turned).dot(up)
                })
                .sum()
        };
        points.iter().map(height).fold(f64::MAX, f64::min)
    }
}

/// Returns, for each of the segments, the points that mostly belong to it and lie farthest out in
/// one of 26 directions.
fn outermost(joints: &Joints, surface: &Surface, segments: &[Segment]) -> Vec<Point> {
    let mut chosen = std::collections::BTreeSet::new();
    for &segment in segments {
        let own: Vec<usize> =
            (0..surface.points.len()).filter(|&p| main(surface, p) == segment).collect();
        for (x, y, z) in STEPS
            .into_iter()
            .flat_map(|x| STEPS.into_iter().flat_map(move |y| STEPS.map(move |z| (x, y, z))))
        {
            let towards = DVec3::new(x, y, z);
            let along = |p: &usize| surface.points[*p].dot(towards);
            chosen.extend(own.iter().copied().max_by(|a, b| along(a).total_cmp(&along(b))));
        }
    }
    chosen
        .into_iter()
        .map(|point| {
            let sum: f64 = surface.weights[point].iter().map(|(_, w)| w).sum();
            let joint = |segment: Segment| usize::from(joints.of_segment[segment]);
            Point {
                rest: surface.points[point],
                weights: surface.weights[point].iter().map(|&(s, w)| (joint(s), w / sum)).collect(),
            }
        })
        .collect()
}

/// Returns the farthest distance before the model's origin at rest, of trunk points between two
/// heights ([`Body::trunk_y`]).
fn foremost(body: &Body, surface: &Surface, [low, high]: [f64; 2]) -> f64 {
    let heights = body.trunk_y(low)..body.trunk_y(high);
    let trunk = |p: usize| main(surface, p) <= SPINE[3];
    let points = (0..surface.points.len())
        .filter(|&p| heights.contains(&surface.points[p].y) && trunk(p))
        .map(|p| surface.points[p].z);
    points.fold(0.0, f64::max)
}

/// Returns the segment with the largest weight at a point.
fn main(surface: &Surface, point: usize) -> Segment {
    let largest = surface.weights[point].iter().max_by(|a, b| a.1.total_cmp(&b.1));
    largest.map_or(PELVIS, |(segment, _)| *segment)
}

/// Returns the mean distance from the joint between two segments of the left half to the points
/// that belong to both.
fn girth(body: &Body, surface: &Surface, limbs: [Limb; 2]) -> f64 {
    let [upper, lower] = limbs.map(|limb| limb.of(Side::Left));
    let weight = |point: usize, segment: Segment| -> f64 {
        surface.weights[point].iter().filter(|(s, _)| *s == segment).map(|(_, w)| w).sum()
    };
    let shared = (0..surface.points.len())
        .filter(|&p| weight(p, upper) > 0.2 && weight(p, lower) > 0.2)
        .map(|p| surface.points[p].distance(body.joints[lower]));
    let (sum, count) = shared.fold((0.0, 0.0), |(sum, count), d| (sum + d, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
