//! Compiles a leg of planted feet: its chain from the pelvis to the toes, and its sole.

use populace_model::convert::u32_from;
use populace_model::{JointIndex, Skeleton, f64math};

use super::limb::{bad, float4, limb_links};
use crate::Error;
use crate::control::{Feet, Foot, in_joint, path};
use crate::fault::ConstraintFault;
use crate::layout::{self, Float4, Link, MAX_LINKS};
use crate::tables::soles::{SoleRun, Soles};

/// Fraction of a leg's length over which it straightens. It is small because clips of standing
/// people have almost straight legs.
const FOOT_SOFT: f32 = 0.005;
/// Ankle heights above rest, as fractions of the leg's length, for clips whose contacts are not
/// known. Up to `PLANTED` a foot is planted; from `LIFTED` on it follows only the clip.
const PLANTED: f32 = 0.03;
const LIFTED: f32 = 0.14;
/// Maximum lag of a foot behind the clip, as a fraction of the leg's length.
const HELD_BACK: f32 = 0.5;
/// Builds the constraint and the chain of one foot. The chain begins at the pelvis.
pub(super) fn foot_row(
    skeleton: &Skeleton,
    feet: &Feet,
    foot: &Foot,
    soles: &Soles,
) -> Result<(layout::Constraint, Vec<Link>), Error> {
    let legs = [foot.hip, foot.knee, foot.ankle];
    let (mut links, middle) = limb_links(skeleton, feet.pelvis, legs)?;
    let upper = links.iter().position(|link| link.joint == foot.hip.0).unwrap_or(0);
    if upper == 0 {
        let ankle = skeleton.name(foot.ankle).to_owned();
        return bad(ConstraintFault::LegAtPelvis { ankle });
    }
    let standing = skeleton.in_bind_pose();
    let [length, rest_height, middle_z] = f64math::to_f32([
        standing.leg_length_m(legs),
        standing.rest_place(foot.ankle).y,
        standing.middle_of_steps_z(legs),
    ]);
    let own = soles.of(foot.ankle).unwrap_or_default();
    let (toes, toe) = toes(skeleton, foot.ankle, soles);
    let fits = links.len() + toes.len() <= MAX_LINKS as usize;
    let (toes, toe) = if fits { (toes, toe) } else { (Vec::new(), SoleRun::default()) };
    links.extend(toes.iter().map(|joint| Link { joint: joint.0, share: 0.0 }));
    let height = if own.count + toe.count == 0 { rest_height } else { 0.0 };
    let row = layout::Constraint {
        axis: float4(in_joint(standing, Some(foot.hip), [0.0, 0.0, 1.0]), 0.0),
        up: Float4([rest_height, PLANTED * length, LIFTED * length, HELD_BACK * length]),
        limits: Float4([FOOT_SOFT, feet.weight, middle_z, height]),
        middle,
        upper: u32_from(upper),
        keeps_end: 1,
        sole_first: own.first,
        sole_count: own.count,
        toe_first: toe.first,
        toe_count: toe.count,
        toe_links: u32_from(toes.len()),
        ..layout::Constraint::default()
    };
    Ok((row, links))
}

/// Returns the joints below an ankle, down to the one whose sole reaches farthest forward, and the
/// points that this one carries.
fn toes(skeleton: &Skeleton, ankle: JointIndex, soles: &Soles) -> (Vec<JointIndex>, SoleRun) {
    let forward = |joint: JointIndex| {
        skeleton.soles(joint).iter().map(|point| point[2]).fold(f32::NEG_INFINITY, f32::max)
    };
    let carrying = skeleton.joints().filter_map(|joint| Some((joint, soles.of(joint)?)));
    let below = carrying.filter(|(joint, _)| skeleton.is_below(*joint, ankle));
    let farthest = below.max_by(|a, b| forward(a.0).total_cmp(&forward(b.0)));
    let Some((toe, run)) = farthest else { return (Vec::new(), SoleRun::default()) };
    match path(skeleton, ankle, toe) {
        Ok(joints) => (joints[1..].to_vec(), run),
        Err(_) => (Vec::new(), SoleRun::default()),
    }
}
