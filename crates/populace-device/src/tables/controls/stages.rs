//! User stages: their parameters, and the steps of the members that use them.

use populace_model::Skeleton;
use populace_model::convert::u32_from;

use super::compile::Program;
use super::write;
use crate::control::path;
use crate::layout::{Float4, MAX_STAGES, STAGE_PARAMETERS, STEP_STAGE, Step};
use crate::tables::Tables;
use crate::tables::space::Space;
use crate::{After, Error, StageUse};

/// Elements of one stage's parameters.
const ELEMENTS: usize = STAGE_PARAMETERS as usize / 4;
/// Elements of all stages' parameters; the values of members follow them.
pub(in crate::tables) const PARAMETER_ELEMENTS: usize = MAX_STAGES as usize * ELEMENTS;

/// Creates the allocation of member values, with the parameters reserved.
pub(super) fn space() -> Space {
    let mut space = Space::new(usize::MAX);
    space.take(PARAMETER_ELEMENTS);
    space
}

impl Tables {
    /// Sets the parameters of a user stage.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if `stage` is [`MAX_STAGES`] or above.
    pub fn set_stage_parameters(
        &mut self,
        stage: u32,
        parameters: &[f32; STAGE_PARAMETERS as usize],
    ) -> Result<(), Error> {
        if stage >= MAX_STAGES {
            return Err(Error::BadPlayback { what: "stage", value: stage });
        }
        let elements = parameters.as_chunks::<4>().0.iter().map(|four| Float4(*four));
        write(&mut self.all.stage_values, stage as usize * ELEMENTS, &elements.collect::<Vec<_>>());
        Ok(())
    }
}

impl Program {
    /// Adds the steps of user stages that run after Transform, and returns those that run after
    /// Pose.
    pub(super) fn stages(
        &mut self,
        skeleton: &Skeleton,
        uses: &[StageUse],
    ) -> Result<Vec<Step>, Error> {
        let mut pose_steps = Vec::new();
        for given in uses {
            if given.stage >= MAX_STAGES {
                return Err(Error::BadPlayback { what: "stage", value: given.stage });
            }
            let value = u32_from(self.values.len());
            self.values.push(Float4(given.values));
            for joint in &given.joints {
                path(skeleton, *joint, *joint)?;
                let step =
                    Step { joint: joint.0, kind: STEP_STAGE, index: given.stage, operand: value };
                if given.after == After::Pose { &mut pose_steps } else { &mut self.steps }
                    .push(step);
            }
        }
        // Stable sort: stages of one joint keep their order.
        pose_steps.sort_by_key(|step| step.joint);
        Ok(pose_steps)
    }
}
