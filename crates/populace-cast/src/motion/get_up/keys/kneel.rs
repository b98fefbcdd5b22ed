//! From all fours to standing: the right foot steps to the hands, the trunk rises over the left
//! knee, and the left foot follows.

use super::{HAND, HOME, STAND, TUCKED};
use crate::motion::get_up::key::{Foot, Hand, Key};

const ALL_FOURS: Key = Key {
    secs: 0.0,
    pelvis: [0.0, 0.53, -0.235],
    turn: [84.0, 0.0, 0.0],
    chest: [4.0, 0.0, 0.0],
    head: [-18.0, 0.0, 0.0],
    hands: [HAND; 2],
    feet: [TUCKED; 2],
};
const STEP: Key = Key {
    secs: 0.32,
    pelvis: [0.02, 0.54, -0.225],
    turn: [82.0, 0.0, 0.0],
    chest: [8.0, 0.0, 0.0],
    feet: [
        TUCKED,
        Foot { at: [0.035, 0.05, -0.2], turn: [8.0, -30.0, 10.0], knee: [0.6, 0.5, 1.0] },
    ],
    ..ALL_FOURS
};
const PLANTED: Key = Key {
    secs: 0.6,
    pelvis: [0.015, 0.55, -0.205],
    turn: [78.0, 0.0, 0.0],
    chest: [14.0, 0.0, 0.0],
    head: [-22.0, 0.0, 0.0],
    feet: [TUCKED, HOME],
    ..STEP
};
const THIGH: Hand = Hand {
    at: [0.09, 0.25, 0.0],
    turn: [-20.0, -10.0, 0.0],
    elbow: [0.7, 0.0, -1.0],
    curl: 0.3,
    hang: 0.0,
};
const KNEEL: Key = Key {
    secs: 1.05,
    pelvis: [0.01, 0.56, -0.20],
    turn: [26.0, 0.0, 0.0],
    chest: [18.0, 0.0, 0.0],
    head: [-10.0, 0.0, 0.0],
    hands: [Hand { hang: 0.8, ..THIGH }, THIGH],
    ..PLANTED
};
const PUSH: Key = Key {
    secs: 1.45,
    pelvis: [-0.005, 0.76, -0.10],
    turn: [26.0, 0.0, 0.0],
    chest: [14.0, 0.0, 0.0],
    hands: [Hand { hang: 1.0, ..THIGH }, Hand { at: [0.09, 0.28, 0.0], hang: 0.3, ..THIGH }],
    feet: [Foot { at: [0.0, 0.0, -0.45], turn: [0.0, -62.0, 56.0], knee: [0.1, -0.2, 1.0] }, HOME],
    ..KNEEL
};
const SWING: Key = Key {
    secs: 1.75,
    pelvis: [-0.012, 0.95, -0.02],
    turn: [10.0, 0.0, 0.0],
    chest: [6.0, 0.0, 0.0],
    head: [-4.0, 0.0, 0.0],
    hands: STAND.hands,
    feet: [Foot { at: [0.0, 0.035, -0.16], turn: [0.0, -30.0, 6.0], knee: [0.1, 0.0, 1.0] }, HOME],
};
const UP: Key = Key { secs: 2.05, pelvis: [-0.004, 0.995, 0.0], turn: [2.0, 0.0, 0.0], ..STAND };
const END: Key = Key { secs: 2.35, ..STAND };
/// The keys, the first of them at 0 seconds.
pub(super) const KEYS: [Key; 8] = [ALL_FOURS, STEP, PLANTED, KNEEL, PUSH, SWING, UP, END];
