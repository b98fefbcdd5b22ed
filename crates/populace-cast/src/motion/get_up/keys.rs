//! Key poses of getting up, in fractions of the body's height and degrees.

mod back;
mod front;
mod kneel;
mod left;

use super::key::{Foot, Hand, Key};

/// A hand flat on the ground with the fingers forward.
const HAND: Hand = Hand {
    at: [0.12, 0.0, 0.05],
    turn: [0.0, 0.0, 0.0],
    elbow: [0.4, 0.0, -1.0],
    curl: 0.08,
    hang: 0.0,
};
/// A foot on the ground where it is at the end.
const HOME: Foot = Foot { at: [0.0; 3], turn: [0.0; 3], knee: [0.12, 0.0, 1.0] };
/// Standing as at the end.
const STAND: Key = Key {
    secs: 3.2,
    pelvis: [0.0, 1.0, 0.0],
    turn: [0.0; 3],
    chest: [1.0, 0.0, 0.0],
    head: [0.0; 3],
    hands: [Hand { hang: 1.0, at: [0.17, 0.42, 0.02], ..HAND }; 2],
    feet: [HOME; 2],
};

/// A foot whose toes are tucked under behind the knee of that leg.
const TUCKED: Foot =
    Foot { at: [0.0, 0.0, -0.47], turn: [0.0, -78.0, 70.0], knee: [0.1, -0.7, 1.0] };

/// Returns the keys of getting up from the back: over sitting and squatting.
pub(super) fn from_back() -> Vec<Key> {
    back::KEYS.to_vec()
}

/// Returns the keys of getting up from the front: over all fours and one knee.
pub(super) fn from_front() -> Vec<Key> {
    let mut keys = [front::KEYS.to_vec(), kneeling_after(1.3)].concat();
    let pressing = keys[2].hands;
    for key in &mut keys[4..7] {
        key.hands = pressing;
    }
    keys
}

/// Returns the keys of getting up from the left side: rolling onto all fours.
pub(super) fn from_left() -> Vec<Key> {
    [left::KEYS.to_vec(), kneeling_after(1.5)].concat()
}

/// Returns the keys from all fours to standing, the first of them at `secs`.
fn kneeling_after(secs: f64) -> Vec<Key> {
    kneel::KEYS.iter().map(|key| Key { secs: secs + key.secs, ..*key }).collect()
}
