//! Segments of a body, and the joint positions that follow from its [`Look`].

use glam::{DQuat, DVec3};

use crate::Look;

/// The left or the right half of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// At +X.
    Left,
    /// At -X.
    Right,
}

impl Side {
    pub(crate) const BOTH: [Self; 2] = [Self::Left, Self::Right];

    pub(crate) const fn index(self) -> usize {
        self as usize
    }

    /// Returns 1 on the left and -1 on the right.
    pub(crate) fn sign(self) -> f64 {
        if self == Self::Left { 1.0 } else { -1.0 }
    }

    /// Returns a point of the left half, mirrored if this is the right half.
    pub(crate) fn mirror_point(self, p: DVec3) -> DVec3 {
        DVec3::new(p.x * self.sign(), p.y, p.z)
    }

    /// Returns a rotation of the left half, mirrored if this is the right half.
    pub(crate) fn mirror_rotation(self, q: DQuat) -> DQuat {
        if self == Self::Left { q } else { DQuat::from_xyzw(q.x, -q.y, -q.z, q.w) }
    }
}

/// Index of a rigid piece of the body. Surfaces and motions are defined for segments. Rigs have
/// joints for all or some of them.
pub(crate) type Segment = usize;

/// Number of segments.
pub(crate) const SEGMENTS: usize = 54;
pub(crate) const PELVIS: Segment = 0;
pub(crate) const SPINE: [Segment; 4] = [1, 2, 3, 4];
pub(crate) const NECK: [Segment; 2] = [5, 6];
pub(crate) const HEAD: Segment = 7;
/// First segment of the left limbs.
const SIDES: usize = 8;
/// Number of limb segments on each side.
const PER_SIDE: usize = 23;

/// Segments of the limbs on one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limb {
    Clavicle,
    UpperArm,
    Forearm,
    Hand,
    /// Finger, 0 (thumb) to 4, and joint, 0 (root) to 2.
    Finger(usize, usize),
    Thigh,
    Shin,
    Foot,
    Toes,
}

impl Limb {
    /// Returns the index of the segment on one side.
    pub(crate) const fn of(self, side: Side) -> Segment {
        let at = match self {
            Self::Clavicle => 0,
            Self::UpperArm => 1,
            Self::Forearm => 2,
            Self::Hand => 3,
            Self::Finger(finger, joint) => 4 + 3 * finger + joint,
            Self::Thigh => 19,
            Self::Shin => 20,
            Self::Foot => 21,
            Self::Toes => 22,
        };
        SIDES + PER_SIDE * side.index() + at
    }
}

/// Returns the parent of a segment, which has a lower index, or `None` for the pelvis.
pub(crate) fn parent(segment: Segment) -> Option<Segment> {
    match segment {
        PELVIS => None,
        1..SIDES => Some(segment - 1),
        _ => {
            let at = (segment - SIDES) % PER_SIDE;
            let first = segment - at;
            Some(match at {
                0 => SPINE[3],
                19 => PELVIS,
                4..19 if (at - 4).is_multiple_of(3) => first + 3,
                _ => segment - 1,
            })
        }
    }
}

/// Angle in radians of the arms at rest, measured from hanging straight down.
pub(crate) const REST_SPREAD_RAD: f64 = 0.66;

/// Height of the toe joint, where the sole bends, and its distance before the ankle. In metres for
/// a foot of scale 1, as the following three lengths.
pub(crate) const TOE_JOINT: [f64; 2] = [0.018, 0.132];
/// Distance behind the ankle at which the heel strikes the ground.
pub(crate) const HEEL_BACK: f64 = 0.04;
/// Distance of the tip of the shoe before the ankle.
pub(crate) const TOE_TIP: f64 = 0.205;
/// Height of the ankle above the sole.
const ANKLE_UP: f64 = 0.08;

/// A body at rest: feet together on y = 0, arms slightly spread, facing +Z. Lengths are in metres,
/// vectors in model space.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) look: Look,
    /// Height from sole to crown, with hair.
    pub(crate) height: f64,
    /// Height from chin to crown, without hair.
    pub(crate) head: f64,
    pub(crate) chin_y: f64,
    pub(crate) hip_y: f64,
    pub(crate) neck_y: f64,
    /// Scale of the feet; a foot of scale 1 is 0.26 m long.
    pub(crate) foot: f64,
    /// Unit vector along the left arm, towards the hand.
    pub(crate) along: DVec3,
    /// Unit vector out of the back of the left hand.
    pub(crate) outward: DVec3,
    /// Unit vector along the left thumb.
    pub(crate) thumb: DVec3,
    /// Position of each segment's joint.
    pub(crate) joints: [DVec3; SEGMENTS],
}

/// Thickness of usual hair at the crown, as a fraction of the head's height. Joints do not depend on
/// the cut, so that people of one build share their clips.
const HAIR: f64 = 0.04;

/// Lengths of the index to little fingers, as fractions of the body's height.
pub(crate) const FINGERS: [f64; 4] = [0.041, 0.046, 0.042, 0.033];
/// Offsets of the knuckles across the hand, index finger first, as fractions of the half width;
/// positive to the front.
pub(crate) const KNUCKLES: [f64; 4] = [0.66, 0.22, -0.22, -0.66];
/// Half width of the hand at the knuckles, as a fraction of the body's height.
pub(crate) const PALM: f64 = 0.0255;
/// Distance of the elbow from the shoulder, as a fraction of the body's height.
pub(crate) const ELBOW: f64 = 0.172;
/// Distance of the wrist from the shoulder, as a fraction of the body's height.
pub(crate) const WRIST: f64 = 0.316;
/// Distance of the knuckles from the shoulder, as a fraction of the body's height.
pub(crate) const KNUCKLE: f64 = 0.378;

impl Body {
    pub(crate) fn new(look: &Look) -> Self {
        let height = look.height_m;
        let head = 0.132 * height * look.head;
        let chin_y = height - head * (1.0 + HAIR);
        let foot = height / 1.75 * look.foot;
        let (sin, cos) = REST_SPREAD_RAD.sin_cos();
        let along = DVec3::new(sin, -cos, 0.0);
        let outward = DVec3::new(cos, sin, 0.0);
        let mut body = Self {
            look: look.clone(),
            height,
            head,
            chin_y,
            hip_y: 0.525 * height * look.legs,
            neck_y: chin_y - 0.016 * height,
            foot,
            along,
            outward,
            thumb: (along * 0.82 + DVec3::Z * 0.55 - outward * 0.16).normalize(),
            joints: [DVec3::ZERO; SEGMENTS],
        };
        body.place_trunk();
        body.place_limbs();
        body
    }

    /// Returns the height at `u` between the hip joints (0) and the base of the neck (1).
    pub(crate) fn trunk_y(&self, u: f64) -> f64 {
        self.hip_y + u * (self.neck_y - self.hip_y)
    }

    fn place_trunk(&mut self) {
        let h = self.height;
        self.joints[PELVIS] = DVec3::new(0.0, self.trunk_y(0.05), -0.004 * h);
        for (at, u) in SPINE_AT.into_iter().enumerate() {
            self.joints[SPINE[at]] = DVec3::new(0.0, self.trunk_y(u), -0.008 * h);
        }
        self.joints[NECK[0]] = DVec3::new(0.0, self.neck_y, -0.010 * h);
        self.joints[NECK[1]] = DVec3::new(0.0, self.chin_y + 0.02 * self.head, -0.004 * h);
        self.joints[HEAD] = DVec3::new(0.0, self.chin_y + 0.2 * self.head, 0.0);
    }

    fn place_limbs(&mut self) {
        let h = self.height;
        let shoulder = DVec3::new(0.107 * h * self.look.shoulders, self.trunk_y(0.85), -0.006 * h);
        let mut left = vec![(Limb::Clavicle, DVec3::new(0.018 * h, self.trunk_y(0.9), 0.008 * h))];
        for (limb, at) in [(Limb::UpperArm, 0.0), (Limb::Forearm, ELBOW), (Limb::Hand, WRIST)] {
            left.push((limb, shoulder + self.along * at * h));
        }
        for (finger, (length, across)) in FINGERS.into_iter().zip(KNUCKLES).enumerate() {
            let knuckle = shoulder + self.along * KNUCKLE * h + DVec3::Z * across * PALM * h;
            for (joint, part) in FINGER_AT.into_iter().enumerate() {
                left.push((
                    Limb::Finger(finger + 1, joint),
                    knuckle + self.along * part * length * h,
                ));
            }
        }
        let root =
            shoulder + self.along * 0.335 * h + DVec3::Z * 0.014 * h - self.outward * 0.003 * h;
        for (joint, part) in [0.0, 0.026, 0.047].into_iter().enumerate() {
            left.push((Limb::Finger(0, joint), root + self.thumb * part * h));
        }
        let ankle = DVec3::new(0.05 * h * self.look.hips, ANKLE_UP * self.foot, -0.012 * h);
        let hip = DVec3::new(0.051 * h * self.look.hips, self.hip_y, 0.0);
        left.push((Limb::Thigh, hip));
        left.push((Limb::Shin, hip.lerp(ankle, 0.5) + DVec3::Z * 0.006 * h));
        left.push((Limb::Foot, ankle));
        let [toe_y, toe_z] = TOE_JOINT.map(|v| v * self.foot);
        left.push((Limb::Toes, DVec3::new(ankle.x, toe_y, ankle.z + toe_z)));
        for side in Side::BOTH {
            for &(limb, position) in &left {
                self.joints[limb.of(side)] = side.mirror_point(position);
            }
        }
    }

    /// Returns the position of a limb's joint.
    pub(crate) fn joint(&self, limb: Limb, side: Side) -> DVec3 {
        self.joints[limb.of(side)]
    }
}

/// Positions of the spine's joints between the hip joints (0) and the base of the neck (1).
pub(crate) const SPINE_AT: [f64; 4] = [0.2, 0.38, 0.56, 0.74];
/// Positions of a finger's joints between knuckle (0) and tip (1).
pub(crate) const FINGER_AT: [f64; 3] = [0.0, 0.45, 0.72];
