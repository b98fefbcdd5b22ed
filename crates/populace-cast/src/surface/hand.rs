//! Surface of the hands: a palm with four fingers, and a thumb at its front.

use glam::DVec3;

use super::wrist::{self, AROUND, on_arm};
use super::{Region, Surface, Weights, chain};
use crate::anatomy::{Body, FINGER_AT, FINGERS, KNUCKLE, KNUCKLES, Limb, PALM, Side, WRIST};

/// Distance from the shoulder, half breadth and half depth of each ring of the palm, as fractions
/// of the body's height.
const RINGS: [[f64; 3]; 3] =
    [[0.332, 0.0205, 0.0118], [0.356, 0.0245, 0.0112], [0.380, PALM, 0.0085]];
/// Points of a palm ring from which the thumb grows: on the palm, in front, on the back.
const THUMB: [usize; 3] = [10, 11, 0];
/// Cross-section of a finger: two points on the back of the hand, one between fingers, two on the
/// palm, one between fingers. Offsets across and outwards from the axis, in units of the radius.
const HEXAGON: [[f64; 2]; 6] =
    [[0.55, 0.85], [-0.55, 0.85], [-1.0, 0.0], [-0.55, -0.85], [0.55, -0.85], [1.0, 0.0]];
/// Radius of a finger at its root, as a fraction of the body's height.
const FINGER_RADIUS: f64 = 0.0047;

pub(super) fn build(surface: &mut Surface, body: &Body, side: Side, wrist: &[usize]) {
    let mirrored = side == Side::Left;
    let mut last = wrist.to_vec();
    for (row, &[at, breadth, depth]) in RINGS.iter().enumerate() {
        let next: Vec<usize> = (0..AROUND)
            .map(|k| {
                let [across, out] = flat(k);
                let position = on_arm(body, at, breadth * across, depth * out);
                surface.point(side.mirror_point(position), weights(side, at))
            })
            .collect();
        if row == 1 {
            with_thumb(surface, body, side, [&last, &next]);
        } else {
            surface.bridge(&last, &next, Region::Skin, mirrored);
        }
        last = next;
    }
    fingers(surface, body, side, &last);
}

/// Returns point `k` of a flattened ring: its offsets across the palm, from -1 in front to 1
/// behind, and outwards, from -1 on the palm to 1 on the back of the hand.
fn flat(k: usize) -> [f64; 2] {
    let across = [-0.86, -0.44, 0.0, 0.44, 0.86];
    match k {
        0..=4 => [across[k], 1.0 - 0.25 * across[k].powi(2)],
        5 => [1.0, 0.0],
        6..=10 => [across[10 - k], -1.0 + 0.25 * across[10 - k].powi(2)],
        _ => [-1.0, 0.0],
    }
}

fn weights(side: Side, at: f64) -> Weights {
    let segments = [Limb::Forearm, Limb::Hand].map(|limb| limb.of(side));
    chain(at, &segments, &[(WRIST, wrist::BLEND)])
}

/// Adds the band of the palm between two rings, and the thumb that grows out of it.
fn with_thumb(surface: &mut Surface, body: &Body, side: Side, [low, high]: [&[usize]; 2]) {
    let mirrored = side == Side::Left;
    for k in 0..AROUND {
        let next = (k + 1) % AROUND;
        if !(THUMB[0]..=THUMB[1]).contains(&k) {
            let [a, b, c, d] = [low[k], low[next], high[next], high[k]];
            surface.quad(
                if mirrored { [b, a, d, c] } else { [a, b, c, d] },
                Region::Skin,
                mirrored,
            );
        }
    }
    let [inner, front, outer] = THUMB;
    let mut last = vec![low[inner], low[front], low[outer], high[outer], high[front], high[inner]];
    // The thumb is built on the left; `mirror_point` is its own inverse.
    let center = last.iter().map(|&p| side.mirror_point(surface.points[p])).sum::<DVec3>() / 6.0;
    let dir = body.thumb;
    let spokes: Vec<DVec3> = last
        .iter()
        .map(|&p| {
            let spoke = side.mirror_point(surface.points[p]) - center;
            (spoke - dir * spoke.dot(dir)).normalize()
        })
        .collect();
    let root = body.joint(Limb::Finger(0, 0), Side::Left);
    let tip = 0.066;
    for (at, radius) in [(0.024, 0.0078), (0.045, 0.0066), (0.061, 0.0046)] {
        let middle = root + dir * at * body.height;
        let next: Vec<usize> = spokes
            .iter()
            .map(|spoke| {
                let position = middle + *spoke * radius * body.height;
                surface.point(side.mirror_point(position), thumb_weights(side, at))
            })
            .collect();
        surface.bridge(&last, &next, Region::Skin, mirrored);
        last = next;
    }
    let end =
        surface.point(side.mirror_point(root + dir * tip * body.height), thumb_weights(side, tip));
    surface.cap(&last, end, Region::Skin, mirrored);
}

fn thumb_weights(side: Side, at: f64) -> Weights {
    let segments = [Limb::Hand, Limb::Finger(0, 0), Limb::Finger(0, 1), Limb::Finger(0, 2)]
        .map(|limb| limb.of(side));
    chain(at, &segments, &[(0.010, 0.015), (0.028, 0.006), (0.049, 0.006)])
}

fn fingers(surface: &mut Surface, body: &Body, side: Side, palm: &[usize]) {
    let mirrored = side == Side::Left;
    let mut webs = vec![palm[11]];
    for web in 1..4 {
        let middle = 0.5 * (surface.points[palm[web]] + surface.points[palm[10 - web]]);
        let position = middle + side.mirror_point(body.along) * 0.004 * body.height;
        webs.push(surface.point(position, weights(side, 0.4)));
    }
    webs.push(palm[5]);
    for finger in 0..4 {
        let (back, inside) = (palm[10 - finger], palm[9 - finger]);
        let mut last =
            vec![palm[finger], palm[finger + 1], webs[finger + 1], inside, back, webs[finger]];
        let length = FINGERS[finger];
        for (at, radius) in [(0.45, 0.98), (0.88, 0.72)] {
            let next: Vec<usize> = HEXAGON
                .iter()
                .map(|&[across, out]| {
                    let radius = FINGER_RADIUS * radius * if finger == 3 { 0.88 } else { 1.0 };
                    let position = on_arm(
                        body,
                        KNUCKLE + at * length,
                        -(KNUCKLES[finger] * PALM + radius * across),
                        radius * 1.05 * out,
                    );
                    surface.point(side.mirror_point(position), finger_weights(side, finger, at))
                })
                .collect();
            surface.bridge(&last, &next, Region::Skin, mirrored);
            last = next;
        }
        let tip = on_arm(body, KNUCKLE + 1.02 * length, -KNUCKLES[finger] * PALM, -0.001);
        let end = surface.point(side.mirror_point(tip), finger_weights(side, finger, 1.0));
        surface.cap(&last, end, Region::Skin, mirrored);
    }
}

fn finger_weights(side: Side, finger: usize, at: f64) -> Weights {
    let joints = [0, 1, 2].map(|joint| Limb::Finger(finger + 1, joint).of(side));
    let segments = [Limb::Hand.of(side), joints[0], joints[1], joints[2]];
    chain(at, &segments, &[(0.06, 0.16), (FINGER_AT[1], 0.12), (FINGER_AT[2], 0.1)])
}
