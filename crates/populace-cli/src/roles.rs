//! Loads the characters of a crowd, from files or from the built-in people.

mod clipless;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use populace::character::Character;
use populace::clip::{Clip, RootMotion};
use populace::model::RoleMap;
use populace::retarget::Binding;
use populace::{
    BindingReport, CharacterId, ClipId, Crowd, MotionOrigin, MotionSettings, MotionSource,
};
use rayon::prelude::*;

use crate::built_in::{self, Clothes};
use crate::clip_words::shortest;
use crate::failure::Failure;
use crate::fit;
use crate::folder::paths_in;
use crate::input::InputArgs;
use crate::legs::on_legs;
use crate::levels::{Levels, is_cache};
use crate::names::hint;
use crate::progress::Progress;
use crate::report::message;

/// Clips with a slower ground speed are taken to stand still.
const WALKING_M_PER_SEC: f32 = 0.1;
/// In a crowd of several characters, heights outside of this range are taken to be in another unit
/// than metres.
const PLAUSIBLE_M: std::ops::Range<f32> = 0.5..2.2;
/// The same for a character alone: a fox of 79 m is one of 79 cm.
const ALONE_M: std::ops::Range<f32> = 0.03..40.0;
/// Height given to a character in another unit that is higher than long.
const UPRIGHT_M: f32 = 1.75;
/// Height given to a character in another unit that is longer than high.
const FOUR_LEGGED_M: f32 = 0.8;

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

/// Loads characters from files, and records all files that they refer to.
pub(crate) struct Loader<'a> {
    input: &'a InputArgs,
    referenced: Vec<PathBuf>,
}

impl<'a> Loader<'a> {
    pub(crate) fn new(input: &'a InputArgs) -> Self {
        Self { input, referenced: Vec::new() }
    }

    /// Returns all files that the loaded characters refer to.
    pub(crate) fn into_referenced(self) -> Vec<PathBuf> {
        self.referenced
    }

    pub(crate) fn load(&mut self, file: &Path) -> Result<Character, Failure> {
        let imported = self.input.load(file)?;
        for note in &imported.notes {
            message!("{}: {}: {}", file.display(), note.place, note.what);
        }
        self.referenced.extend(imported.named_files);
        Ok(imported.character)
    }
}

/// What else is in the picture, by which a character has a plausible size.
#[derive(Clone, Copy)]
enum Among {
    None,
    Others,
    Scene,
}

impl Among {
    fn of(choice: ClipChoice, characters: usize) -> Self {
        match choice {
            // What scenes have is as large as people need it.
            ClipChoice::Scene => Self::Scene,
            _ if characters > 1 => Self::Others,
            _ => Self::None,
        }
    }
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
    Ok(LoadedRoles { roles, files: loader.referenced })
}

/// Characters to draw, with their files: none of those that are built in.
type Drawn = Vec<(Character, Vec<PathBuf>)>;

/// The clips of a file that are added to all characters.
struct AddedClips {
    file: PathBuf,
    clips: Vec<Arc<Clip>>,
    /// True once one of them fits a character.
    fits: bool,
    /// Why the last one that was refused does not fit.
    reason: String,
}

impl AddedClips {
    fn new(file: &Path, clips: Vec<Arc<Clip>>) -> Self {
        Self { file: file.to_owned(), clips, fits: false, reason: "it has none".to_owned() }
    }

    /// Says that none of the clips fits any character.
    fn unfit(&self) -> Option<String> {
        let Self { file, fits, reason, .. } = self;
        let file = file.display();
        (!fits).then(|| format!("no clip of {file} fits any of the characters: {reason}"))
    }
}

/// Reads the characters to draw, and the clips of the files that have nothing else.
fn read(
    loader: &mut Loader,
    inputs: &[PathBuf],
    clip_files: &[PathBuf],
    clothes: Clothes,
) -> Result<(Drawn, Vec<AddedClips>), Failure> {
    let (mut drawn, mut added) = (Drawn::new(), Vec::new());
    let mut progress = Progress::new("files", inputs.len() + clip_files.len());
    for file in clip_files {
        added.push(AddedClips::new(file, load_clips(loader, file)?));
        progress.step();
    }
    for input in inputs {
        match built_in::name_of(input) {
            Some(name) => {
                drawn.extend(built_in::dressed(name, clothes)?.into_iter().map(|c| (c, vec![])))
            }
            None => {
                let known = loader.referenced.len();
                let character = loader.load(input)?;
                if character.parts.is_empty() {
                    added.push(AddedClips::new(input, character.clips.clone()));
                } else {
                    let referenced = loader.referenced[known..].iter().cloned();
                    let files = std::iter::once(input.clone()).chain(referenced).collect();
                    drawn.push((character, files));
                }
            }
        }
        progress.step();
    }
    if drawn.is_empty() {
        return Err(Failure::Input(anyhow::anyhow!("none of the files contains a mesh to draw")));
    }
    Ok((drawn, added))
}

/// Returns true for a character whose joints have names of a humanoid.
fn has_roles(character: &Character) -> bool {
    RoleMap::detect(&character.skeleton).is_some()
}

/// Says that a character is in another unit than metres.
fn report_scale(character: &Character, scale: f32, among: Among) {
    let (name, own_m) = (&character.name, character.size_m());
    let own = if own_m < 0.1 { format!("{:.2} mm", own_m * 1e3) } else { format!("{own_m:.2} m") };
    let (reason, setter) = match among {
        Among::None => ("which is hardly meant in metres", "--height"),
        Among::Others => ("which suits no crowd of several characters", "--height"),
        Among::Scene => ("which suits no scene of people", "height_m of its cast"),
    };
    let extent = if own_m > character.height_m() { "long" } else { "high" };
    message!(
        "\"{name}\" is {own} {extent}, {reason}; it is drawn {:.2} m {extent}, and {setter} \
         sets it",
        scale * own_m
    );
}

/// Doubts a height in metres that was asked for and that no character has.
fn doubt_height(height_m: f32) -> Option<String> {
    let as_cm_m = height_m / 100.0;
    let hint = if PLAUSIBLE_M.contains(&as_cm_m) {
        format!("; {height_m} cm are {as_cm_m}")
    } else {
        String::new()
    };
    (!ALONE_M.contains(&height_m))
        .then(|| format!("a height of {height_m} m is hardly meant; heights are in metres{hint}"))
}

/// Returns the inputs with folders replaced by the glTF files in them, by name.
fn in_folders(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for input in inputs {
        if built_in::name_of(input).is_some() || !input.is_dir() {
            files.push(input.clone());
            continue;
        }
        let mut found = paths_in(input)?;
        let is_gltf = |path: &Path| {
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
            ["glb", "gltf", "vrm"].contains(&extension.to_ascii_lowercase().as_str())
        };
        found.retain(|path| is_gltf(path) && !is_cache(path));
        if found.is_empty() {
            return Err(Failure::Input(anyhow::anyhow!(
                "the folder {} holds no glTF file (.glb, .gltf, .vrm)",
                input.display()
            )));
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}

/// Loads the clips of a file or of a built-in person; `@people` stands for the first of them.
pub(crate) fn load_clips(loader: &mut Loader, file: &Path) -> Result<Vec<Arc<Clip>>, Failure> {
    match built_in::name_of(file) {
        Some(name) => built_in::clips(name),
        None => Ok(loader.load(file)?.clips.clone()),
    }
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

/// Adds a clip if it fits the character. Returns how well it fits, or why it does not.
fn add_fitting(
    crowd: &mut Crowd,
    (id, character): (CharacterId, &Character),
    clip: &Arc<Clip>,
) -> Result<Result<(ClipId, BindingReport), String>, Failure> {
    let (clip_roles, own) =
        (RoleMap::detect(clip.skeleton()), RoleMap::detect(&character.skeleton));
    let report = BindingReport::new(clip, clip_roles.as_ref(), &character.skeleton, own.as_ref())
        .and_then(|report| report.check(clip.name()).map(|()| report));
    Ok(match report {
        Ok(report) if report.bound_joints > 0 => {
            Ok((crowd.character_mut(id)?.add_clip(clip)?, report))
        }
        Ok(_) => Err("it moves none of its joints".to_owned()),
        Err(error) => Err(error.to_string()),
    })
}

/// Finds a character's clip by its name.
pub(crate) fn clip(crowd: &Crowd, id: CharacterId, name: &str) -> Result<ClipId, Failure> {
    let clips = crowd.character(id)?.clips();
    crowd.clip(id, name).map_err(|_| {
        let hint = hint(name, clips.iter().map(|(_, clip)| clip.name()));
        let character = crowd.character(id).map_or("", |character| &character.asset().name);
        Failure::usage(format!("\"{character}\" has no clip \"{name}\"{hint}"))
    })
}

/// Adds root motion to a clip: that of the body if it was asked for; otherwise, for a clip that
/// walks in place, that of the feet.
fn role_clip(
    crowd: &mut Crowd,
    role: CharacterId,
    clip: ClipId,
    choice: ClipChoice,
) -> Result<RoleClip, Failure> {
    let Some((_, plain)) = crowd.character(role)?.clips().into_iter().find(|(id, _)| *id == clip)
    else {
        return Ok(RoleClip { id: clip, motion: None });
    };
    let walks = plain.stats().ground_speed_m_per_sec.is_some_and(|speed| speed > WALKING_M_PER_SEC);
    if !choice.has_root_motion() && !walks {
        return Ok(RoleClip { id: clip, motion: None });
    }
    let from = if choice.has_root_motion() { MotionSource::Auto } else { MotionSource::Feet };
    let settings = MotionSettings { from, ..MotionSettings::default() };
    let with_motion =
        plain.with_root_motion(&settings).map_err(|e| Failure::usage(e.to_string()))?;
    if with_motion.root_motion().is_none_or(|motion| *motion.origin() == MotionOrigin::Nothing) {
        return Ok(RoleClip { id: clip, motion: None });
    }
    let with_motion = Arc::new(with_motion);
    let skeleton = &crowd.character(role)?.asset().skeleton;
    let [clip_roles, own] = [with_motion.skeleton(), skeleton].map(RoleMap::detect);
    let scale = Binding::fitting(&with_motion, clip_roles.as_ref(), skeleton, own.as_ref())
        .map_or(1.0, |binding| binding.motion_scale());
    let motion = with_motion.root_motion().cloned().map(|motion| (motion, scale));
    Ok(RoleClip { id: crowd.character_mut(role)?.add_clip(&with_motion)?, motion })
}

/// Returns the scale to the height asked for or, for a character in another unit than metres, to a
/// plausible height.
fn scale(character: &Character, height_m: Option<f32>, among: Among) -> f32 {
    let own = character.size_m().max(1e-6);
    // A humanoid may hold a long sword.
    let longer_than_high = !has_roles(character)
        && character.rest_bounds().is_some_and(|b| b.high[2] - b.low[2] > own);
    let plausible_m = if matches!(among, Among::None) { ALONE_M } else { PLAUSIBLE_M };
    match height_m {
        Some(height_m) => height_m / own,
        None if plausible_m.contains(&own) => 1.0,
        None if longer_than_high => FOUR_LEGGED_M / own,
        None => UPRIGHT_M / own,
    }
}

/// Returns up to three walks and one idle of a character, found by name; the shortest names are
/// preferred. If there are none, returns all clips.
fn default_clips(crowd: &Crowd, id: CharacterId) -> Result<Vec<ClipId>, Failure> {
    let clips = crowd.character(id)?.clips();
    let names = || clips.iter().map(|(_, clip)| clip.name());
    let defaults = [shortest(names(), "walk", 3), shortest(names(), "idle", 1)].concat();
    let all = if defaults.is_empty() { (0..clips.len()).collect() } else { defaults };
    Ok(all.into_iter().map(|index| clips[index].0).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_in_centimetres_are_doubted() {
        let doubt = "a height of 180 m is hardly meant; heights are in metres; 180 cm are 1.8";
        assert_eq!(doubt_height(180.0).as_deref(), Some(doubt));
        assert!(doubt_height(1000.0).is_some_and(|doubt| doubt.ends_with("in metres")));
        assert_eq!([0.05, 0.3, 1.8, 30.0].map(doubt_height), [const { None }; 4]);
    }
}
