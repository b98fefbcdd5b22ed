//! Constraint programs in the form that devices read: a [`Control`] per member that needs one, and
//! runs of steps, overrides, constraints, links and targets.

mod compile;
mod epochs;
mod foot;
mod ground;
mod interned;
mod limb;
mod ranges;
mod shared;
mod stages;
mod targets;

use std::collections::BTreeSet;
use std::ops::Range;

use compile::{FeetJoints, Program};
use populace_model::Skeleton;
use populace_model::convert::u32_from;

use interned::Interned;
use shared::SharedRows;

use super::soles::Soles;
use super::{Space, Table, Tables};
use crate::Error;
use crate::control::Controls;
use crate::layout::{Control, Float4, NONE, STATES_PER_CONTROL, Target, WATCHED_ELEMENTS};
use crate::place::Place;

pub use ground::Ground;
pub(super) use stages::PARAMETER_ELEMENTS;

/// How feet step for which no stride is set.
const NO_STRIDE: Float4 = Float4([0.0, 1.0, 0.0, 0.0]);

/// Runs that a control has alone: first element and length. And its program, whose other rows
/// equal programs share.
#[derive(Clone, Copy, Debug)]
struct Runs {
    overrides: (usize, usize),
    targets: (usize, usize),
    values: (usize, usize),
    /// Number of the program in [`SharedRows`], or [`NONE`].
    program: u32,
    /// Joints that the program needs, counted from the first.
    joint_count: u32,
    /// The feet that the program plants.
    feet: Option<FeetJoints>,
}

impl Runs {
    const NONE: Self = Self {
        overrides: (0, 0),
        targets: (0, 0),
        values: (0, 0),
        program: NONE,
        joint_count: 0,
        feet: None,
    };
}

/// Allocation of controls and of their runs.
#[derive(Clone, Debug)]
pub(super) struct ControlSpaces {
    controls: Space,
    overrides: Space,
    targets: Space,
    values: Space,
    watched: Space,
    /// Indices of watched joints allocated since the last `mark_clean`.
    watched_new: BTreeSet<u32>,
    /// Number of watched elements that every device has memory for.
    watched_known: usize,
    /// Runs, by control index.
    runs: Vec<Runs>,
    shared: SharedRows,
    /// Shapes of the programs in use.
    shapes: Interned<()>,
    /// Controls whose programs changed since the last `mark_clean`.
    unchecked: BTreeSet<u32>,
    epoch: u32,
}

impl ControlSpaces {
    pub(super) fn new() -> Self {
        let space = || Space::new(usize::MAX);
        Self {
            controls: space(),
            overrides: space(),
            targets: space(),
            values: stages::space(),
            watched: space(),
            watched_new: BTreeSet::new(),
            watched_known: 0,
            runs: Vec::new(),
            shared: SharedRows::new(),
            shapes: Interned::default(),
            unchecked: BTreeSet::new(),
            epoch: 0,
        }
    }
}

impl ControlSpaces {
    /// Returns how many joints, counted from the first, a member with this control needs.
    pub(super) fn joints_needed(&self, control: u32) -> u32 {
        self.runs.get(control as usize).map_or(0, |runs| runs.joint_count)
    }
}

/// Replaces a run by one of `count` elements; keeps it if the length is unchanged.
fn resize_run(space: &mut Space, run: &mut (usize, usize), count: usize) {
    if run.1 != count {
        space.release(*run);
        *run = space.take(count);
    }
}

/// Writes elements to the table, and records only those that differ.
fn write<T: bytemuck::Pod + Default + PartialEq>(table: &mut Table<T>, first: usize, values: &[T]) {
    table.grow(first + values.len(), T::default());
    for (index, value) in (first..).zip(values) {
        if table.as_slice()[index] != *value {
            table.set(index, *value);
        }
    }
}

impl Tables {
    /// Sets the constraint program of a member, replacing the previous one. `skeleton` must be that
    /// of its body.
    ///
    /// History state on devices, such as foot positions, is kept.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member does not exist or a watched joint was not allocated,
    /// [`Error::BadConstraint`] for a constraint that cannot be solved, [`Error::TooLarge`] if
    /// offsets exceed 32 bits. The tables are then unchanged.
    pub fn set_controls(
        &mut self,
        member_index: u32,
        skeleton: &Skeleton,
        controls: &Controls,
    ) -> Result<(), Error> {
        let member = *self.used_member(member_index)?;
        if controls.is_empty() {
            self.remove_control(member_index);
            return Ok(());
        }
        let watched = controls.watches.iter().chain(&controls.carries).map(|(_, watched)| *watched);
        let unknown = |watched: &u32| *watched as usize >= self.control_spaces.watched.end();
        if let Some(value) =
            watched.chain(controls.attached.map(|(watched, _)| watched)).find(unknown)
        {
            return Err(Error::BadPlayback { what: "watched joint", value });
        }
        let program = match self.soles_of_bodies.get(&member.body) {
            Some(soles) => Program::compile(skeleton, soles, controls)?,
            None => Program::compile(skeleton, &Soles::default(), controls)?,
        };
        self.check_control_capacity(&program)?;
        let control =
            if member.control == NONE { self.add_control(member_index) } else { member.control };
        self.resize_runs(control as usize, &program);
        self.write_program(control as usize, program);
        self.set_reduced(member_index, member.posed - member.body);
        Ok(())
    }

    fn check_control_capacity(&self, program: &Program) -> Result<(), Error> {
        let spaces = &self.control_spaces;
        for (what, count) in [
            ("the steps", spaces.shared.steps.end_with(program.steps.len())),
            ("the overrides", spaces.overrides.end_with(program.overrides.len())),
            ("the links of chains", spaces.shared.links.end_with(program.links.len())),
            ("the values of stages", spaces.values.end_with(program.values.len())),
            ("the targets", spaces.targets.end_with(program.targets.len())),
            (
                "the controls",
                (spaces.controls.end_with(1) + 1).saturating_mul(STATES_PER_CONTROL as usize),
            ),
        ] {
            if count >= NONE as usize {
                return Err(Error::TooLarge { what, count, limit: NONE as usize });
            }
        }
        Ok(())
    }

    fn add_control(&mut self, member_index: u32) -> u32 {
        let spaces = &mut self.control_spaces;
        let (first, _) = spaces.controls.take(1);
        spaces.runs.resize(spaces.runs.len().max(first + 1), Runs::NONE);
        let epoch = spaces.next_epoch();
        let standing = Place { position: [0.0; 3], sin_cos: [0.0, 1.0], scale: 1.0 };
        let [sine, cosine] = standing.sin_cos;
        let control = Control {
            place: device_place(&standing),
            sine,
            cosine,
            stride: NO_STRIDE,
            epoch,
            scale_first: NONE,
            member: member_index,
            ..Control::default()
        };
        self.all.controls.grow(first + 1, control);
        self.all.controls.set(first, control);
        let mut member = self.all.members.as_slice()[member_index as usize];
        member.control = u32_from(first);
        self.all.members.set(member_index as usize, member);
        member.control
    }

    /// Returns whether a member has a constraint program.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    #[must_use]
    pub fn has_control(&self, member_index: u32) -> bool {
        self.all.members.as_slice()[member_index as usize].control != NONE
    }

    /// Returns the sine and the cosine of the heading that [`set_place`](Self::set_place) set;
    /// `None` for a member without a constraint program.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    #[must_use]
    pub fn sin_cos(&self, member_index: u32) -> Option<[f32; 2]> {
        let control = self.all.members.as_slice()[member_index as usize].control;
        let control = self.all.controls.as_slice().get(control as usize)?;
        Some([control.sine, control.cosine])
    }

    /// Removes the constraint program of a member.
    pub(super) fn remove_control(&mut self, member_index: u32) {
        let mut member = self.all.members.as_slice()[member_index as usize];
        if member.control == NONE {
            return;
        }
        self.resize_runs(member.control as usize, &Program::default());
        let runs = &mut self.control_spaces.runs[member.control as usize];
        let program = std::mem::replace(&mut runs.program, NONE);
        self.release_program(program);
        self.control_spaces.unchecked.remove(&member.control);
        self.control_spaces.shapes.release(member.shape);
        self.control_spaces.controls.release((member.control as usize, 1));
        self.all.controls.truncate(self.control_spaces.controls.end());
        (member.control, member.shape) = (NONE, NONE);
        self.all.members.set(member_index as usize, member);
        self.mix_page(member_index);
    }

    fn resize_runs(&mut self, control: usize, program: &Program) {
        let spaces = &mut self.control_spaces;
        let runs = &mut spaces.runs[control];
        resize_run(&mut spaces.overrides, &mut runs.overrides, program.overrides.len());
        resize_run(&mut spaces.targets, &mut runs.targets, program.targets.len());
        resize_run(&mut spaces.values, &mut runs.values, program.values.len());
        self.all.overrides.truncate(spaces.overrides.end());
        self.all.targets.truncate(spaces.targets.end());
        self.all.stage_values.truncate(spaces.values.end());
    }

    fn write_program(&mut self, control: usize, mut program: Program) {
        self.forget_feet_before(control, &program);
        self.control_spaces.runs[control].joint_count = program.joints_needed();
        self.set_shape(control, &program.shape());
        let runs = self.control_spaces.runs[control];
        program.move_own(runs.overrides.0, runs.values.0);
        write(&mut self.all.overrides, runs.overrides.0, &program.overrides);
        write(&mut self.all.targets, runs.targets.0, &program.targets);
        write(&mut self.all.stage_values, runs.values.0, &program.values);
        let known = self.all.controls.as_slice()[control];
        let row = Control {
            step_count: u32_from(program.steps.len() - program.pose_step_count),
            pose_step_count: u32_from(program.pose_step_count),
            local_first: u32_from(runs.overrides.0),
            local_count: u32_from(program.local_count),
            target_first: u32_from(runs.targets.0),
            scale_first: program.scale_first,
            motion_epoch: program.motion_epoch,
            stride: if program.feet.is_some() { known.stride } else { NO_STRIDE },
            ..known
        };
        let number = self.replace_program(runs.program, program);
        self.control_spaces.runs[control].program = number;
        let step_first = u32_from(self.control_spaces.shared.runs(number).steps.0);
        let row = Control { step_first, ..row };
        write(&mut self.all.controls, control, &[row]);
        self.control_spaces.unchecked.insert(u32_from(control));
    }

    /// Records the shape of a member's program.
    fn set_shape(&mut self, control: usize, shape: &[u32]) {
        let member_index = self.all.controls.as_slice()[control].member;
        let mut member = self.all.members.as_slice()[member_index as usize];
        let shapes = &mut self.control_spaces.shapes;
        let number = shapes.share(shape).unwrap_or_else(|| shapes.add(shape, ()));
        shapes.release(member.shape);
        if member.shape != number {
            member.shape = number;
            self.all.members.set(member_index as usize, member);
            self.mix_page(member_index);
        }
    }

    /// Sets the place of a member in the world. Does nothing if the member has no constraint
    /// program.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member does not exist.
    pub fn set_place(&mut self, member_index: u32, standing: &Place) -> Result<(), Error> {
        let control = self.used_member(member_index)?.control;
        if control != NONE {
            let (place, [sine, cosine]) = (device_place(standing), standing.sin_cos);
            let row = &self.all.controls.as_slice()[control as usize];
            if row.place != place || [row.sine, row.cosine] != [sine, cosine] {
                let row = self.all.controls.change(control as usize);
                (row.place, row.sine, row.cosine) = (place, sine, cosine);
            }
        }
        Ok(())
    }

    /// Sets how a member's locked feet step; see [`Control::stride`]. Holds until feet are planted
    /// no longer. Does nothing for a member whose feet are not planted.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member does not exist.
    pub fn set_stride(&mut self, member_index: u32, stride: Float4) -> Result<(), Error> {
        let control = self.used_member(member_index)?.control;
        if control == NONE || self.control_spaces.runs[control as usize].feet.is_none() {
            return Ok(());
        }
        let controls = &mut self.all.controls;
        if controls.as_slice()[control as usize].stride != stride {
            controls.change(control as usize).stride = stride;
        }
        Ok(())
    }

    /// Replaces one target of a member's constraints. `index` counts through the targets of all its
    /// constraints in order. This is cheaper than [`set_controls`](Self::set_controls).
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the member or target does not exist.
    pub fn set_target(
        &mut self,
        member_index: u32,
        index: usize,
        target: Target,
    ) -> Result<(), Error> {
        let control = self.used_member(member_index)?.control as usize;
        let run = self.control_spaces.runs.get(control).map_or((0, 0), |runs| runs.targets);
        if index >= run.1 {
            return Err(Error::BadPlayback {
                what: "target",
                value: u32::try_from(index).unwrap_or(NONE),
            });
        }
        write(&mut self.all.targets, run.0 + index, &[target]);
        Ok(())
    }

    /// Allocates a watched joint and returns its index. Devices write the joint's matrix there for
    /// other members, attachments or readback.
    pub fn add_watched(&mut self) -> u32 {
        let watched = u32_from(self.control_spaces.watched.take(1).0);
        self.control_spaces.watched_new.insert(watched);
        watched
    }

    /// Frees a watched joint.
    pub fn remove_watched(&mut self, watched: u32) {
        self.control_spaces.watched.release((watched as usize, 1));
    }

    /// Element ranges of joints watched since [`mark_clean`](Self::mark_clean). Devices set them to
    /// zero, which means "not seen yet", because another joint may have used the same elements
    /// before.
    pub fn new_watched_elements(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let (each, end) = (WATCHED_ELEMENTS as usize, self.watched_elements());
        let runs =
            self.control_spaces.watched_new.iter().map(move |watched| *watched as usize * each);
        runs.map(move |first| first..first + each).filter(move |run| run.end <= end)
    }

    /// Elements of [`StageBuffer::Watched`](crate::StageBuffer::Watched), up to the last one in
    /// use.
    #[must_use]
    pub fn watched_elements(&self) -> usize {
        self.control_spaces.watched.end() * WATCHED_ELEMENTS as usize
    }

    /// The part of the watched elements that every device had memory for at the last
    /// [`mark_clean`](Self::mark_clean).
    #[must_use]
    pub fn watched_elements_known(&self) -> usize {
        self.control_spaces.watched_known.min(self.watched_elements())
    }

    pub(super) fn mark_controls_clean(&mut self) {
        self.control_spaces.watched_known = self.watched_elements();
        self.control_spaces.watched_new.clear();
        self.control_spaces.unchecked.clear();
    }

    pub(super) fn mark_controls_dirty(&mut self) {
        self.control_spaces.watched_known = 0;
    }

    /// Elements of [`StageBuffer::States`](crate::StageBuffer::States), up to the last one in use.
    #[must_use]
    pub fn state_elements(&self) -> usize {
        self.all.controls.len() * STATES_PER_CONTROL as usize
    }
}

fn device_place(standing: &Place) -> Float4 {
    let [x, y, z] = standing.position;
    Float4([x, y, z, standing.scale])
}
