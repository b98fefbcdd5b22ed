//! Getting up from the back: over sitting and squatting.

use super::{HOME, STAND};
use crate::motion::get_up::key::{Foot, Hand, Key};

const BESIDE: Hand = Hand {
    at: [0.20, 0.0, -0.31],
    turn: [12.0, 0.0, 0.0],
    elbow: [1.0, -0.3, -0.2],
    curl: 0.35,
    hang: 0.0,
};
const STRETCHED: Foot =
    Foot { at: [0.03, 0.0, 0.172], turn: [18.0, 58.0, -8.0], knee: [0.35, 1.0, 0.3] };
const LIE: Key = Key {
    secs: 0.0,
    pelvis: [0.0, 0.0, -0.31],
    turn: [-90.0, 0.0, 0.0],
    chest: [0.0; 3],
    head: [4.0, 0.0, 0.0],
    hands: [BESIDE; 2],
    feet: [STRETCHED; 2],
};
const STILL: Key = Key { secs: 0.2, ..LIE };
const BENT: Foot = Foot { at: [0.01, 0.012, 0.09], turn: [8.0, 14.0, 0.0], knee: [0.2, 1.0, 0.5] };
const CURL: Key = Key {
    secs: 0.6,
    turn: [-78.0, 0.0, 0.0],
    chest: [22.0, 0.0, 0.0],
    head: [26.0, 0.0, 0.0],
    feet: [BENT, Foot { at: [0.03, 0.0, 0.165], ..STRETCHED }],
    ..LIE
};
const BEHIND: Hand = Hand {
    at: [0.175, 0.0, -0.435],
    turn: [50.0, 0.0, 0.0],
    elbow: [0.6, 0.3, -1.0],
    curl: 0.1,
    hang: 0.0,
};
const SEAT: Foot = Foot { knee: [0.2, 1.0, 0.4], ..HOME };
const PROP: Key = Key {
    secs: 1.05,
    pelvis: [0.0, 0.0, -0.30],
    turn: [-48.0, 0.0, 0.0],
    chest: [26.0, 0.0, 0.0],
    head: [18.0, 0.0, 0.0],
    hands: [BEHIND; 2],
    feet: [SEAT, Foot { at: [0.01, 0.012, 0.08], ..BENT }],
};
const SIT: Key = Key {
    secs: 1.5,
    pelvis: [0.0, 0.0, -0.285],
    turn: [-18.0, 0.0, 0.0],
    chest: [24.0, 0.0, 0.0],
    head: [4.0, 0.0, 0.0],
    feet: [SEAT; 2],
    ..PROP
};
const REACH: Hand = Hand {
    at: [0.12, 0.17, 0.04],
    turn: [-8.0, -15.0, 30.0],
    elbow: [0.8, -0.3, -0.8],
    curl: 0.3,
    hang: 0.0,
};
const LEAVE: Hand =
    Hand { at: [0.18, 0.05, -0.26], turn: [15.0, -10.0, 10.0], curl: 0.2, ..BEHIND };
const LEAN: Key = Key {
    secs: 2.0,
    pelvis: [0.0, 0.0, -0.255],
    turn: [14.0, 0.0, 0.0],
    chest: [32.0, 0.0, 0.0],
    head: [-14.0, 0.0, 0.0],
    hands: [Hand { at: [0.15, 0.14, -0.06], ..REACH }, LEAVE],
    ..SIT
};
const SQUAT: Key = Key {
    secs: 2.35,
    pelvis: [0.0, 0.36, -0.16],
    turn: [38.0, 0.0, 0.0],
    chest: [26.0, 0.0, 0.0],
    head: [-24.0, 0.0, 0.0],
    hands: [REACH; 2],
    feet: [Foot { knee: [0.2, 0.5, 1.0], ..HOME }; 2],
};
const RISE: Key = Key {
    secs: 2.8,
    pelvis: [0.0, 0.72, -0.07],
    turn: [30.0, 0.0, 0.0],
    chest: [16.0, 0.0, 0.0],
    head: [-14.0, 0.0, 0.0],
    hands: [Hand { hang: 0.85, at: [0.13, 0.3, 0.08], ..REACH }; 2],
    feet: [HOME; 2],
};
const UP: Key = Key { secs: 3.25, pelvis: [0.0, 0.98, -0.004], turn: [4.0, 0.0, 0.0], ..STAND };
/// The keys.
pub(super) const KEYS: [Key; 10] =
    [LIE, STILL, CURL, PROP, SIT, LEAN, SQUAT, RISE, UP, Key { secs: 3.6, ..STAND }];
