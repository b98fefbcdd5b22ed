//! Users' stages: their part of the kernels' source, and the kernels built with them.

use std::fmt::Write;

use populace_device::{BackendError, UserStage};

use crate::OpenClDevice;
use crate::handles::Kernel;
use crate::program::Form;

/// The two kernels of a schedule that run users' stages.
#[derive(Clone, Copy)]
pub(crate) struct StageKernels {
    pub(crate) form: Form,
    pub(crate) names: [&'static str; 2],
}

/// The users' stages in the current kernels, by index.
#[derive(Default)]
pub(crate) struct UserStages {
    stages: Vec<Option<UserStage>>,
    /// Kernels with other stages, to be used from the next update on.
    pub(crate) next: Option<[Kernel; 2]>,
}

impl UserStages {
    /// Builds both kernels with `stages` in place of the previous ones. On an error nothing
    /// changes.
    pub(crate) fn set(
        &mut self,
        device: &OpenClDevice,
        kernels: StageKernels,
        stages: &[Option<UserStage>],
    ) -> Result<(), BackendError> {
        let text = text_of(device, stages)?;
        // Kernels with additional, unused stages still serve, so they are not rebuilt.
        if !self.contains(stages) || stages.iter().flatten().count() == 0 {
            let [first, second] =
                kernels.names.map(|name| device.kernel(kernels.form, &text, name));
            self.next = Some([first?, second?]);
            self.stages = stages.to_vec();
        }
        Ok(())
    }

    /// Returns whether each of `stages` is part of the current kernels at the same index.
    fn contains(&self, stages: &[Option<UserStage>]) -> bool {
        let same = |a: &UserStage, b: &UserStage| {
            a.name() == b.name()
                && a.opencl_c_text().map(str::as_ptr) == b.opencl_c_text().map(str::as_ptr)
        };
        (0..).zip(stages).all(|(number, stage)| {
            let built = self.stages.get::<usize>(number).and_then(Option::as_ref);
            stage.as_ref().is_none_or(|stage| built.is_some_and(|built| same(stage, built)))
        })
    }
}

/// Returns the text that stages add to a program: each text once, then the function that selects
/// one by index. Empty without stages.
fn text_of(device: &OpenClDevice, stages: &[Option<UserStage>]) -> Result<String, BackendError> {
    let (mut texts, mut all, mut cases) = (Vec::new(), String::new(), String::new());
    for (number, stage) in
        (0..).zip(stages).filter_map(|(number, stage): (u32, _)| Some((number, stage.as_ref()?)))
    {
        let Some(text) = stage.opencl_c_text() else {
            let (device, stage) = (device.info.name.clone(), stage.name().to_owned());
            return Err(BackendError::NoForm { device, stage, form: "a text in OpenCL C" });
        };
        if !texts.contains(&text) {
            texts.push(text);
            // Compiler errors then name the stage and the line in the user's text.
            let _never_fails = write!(all, "#line 1 \"stage {}\"\n{text}\n", stage.name());
        }
        cases += &format!("    case {number}: {}(joint); break;\n", stage.name());
    }
    if all.is_empty() {
        return Ok(all);
    }
    let rule = "each stage's text defines the function of its name";
    let head =
        format!("#line 1 \"{rule}\"\nstatic void run_user_stage(uint stage, StageJoint *joint)");
    Ok(format!("{all}{head}\n{{\n    switch (stage) {{\n{cases}    }}\n}}\n"))
}
