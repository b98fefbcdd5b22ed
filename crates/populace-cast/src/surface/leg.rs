//! Surface of the legs: rings from the crotch to the ankle, and over heel and sole to the tip of
//! the shoe.

use std::f64::consts::PI;

use glam::DVec3;

use super::covers::Covers;
use super::{Cover, Region, Surface, Weights, chain, mixed};
use crate::Bottom;
use crate::anatomy::{Body, Limb, PELVIS, Side, TOE_JOINT, TOE_TIP};

/// Points around a leg: thirteen on the outside, from front to back, and three on the inside.
const AROUND: usize = 16;
/// Ring at which short trousers end.
const KNEE_HEM: usize = 3;
/// Ring at which long trousers end.
const ANKLE_HEM: usize = 8;

/// Position of a ring between crotch (0) and ankle (1); half breadth, half depth, forward offset of
/// its centre and distance of cloth from the skin, as fractions of the body's height.
const RINGS: [[f64; 5]; 9] = [
    [0.050, 0.0470, 0.0560, -0.004, 0.002],
    [0.210, 0.0430, 0.0500, 0.003, 0.002],
    [0.365, 0.0370, 0.0410, 0.006, 0.003],
    [0.395, 0.0360, 0.0395, 0.006, 0.005],
    [0.468, 0.0338, 0.0372, 0.003, 0.003],
    [0.600, 0.0330, 0.0370, -0.006, 0.003],
    [0.720, 0.0285, 0.0315, -0.007, 0.006],
    [0.940, 0.0200, 0.0230, -0.010, 0.013],
    [0.985, 0.0195, 0.0235, -0.011, 0.015],
];

/// Height and distance before the ankle of a ring's upper edge, the same of its lower edge, and its
/// half breadth, in metres for a foot of scale 1. From the second ring on, the lower edge is the
/// sole.
const FOOT: [[f64; 5]; 6] = [
    [0.084, 0.056, 0.058, -0.054, 0.0350],
    [0.074, 0.074, 0.000, -0.050, 0.0360],
    [0.058, 0.104, 0.000, 0.055, 0.0400],
    [0.042, 0.146, 0.000, 0.140, 0.0485],
    [0.033, 0.183, 0.000, 0.183, 0.0400],
    [0.024, 0.200, 0.002, 0.198, 0.0260],
];

/// Points of a foot's ring that belong to the sole; the first and the last are its upper edge.
const SOLE: std::ops::RangeInclusive<usize> = 8..=13;
/// Height of a sole's upper edge, and how far it stands out, in metres for a foot of scale 1.
const SOLE_EDGE: [f64; 2] = [0.017, 0.0035];

pub(super) fn build(
    surface: &mut Surface,
    body: &Body,
    covers: &Covers,
    side: Side,
    opening: &[usize],
) {
    let mirrored = side == Side::Left;
    let mut last = opening.to_vec();
    let hem = match body.look.bottom {
        Bottom::Trousers => ANKLE_HEM,
        Bottom::Shorts => KNEE_HEM,
        Bottom::Skirt | Bottom::Dress => 0,
    };
    // Skirts hide the thighs.
    let hidden = if hem == 0 { 1..3 } else { 0..0 };
    for row in (0..RINGS.len()).filter(|row| !hidden.contains(row)) {
        let next = ring(surface, body, side, row);
        let cover = if row <= hem { covers.legs } else { Region::Skin.into() };
        surface.bridge(&last, &next, cover, mirrored);
        last = next;
    }
    for row in 0..FOOT.len() {
        let next = foot_ring(surface, body, side, row);
        for k in 0..AROUND {
            let next_k = (k + 1) % AROUND;
            let [a, b, c, d] = [last[k], last[next_k], next[next_k], next[k]];
            let corners = if mirrored { [b, a, d, c] } else { [a, b, c, d] };
            surface.quad(corners, shoe(body, row, k), mirrored);
        }
        last = next;
    }
    let ankle = body.joint(Limb::Foot, side);
    let tip = DVec3::new(ankle.x, 0.012 * body.foot, ankle.z + TOE_TIP * body.foot);
    let end = surface.point(tip, foot_weights(side, TOE_TIP, 0.0));
    for k in 0..AROUND {
        let [a, b] = [last[k], last[(k + 1) % AROUND]];
        let corners = if mirrored { [b, a, end] } else { [a, b, end] };
        surface.triangles.push((corners, shoe(body, FOOT.len(), k)));
    }
}

/// Returns the cover between the points `k` and `k + 1` below ring `row` of the foot: leather, or
/// the sole.
fn shoe(body: &Body, row: usize, k: usize) -> Cover {
    let sole = row > 1 && SOLE.contains(&k) && SOLE.contains(&(k + 1));
    let paint = if sole { body.look.sole_paint() } else { super::PLAIN };
    Cover { region: Region::Shoes, lift: 0.0, paint }
}

/// Returns the angle of point `k` of a ring in radians: 0 in front, a quarter turn on the outside.
fn angle(k: usize) -> f64 {
    let degrees = match k {
        0..=12 => -20.0 + 220.0 / 12.0 * k as f64,
        _ => [236.0, 270.0, 304.0][(k - 13) % 3],
    };
    degrees * PI / 180.0
}

fn ring(surface: &mut Surface, body: &Body, side: Side, row: usize) -> Vec<usize> {
    let [q, breadth, depth, forward, ease] = RINGS[row];
    let h = body.height;
    let ankle = body.joint(Limb::Foot, Side::Left);
    let crotch = body.trunk_y(-0.150);
    let y = crotch + q * (ankle.y - crotch);
    let x = 0.052 * h * body.look.hips * (1.0 - q) + ankle.x * q;
    let ease = match body.look.bottom {
        Bottom::Trousers => ease,
        Bottom::Shorts if row <= KNEE_HEM => 0.004,
        Bottom::Shorts | Bottom::Skirt | Bottom::Dress => 0.0,
    };
    let mut girth = body.look.limbs + (1.0 - body.look.limbs) * 0.6 * q;
    if matches!(body.look.bottom, Bottom::Skirt | Bottom::Dress) && row <= KNEE_HEM {
        // Under a skirt.
        girth *= 0.85;
    }
    // The breadth of thighs is limited, so that they do not pass through each other.
    let breadth = (breadth * girth).min(0.98 * x / h - ease + 0.012 * q);
    // On the outside they start no broader than the hips.
    let outer = breadth.min(0.0455 * body.look.hips + 0.05 * q);
    (0..AROUND)
        .map(|k| {
            let (sin, cos) = angle(k).sin_cos();
            let breadth = if sin > 0.0 { outer } else { breadth };
            let position = DVec3::new(
                x + (breadth + ease) * sin * h,
                y,
                ((depth * girth + ease) * cos + forward) * h,
            );
            surface.point(side.mirror_point(position), weights(body, side, position.y, q, sin))
        })
        .collect()
}

/// Returns the weights at height `y` of the ring at `q`. `outside` is 1 on the outside of the leg
/// and -1 on the inside.
fn weights(body: &Body, side: Side, y: f64, q: f64, outside: f64) -> Weights {
    let h = body.height;
    let knee = body.joint(Limb::Shin, side).y;
    let ankle = body.joint(Limb::Foot, side).y;
    let segments = [Limb::Thigh, Limb::Shin, Limb::Foot].map(|limb| limb.of(side));
    let leg = chain(-y, &segments, &[(-knee, 0.030 * h), (-ankle + 0.004 * h, 0.018 * h)]);
    let pelvis = (0.24 - 0.26 * outside.min(0.0)) * (1.0 - super::smooth(0.03, 0.16, q));
    mixed(leg, &[(PELVIS, 1.0)], pelvis)
}

fn foot_ring(surface: &mut Surface, body: &Body, side: Side, row: usize) -> Vec<usize> {
    let [top_y, top_z, sole_y, sole_z, breadth] = FOOT[row];
    let ankle = body.joint(Limb::Foot, Side::Left);
    (0..AROUND)
        .map(|k| {
            let (sin, cos) = angle(k).sin_cos();
            // The section is flat below, so that the sole is level, and has steep sides.
            let up = 0.5 + 0.5 * (1.3 * cos).clamp(-1.0, if row < 1 { 1.0 } else { 0.97 });
            let x = breadth * sin.signum() * sin.abs().powf(0.75);
            let (mut y, z) = (sole_y + up * (top_y - sole_y), sole_z + up * (top_z - sole_z));
            let mut x = x;
            if row >= 1 && SOLE.contains(&k) {
                let edge = k == *SOLE.start() || k == *SOLE.end();
                y = if edge { SOLE_EDGE[0].min(0.5 * top_y) } else { sole_y };
                x += SOLE_EDGE[1] * sin.signum();
            }
            let position = DVec3::new(ankle.x, 0.0, ankle.z) + DVec3::new(x, y, z) * body.foot;
            surface.point(side.mirror_point(position), foot_weights(side, z, y))
        })
        .collect()
}

/// Returns the weights of a point of the foot at `z` before the ankle and height `y`, in metres for
/// a foot of scale 1.
fn foot_weights(side: Side, z: f64, y: f64) -> Weights {
    let [_, toe] = TOE_JOINT;
    let segments = [Limb::Foot, Limb::Toes].map(|limb| limb.of(side));
    let foot = chain(z, &segments, &[(toe + 0.006, 0.022)]);
    mixed(foot, &[(Limb::Shin.of(side), 1.0)], 0.35 * super::smooth(0.055, 0.09, y))
}
