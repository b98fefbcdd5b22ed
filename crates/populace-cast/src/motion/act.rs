//! Motions for streets, stands and battles: stances, and hands that reach.

mod battle;
mod car;
mod gesture;
mod hand;
mod phone;
mod seat;
mod shop;
mod talk;
mod wall;

use std::f64::consts::TAU;

use super::figure::Figure;
use super::stance::Stance;
use super::{Motion, Pose, idle};
use crate::anatomy::Body;
use crate::surface::smooth;

/// Returns the motions that loop, in their order among the clips.
pub(super) fn loops(figure: &Figure) -> Vec<Motion> {
    vec![
        shop::look_around(figure),
        shop::look_in(figure),
        wall::lean(figure),
        seat::sit(figure),
        car::drive(figure),
        talk::talk(figure),
        talk::listen(figure),
        phone::call(figure),
        phone::text(figure),
        gesture::wave_hand(figure),
        gesture::clap(figure),
        gesture::cheer(figure),
        hand::carry(figure),
        hand::push(figure),
        battle::shield(figure),
        battle::spear(figure),
    ]
}

/// Returns the motions that play once, in their order among the clips.
pub(super) fn once(figure: &Figure) -> Vec<Motion> {
    let [get_in, get_out] = car::get_in_and_out(figure);
    let [sit_down, stand_up] = seat::down_and_up(figure);
    vec![
        sit_down,
        stand_up,
        gesture::point(figure),
        hand::open_door(figure),
        get_in,
        get_out,
        battle::thrust(figure),
        battle::hit(figure),
        hand::push_away(figure),
    ]
}

/// A clip's name, duration in seconds, and keys per second.
#[derive(Clone, Copy)]
struct Timing(&'static str, f64, f64);

impl Timing {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few dozen keys")]
    fn keys(self) -> usize {
        (self.1 * self.2).round().max(1.0) as usize
    }

    /// Samples a motion that loops: `pose` at phases from 0 to below 1.
    fn looping(self, pose: impl Fn(f64) -> Pose) -> Motion {
        let keys = self.keys();
        let mut poses: Vec<Pose> = (0..keys).map(|key| pose(key as f64 / keys as f64)).collect();
        poses.push(poses[0].clone());
        Motion { name: self.0, duration_secs: self.1, poses }
    }

    /// Samples a motion that plays once: `pose` at times in seconds.
    fn once(self, pose: impl Fn(f64) -> Pose) -> Motion {
        let keys = self.keys();
        let secs = |key: usize| self.1 * key as f64 / keys as f64;
        let poses = (0..=keys).map(|key| pose(secs(key))).collect();
        Motion { name: self.0, duration_secs: self.1, poses }
    }
}

/// Returns the first stance of the idle, with arms and fingers that move a little in between: at 0
/// and at 1 they do not.
fn standing(body: &Body, way: f64) -> Stance {
    let mut stance = idle::at(body, 0.0);
    let away = smooth(0.0, 0.35, way) * smooth(1.0, 0.6, way);
    for arm in &mut stance.arms {
        arm.swing_rad += 0.05 * away;
        arm.elbow_rad += 0.14 * away;
        arm.curl_rad += 0.18 * away;
    }
    stance
}

/// Returns a sine of whole cycles per loop, at a phase from 0 to 1. `late` is a delay in cycles.
fn wave(phase: f64, cycles: f64, late: f64) -> f64 {
    (TAU * (cycles * phase - late)).sin()
}
