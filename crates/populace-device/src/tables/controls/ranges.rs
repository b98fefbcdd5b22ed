//! Checks that all indices of constraint programs lie within their tables.

use super::Tables;
use crate::Error;
use crate::layout::{
    Control, MAX_STAGES, MAX_STEP_ROTATIONS, NONE, STEP_ATTACH, STEP_CARRY, STEP_CHAIN, STEP_FOOT,
    STEP_GAZE, STEP_MOTION, STEP_OVERRIDE, STEP_PELVIS, STEP_REACH, STEP_ROTATION, STEP_STAGE,
    STEP_WATCH, Step, WATCHED_ELEMENTS,
};

impl Tables {
    /// Checks every range of every control, and every index within programs that changed since
    /// [`mark_clean`](Self::mark_clean). Takes time proportional to the number of controls, and
    /// none if no control changed.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if a range exceeds its table, which is a bug in the library. Devices
    /// must not follow it.
    pub fn check_ranges(&self) -> Result<(), Error> {
        let all = &self.all;
        let clean = all.controls.is_clean() && all.steps.is_clean() && all.overrides.is_clean();
        if clean && all.constraints.is_clean() && all.links.is_clean() && all.targets.is_clean() {
            return Ok(());
        }
        for (control, runs) in self.control_spaces.runs.iter().enumerate() {
            let shared = self.control_spaces.shared.runs(runs.program);
            for (table, (first, count), length) in [
                ("steps", shared.steps, all.steps.len()),
                ("overrides", runs.overrides, all.overrides.len()),
                ("constraints", shared.constraints, all.constraints.len()),
                ("links", shared.links, all.links.len()),
                ("targets", runs.targets, all.targets.len()),
                ("stage_values", runs.values, all.stage_values.len()),
            ] {
                within(table, control, first, count, length)?;
            }
        }
        self.control_spaces
            .unchecked
            .iter()
            .try_for_each(|control| self.check_program(*control as usize))
    }

    fn check_program(&self, control: usize) -> Result<(), Error> {
        let all = &self.all;
        let row: Control = all.controls.as_slice()[control];
        let steps = row.step_count as usize + row.pose_step_count as usize;
        within("steps", control, row.step_first as usize, steps, all.steps.len())?;
        within(
            "overrides",
            control,
            row.local_first as usize,
            row.local_count as usize,
            all.overrides.len(),
        )?;
        if row.scale_first != NONE {
            within("joint_scales", control, row.scale_first as usize, 1, all.joint_scales.len())?;
        }
        let steps = &all.steps.as_slice()[row.step_first as usize..][..steps];
        steps.iter().try_for_each(|step| self.check_step(control, &row, step))
    }

    fn check_step(&self, control: usize, of: &Control, step: &Step) -> Result<(), Error> {
        let all = &self.all;
        let (index, operand) = (step.index as usize, step.operand as usize);
        match step.kind {
            STEP_WATCH | STEP_CARRY | STEP_ATTACH => {
                let watched = self.watched_elements() / WATCHED_ELEMENTS as usize;
                within("watched", control, index, 1, watched)?;
                let given = usize::from(step.kind == STEP_ATTACH);
                within("overrides", control, operand * given, given, all.overrides.len())
            }
            STEP_OVERRIDE => within("overrides", control, index, 1, all.overrides.len()),
            STEP_GAZE | STEP_REACH | STEP_CHAIN | STEP_PELVIS | STEP_FOOT => {
                within("constraints", control, index, 1, all.constraints.len())?;
                let row = all.constraints.as_slice()[index];
                within(
                    "links",
                    control,
                    row.link_first as usize,
                    row.link_count as usize,
                    all.links.len(),
                )?;
                // For feet, `target_count` is the number of the member's feet.
                if matches!(step.kind, STEP_PELVIS | STEP_FOOT) {
                    return Ok(());
                }
                let first = of.target_first as usize + row.target_first as usize;
                let count = row.target_count as usize;
                within("targets", control, first, count, all.targets.len())
            }
            STEP_ROTATION => {
                within("step rotations", control, operand, 1, MAX_STEP_ROTATIONS as usize)
            }
            STEP_STAGE => {
                within("stages", control, index, 1, MAX_STAGES as usize)?;
                within("stage_values", control, operand, 1, all.stage_values.len())
            }
            STEP_MOTION => Ok(()),
            kind => within("step kinds", control, kind as usize, 1, STEP_MOTION as usize + 1),
        }
    }
}

fn within(
    table: &'static str,
    control: usize,
    first: usize,
    count: usize,
    length: usize,
) -> Result<(), Error> {
    if first.checked_add(count).is_some_and(|end| end <= length) {
        return Ok(());
    }
    Err(Error::OutOfRange { table, control, first, count, length })
}

#[cfg(test)]
mod tests {
    use crate::control::Controls;
    use crate::layout::{Control, STEP_MOTION, STEP_ROTATION, STEP_STAGE, Step};
    use crate::{Error, JointOverride, Space, Tables};
    use populace_model::{JointIndex, JointSource, Skeleton, Trs};

    /// A member with joint 0 overridden in both spaces.
    fn overridden() -> Tables {
        let joint = JointSource { name: "hips".into(), parent: None, rest: Trs::IDENTITY };
        let skeleton = Skeleton::new(&[joint]).unwrap();
        let mut tables = Tables::new(1);
        let body = tables.add_body(&skeleton, &[]).unwrap();
        let place = tables.add_member(body).unwrap();
        let given = |space| JointOverride {
            joint: JointIndex(0),
            transform: Trs::IDENTITY,
            weight: 1.0,
            space,
        };
        let overrides = vec![given(Space::Local), given(Space::Model)];
        tables
            .set_controls(place, &skeleton, &Controls { overrides, ..Controls::default() })
            .unwrap();
        tables
    }

    #[track_caller]
    fn assert_found(tables: &Tables, wanted: &str) {
        match tables.check_ranges() {
            Err(Error::OutOfRange { table, .. }) => assert_eq!(table, wanted),
            other => panic!("{other:?}, but a range of {wanted} is past its end"),
        }
    }

    #[test]
    fn ranges_past_the_end_of_a_table_are_detected() {
        let good = overridden();
        assert_eq!(good.check_ranges(), Ok(()));
        let mut tables = good.clone();
        tables.mark_clean();
        tables.all.overrides.truncate(1);
        assert_found(&tables, "overrides");
        let mut tables = good.clone();
        tables.all.steps.truncate(0);
        assert_found(&tables, "steps");
        let mut tables = good.clone();
        let row = Control { step_first: 1, ..tables.all.controls.as_slice()[0] };
        tables.all.controls.set(0, row);
        assert_found(&tables, "steps");
        let with_step = |change: fn(&mut Step)| {
            let mut tables = good.clone();
            let mut step = tables.all.steps.as_slice()[0];
            change(&mut step);
            tables.all.steps.set(0, step);
            tables
        };
        assert_found(&with_step(|step| step.index = 2), "overrides");
        assert_found(
            &with_step(|step| (step.kind, step.operand) = (STEP_ROTATION, 48)),
            "step rotations",
        );
        assert_found(&with_step(|step| (step.kind, step.index) = (STEP_STAGE, 8)), "stages");
        assert_found(
            &with_step(|step| (step.kind, step.operand) = (STEP_STAGE, 99)),
            "stage_values",
        );
        assert_found(&with_step(|step| step.kind = 12), "step kinds");
        assert_eq!(with_step(|step| step.kind = STEP_MOTION).check_ranges(), Ok(()));
    }
}
