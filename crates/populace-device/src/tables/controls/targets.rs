//! New targets for a constraint program that stays as it is otherwise.

use super::compile::check_targets;
use super::write;
use crate::Error;
use crate::control::{Constraint, Controls};
use crate::layout::{NONE, Target};
use crate::tables::Tables;

impl Tables {
    /// Sets the controls of a member that differ from those `before` by their targets alone, and
    /// not by the number of targets of any constraint. Returns false, and changes nothing, if they
    /// differ by more; see [`set_controls`](Self::set_controls) then.
    ///
    /// # Errors
    ///
    /// As for [`set_controls`](Self::set_controls).
    pub fn set_targets(
        &mut self,
        member_index: u32,
        before: &Controls,
        controls: &Controls,
    ) -> Result<bool, Error> {
        let control = self.used_member(member_index)?.control;
        if control == NONE || !differ_by_targets(before, controls) {
            return Ok(false);
        }
        let targets: Vec<Target> =
            controls.constraints.iter().flat_map(targets_of).copied().collect();
        let (first, count) = self.control_spaces.runs[control as usize].targets;
        if count != targets.len() {
            return Ok(false);
        }
        check_targets(&targets)?;
        write(&mut self.all.targets, first, &targets);
        self.control_spaces.unchecked.insert(control);
        Ok(true)
    }
}

/// The targets of a constraint.
fn targets_of(constraint: &Constraint) -> &[Target] {
    match constraint {
        Constraint::Gaze(gaze) => &gaze.targets,
        Constraint::Limb(limb) => &limb.targets,
        Constraint::Chain(chain) => &chain.targets,
        Constraint::Feet(_) => &[],
    }
}

/// Returns whether two programs differ by the targets of gazes at most.
fn differ_by_targets(before: &Controls, now: &Controls) -> bool {
    let alike = |(before, now): (&Constraint, &Constraint)| match (before, now) {
        (Constraint::Gaze(before), Constraint::Gaze(now)) => {
            before.chain == now.chain
                && before.facing == now.facing
                && before.limits == now.limits
                && before.targets.len() == now.targets.len()
        }
        _ => before == now,
    };
    before.constraints.len() == now.constraints.len()
        && before.constraints.iter().zip(&now.constraints).all(alike)
        && before.overrides == now.overrides
        && before.stages == now.stages
        && before.watches == now.watches
        && before.carries == now.carries
        && before.attached == now.attached
        && before.proportions == now.proportions
        && before.motion == now.motion
}
