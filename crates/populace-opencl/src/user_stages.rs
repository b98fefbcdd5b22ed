//! Users' stages: their texts as a part of the kernels' programs, and the kernels built with them.

use std::fmt::Write;

use opencl3::kernel::Kernel;
use populace_device::{BackendError, UserStage};

use crate::OpenClDevice;
use crate::program::Form;

/// The kernels that run users' stages, and those stages by number.
#[derive(Default)]
pub(crate) struct UserStages {
    stages: Vec<Option<UserStage>>,
    /// Built for stages that run from the next update on.
    pub(crate) next: Option<[Kernel; 2]>,
}

impl UserStages {
    /// Builds two kernels of a form with stages in place of those before, or leaves all as it was.
    pub(crate) fn set(
        &mut self,
        device: &OpenClDevice,
        (form, names): (Form, [&str; 2]),
        stages: &[Option<UserStage>],
    ) -> Result<(), BackendError> {
        let text = text_of(device, stages)?;
        // Stages that nobody uses any longer harm nobody: what knows them need not be built anew.
        if !self.knows(stages) || stages.iter().flatten().count() == 0 {
            let [first, second] = names.map(|name| device.kernel(form, &text, name));
            self.next = Some([first?, second?]);
            self.stages = stages.to_vec();
        }
        Ok(())
    }

    /// Whether each of these stages is among those built, under the same number.
    fn knows(&self, stages: &[Option<UserStage>]) -> bool {
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

/// What stages add to a program: each text once, then what chooses among them; nothing for none.
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
            // Errors then name the stage and the user's own line.
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
