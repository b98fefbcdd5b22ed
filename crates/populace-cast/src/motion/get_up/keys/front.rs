//! Getting up from the front: pressing up onto all fours.

use super::HAND;
use crate::motion::get_up::key::{Foot, Hand, Key};

const BESIDE: Hand =
    Hand { at: [0.19, 0.0, 0.09], turn: [-12.0, 0.0, 0.0], elbow: [1.0, 0.1, -0.6], ..HAND };
const BEHIND: Foot =
    Foot { at: [0.02, 0.0, -0.772], turn: [-6.0, -152.0, -6.0], knee: [0.25, -1.0, 0.0] };
const LIE: Key = Key {
    secs: 0.0,
    pelvis: [0.0, 0.0, -0.17],
    turn: [90.0, 0.0, 0.0],
    chest: [0.0; 3],
    head: [-8.0, 0.0, 22.0],
    hands: [Hand { curl: 0.3, ..BESIDE }; 2],
    feet: [BEHIND; 2],
};
const STILL: Key = Key { secs: 0.2, ..LIE };
const PRESS: Key = Key {
    secs: 0.6,
    pelvis: [0.0, 0.0, -0.18],
    turn: [84.0, 0.0, 0.0],
    chest: [-16.0, 0.0, 0.0],
    head: [-14.0, 0.0, 6.0],
    hands: [Hand { at: [0.17, 0.0, 0.08], ..BESIDE }; 2],
    ..LIE
};
const TUCK: Foot =
    Foot { at: [0.0, 0.0, -0.60], turn: [0.0, -110.0, 60.0], knee: [0.15, -1.0, 0.4] };
const RISE: Key = Key {
    secs: 0.95,
    pelvis: [0.0, 0.42, -0.20],
    turn: [80.0, 0.0, 0.0],
    chest: [-8.0, 0.0, 0.0],
    head: [-18.0, 0.0, 0.0],
    feet: [TUCK; 2],
    ..PRESS
};

/// The keys up to all fours, in which the hands stay where they press.
pub(super) const KEYS: [Key; 4] = [LIE, STILL, PRESS, RISE];
