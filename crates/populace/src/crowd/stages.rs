//! User stages and the members that use them.

use std::collections::BTreeSet;

use populace_device::layout::{MAX_STAGES, STAGE_PARAMETERS};
use populace_device::{After, StageFault, UserStage, layout};
use populace_model::JointIndex;
use populace_settings::parts::{Parts, StageUseParts, finite};

use super::base::Base;
use super::constraints::Constraints;
use super::{Crowd, MemberId, u32_from};
use crate::{Allowed, Error, IdKind, StageUse};

/// A user stage of a crowd. The id goes stale when the stage is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StageId {
    crowd: u32,
    number: u32,
    serial: u32,
}

/// The stages of a crowd, by number.
#[derive(Clone, Debug, Default)]
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

    pub(super) fn is_any(&self) -> bool {
        self.all.iter().any(Option::is_some)
    }

    /// Returns the stages with one more, and its number.
    fn with(&self, stage: UserStage) -> Result<(Vec<Option<UserStage>>, usize), Error> {
        stage.check()?;
        let mut all = self.all.clone();
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
        Ok((all, number))
    }

    /// Takes stages that devices have received, of which `number` is new. Returns its serial.
    fn take(&mut self, all: Vec<Option<UserStage>>, number: usize, after: After) -> u32 {
        self.all = all;
        self.taken.resize(self.all.len(), None);
        self.last_serial = self.last_serial.wrapping_add(1);
        self.taken[number] = Some((after, self.last_serial));
        self.last_serial
    }

    /// Makes a member run a stage.
    pub(super) fn set(
        &self,
        base: &mut Base,
        constraints: &mut Constraints,
        member: MemberId,
        id: StageId,
        usage: StageUse,
    ) -> Result<(), Error> {
        let after = self.after(base, id)?;
        let character = base.check(member)?;
        let StageUseParts { joints, values } = usage.parts();
        finite("a member's value for a stage", &values)?;
        let skeleton = &base.character_state(character)?.character.skeleton;
        let all = || (0..u32_from(skeleton.joint_count())).map(JointIndex).collect();
        // Each joint once, even if named several times.
        let joints: BTreeSet<_> = joints.unwrap_or_else(all).into_iter().collect();
        let joints = joints.into_iter().collect();
        let stage = populace_device::StageUse { stage: id.number, after, joints, values };
        constraints.change(base, member, |controls| {
            match controls.stages.iter_mut().find(|old| old.stage == stage.stage) {
                Some(old) => *old = stage,
                None => controls.stages.push(stage),
            }
        })
    }

    /// Makes a member no longer run a stage.
    pub(super) fn clear(
        &self,
        base: &mut Base,
        constraints: &mut Constraints,
        member: MemberId,
        id: StageId,
    ) -> Result<(), Error> {
        self.after(base, id)?;
        constraints.clear_stage(base, member, id.number)
    }

    /// Returns the stage of the pipeline after which a user stage runs.
    fn after(&self, base: &Base, id: StageId) -> Result<After, Error> {
        base.check_crowd(IdKind::Stage, id.crowd, id.number)?;
        let taken = self.taken.get(id.number as usize).copied().flatten();
        let ours = taken.filter(|(_, serial)| *serial == id.serial);
        ours.map(|(after, _)| after)
            .ok_or(Error::UnknownId { what: IdKind::Stage, index: id.number })
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
        let Self { state, device, .. } = self;
        let (base, stages) = (&mut state.base, &mut state.stages);
        let (all, number) = stages.with(stage)?;
        device.backend_mut().set_stages(&all)?;
        let serial = stages.take(all, number, after);
        let number = u32_from(number);
        base.tables.set_stage_parameters(number, &[0.0; STAGE_PARAMETERS as usize])?;
        Ok(StageId { crowd: base.number, number, serial })
    }

    /// Removes a stage; members no longer run it. Nothing is changed on an error.
    pub(super) fn remove_stage(&mut self, id: StageId) -> Result<(), Error> {
        let Self { state, device, .. } = self;
        let (base, stages) = (&mut state.base, &mut state.stages);
        let constraints = &mut state.constraints;
        stages.after(base, id)?;
        let mut all = stages.all.clone();
        all[id.number as usize] = None;
        device.backend_mut().set_stages(&all)?;
        stages.all = all;
        stages.taken[id.number as usize] = None;
        for index in constraints.users_of_stage(id.number) {
            constraints.clear_stage(base, base.member_id(index), id.number)?;
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
        let (base, stages) = (&mut self.state.base, &mut self.state.stages);
        stages.after(base, id)?;
        finite("a parameter of a stage", parameters)?;
        let mut all = [0.0; STAGE_PARAMETERS as usize];
        let Some(given) = all.get_mut(..parameters.len()) else {
            let (what, value) = ("the number of a stage's parameters", parameters.len() as f32);
            return Err(Error::BadValue {
                what,
                value,
                allowed: Allowed::AtMost(STAGE_PARAMETERS as usize),
            });
        };
        given.copy_from_slice(parameters);
        Ok(base.tables.set_stage_parameters(id.number, &all)?)
    }
}

impl Constraints {
    fn clear_stage(&mut self, base: &mut Base, member: MemberId, number: u32) -> Result<(), Error> {
        self.change(base, member, |controls| {
            controls.stages.retain(|given| given.stage != number);
        })
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
