//! Seats: sitting, sitting down and standing up.

use glam::{DQuat, DVec3};

use super::{Timing, wave};
use crate::anatomy::{Limb, Side};
use crate::motion::figure::Figure;
use crate::motion::reach::{PALM_SPOT, Reach};
use crate::motion::stance::{Leg, Stance};
use crate::motion::{Motion, Pose, curve, idle};
use crate::places::{SEAT_BACK_M, SEAT_HEIGHT_M};

/// Distance in metres of the hip joints behind the middle of a seat.
pub(super) const HIPS_BEHIND_M: f64 = 0.05;
/// Height in metres of a knee over a planted foot, below which the feet hang from a seat.
const LEAST_KNEE_M: f64 = 0.40;

/// A body on a seat.
struct Seated<'a> {
    figure: &'a Figure<'a>,
    /// The stance without breath and looks.
    stance: Stance,
}

/// Breath and looks of a seated person.
#[derive(Default)]
struct State {
    breath: f64,
    look: f64,
    nod: f64,
    lean: f64,
}

impl<'a> Seated<'a> {
    fn new(figure: &'a Figure<'a>) -> Self {
        let body = figure.body;
        let stoop = body.look.stoop_rad;
        let mut stance = idle::at(body, 0.0);
        let hips_z = -f64::from(SEAT_BACK_M) - HIPS_BEHIND_M;
        stance.pelvis_offset = DVec3::new(0.0, 0.0, hips_z);
        stance.pelvis = DQuat::from_rotation_x(-0.16);
        stance.chest = DQuat::from_rotation_x(0.03 + 0.6 * stoop);
        stance.head = DQuat::from_rotation_x(0.04 + 0.2 * stoop);
        let mut seated = Self { figure, stance };
        seated.settle();
        seated
    }

    /// Lowers the rump onto the seat, and hangs the legs of small bodies.
    fn settle(&mut self) {
        let body = self.figure.body;
        let [knee, ankle] = [Limb::Shin, Limb::Foot].map(|limb| body.joint(limb, Side::Left));
        let hangs = ankle.y + knee.distance(ankle) < LEAST_KNEE_M;
        for _ in 0..5 {
            if hangs {
                for side in Side::BOTH {
                    self.stance.legs[side.index()] = self.hanging(side);
                }
            }
            let low = self.figure.rump_low(&self.stance.solve(body));
            self.stance.pelvis_offset.y += f64::from(SEAT_HEIGHT_M) - low;
        }
    }

    /// Returns a leg that hangs over the edge of the seat.
    fn hanging(&self, side: Side) -> Leg {
        let body = self.figure.body;
        let [hip, knee, ankle] =
            [Limb::Thigh, Limb::Shin, Limb::Foot].map(|limb| body.joint(limb, side));
        let from = self.stance.hip(body, side);
        let aside = 0.06 * side.sign();
        let thigh = DVec3::new(aside, -0.06, 1.0).normalize() * hip.distance(knee);
        let shin = DVec3::new(0.0, -1.0, -0.06).normalize() * knee.distance(ankle);
        let (pitch_rad, toe_pitch_rad) = (-0.35, -0.45);
        Leg { ankle: from + thigh + shin, pitch_rad, toe_pitch_rad, yaw_rad: 0.1 }
    }

    fn stance(&self, state: &State) -> Stance {
        let mut stance = self.stance.clone();
        let State { breath, look, nod, lean } = *state;
        stance.chest = DQuat::from_rotation_y(0.15 * look)
            * stance.chest
            * DQuat::from_rotation_x(lean - 0.014 * breath);
        stance.head = DQuat::from_rotation_y(look) * stance.head * DQuat::from_rotation_x(nod);
        stance.shrug_rad = 0.014 * breath;
        stance
    }
}

/// Returns where a hand lies on the thigh.
fn on_thigh(figure: &Figure, pose: &Pose, side: Side, curl: f64) -> Reach {
    let body = figure.body;
    let [hip, knee] = [Limb::Thigh, Limb::Shin].map(|limb| body.joint(limb, Side::Left));
    let cover = if figure.lap > 0.0 { 0.05 } else { 0.0 };
    let along = if side == Side::Left { 0.62 } else { 0.68 } + cover;
    let bone = hip.lerp(knee, along);
    let cloth = (figure.lap - bone.z + 0.006 * body.height).max(1.22 * figure.knee);
    Reach {
        frame: figure.frame(pose, Limb::Thigh.of(side)),
        at: bone + DVec3::new(0.0, 0.0, cloth),
        spot: PALM_SPOT,
        fingers: DVec3::new(-0.32, -1.0, 0.0),
        palm: DVec3::new(-0.1, 0.0, -1.0),
        elbow: DVec3::new(0.75, 0.75, -0.5),
        curl: [0.2, 0.22, 0.24, 0.26, 0.3].map(|own| own + curl),
    }
}

/// Returns sitting with the hands on the thighs.
pub(super) fn sit(figure: &Figure) -> Motion {
    let seated = Seated::new(figure);
    let look = |phase: f64| {
        curve::at(
            &[(0.1, 0.0), (0.22, 0.42), (0.34, 0.45), (0.45, 0.0), (0.62, -0.3), (0.78, -0.25)],
            phase,
        )
    };
    Timing("Sit", 8.0, 8.0).looping(|phase| {
        let state = State {
            breath: wave(phase, 2.0, 0.0),
            look: look(phase) - look(0.0),
            nod: 0.04 * wave(phase, 2.0, 0.0),
            lean: 0.02 * wave(phase, 1.0, 0.0),
        };
        let mut pose = seated.stance(&state).solve(figure.body);
        for side in Side::BOTH {
            let curl = 0.10 * wave(phase, 1.0, 0.1 * side.sign()) * wave(phase, 2.0, 0.0);
            let reach = on_thigh(figure, &pose, side, curl);
            figure.reach(&mut pose, side, &reach, 1.0);
        }
        pose
    })
}

/// How far a body has sat down, by parts: 0 standing, 1 seated.
struct Progress {
    back: f64,
    down: f64,
    feet: f64,
    turn: f64,
    hands: [f64; 2],
    /// Extra bend of the trunk in radians: of the pelvis, the chest and the head.
    bend: [f64; 3],
}

/// Returns sitting down and standing up.
pub(super) fn down_and_up(figure: &Figure) -> [Motion; 2] {
    let seated = Seated::new(figure);
    let down = Timing("Sit_Down", 2.0, 20.0).once(|at| {
        let lean = curve::through(&[(0.05, 0.0), (0.75, 1.0), (1.05, 0.95), (1.85, 0.0)], at);
        on_the_way(
            &seated,
            &Progress {
                back: curve::through(&[(0.1, 0.0), (0.55, 0.45), (1.3, 1.0)], at),
                down: curve::through(&[(0.12, 0.0), (0.6, 0.22), (1.42, 1.0)], at),
                feet: curve::through(&[(0.45, 0.0), (1.3, 1.0)], at),
                turn: curve::through(&[(0.9, 0.0), (1.8, 1.0)], at),
                hands: [
                    curve::through(&[(0.3, 0.0), (1.05, 0.9), (1.5, 1.0)], at),
                    curve::through(&[(0.4, 0.0), (1.15, 0.9), (1.65, 1.0)], at),
                ],
                bend: [0.45 * lean, 0.72 * lean, 0.42 * lean],
            },
        )
    });
    let up = Timing("Stand_Up", 1.9, 20.0).once(|at| {
        let lean = curve::through(&[(0.0, 0.0), (0.6, 1.0), (0.8, 0.95), (1.6, 0.0)], at);
        on_the_way(
            &seated,
            &Progress {
                back: curve::through(&[(0.4, 1.0), (0.9, 0.6), (1.6, 0.0)], at),
                down: curve::through(&[(0.5, 1.0), (0.95, 0.6), (1.65, 0.0)], at),
                feet: curve::through(&[(0.25, 1.0), (0.85, 0.0)], at),
                turn: curve::through(&[(0.3, 1.0), (1.2, 0.0)], at),
                hands: [
                    curve::through(&[(0.38, 1.0), (0.8, 0.75), (1.55, 0.0)], at),
                    curve::through(&[(0.32, 1.0), (0.75, 0.75), (1.65, 0.0)], at),
                ],
                bend: [0.5 * lean, 0.68 * lean, 0.32 * lean],
            },
        )
    });
    [down, up]
}

/// Returns a pose between standing and sitting.
fn on_the_way(seated: &Seated, progress: &Progress) -> Pose {
    let figure = seated.figure;
    let body = figure.body;
    let stand = idle::at(body, 0.0);
    let sit = seated.stance(&State::default());
    let mut stance = stand.towards(&sit, progress.turn);
    let (from, to) = (stand.pelvis_offset, sit.pelvis_offset);
    stance.pelvis_offset = DVec3::new(
        from.x + (to.x - from.x) * progress.down,
        from.y + (to.y - from.y) * progress.down,
        from.z + (to.z - from.z) * progress.back,
    );
    let [pelvis, chest, head] = progress.bend.map(DQuat::from_rotation_x);
    stance.pelvis *= pelvis;
    stance.chest *= chest;
    stance.head *= head;
    stance.legs =
        std::array::from_fn(|side| stand.legs[side].towards(&sit.legs[side], progress.feet));
    let mut pose = stance.solve(body);
    for side in Side::BOTH {
        let reach = on_thigh(figure, &pose, side, 0.0);
        figure.reach(&mut pose, side, &reach, progress.hands[side.index()]);
    }
    pose
}
