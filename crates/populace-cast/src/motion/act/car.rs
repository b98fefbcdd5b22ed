//! Cars: driving, getting in and getting out.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3};

use super::seat::HIPS_BEHIND_M;
use super::{Timing, wave};
use crate::anatomy::{Limb, PELVIS, Side};
use crate::motion::figure::Figure;
use crate::motion::reach::{FIST, Frame, GRIP_SPOT, Reach};
use crate::motion::stance::{Leg, Stance};
use crate::motion::{Motion, Pose, curve, idle};
use crate::places::{
    CAR_FLOOR_M, CAR_SEAT_M, STEERING_WHEEL_M, STEERING_WHEEL_RADIUS_M, STEERING_WHEEL_TILT_RAD,
};

/// Pitch of the feet on the pedals in radians.
const PEDAL_RAD: f64 = 0.42;
/// Angle of the hands on the wheel above its middle in radians.
const HANDS_RAD: f64 = 0.30;

/// Returns driving: small corrections, and a look into the mirrors.
pub(super) fn drive(figure: &Figure) -> Motion {
    let body = figure.body;
    let seated = seated(figure);
    Timing("Drive", 6.0, 8.0).looping(|phase| {
        let steer = 0.10 * wave(phase, 2.0, 0.0) + 0.05 * wave(phase, 5.0, 0.0);
        let mirror = curve::at(&[(0.50, 0.0), (0.56, 1.0), (0.64, 1.0), (0.71, 0.0)], phase);
        let mut stance = seated.clone();
        let breath = wave(phase, 2.0, 0.0);
        stance.chest *=
            DQuat::from_rotation_x(-0.01 * breath) * DQuat::from_rotation_z(-0.12 * steer);
        stance.head = DQuat::from_rotation_y(0.55 * mirror + 0.25 * steer)
            * stance.head
            * DQuat::from_rotation_x(0.02 * wave(phase, 3.0, 0.0));
        let mut pose = stance.solve(body);
        for side in Side::BOTH {
            figure.reach(&mut pose, side, &on_wheel(side, steer, Frame::MODEL), 1.0);
        }
        pose
    })
}

/// Returns where a hand holds the wheel, turned to the left by `steer` radians.
fn on_wheel(side: Side, steer: f64, frame: Frame) -> Reach {
    let (sin, cos) = f64::from(STEERING_WHEEL_TILT_RAD).sin_cos();
    let up = DVec3::new(0.0, cos, sin);
    let ahead = DVec3::new(0.0, -sin, cos);
    let (high, wide) = (HANDS_RAD - side.sign() * steer).sin_cos();
    let out = DVec3::X * wide + up * high;
    let tangent = up * wide - DVec3::X * high;
    let palm = (ahead * 0.45 - out).normalize();
    let centre = DVec3::from(STEERING_WHEEL_M.map(f64::from));
    Reach {
        frame,
        at: centre + out * f64::from(STEERING_WHEEL_RADIUS_M),
        spot: GRIP_SPOT,
        fingers: tangent.cross(palm),
        palm,
        elbow: DVec3::new(0.8, -1.0, -0.2),
        curl: FIST.map(|curl| curl + 0.9 * steer.abs()),
    }
}

/// Returns the stance on a driver's seat: the middle of its surface is at x = z = 0.
fn seated(figure: &Figure) -> Stance {
    let body = figure.body;
    let mut stance = idle::at(body, 0.0);
    stance.pelvis_offset = DVec3::new(0.0, 0.0, -HIPS_BEHIND_M);
    stance.shrug_rad = 0.0;
    for round in 0..6 {
        for side in Side::BOTH {
            stance.legs[side.index()] = on_floor(figure, &stance, side);
        }
        if round < 3 {
            lean(figure, &mut stance);
        }
        let low = figure.rump_low(&stance.solve(body));
        stance.pelvis_offset.y += f64::from(CAR_SEAT_M[1]) - low;
    }
    stance
}

/// Leans the trunk back, but no farther than the arms reach the wheel.
fn lean(figure: &Figure, stance: &mut Stance) {
    let body = figure.body;
    let stoop = body.look.stoop_rad;
    let mut lean = |angle: f64| {
        stance.pelvis = DQuat::from_rotation_x(-0.30 + 0.3 * angle);
        stance.chest = DQuat::from_rotation_x(-0.20 + 0.4 * stoop + angle);
        stance.head = DQuat::from_rotation_x(-0.02 + 0.2 * stoop);
        let mut pose = stance.solve(body);
        let wrist =
            figure.reach(&mut pose, Side::Left, &on_wheel(Side::Left, 0.0, Frame::MODEL), 1.0);
        figure.stretch(&pose, Side::Left, wrist)
    };
    let (mut low, mut high) = (0.0, 0.7);
    for _ in 0..10 {
        let middle = 0.5 * (low + high);
        if lean(middle) > 0.90 { low = middle } else { high = middle }
    }
    lean(high);
}

/// Returns a leg with the heel on the floor, ahead as far as is comfortable.
fn on_floor(figure: &Figure, stance: &Stance, side: Side) -> Leg {
    let body = figure.body;
    let [hip, knee, ankle] =
        [Limb::Thigh, Limb::Shin, Limb::Foot].map(|limb| body.joint(limb, side));
    let length = hip.distance(knee) + knee.distance(ankle);
    let from = stance.hip(body, side);
    let yaw_rad = 0.14;
    let rotations = {
        let mut stance = stance.clone();
        let leg = &mut stance.legs[side.index()];
        (leg.pitch_rad, leg.toe_pitch_rad, leg.yaw_rad) = (PEDAL_RAD, PEDAL_RAD, yaw_rad);
        stance.solve(body).rotations
    };
    let y = f64::from(CAR_FLOOR_M) - figure.foot_low(side, &rotations);
    let reach = if side == Side::Left { 0.90 } else { 0.92 } * length;
    let drop = from.y - y;
    let ahead = (reach * reach - drop * drop).max(0.0).sqrt();
    Leg {
        ankle: DVec3::new(1.15 * from.x, y, from.z + ahead),
        pitch_rad: PEDAL_RAD,
        toe_pitch_rad: PEDAL_RAD,
        yaw_rad,
    }
}

/// A place and a heading: where a pose is put in the clip's space.
#[derive(Clone, Copy)]
struct Facing {
    origin: DVec3,
    yaw_rad: f64,
}

impl Facing {
    fn turn(self) -> DQuat {
        DQuat::from_rotation_y(self.yaw_rad)
    }

    /// Moves a pose from the facing's own space to the clip's.
    fn place(self, figure: &Figure, mut pose: Pose) -> Pose {
        let turn = self.turn();
        let rest = figure.body.joints[PELVIS];
        pose.pelvis_offset = turn * (rest + pose.pelvis_offset) + self.origin - rest;
        for rotation in &mut pose.rotations {
            *rotation = turn * *rotation;
        }
        pose
    }

    /// Returns a leg of the clip's space in the facing's own.
    fn local(self, leg: Leg, side: Side) -> Leg {
        let ankle = self.turn().inverse() * (leg.ankle - self.origin);
        Leg { ankle, yaw_rad: leg.yaw_rad - side.sign() * self.yaw_rad, ..leg }
    }

    /// Returns a leg of the facing's own space in the clip's.
    fn global(self, leg: Leg, side: Side) -> Leg {
        let ankle = self.turn() * leg.ankle + self.origin;
        Leg { ankle, yaw_rad: leg.yaw_rad + side.sign() * self.yaw_rad, ..leg }
    }
}

/// The driver's seat in the space of `Get_In`.
fn car() -> Facing {
    let [x, _, z] = CAR_SEAT_M.map(f64::from);
    Facing { origin: DVec3::new(x, 0.0, z), yaw_rad: FRAC_PI_2 }
}

/// Duration in seconds of getting in.
const IN_SECS: f64 = 3.6;
/// Duration in seconds of getting out.
const OUT_SECS: f64 = 3.8;

/// Returns getting in, and getting out the same way.
pub(super) fn get_in_and_out(figure: &Figure) -> [Motion; 2] {
    let way = Way::new(figure);
    [
        Timing("Get_In", IN_SECS, 20.0).once(|at| way.pose(at)),
        Timing("Get_Out", OUT_SECS, 20.0).once(|at| way.pose(IN_SECS * (1.0 - at / OUT_SECS))),
    ]
}

/// The way into a car.
struct Way<'a> {
    figure: &'a Figure<'a>,
    stand: Stance,
    seated: Stance,
    /// Length of the legs relative to a man's.
    legs: f64,
    /// How far the trunk ducks: tall people duck more.
    duck: f64,
}

impl<'a> Way<'a> {
    fn new(figure: &'a Figure<'a>) -> Self {
        let body = figure.body;
        let stand = idle::at(body, 0.0);
        let duck = (0.7 + 1.6 * (body.height - 1.5)).clamp(0.6, 1.3);
        Self { figure, stand, seated: seated(figure), legs: body.hip_y / 0.93, duck }
    }

    fn pose(&self, at: f64) -> Pose {
        let figure = self.figure;
        let through = |knots: &curve::Knots| curve::through(knots, at);
        let facing = self.facing(at);
        let sit = through(&[(0.9, 0.0), (1.4, 0.48), (2.3, 1.0)]);
        let upright = through(&[(1.9, 0.0), (2.9, 1.0)]);
        let mut stance = self.stand.towards(&self.seated, upright);
        let (from, to) = (self.stand.pelvis_offset, self.seated.pelvis_offset);
        stance.pelvis_offset = from.lerp(to, sit);
        // The trunk ducks under the edge of the roof, head first.
        let duck = self.duck * through(&[(0.6, 0.0), (1.35, 1.0), (2.0, 0.95), (2.9, 0.0)]);
        let tilt = through(&[(0.9, 0.0), (1.4, 0.5), (2.0, -0.35), (2.8, 0.0)]);
        stance.pelvis *= DQuat::from_rotation_x(0.5 * duck) * DQuat::from_rotation_z(0.10 * tilt);
        stance.chest *= DQuat::from_rotation_x(1.0 * duck) * DQuat::from_rotation_z(0.28 * tilt);
        let look = through(&[(0.3, 0.0), (0.8, 1.0), (1.5, 0.6), (2.3, 0.0)]);
        stance.head = DQuat::from_rotation_y(-0.35 * look)
            * stance.head
            * DQuat::from_rotation_x(0.8 * duck)
            * DQuat::from_rotation_z(0.30 * tilt);
        stance.legs = Side::BOTH.map(|side| facing.local(self.leg(side, at), side));
        let mut pose = stance.solve(figure.body);
        let inverse = facing.turn().inverse();
        let wheel = Frame {
            origin: inverse * (car().origin - facing.origin),
            turn: inverse * car().turn(),
        };
        let hands =
            [through(&[(2.35, 0.0), (3.4, 1.0)]), through(&[(1.5, 0.0), (2.3, 0.9), (2.8, 1.0)])];
        for side in Side::BOTH {
            let reach = on_wheel(side, 0.0, wheel);
            figure.reach(&mut pose, side, &reach, hands[side.index()]);
        }
        facing.place(figure, pose)
    }

    /// Returns where the hips are, and where they face.
    fn facing(&self, at: f64) -> Facing {
        let through = |knots: &curve::Knots| curve::through(knots, at);
        let car = car();
        let near = 0.12 / self.legs.max(0.6);
        let z = [(0.15, 0.0), (0.85, near), (1.2, near + 0.07), (1.8, 0.68), (2.35, car.origin.z)];
        let x = [(0.2, 0.0), (0.8, -0.05), (1.5, -0.05), (2.3, car.origin.x)];
        let yaw = [(0.1, 0.0), (0.9, 1.3), (1.5, 1.42), (2.4, car.yaw_rad)];
        Facing { origin: DVec3::new(through(&x), 0.0, through(&z)), yaw_rad: through(&yaw) }
    }

    /// Returns a leg in the clip's space: the right foot enters first.
    fn leg(&self, side: Side, at: f64) -> Leg {
        let h = self.figure.body.height;
        let stand = self.stand.legs[side.index()];
        let end = car().global(self.seated.legs[side.index()], side);
        let near = 0.24 / self.legs.max(0.6);
        let floor = f64::from(CAR_FLOOR_M);
        let lifted = |leg: Leg, rise: f64, pitch: f64| Leg {
            ankle: leg.ankle + DVec3::Y * rise,
            pitch_rad: leg.pitch_rad + pitch,
            toe_pitch_rad: leg.toe_pitch_rad + pitch,
            ..leg
        };
        if side == Side::Left {
            // A step towards the sill, and later in over it.
            let beside = Leg {
                ankle: DVec3::new(0.06 * h, stand.ankle.y, near - 0.03),
                yaw_rad: 1.25,
                ..stand
            };
            let step = curve::through(&[(0.15, 0.0), (0.72, 1.0)], at);
            let over = curve::through(&[(1.72, 0.0), (2.8, 1.0)], at);
            let leg = stand.towards(&beside, step).towards(&end, over);
            let rise = bump(step) * 0.05 * h + bump(over) * (0.12 + 0.10 * self.legs);
            return lifted(leg, rise, -0.35 * bump(step) - 0.25 * bump(over));
        }
        let inside = Leg {
            ankle: DVec3::new(0.20 * h, floor + stand.ankle.y, 0.80 - 0.06 * self.legs),
            pitch_rad: 0.0,
            toe_pitch_rad: 0.0,
            yaw_rad: -1.2,
        };
        let over = curve::through(&[(0.75, 0.0), (1.5, 1.0)], at);
        let ahead = curve::through(&[(1.75, 0.0), (2.5, 1.0)], at);
        let leg = stand.towards(&inside, over).towards(&end, ahead);
        lifted(leg, bump(over) * (0.14 + 0.16 * self.legs) + bump(ahead) * 0.03, -0.45 * bump(over))
    }
}

/// Returns a smooth bump over the way from 0 to 1, at most 1.
fn bump(way: f64) -> f64 {
    16.0 * (way * (1.0 - way)).powi(2)
}
