//! Surface of the legs: rings from the crotch to the ankle, and over heel and sole to the tip of
//! the shoe.

use std::f64::consts::PI;

use glam::DVec3;

use super::{Region, Surface, Weights, chain, mixed};
use crate::Reach;
use crate::anatomy::{Body, Limb, PELVIS, Side, TOE_JOINT, TOE_TIP};

/// Points around a leg: thirteen on the outside, from front to back, and three on the inside.
const AROUND: usize = 16;
/// Ring at which short trousers end.
const KNEE_HEM: usize = 3;
/// Ring at which long trousers end.
const ANKLE_HEM: usize = 10;

/// Position of a ring between crotch (0) and ankle (1); half breadth, half depth, forward offset of
/// its centre and distance of cloth from the skin, as fractions of the body's height.
const RINGS: [[f64; 5]; 12] = [
    [0.050, 0.0470, 0.0560, -0.004, 0.002],
    [0.210, 0.0430, 0.0500, 0.003, 0.002],
    [0.365, 0.0370, 0.0410, 0.006, 0.003],
    [0.395, 0.0360, 0.0395, 0.006, 0.005],
    [0.412, 0.0352, 0.0385, 0.006, 0.003],
    [0.445, 0.0345, 0.0375, 0.005, 0.003],
    [0.478, 0.0335, 0.0370, 0.002, 0.003],
    [0.600, 0.0330, 0.0370, -0.006, 0.003],
    [0.720, 0.0285, 0.0315, -0.007, 0.006],
    [0.940, 0.0200, 0.0230, -0.010, 0.013],
    [0.985, 0.0195, 0.0235, -0.011, 0.015],
    [0.990, 0.0195, 0.0235, -0.012, 0.000],
];

/// Height and distance before the ankle of a ring's upper edge, the same of its lower edge, and its
/// half breadth, in metres for a foot of scale 1. From the third ring on, the lower edge is the
/// sole.
const FOOT: [[f64; 5]; 8] = [
    [0.086, 0.052, 0.064, -0.052, 0.0345],
    [0.078, 0.066, 0.020, -0.056, 0.0355],
    [0.072, 0.078, 0.000, -0.040, 0.0360],
    [0.058, 0.104, 0.000, 0.055, 0.0400],
    [0.044, 0.140, 0.000, 0.130, 0.0480],
    [0.039, 0.160, 0.000, 0.157, 0.0470],
    [0.033, 0.183, 0.000, 0.183, 0.0400],
    [0.024, 0.200, 0.002, 0.198, 0.0260],
];

pub(super) fn build(surface: &mut Surface, body: &Body, side: Side, opening: &[usize]) {
    let mirrored = side == Side::Left;
    let mut last = opening.to_vec();
    let hem = if body.look.trouser_legs == Reach::Short { KNEE_HEM } else { ANKLE_HEM };
    for row in 0..RINGS.len() {
        let next = ring(surface, body, side, row);
        let region = if row <= hem { Region::Trousers } else { Region::Skin };
        surface.bridge(&last, &next, region, mirrored);
        last = next;
    }
    for row in 0..FOOT.len() {
        let next = foot_ring(surface, body, side, row);
        surface.bridge(&last, &next, Region::Shoes, mirrored);
        last = next;
    }
    let ankle = body.joint(Limb::Foot, side);
    let tip = DVec3::new(ankle.x, 0.012 * body.foot, ankle.z + TOE_TIP * body.foot);
    let end = surface.point(tip, foot_weights(side, TOE_TIP, 0.0));
    surface.cap(&last, end, Region::Shoes, mirrored);
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
    let short = body.look.trouser_legs == Reach::Short;
    let ease = match (short, row) {
        (true, r) if r > KNEE_HEM => 0.0,
        (true, _) => 0.004,
        (false, _) => ease,
    };
    let girth = body.look.limbs + (1.0 - body.look.limbs) * 0.6 * q;
    // The breadth of thighs is limited, so that they do not pass through each other.
    let breadth = (breadth * girth).min(0.98 * x / h - ease + 0.012 * q);
    (0..AROUND)
        .map(|k| {
            let (sin, cos) = angle(k).sin_cos();
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
            let up = 0.5 + 0.5 * (1.3 * cos).clamp(-1.0, if row < 2 { 1.0 } else { 0.97 });
            let x = breadth * sin.signum() * sin.abs().powf(0.75);
            let (y, z) = (sole_y + up * (top_y - sole_y), sole_z + up * (top_z - sole_z));
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
