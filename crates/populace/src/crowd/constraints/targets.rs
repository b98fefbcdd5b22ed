//! Targets of constraints: fades between them, and the identity of a constraint.

use std::mem::{Discriminant, discriminant};

use populace_device::layout::{self, LAYERS_PER_MEMBER};
use populace_device::{Constraint, Controls};
use populace_model::JointIndex;
use populace_settings::parts::WeightParts;

use crate::Gaze;

/// The most targets between which one constraint eases; the weakest is dropped.
const TARGETS: usize = LAYERS_PER_MEMBER as usize;

/// The identity of a constraint within a member: its kind, and the joint that faces or meets the
/// target.
pub(super) type Goal = (Discriminant<Constraint>, Option<JointIndex>);

/// Fades to one target from all others. If `follows` is set, the target replaces the previous one
/// of its kind.
pub(super) fn aim_at(
    targets: &mut Vec<layout::Target>,
    target: layout::Target,
    tick: u64,
    weight: WeightParts,
    follows: bool,
) {
    targets.retain(|target| !faded(target, tick));
    let alike = |old: &layout::Target| old.kind == target.kind && old.watched == target.watched;
    let same = targets.iter().position(|old| alike(old) && old.point == target.point);
    let at = same.or_else(|| targets.iter().position(|old| follows && alike(old) && !leaves(old)));
    let before = at.map_or(target, |at| targets.remove(at));
    for old in targets.iter_mut() {
        *old = old.ramped_to(tick, 0.0, weight.secs);
    }
    if targets.len() == TARGETS {
        let weakest = (0..TARGETS)
            .min_by(|a, b| targets[*a].ramp_at(tick).total_cmp(&targets[*b].ramp_at(tick)));
        targets.remove(weakest.unwrap_or(0));
    }
    let taking = layout::Target { point: target.point, ..before };
    targets.push(taking.ramped_to(tick, weight.value, weight.secs));
}

/// Returns whether a target's weight ends at 0.
pub(super) fn leaves(target: &layout::Target) -> bool {
    target.end_weight <= 0.0
}

/// Returns whether a target's weight has reached 0 for good.
pub(super) fn faded(target: &layout::Target, tick: u64) -> bool {
    leaves(target) && target.ramp_at(tick) <= 0.0
}

/// Returns a gaze without targets.
pub(super) fn gaze_of(gaze: Gaze) -> Constraint {
    let Gaze { chain, facing, limits } = gaze;
    Constraint::Gaze(populace_device::Gaze { chain, facing, limits, targets: Vec::new() })
}

pub(super) fn goal_of(constraint: &Constraint) -> Goal {
    let end = match constraint {
        Constraint::Gaze(gaze) => gaze.chain.last().map(|(joint, _)| *joint),
        Constraint::Limb(limb) => Some(limb.end),
        Constraint::Chain(chain) => Some(chain.end),
        Constraint::Feet(_) => None,
    };
    (discriminant(constraint), end)
}

/// Removes constraints whose targets have all faded out.
pub(super) fn forget_faded(controls: &mut Controls, tick: u64) {
    controls.constraints.retain_mut(|constraint| {
        let stays = matches!(constraint, Constraint::Feet(_));
        stays || targets_of(constraint).iter().any(|target| !faded(target, tick))
    });
}

pub(super) fn targets_of(constraint: &mut Constraint) -> &mut [layout::Target] {
    match constraint {
        Constraint::Gaze(gaze) => &mut gaze.targets,
        Constraint::Limb(limb) => &mut limb.targets,
        Constraint::Chain(chain) => &mut chain.targets,
        Constraint::Feet(_) => &mut [],
    }
}

pub(super) fn set_targets(constraint: &mut Constraint, targets: Vec<layout::Target>) {
    match constraint {
        Constraint::Gaze(gaze) => gaze.targets = targets,
        Constraint::Limb(limb) => limb.targets = targets,
        Constraint::Chain(chain) => chain.targets = targets,
        Constraint::Feet(_) => {}
    }
}
