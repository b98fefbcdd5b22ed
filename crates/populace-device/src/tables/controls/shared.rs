//! Rows that members with equal programs have in common: steps, constraints and links. Members of a
//! crowd mostly do the same, so devices read few of these rows.

use populace_model::convert::u32_from;

use super::compile::Program;
use super::interned::Interned;
use super::{resize_run, write};
use crate::layout::NONE;
use crate::tables::{Space, Tables};

/// Runs of the rows that programs share: first element and length.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SharedRuns {
    pub(super) steps: (usize, usize),
    pub(super) constraints: (usize, usize),
    pub(super) links: (usize, usize),
}

/// Allocation of rows that programs share.
#[derive(Clone, Debug)]
pub(super) struct SharedRows {
    pub(super) steps: Space,
    pub(super) constraints: Space,
    pub(super) links: Space,
    /// Programs in use by their rows, with offsets that count from the program's own first rows.
    programs: Interned<SharedRuns>,
}

impl SharedRows {
    pub(super) fn new() -> Self {
        let space = || Space::new(usize::MAX);
        Self { steps: space(), constraints: space(), links: space(), programs: Interned::default() }
    }

    /// Returns the runs of the program with a number; empty ones for [`NONE`].
    pub(super) fn runs(&self, number: u32) -> SharedRuns {
        if number == NONE { SharedRuns::default() } else { self.programs.made(number) }
    }

    fn release(&mut self, number: u32) {
        let Some(mut runs) = self.programs.release(number) else { return };
        resize_run(&mut self.steps, &mut runs.steps, 0);
        resize_run(&mut self.constraints, &mut runs.constraints, 0);
        resize_run(&mut self.links, &mut runs.links, 0);
    }
}

/// All that makes programs equal.
fn words(program: &Program) -> Vec<u32> {
    let lengths = [program.steps.len(), program.constraints.len(), program.links.len()];
    let mut words: Vec<u32> = lengths.map(u32_from).to_vec();
    words.extend_from_slice(bytemuck::cast_slice(&program.steps));
    words.extend_from_slice(bytemuck::cast_slice(&program.constraints));
    words.extend_from_slice(bytemuck::cast_slice(&program.links));
    words
}

impl Tables {
    /// Gives a control the rows of a program in place of those of program `before`, and returns the
    /// program's number. Equal programs have the same number and rows.
    pub(super) fn replace_program(&mut self, before: u32, mut program: Program) -> u32 {
        let words = words(&program);
        let shared = &mut self.control_spaces.shared;
        if let Some(number) = shared.programs.share(&words) {
            self.release_program(before);
            return number;
        }
        // Before the new rows are allocated: changes to a program that nobody shares stay in place.
        shared.release(before);
        let runs = SharedRuns {
            steps: shared.steps.take(program.steps.len()),
            constraints: shared.constraints.take(program.constraints.len()),
            links: shared.links.take(program.links.len()),
        };
        let number = shared.programs.add(&words, runs);
        program.move_shared(runs.constraints.0, runs.links.0);
        write(&mut self.all.steps, runs.steps.0, &program.steps);
        write(&mut self.all.constraints, runs.constraints.0, &program.constraints);
        write(&mut self.all.links, runs.links.0, &program.links);
        self.truncate_shared();
        number
    }

    /// Counts one control less that has the program with a number.
    pub(super) fn release_program(&mut self, number: u32) {
        self.control_spaces.shared.release(number);
        self.truncate_shared();
    }

    fn truncate_shared(&mut self) {
        let shared = &self.control_spaces.shared;
        self.all.steps.truncate(shared.steps.end());
        self.all.constraints.truncate(shared.constraints.end());
        self.all.links.truncate(shared.links.end());
    }
}

#[cfg(test)]
mod tests {
    use populace_model::{JointIndex, JointSource, Skeleton, Trs};

    use crate::control::{Constraint, Controls, Gaze, GazeLimits};
    use crate::layout::{TARGET_MODEL, Target};
    use crate::tables::Tables;

    fn looks_at(x: f32, yaw_rad: f32) -> Controls {
        let limits = GazeLimits { yaw_rad, up_rad: 0.5, down_rad: 0.5 };
        let target = Target { kind: TARGET_MODEL, ..Target::default() };
        let targets = vec![Target { point: crate::layout::Float4([x, 0.0, 1.0, 0.0]), ..target }];
        let chain = vec![(JointIndex(0), 1.0)];
        let gaze = Gaze { chain, facing: [0.0, 0.0, 1.0], limits, targets };
        Controls { constraints: vec![Constraint::Gaze(gaze)], ..Controls::default() }
    }

    #[test]
    fn equal_programs_share_rows_until_one_changes() {
        let joint = JointSource { name: "head".into(), parent: None, rest: Trs::IDENTITY };
        let skeleton = Skeleton::new(&[joint]).unwrap();
        let mut tables = Tables::new(1);
        let body = tables.add_body(&skeleton, &[]).unwrap();
        let members = [(); 3].map(|()| tables.add_member(body).unwrap());
        for (x, member) in [1.0, 2.0, 3.0].into_iter().zip(members) {
            tables.set_controls(member, &skeleton, &looks_at(x, 1.0)).unwrap();
        }
        let rows = |tables: &Tables| {
            let controls = tables.controls().as_slice().iter();
            let first: Vec<u32> = controls.map(|control| control.step_first).collect();
            (first, tables.constraints().as_slice().len(), tables.targets().as_slice().len())
        };
        assert_eq!(rows(&tables), (vec![0, 0, 0], 1, 3), "each has a target of its own");
        assert_eq!(tables.check_ranges(), Ok(()));
        tables.set_controls(members[1], &skeleton, &looks_at(2.0, 0.7)).unwrap();
        assert_eq!(rows(&tables), (vec![0, 1, 0], 2, 3));
        tables.set_controls(members[1], &skeleton, &looks_at(2.0, 0.8)).unwrap();
        assert_eq!(rows(&tables), (vec![0, 1, 0], 2, 3), "in place of its own rows");
        assert_eq!(tables.check_ranges(), Ok(()));
        for member in [members[0], members[2]] {
            tables.set_controls(member, &skeleton, &Controls::default()).unwrap();
            assert_eq!(tables.check_ranges(), Ok(()));
        }
        let kept = tables.constraints().as_slice()[1];
        assert!((kept.limits.0[0] - 0.8).abs() < 1e-6, "the rows of who still looks");
        tables.set_controls(members[1], &skeleton, &Controls::default()).unwrap();
        assert_eq!(tables.constraints().as_slice().len(), 0);
    }
}
