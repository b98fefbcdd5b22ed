//! Where the joints of a body stand, from its [`Look`].

use glam::{DQuat, DVec3};

use crate::Look;

/// The left or the right half of a body; the left is at +X.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
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

    /// +1 on the left, -1 on the right.
    pub(crate) fn sign(self) -> f64 {
        if self == Self::Left { 1.0 } else { -1.0 }
    }

    /// A point of the left half, or its mirror image.
    pub(crate) fn place(self, p: DVec3) -> DVec3 {
        DVec3::new(p.x * self.sign(), p.y, p.z)
    }

    /// A turn of the left half, or its mirror image.
    pub(crate) fn turn(self, q: DQuat) -> DQuat {
        if self == Self::Left { q } else { DQuat::from_xyzw(q.x, -q.y, -q.z, q.w) }
    }
}

/// A rigid piece of the body that surfaces and motions are made for; rigs have joints for all or
/// some of them.
pub(crate) type Segment = usize;

/// How many segments there are.
pub(crate) const SEGMENTS: usize = 54;
pub(crate) const PELVIS: Segment = 0;
pub(crate) const SPINE: [Segment; 4] = [1, 2, 3, 4];
pub(crate) const NECK: [Segment; 2] = [5, 6];
pub(crate) const HEAD: Segment = 7;
const SIDES: usize = 8;
const PER_SIDE: usize = 23;

/// Pieces of the limbs, left and right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limb {
    Clavicle,
    UpperArm,
    Forearm,
    Hand,
    /// Finger 0 (the thumb) to 4, joint 0 to 2.
    Finger(usize, usize),
    Thigh,
    Shin,
    Foot,
    Toes,
}

impl Limb {
    /// The segment of one side.
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

/// The segment that a segment hangs on; always of a lower index.
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

/// How far arms are spread at rest, from hanging straight down.
pub(crate) const REST_SPREAD_RAD: f64 = 0.66;

/// Heights in units of the foot's scale: where the sole bends, and how far before the ankle.
pub(crate) const TOE_JOINT: [f64; 2] = [0.018, 0.132];
/// Where the heel strikes the ground, behind the ankle.
pub(crate) const HEEL_BACK: f64 = 0.04;
/// The tip of the shoe before the ankle.
pub(crate) const TOE_TIP: f64 = 0.205;
/// The ankle's height over the sole.
const ANKLE_UP: f64 = 0.08;

/// A body at rest: feet together on y = 0, arms spread a little, facing +Z.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) look: Look,
    /// Metres from sole to crown.
    pub(crate) height: f64,
    /// Chin to crown without hair, metres.
    pub(crate) head: f64,
    pub(crate) chin_y: f64,
    pub(crate) hip_y: f64,
    pub(crate) neck_y: f64,
    /// Scale of a foot that is 0.26 m long at 1.
    pub(crate) foot: f64,
    /// Along the left arm, towards the hand.
    pub(crate) along: DVec3,
    /// Out of the back of the left hand.
    pub(crate) outward: DVec3,
    /// Along the left thumb.
    pub(crate) thumb: DVec3,
    pub(crate) joints: [DVec3; SEGMENTS],
}

/// Lengths of index to little finger, as a part of the body's height.
pub(crate) const FINGERS: [f64; 4] = [0.041, 0.046, 0.042, 0.033];
/// Where knuckles stand across the hand, as a part of its half width; the index finger is in front.
pub(crate) const KNUCKLES: [f64; 4] = [0.66, 0.22, -0.22, -0.66];
/// Half width of the hand at the knuckles.
pub(crate) const PALM: f64 = 0.0255;
/// Where along the arm the elbow, wrist and knuckles are.
pub(crate) const ELBOW: f64 = 0.172;
pub(crate) const WRIST: f64 = 0.316;
pub(crate) const KNUCKLE: f64 = 0.378;

impl Body {
    pub(crate) fn new(look: &Look) -> Self {
        let height = look.height_m;
        let head = 0.132 * height * look.head;
        let chin_y = height - head * (1.0 + look.hair.height());
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

    /// The height of a place between the hip joints (0) and the foot of the neck (1).
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
            for &(limb, place) in &left {
                self.joints[limb.of(side)] = side.place(place);
            }
        }
    }

    /// Where a joint of a limb stands.
    pub(crate) fn joint(&self, limb: Limb, side: Side) -> DVec3 {
        self.joints[limb.of(side)]
    }
}

/// Where the spine's joints stand between hips (0) and the foot of the neck (1).
pub(crate) const SPINE_AT: [f64; 4] = [0.2, 0.38, 0.56, 0.74];
/// Where along a finger its joints are.
pub(crate) const FINGER_AT: [f64; 3] = [0.0, 0.45, 0.72];
