//! User stages and the members that use them.

use std::collections::BTreeSet;

use populace_device::layout::{MAX_STAGES, STAGE_PARAMETERS};
use populace_device::{After, StageFault, UserStage, layout};
use populace_model::JointIndex;

use super::{Crowd, MemberId, u32_from};
use crate::error::finite;
use crate::{Error, StageUse};

/// A user stage of a crowd. The id goes stale when the stage is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StageId {
    crowd: u32,
    number: u32,
    serial: u32,
}

/// The stages of a crowd, by number.
#[derive(Debug, Default)]
pub(super) struct UserStages {
    /// The stages as devices receive them.
    all: Vec<Option<UserStage>>,
    /// The stage after which each runs, and the serial number of its id.
    taken: Vec<Option<(After, u32)>>,
    last_serial: u32,
}

impl UserStages {
    pub(super) fn as_slice(&self) -> &[Option<UserStage>] {
        &self.all
    }
}

impl Crowd {
    /// Adds a user stage to the pipeline: a function over one joint of one member. It runs for the
    /// members that [`set_stage`](crate::MemberMut::set_stage) selects; all others keep the same
    /// bits.
    ///
    /// OpenCL devices rebuild their kernels. That takes up to some seconds the first time, and no
    /// time if another crowd of the process has added the same stages.
    ///
    /// # Errors
    ///
    /// A stage without the form that a device in use runs, a ninth stage, or a text that does not
    /// compile: the error holds the compiler's message, with line numbers of the user's text.
    /// Nothing is changed then.
    pub fn add_stage(&mut self, after: After, stage: UserStage) -> Result<StageId, Error> {
        stage.check()?;
        let mut all = self.stages.all.clone();
        let number = all.iter().position(Option::is_none).unwrap_or(all.len());
        if number >= MAX_STAGES as usize {
            return Err(bad_stage(&stage, StageFault::TooMany));
        }
        if let Some(other) = all.iter().flatten().find(|other| collide(other, &stage)) {
            let other = other.name().to_owned();
            return Err(bad_stage(&stage, StageFault::NameTaken { other }));
        }
        all.resize(all.len().max(number + 1), None);
        all[number] = Some(stage);
        self.opened.backend_mut().set_stages(&all)?;
        let stages = &mut self.stages;
        stages.all = all;
        stages.taken.resize(stages.all.len(), None);
        stages.last_serial = stages.last_serial.wrapping_add(1);
        stages.taken[number] = Some((after, stages.last_serial));
        let number = u32_from(number);
        self.tables.set_stage_parameters(number, &[0.0; STAGE_PARAMETERS as usize])?;
        Ok(StageId { crowd: self.number, number, serial: self.stages.last_serial })
    }

    /// Removes a stage. Its id goes stale, and members no longer run it.
    ///
    /// # Errors
    ///
    /// A stage that does not exist, or a failing device. Nothing is changed then.
    pub fn remove_stage(&mut self, id: StageId) -> Result<(), Error> {
        self.stage_after(id)?;
        let mut all = self.stages.all.clone();
        all[id.number as usize] = None;
        self.opened.backend_mut().set_stages(&all)?;
        self.stages.all = all;
        self.stages.taken[id.number as usize] = None;
        let uses = |state: &super::MemberControls| {
            state.controls.stages.iter().any(|u| u.stage == id.number)
        };
        let places = self.controls.iter().filter(|(_, state)| uses(state)).map(|(place, _)| *place);
        // Sorted, so that equal calls leave equal tables.
        for place in places.collect::<BTreeSet<_>>() {
            let generation = self.members[place as usize].generation;
            self.forget_use(MemberId { crowd: self.number, index: place, generation }, id.number)?;
        }
        Ok(())
    }

    /// Sets the `parameters` that a stage reads from the next update on: at most 16 numbers, the
    /// rest is 0. A change uploads 64 bytes, for any number of members.
    ///
    /// # Errors
    ///
    /// A stage that does not exist, more than 16 numbers, or one that is not finite.
    pub fn set_stage_parameters(&mut self, id: StageId, parameters: &[f32]) -> Result<(), Error> {
        self.stage_after(id)?;
        finite("a parameter of a stage", parameters)?;
        let mut all = [0.0; STAGE_PARAMETERS as usize];
        let Some(given) = all.get_mut(..parameters.len()) else {
            let (what, value) = ("the number of a stage's parameters", parameters.len() as f32);
            return Err(Error::BadValue { what, value, rule: "at most 16" });
        };
        given.copy_from_slice(parameters);
        Ok(self.tables.set_stage_parameters(id.number, &all)?)
    }

    pub(super) fn use_stage(
        &mut self,
        member: MemberId,
        id: StageId,
        how: StageUse,
    ) -> Result<(), Error> {
        let after = self.stage_after(id)?;
        let character = self.check(member)?;
        finite("a member's value for a stage", &how.values)?;
        let skeleton = &self.character_state(character)?.character.skeleton;
        let all = || (0..u32_from(skeleton.joint_count())).map(JointIndex).collect();
        // Each joint once, even if named several times.
        let joints: BTreeSet<_> = how.joints.unwrap_or_else(all).into_iter().collect();
        let joints = joints.into_iter().collect();
        let stage =
            populace_device::StageUse { stage: id.number, after, joints, values: how.values };
        self.change_controls(member, |controls| {
            match controls.stages.iter_mut().find(|old| old.stage == stage.stage) {
                Some(old) => *old = stage,
                None => controls.stages.push(stage),
            }
            Ok(())
        })
    }

    pub(super) fn leave_stage(&mut self, member: MemberId, id: StageId) -> Result<(), Error> {
        self.stage_after(id)?;
        self.forget_use(member, id.number)
    }

    fn forget_use(&mut self, member: MemberId, number: u32) -> Result<(), Error> {
        self.change_controls(member, |controls| {
            controls.stages.retain(|given| given.stage != number);
            Ok(())
        })
    }

    fn stage_after(&self, id: StageId) -> Result<After, Error> {
        self.check_crowd("stage", id.crowd, id.number)?;
        let taken = self.stages.taken.get(id.number as usize).copied().flatten();
        let ours = taken.filter(|(_, serial)| *serial == id.serial);
        ours.map(|(after, _)| after).ok_or(Error::UnknownId { what: "stage", index: id.number })
    }
}

/// Returns whether two stages define different functions of the same name.
fn collide(a: &UserStage, b: &UserStage) -> bool {
    let texts = a.opencl_c_text().zip(b.opencl_c_text());
    a.name() == b.name() && texts.is_some_and(|(a, b)| a != b)
}

const _: () = assert!(layout::STAGE_PARAMETERS == 16, "the documentation says so");

fn bad_stage(stage: &UserStage, fault: StageFault) -> Error {
    populace_device::Error::BadStage { stage: stage.name().into(), fault }.into()
}
