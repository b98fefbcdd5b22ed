//! Key poses of getting up, in fractions of the body's height and degrees.

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

/// Returns the keys of getting up from the back: over sitting and squatting.
pub(super) fn back() -> Vec<Key> {
    let beside = Hand {
        at: [0.20, 0.0, -0.31],
        turn: [12.0, 0.0, 0.0],
        elbow: [1.0, -0.3, -0.2],
        curl: 0.35,
        hang: 0.0,
    };
    let stretched =
        Foot { at: [0.03, 0.0, 0.172], turn: [18.0, 58.0, -8.0], knee: [0.35, 1.0, 0.3] };
    let lie = Key {
        secs: 0.0,
        pelvis: [0.0, 0.0, -0.31],
        turn: [-90.0, 0.0, 0.0],
        chest: [0.0; 3],
        head: [4.0, 0.0, 0.0],
        hands: [beside; 2],
        feet: [stretched; 2],
    };
    let still = Key { secs: 0.2, ..lie };
    let bent = |lift: f64, z: f64| Foot {
        at: [0.01, lift, z],
        turn: [8.0, 14.0, 0.0],
        knee: [0.2, 1.0, 0.5],
    };
    let curl = Key {
        secs: 0.6,
        turn: [-78.0, 0.0, 0.0],
        chest: [22.0, 0.0, 0.0],
        head: [26.0, 0.0, 0.0],
        feet: [bent(0.012, 0.09), Foot { at: [0.03, 0.0, 0.165], ..stretched }],
        ..lie
    };
    let behind = Hand {
        at: [0.175, 0.0, -0.435],
        turn: [50.0, 0.0, 0.0],
        elbow: [0.6, 0.3, -1.0],
        curl: 0.1,
        hang: 0.0,
    };
    let seat = Foot { knee: [0.2, 1.0, 0.4], ..HOME };
    let prop = Key {
        secs: 1.05,
        pelvis: [0.0, 0.0, -0.30],
        turn: [-48.0, 0.0, 0.0],
        chest: [26.0, 0.0, 0.0],
        head: [18.0, 0.0, 0.0],
        hands: [behind; 2],
        feet: [seat, bent(0.012, 0.08)],
    };
    let sit = Key {
        secs: 1.5,
        pelvis: [0.0, 0.0, -0.285],
        turn: [-18.0, 0.0, 0.0],
        chest: [24.0, 0.0, 0.0],
        head: [4.0, 0.0, 0.0],
        feet: [seat; 2],
        ..prop
    };
    let reach = Hand {
        at: [0.12, 0.17, 0.04],
        turn: [-8.0, -15.0, 30.0],
        elbow: [0.8, -0.3, -0.8],
        curl: 0.3,
        hang: 0.0,
    };
    let leave = Hand { at: [0.18, 0.05, -0.26], turn: [15.0, -10.0, 10.0], curl: 0.2, ..behind };
    let lean = Key {
        secs: 2.0,
        pelvis: [0.0, 0.0, -0.255],
        turn: [14.0, 0.0, 0.0],
        chest: [32.0, 0.0, 0.0],
        head: [-14.0, 0.0, 0.0],
        hands: [Hand { at: [0.15, 0.14, -0.06], ..reach }, leave],
        ..sit
    };
    let squat = Key {
        secs: 2.35,
        pelvis: [0.0, 0.36, -0.16],
        turn: [38.0, 0.0, 0.0],
        chest: [26.0, 0.0, 0.0],
        head: [-24.0, 0.0, 0.0],
        hands: [reach; 2],
        feet: [Foot { knee: [0.2, 0.5, 1.0], ..HOME }; 2],
        ..lean
    };
    let rise = Key {
        secs: 2.8,
        pelvis: [0.0, 0.72, -0.07],
        turn: [30.0, 0.0, 0.0],
        chest: [16.0, 0.0, 0.0],
        head: [-14.0, 0.0, 0.0],
        hands: [Hand { hang: 0.85, at: [0.13, 0.3, 0.08], ..reach }; 2],
        feet: [HOME; 2],
        ..squat
    };
    let up = Key { secs: 3.25, pelvis: [0.0, 0.98, -0.004], turn: [4.0, 0.0, 0.0], ..STAND };
    vec![lie, still, curl, prop, sit, lean, squat, rise, up, Key { secs: 3.6, ..STAND }]
}

/// A foot whose toes are tucked under behind the knee of that leg.
const TUCKED: Foot =
    Foot { at: [0.0, 0.0, -0.47], turn: [0.0, -78.0, 70.0], knee: [0.1, -0.7, 1.0] };

/// Returns the keys from all fours to standing: the right foot steps to the hands, the trunk rises
/// over the left knee, and the left foot follows.
fn from_all_fours(start_secs: f64) -> Vec<Key> {
    let all_fours = Key {
        secs: start_secs,
        pelvis: [0.0, 0.53, -0.235],
        turn: [84.0, 0.0, 0.0],
        chest: [4.0, 0.0, 0.0],
        head: [-18.0, 0.0, 0.0],
        hands: [HAND; 2],
        feet: [TUCKED; 2],
    };
    let step = Key {
        secs: start_secs + 0.32,
        pelvis: [0.02, 0.54, -0.225],
        turn: [82.0, 0.0, 0.0],
        chest: [8.0, 0.0, 0.0],
        feet: [
            TUCKED,
            Foot { at: [0.035, 0.05, -0.2], turn: [8.0, -30.0, 10.0], knee: [0.6, 0.5, 1.0] },
        ],
        ..all_fours
    };
    let planted = Key {
        secs: start_secs + 0.6,
        pelvis: [0.015, 0.55, -0.205],
        turn: [78.0, 0.0, 0.0],
        chest: [14.0, 0.0, 0.0],
        head: [-22.0, 0.0, 0.0],
        feet: [TUCKED, HOME],
        ..step
    };
    let thigh = Hand {
        at: [0.09, 0.25, 0.0],
        turn: [-20.0, -10.0, 0.0],
        elbow: [0.7, 0.0, -1.0],
        curl: 0.3,
        hang: 0.0,
    };
    let kneel = Key {
        secs: start_secs + 1.05,
        pelvis: [0.01, 0.56, -0.20],
        turn: [26.0, 0.0, 0.0],
        chest: [18.0, 0.0, 0.0],
        head: [-10.0, 0.0, 0.0],
        hands: [Hand { hang: 0.8, ..thigh }, thigh],
        ..planted
    };
    let push = Key {
        secs: start_secs + 1.45,
        pelvis: [-0.005, 0.76, -0.10],
        turn: [26.0, 0.0, 0.0],
        chest: [14.0, 0.0, 0.0],
        hands: [Hand { hang: 1.0, ..thigh }, Hand { at: [0.09, 0.28, 0.0], hang: 0.3, ..thigh }],
        feet: [
            Foot { at: [0.0, 0.0, -0.45], turn: [0.0, -62.0, 56.0], knee: [0.1, -0.2, 1.0] },
            HOME,
        ],
        ..kneel
    };
    let swing = Key {
        secs: start_secs + 1.75,
        pelvis: [-0.012, 0.95, -0.02],
        turn: [10.0, 0.0, 0.0],
        chest: [6.0, 0.0, 0.0],
        head: [-4.0, 0.0, 0.0],
        hands: STAND.hands,
        feet: [
            Foot { at: [0.0, 0.035, -0.16], turn: [0.0, -30.0, 6.0], knee: [0.1, 0.0, 1.0] },
            HOME,
        ],
    };
    let up = Key {
        secs: start_secs + 2.05,
        pelvis: [-0.004, 0.995, 0.0],
        turn: [2.0, 0.0, 0.0],
        ..STAND
    };
    let stand = Key { secs: start_secs + 2.35, ..STAND };
    vec![all_fours, step, planted, kneel, push, swing, up, stand]
}

/// Returns the keys of getting up from the front: over all fours and one knee.
pub(super) fn front() -> Vec<Key> {
    let beside =
        Hand { at: [0.19, 0.0, 0.09], turn: [-12.0, 0.0, 0.0], elbow: [1.0, 0.1, -0.6], ..HAND };
    let behind =
        Foot { at: [0.02, 0.0, -0.772], turn: [-6.0, -152.0, -6.0], knee: [0.25, -1.0, 0.0] };
    let lie = Key {
        secs: 0.0,
        pelvis: [0.0, 0.0, -0.17],
        turn: [90.0, 0.0, 0.0],
        chest: [0.0; 3],
        head: [-8.0, 0.0, 22.0],
        hands: [Hand { curl: 0.3, ..beside }; 2],
        feet: [behind; 2],
    };
    let still = Key { secs: 0.2, ..lie };
    let press = Key {
        secs: 0.6,
        pelvis: [0.0, 0.0, -0.18],
        turn: [84.0, 0.0, 0.0],
        chest: [-16.0, 0.0, 0.0],
        head: [-14.0, 0.0, 6.0],
        hands: [Hand { at: [0.17, 0.0, 0.08], ..beside }; 2],
        ..lie
    };
    let tuck = Foot { at: [0.0, 0.0, -0.60], turn: [0.0, -110.0, 60.0], knee: [0.15, -1.0, 0.4] };
    let rise = Key {
        secs: 0.95,
        pelvis: [0.0, 0.42, -0.20],
        turn: [80.0, 0.0, 0.0],
        chest: [-8.0, 0.0, 0.0],
        head: [-18.0, 0.0, 0.0],
        feet: [tuck; 2],
        ..press
    };
    let hands = press.hands;
    let mut keys = vec![lie, still, press, rise];
    keys.extend(from_all_fours(1.3));
    for key in &mut keys[4..7] {
        key.hands = hands;
    }
    keys
}

/// Returns the keys of getting up from the left side: rolling onto all fours.
pub(super) fn left_side() -> Vec<Key> {
    let mut keys = Vec::new();
    let lower_hand = Hand {
        at: [-0.22, 0.0, 0.16],
        turn: [-70.0, 0.0, 60.0],
        elbow: [-0.6, 0.0, -0.6],
        curl: 0.35,
        hang: 0.0,
    };
    let upper_hand = Hand {
        at: [0.12, 0.0, 0.05],
        turn: [-20.0, 0.0, 0.0],
        elbow: [0.6, 0.8, -0.6],
        curl: 0.25,
        hang: 0.0,
    };
    let lower_foot =
        Foot { at: [-0.02, 0.0, -0.52], turn: [0.0, -120.0, 0.0], knee: [-1.0, 0.0, -0.1] };
    let upper_foot =
        Foot { at: [0.06, 0.0, -0.54], turn: [0.0, -120.0, 0.0], knee: [1.0, 0.0, 0.2] };
    let lie = Key {
        secs: 0.0,
        pelvis: [0.05, 0.0, -0.20],
        turn: [90.0, -82.0, 0.0],
        chest: [8.0, 0.0, 6.0],
        head: [8.0, -14.0, 0.0],
        hands: [lower_hand, upper_hand],
        feet: [lower_foot, upper_foot],
    };
    keys.push(lie);
    keys.push(Key { secs: 0.2, ..lie });
    let roll = Key {
        secs: 0.7,
        pelvis: [0.04, 0.0, -0.22],
        turn: [86.0, -50.0, 0.0],
        chest: [4.0, 4.0, 10.0],
        head: [-6.0, 0.0, 10.0],
        hands: [
            Hand { at: [-0.02, 0.0, 0.12], turn: [-50.0, 0.0, 20.0], ..lower_hand },
            upper_hand,
        ],
        feet: [
            Foot { at: [-0.03, 0.0, -0.50], turn: [0.0, -105.0, 20.0], knee: [-0.8, -0.4, 0.4] },
            Foot { at: [0.03, 0.0, -0.50], turn: [0.0, -105.0, 30.0], knee: [0.8, -0.3, 0.6] },
        ],
    };
    keys.push(roll);
    let push = Key {
        secs: 1.2,
        pelvis: [0.015, 0.53, -0.235],
        turn: [83.0, -12.0, 0.0],
        chest: [2.0, 0.0, 4.0],
        head: [-14.0, 0.0, 0.0],
        hands: [Hand { at: [0.08, 0.01, 0.07], ..HAND }, HAND],
        feet: [Foot { knee: [-0.25, -0.7, 1.0], ..TUCKED }, TUCKED],
    };
    keys.push(push);
    keys.extend(from_all_fours(1.5));
    keys
}
