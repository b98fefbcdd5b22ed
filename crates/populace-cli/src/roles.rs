//! Loads the characters of a crowd, from files or from the built-in people.

mod clipless;
mod clips;
mod inputs;
mod size;

use std::path::PathBuf;
use std::sync::Arc;

use populace::character::Character;
use populace::clip::RootMotion;
use populace::model::RoleMap;
use populace::{CharacterId, ClipId, Crowd};
use rayon::prelude::*;

use crate::built_in::{self, Clothes};
use crate::failure::Failure;
use crate::fit;
use crate::input::InputArgs;
use crate::legs::on_legs;
use crate::levels::Levels;
use crate::progress::Progress;
use crate::report::message;
pub(crate) use clips::clip;
use clips::{add_fitting, default_clips, role_clip};
use inputs::{AddedClips, in_folders, read};
pub(crate) use inputs::{Loader, load_clips};
use size::{Among, doubt_height, report_scale, scale};

/// A role in the crowd: a character, its scale, and the clips that its members play.
pub(crate) struct CrowdRole {
    pub(crate) id: CharacterId,
    pub(crate) character: Arc<Character>,
    /// Clips to choose from; may be empty.
    pub(crate) clips: Vec<RoleClip>,
    pub(crate) scale: f32,
    /// True for built-in people, who have the clothes that were asked for.
    pub(crate) is_built_in: bool,
    /// True for a character that had no clips, its own or added.
    pub(crate) is_clipless: bool,
}

/// A clip of a role.
pub(crate) struct RoleClip {
    pub(crate) id: ClipId,
    /// Its root motion, and the factor that scales it for the character.
    pub(crate) motion: Option<(RootMotion, f32)>,
}

/// The clips that members play.
#[derive(Clone, Copy, Default, PartialEq)]
pub(crate) enum ClipChoice<'a> {
    /// Gaits, by the speed at which each member goes: all characters need legs.
    #[default]
    Gaits,
    /// Gaits or clips, as the scene says.
    Scene,
    /// Clips as they are.
    Clips {
        /// The clip of this name; the default clips if `None`.
        name: Option<&'a str>,
        /// True if root motion is extracted from the clip to move the member.
        root_motion: bool,
    },
}

impl<'a> ClipChoice<'a> {
    /// The name of the clip that was asked for.
    const fn name(self) -> Option<&'a str> {
        match self {
            Self::Gaits | Self::Scene => None,
            Self::Clips { name, .. } => name,
        }
    }

    /// Returns whether root motion was asked for.
    const fn has_root_motion(self) -> bool {
        matches!(self, Self::Clips { root_motion: true, .. })
    }
}

/// The roles of a crowd, and all files that their characters refer to.
pub(crate) struct LoadedRoles {
    pub(crate) roles: Vec<CrowdRole>,
    pub(crate) files: Vec<PathBuf>,
}

/// Loads the inputs into the crowd. An input is a file, `@people` for all built-in people, or one
/// of them by name, such as `@child`. The clips of files without meshes, and of `clip_files`, are
/// added to all characters. `levels` says which levels of detail they get. Built-in people
/// wear what `clothes` says.
pub(crate) fn load(
    crowd: &mut Crowd,
    input: &InputArgs,
    inputs: &[PathBuf],
    clip_files: &[PathBuf],
    choice: ClipChoice,
    height_m: Option<f32>,
    levels: Levels,
    clothes: Clothes,
) -> Result<LoadedRoles, Failure> {
    if let Some(doubt) = height_m.and_then(doubt_height) {
        message!("warning: {doubt}");
    }
    let mut loader = Loader::new(input);
    let (drawn, mut added) = read(&mut loader, &in_folders(inputs)?, clip_files, clothes)?;
    let among = Among::of(choice, drawn.len());
    let mut progress = Progress::new("characters", drawn.len());
    let drawn = drawn.into_par_iter();
    let drawn = drawn.map(|(character, files)| {
        let character = levels.of(character, &files, loader.input)?;
        let character = match (files.first(), choice) {
            (Some(file), ClipChoice::Gaits) => on_legs(character, file),
            (Some(file), ClipChoice::Scene) if has_roles(&character) => on_legs(character, file),
            _ => Ok(character),
        };
        Ok((character?, files.is_empty()))
    });
    let drawn: Vec<(Character, bool)> = drawn.collect::<Result<_, Failure>>()?;
    let mut add = |(character, is_built_in): (Character, bool)| {
        let character = Arc::new(character);
        let scale = scale(&character, height_m, among);
        if height_m.is_none() && scale != 1.0 {
            report_scale(&character, scale, among);
        }
        progress.step();
        let role = add_role(crowd, character, &mut added, choice)?;
        Ok::<_, Failure>(CrowdRole { scale, is_built_in, ..role })
    };
    let roles: Vec<_> = drawn.into_iter().map(&mut add).collect::<Result<_, _>>()?;
    drop(progress);
    clipless::report(crowd, &roles, choice)?;
    for unfit in added.iter().filter_map(AddedClips::unfit) {
        message!("warning: {unfit}");
    }
    Ok(LoadedRoles { roles, files: loader.into_referenced() })
}

/// Returns true for a character whose joints have names of a humanoid.
fn has_roles(character: &Character) -> bool {
    RoleMap::detect(&character.skeleton).is_some()
}

/// Adds a character and the clips of others to the crowd. A humanoid that then has no clips gets
/// those of the built-in people.
fn add_role(
    crowd: &mut Crowd,
    character: Arc<Character>,
    added: &mut [AddedClips],
    choice: ClipChoice,
) -> Result<CrowdRole, Failure> {
    let id = crowd.add_character(Arc::clone(&character))?;
    let mut fits = Vec::new();
    for file in added {
        for clip in &file.clips {
            match add_fitting(crowd, (id, &character), clip)? {
                Ok(fit) => {
                    file.fits = true;
                    fits.push(fit);
                }
                Err(reason) if choice.name() == Some(clip.name()) => {
                    let (clip, name) = (clip.name(), &character.name);
                    return Err(Failure::usage(format!(
                        "\"{name}\" cannot play the clip \"{clip}\": {reason}"
                    )));
                }
                Err(reason) => file.reason = reason,
            }
        }
    }
    let is_clipless = crowd.character(id)?.clips().is_empty();
    if is_clipless && has_roles(&character) {
        for clip in &built_in::clips("people")? {
            fits.extend(add_fitting(crowd, (id, &character), clip)?);
        }
    }
    let clips = match choice.name() {
        Some(name) => vec![clip(crowd, id, name)?],
        None => default_clips(crowd, id)?,
    };
    for (clip, report) in fits.iter().filter(|(clip, _)| clips.contains(clip)) {
        let known = crowd.character(id)?.clips().into_iter().find(|(known, _)| known == clip);
        fit::warn(known.as_ref().map_or("", |(_, clip)| clip.name()), &character.name, report);
    }
    let clips = clips
        .into_iter()
        .map(|clip| role_clip(crowd, id, clip, choice))
        .collect::<Result<_, _>>()?;
    Ok(CrowdRole { id, character, clips, scale: 1.0, is_built_in: false, is_clipless })
}
