//! Getting up from the left side: rolling onto all fours.

use super::{HAND, TUCKED};
use crate::motion::get_up::key::{Foot, Hand, Key};

const LOWER_HAND: Hand = Hand {
    at: [-0.22, 0.0, 0.16],
    turn: [-70.0, 0.0, 60.0],
    elbow: [-0.6, 0.0, -0.6],
    curl: 0.35,
    hang: 0.0,
};
const UPPER_HAND: Hand = Hand {
    at: [0.12, 0.0, 0.05],
    turn: [-20.0, 0.0, 0.0],
    elbow: [0.6, 0.8, -0.6],
    curl: 0.25,
    hang: 0.0,
};
const LOWER_FOOT: Foot =
    Foot { at: [-0.02, 0.0, -0.52], turn: [0.0, -120.0, 0.0], knee: [-1.0, 0.0, -0.1] };
const UPPER_FOOT: Foot =
    Foot { at: [0.06, 0.0, -0.54], turn: [0.0, -120.0, 0.0], knee: [1.0, 0.0, 0.2] };
const LIE: Key = Key {
    secs: 0.0,
    pelvis: [0.05, 0.0, -0.20],
    turn: [90.0, -82.0, 0.0],
    chest: [8.0, 0.0, 6.0],
    head: [8.0, -14.0, 0.0],
    hands: [LOWER_HAND, UPPER_HAND],
    feet: [LOWER_FOOT, UPPER_FOOT],
};
const STILL: Key = Key { secs: 0.2, ..LIE };
const ROLL: Key = Key {
    secs: 0.7,
    pelvis: [0.04, 0.0, -0.22],
    turn: [86.0, -50.0, 0.0],
    chest: [4.0, 4.0, 10.0],
    head: [-6.0, 0.0, 10.0],
    hands: [Hand { at: [-0.02, 0.0, 0.12], turn: [-50.0, 0.0, 20.0], ..LOWER_HAND }, UPPER_HAND],
    feet: [
        Foot { at: [-0.03, 0.0, -0.50], turn: [0.0, -105.0, 20.0], knee: [-0.8, -0.4, 0.4] },
        Foot { at: [0.03, 0.0, -0.50], turn: [0.0, -105.0, 30.0], knee: [0.8, -0.3, 0.6] },
    ],
};
const PUSH: Key = Key {
    secs: 1.2,
    pelvis: [0.015, 0.53, -0.235],
    turn: [83.0, -12.0, 0.0],
    chest: [2.0, 0.0, 4.0],
    head: [-14.0, 0.0, 0.0],
    hands: [Hand { at: [0.08, 0.01, 0.07], ..HAND }, HAND],
    feet: [Foot { knee: [-0.25, -0.7, 1.0], ..TUCKED }, TUCKED],
};

/// The keys up to all fours.
pub(super) const KEYS: [Key; 4] = [LIE, STILL, ROLL, PUSH];
