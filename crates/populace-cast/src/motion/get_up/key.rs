//! Key poses, and the smooth curves through them.

use crate::motion::curve::hermite;

/// Where a hand is while it is on the ground, and how its arm bends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hand {
    /// Position of the wrist: outwards, height of the hand's lowest point, and forwards, as
    /// fractions of the body's height.
    pub(super) at: [f64; 3],
    /// Direction of the fingers outwards from +Z, pitch of the fingers upwards, and roll. In
    /// degrees. The palm faces the ground if pitch and roll are 0.
    pub(super) turn: [f64; 3],
    /// Direction in which the elbow points: outwards, up, forwards.
    pub(super) elbow: [f64; 3],
    /// Flexion of the fingers in radians.
    pub(super) curl: f64,
    /// How much the arm hangs from the shoulder instead, from 0 to 1.
    pub(super) hang: f64,
}

/// Where a foot is, and how its leg bends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Position of the ball of the foot relative to where it is at the end: outwards, height of the
    /// sole's lowest point, and forwards, as fractions of the body's height.
    pub(super) at: [f64; 3],
    /// Yaw outwards relative to the end, pitch of the foot upwards, and pitch of the toes
    /// relative to the foot. In degrees.
    pub(super) turn: [f64; 3],
    /// Direction in which the knee points: outwards, up, forwards.
    pub(super) knee: [f64; 3],
}

/// A key pose. Angles are in degrees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Key {
    pub(super) secs: f64,
    /// Position of the pelvis: sideways and forwards relative to the end, as fractions of the
    /// body's height, and height as a fraction of that at the end. The ground lifts it as needed.
    pub(super) pelvis: [f64; 3],
    /// Pitch of the pelvis (0 upright, 90 face down), roll about its length, and yaw.
    pub(super) turn: [f64; 3],
    /// Flexion of the chest against the pelvis, bend to the right, and twist to the left.
    pub(super) chest: [f64; 3],
    /// Flexion of the head against the chest, tilt to the right, and turn to the left.
    pub(super) head: [f64; 3],
    /// Left and right.
    pub(super) hands: [Hand; 2],
    /// Left and right.
    pub(super) feet: [Foot; 2],
}

/// Numbers of a key pose besides its time.
const NUMBERS: usize = 52;

impl Key {
    fn numbers(&self) -> [f64; NUMBERS] {
        let mut numbers = [0.0; NUMBERS];
        let trunk = [self.pelvis, self.turn, self.chest, self.head];
        let hand = |h: &Hand| {
            let [at, turn, elbow] = [h.at, h.turn, h.elbow];
            at.into_iter().chain(turn).chain(elbow).chain([h.curl, h.hang]).collect::<Vec<_>>()
        };
        let foot = |f: &Foot| [f.at, f.turn, f.knee].concat();
        let all = trunk.concat().into_iter().chain(self.hands.iter().flat_map(hand));
        let all = all.chain(self.feet.iter().flat_map(foot));
        numbers.iter_mut().zip(all).for_each(|(number, value)| *number = value);
        numbers
    }

    fn from_numbers(secs: f64, numbers: &[f64; NUMBERS]) -> Self {
        let three = |at: usize| [numbers[at], numbers[at + 1], numbers[at + 2]];
        let hand = |at: usize| Hand {
            at: three(at),
            turn: three(at + 3),
            elbow: three(at + 6),
            curl: numbers[at + 9],
            hang: numbers[at + 10],
        };
        let foot = |at: usize| Foot { at: three(at), turn: three(at + 3), knee: three(at + 6) };
        Self {
            secs,
            pelvis: three(0),
            turn: three(3),
            chest: three(6),
            head: three(9),
            hands: [hand(12), hand(23)],
            feet: [foot(34), foot(43)],
        }
    }

    /// Returns the mirror image: left becomes right.
    pub(super) fn mirrored(mut self) -> Self {
        self.pelvis[0] = -self.pelvis[0];
        for turn in [&mut self.turn, &mut self.chest, &mut self.head] {
            turn[1] = -turn[1];
            turn[2] = -turn[2];
        }
        self.hands.reverse();
        self.feet.reverse();
        self
    }
}

/// Returns the pose at a time between the first and the last key. Every number follows a cubic
/// that is monotone between keys, so that what is at rest from one key to the next stays there.
/// [`curve::at`](crate::motion::curve::at) is the same for cycles.
pub(super) fn between(keys: &[Key], secs: f64) -> Key {
    let last = keys.len() - 1;
    let from = keys.iter().rposition(|key| key.secs <= secs).unwrap_or(0).min(last - 1);
    let width = keys[from + 1].secs - keys[from].secs;
    let t = ((secs - keys[from].secs) / width).clamp(0.0, 1.0);
    let around: Vec<_> = [from.saturating_sub(1), from, from + 1, (from + 2).min(last)]
        .iter()
        .map(|&key| (keys[key].secs, keys[key].numbers()))
        .collect();
    let number = |n: usize| {
        let secant = |a: usize| {
            let ((start, from), (end, to)) = (&around[a], &around[a + 1]);
            if end > start { (to[n] - from[n]) / (end - start) } else { 0.0 }
        };
        let slope = |before: f64, next: f64| {
            if before * next <= 0.0 { 0.0 } else { 2.0 * before * next / (before + next) }
        };
        let secants = [0, 1, 2].map(secant);
        let slopes = [0, 1].map(|s| slope(secants[s], secants[s + 1]) * width);
        hermite(t, [around[1].1[n], around[2].1[n]], slopes)
    };
    Key::from_numbers(secs, &std::array::from_fn(number))
}
