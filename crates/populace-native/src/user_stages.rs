//! Functions of user stages, by stage number.

use populace_device::{BackendError, StageFn, StageJoint, UserStage};

use crate::errors::DEVICE;

/// Rust functions of the stages that exist.
#[derive(Clone, Default)]
pub(crate) struct UserStages(Vec<Option<StageFn>>);

impl UserStages {
    /// Takes the stages' Rust functions.
    ///
    /// # Errors
    ///
    /// [`BackendError::NoForm`] if a stage has none.
    pub(crate) fn new(stages: &[Option<UserStage>]) -> Result<Self, BackendError> {
        let function = |stage: &UserStage| {
            stage.rust_function().cloned().ok_or_else(|| BackendError::NoForm {
                device: DEVICE.into(),
                stage: stage.name().into(),
                form: "a function in Rust",
            })
        };
        let functions = stages.iter().map(|stage| stage.as_ref().map(function).transpose());
        Ok(Self(functions.collect::<Result<_, _>>()?))
    }

    /// Runs a stage on a joint. A stage that does not exist changes nothing.
    pub(crate) fn run(&self, stage: u32, joint: &mut StageJoint) {
        if let Some(Some(function)) = self.0.get(stage as usize) {
            function(joint);
        }
    }
}
