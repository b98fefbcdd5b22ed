//! Inputs and options that have no meaning for what is shown.

use std::path::{Path, PathBuf};

use crate::cli::{PictureArgs, TrajectoryArgs};
use crate::failure::Failure;
use crate::{scene, trajectory};

/// Inputs and options of a command. Some have no meaning for some shows.
pub(crate) struct Given<'a> {
    pub(crate) inputs: &'a [PathBuf],
    pub(crate) cast: &'a [PathBuf],
    pub(crate) members: Option<u32>,
    pub(crate) trajectory: &'a TrajectoryArgs,
    pub(crate) picture: &'a PictureArgs,
}

impl Given<'_> {
    /// Refuses what has no meaning for the scene of a file.
    pub(crate) fn check_for_scene(&self, file: &Path) -> Result<(), Failure> {
        if self.members.is_some() {
            return Err(Failure::usage(
                "--members has no meaning here: the scene file says how many people there are",
            ));
        }
        if let Some(other) = self.others(file).next() {
            let [shown, given] = [file, other].map(Path::display);
            return Err(Failure::usage(if scene::is_scene(other) {
                format!("{shown} and {given} are both scene files; give one")
            } else if trajectory::is_trajectory(other) {
                format!("{shown} is a scene and {given} a recording; give one of them")
            } else {
                has_characters(file, other)
            }));
        }
        if let Some(other) = self.cast.first() {
            return Err(Failure::usage(has_characters(file, other)));
        }
        self.check_without_recording()?;
        check_for_street(self.picture)
    }

    /// Refuses what has no meaning for people of a recording, and returns the inputs that play
    /// them.
    pub(crate) fn cast_for_recording(&self, file: &Path) -> Result<Vec<PathBuf>, Failure> {
        if self.members.is_some() {
            return Err(Failure::usage(
                "--members has no meaning here: the file says how many people there are",
            ));
        }
        if self.picture.clip.is_some() || self.picture.root_motion {
            return Err(Failure::usage(
                "--clip and --root-motion have no meaning for a recording: people walk, run and \
                 stand as it says",
            ));
        }
        match self.others(file).find(|input| trajectory::is_trajectory(input)) {
            Some(other) => Err(Failure::usage(format!(
                "{} and {} are both trajectory files; give one",
                file.display(),
                other.display()
            ))),
            None => Ok(self.others(file).cloned().collect()),
        }
    }

    /// Returns the inputs but for the first one of this name.
    fn others(&self, file: &Path) -> impl Iterator<Item = &PathBuf> {
        let own = self.inputs.iter().position(|input| input == file);
        let inputs = self.inputs.iter().enumerate();
        inputs.filter(move |(nth, _)| Some(*nth) != own).map(|(_, input)| input)
    }

    /// Refuses the options of trajectory files.
    pub(crate) fn check_without_recording(&self) -> Result<(), Failure> {
        self.trajectory.read.refuse_unused()?;
        self.trajectory.overlay.refuse_unused()
    }
}

/// Returns why characters cannot be given beside a scene.
fn has_characters(scene: &Path, given: &Path) -> String {
    let [scene, given] = [scene, given].map(Path::display);
    format!(
        "{scene} is a scene, which names its own characters; name {given} in `from` of a [[cast]]"
    )
}

/// Refuses what has no meaning for people with behaviours.
pub(crate) fn check_for_street(picture: &PictureArgs) -> Result<(), Failure> {
    if picture.clip.is_some() || picture.root_motion {
        return Err(Failure::usage(
            "--clip and --root-motion have no meaning for a scene: what its people do says what \
             they play; `does.stand` of a scene file names a clip",
        ));
    }
    Ok(())
}
