//! The characters of a crowd: from files, or the built-in people.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use populace::character::Character;
use populace::clip::{Clip, RootMotion};
use populace::model::RoleMap;
use populace::retarget::Binding;
use populace::{
    BindingReport, CharacterId, ClipId, Crowd, MotionOrigin, MotionSettings, MotionSource,
};
use populace_cast::{Look, person};

use crate::failure::Failure;
use crate::fit;
use crate::input::InputArgs;
use crate::names::hint;
use crate::progress::Progress;
use crate::report::talk;

/// Slower clips are taken to stand still.
const WALKING_M_PER_SEC: f32 = 0.1;
/// Heights that are believed to be metres in a crowd of mixed characters; others are in some other
/// unit.
const BELIEVED_M: std::ops::Range<f32> = 0.5..2.2;
/// What a character of some other unit becomes, if it stands upright.
const UPRIGHT_M: f32 = 1.75;
/// And if it is longer than it is high.
const FOUR_LEGGED_M: f32 = 0.8;

/// A character and what its members play.
pub(crate) struct Role {
    pub(crate) id: CharacterId,
    pub(crate) character: Arc<Character>,
    /// Clips to choose from; empty where the character has none.
    pub(crate) clips: Vec<Moving>,
    pub(crate) scale: f32,
}

/// A clip, and how it moves who plays it.
pub(crate) struct Moving {
    pub(crate) id: ClipId,
    /// Its root motion, and in parts of that how far the character goes.
    pub(crate) motion: Option<(RootMotion, f32)>,
}

/// What characters are to play.
#[derive(Clone, Copy, Default)]
pub(crate) struct Wanted<'a> {
    /// The clip of this name; else the usual ones.
    pub(crate) clip: Option<&'a str>,
    /// Whether what moves the body is taken out of the pose, to move the member.
    pub(crate) root_motion: bool,
}

/// The characters of a crowd, and every file that theirs name.
pub(crate) struct Cast {
    pub(crate) roles: Vec<Role>,
    pub(crate) files: Vec<PathBuf>,
}

/// Loads characters from files, and keeps the paths of all files that these name.
pub(crate) struct Files<'a> {
    input: &'a InputArgs,
    named: Vec<PathBuf>,
}

impl<'a> Files<'a> {
    pub(crate) fn new(input: &'a InputArgs) -> Self {
        Self { input, named: Vec::new() }
    }

    fn load(&mut self, file: &Path) -> Result<Character, Failure> {
        let imported = self.input.load(file)?;
        for note in &imported.notes {
            talk!("{}: {}: {}", file.display(), note.place, note.what);
        }
        self.named.extend(imported.named_files);
        Ok(imported.character)
    }
}

/// Loads the inputs into the crowd: files, or built-in people as `@people` or one by name as
/// `@child`. Files without meshes lend their clips to all characters, and so do the lenders.
pub(crate) fn load(
    crowd: &mut Crowd,
    input: &InputArgs,
    inputs: &[PathBuf],
    lenders: &[PathBuf],
    wanted: Wanted,
    height_m: Option<f32>,
) -> Result<Cast, Failure> {
    let (mut drawn, mut lent, mut files) = (Vec::new(), Vec::new(), Files::new(input));
    let mut progress = Progress::new("files", inputs.len() + lenders.len());
    for lender in lenders {
        lent.extend(lend(&mut files, lender)?);
        progress.step();
    }
    for input in inputs {
        match built_in_name(input) {
            Some(name) => drawn.extend(built_in(name)?),
            None => {
                let character = files.load(input)?;
                if character.parts.is_empty() {
                    lent.extend(character.clips.iter().cloned());
                } else {
                    drawn.push(Arc::new(character));
                }
            }
        }
        progress.step();
    }
    if drawn.is_empty() {
        return Err(Failure::Input(anyhow::anyhow!("none of the files holds a mesh to draw")));
    }
    let mixed = drawn.len() > 1;
    drop(progress);
    let mut progress = Progress::new("characters", drawn.len());
    let mut role = |character: Arc<Character>| {
        let scale = scale(&character, height_m, mixed);
        progress.step();
        Ok::<_, Failure>(Role { scale, ..role(crowd, character, &lent, wanted)? })
    };
    let roles = drawn.into_iter().map(&mut role).collect::<Result<_, _>>()?;
    Ok(Cast { roles, files: files.named })
}

/// The name of a built-in person that stands in a file's place, as `people` in `@people`.
pub(crate) fn built_in_name(input: &Path) -> Option<&str> {
    input.to_str()?.strip_prefix('@')
}

/// Outfits of each build among `@people`.
const OUTFITS: usize = 5;

/// The looks of built-in people: all of them, in several outfits, for `people`, else the one of
/// that name.
fn looks(name: &str) -> Result<Vec<Look>, Failure> {
    let presets = Look::presets();
    if name == "people" {
        let outfits =
            (0..OUTFITS).flat_map(|number| presets.iter().map(move |look| look.in_outfit(number)));
        return Ok(outfits.collect());
    }
    let list =
        presets.iter().map(|look| format!("\"@{}\"", look.name)).collect::<Vec<_>>().join(", ");
    let look = presets.into_iter().find(|look| look.name == name).ok_or_else(|| {
        Failure::usage(format!("there is no built-in \"@{name}\"; there are \"@people\", {list}"))
    })?;
    Ok(vec![look])
}

fn made(look: &Look) -> Result<Character, Failure> {
    person(look).map_err(|e| Failure::Run(e.into()))
}

fn built_in(name: &str) -> Result<Vec<Arc<Character>>, Failure> {
    looks(name)?.iter().map(|look| made(look).map(Arc::new)).collect()
}

/// The clips of a file, or of a built-in person: `@people` are as the first of them.
pub(crate) fn lend(files: &mut Files, lender: &Path) -> Result<Vec<Arc<Clip>>, Failure> {
    match built_in_name(lender) {
        Some(name) => built_in_clips(name),
        None => Ok(files.load(lender)?.clips.clone()),
    }
}

fn built_in_clips(name: &str) -> Result<Vec<Arc<Clip>>, Failure> {
    looks(name)?.first().map_or(Ok(Vec::new()), |look| Ok(made(look)?.clips.clone()))
}

/// Adds a character to the crowd, with clips of others; a humanoid that then has none gets those of
/// the built-in people.
fn role(
    crowd: &mut Crowd,
    character: Arc<Character>,
    lent: &[Arc<Clip>],
    wanted: Wanted,
) -> Result<Role, Failure> {
    let id = crowd.add_character(Arc::clone(&character))?;
    let mut fits = Vec::new();
    for lent in lent {
        match add_fitting(crowd, (id, &character), lent)? {
            Ok(fit) => fits.push(fit),
            Err(refused) if wanted.clip == Some(lent.name()) => {
                let (clip, name) = (lent.name(), &character.name);
                return Err(Failure::usage(format!(
                    "\"{name}\" cannot play the clip \"{clip}\": {refused}"
                )));
            }
            Err(_) => {}
        }
    }
    let without = crowd.clips(id)?.is_empty();
    if without && RoleMap::detect(&character.skeleton).is_some() {
        for clip in &built_in_clips("people")? {
            fits.extend(add_fitting(crowd, (id, &character), clip)?);
        }
    }
    let clips = match wanted.clip {
        Some(name) => vec![clip(crowd, id, name)?],
        None => usual_clips(crowd, id)?,
    };
    if without {
        tell_borrowed(crowd, (id, &character), &clips)?;
    }
    for (clip, report) in fits.iter().filter(|(clip, _)| clips.contains(clip)) {
        let known = crowd.clips(id)?.into_iter().find(|(known, _)| known == clip);
        fit::warn(known.as_ref().map_or("", |(_, clip)| clip.name()), &character.name, report);
    }
    let clips =
        clips.into_iter().map(|clip| moving(crowd, id, clip, wanted)).collect::<Result<_, _>>()?;
    Ok(Role { id, character, clips, scale: 1.0 })
}

/// Adds a clip if it fits the character; says how well it does, or why not.
fn add_fitting(
    crowd: &mut Crowd,
    (id, character): (CharacterId, &Character),
    clip: &Arc<Clip>,
) -> Result<Result<(ClipId, BindingReport), String>, Failure> {
    let (clip_roles, own) =
        (RoleMap::detect(clip.skeleton()), RoleMap::detect(&character.skeleton));
    Ok(match Binding::fitting(clip, clip_roles.as_ref(), &character.skeleton, own.as_ref()) {
        Ok(binding) if binding.bound_joint_count() > 0 => {
            Ok((crowd.add_clip(id, clip)?, *binding.report()))
        }
        Ok(_) => Err("it drives nothing".to_owned()),
        Err(error) => Err(error.to_string()),
    })
}

/// Says which clips a character without any plays, if it does.
fn tell_borrowed(
    crowd: &Crowd,
    (id, character): (CharacterId, &Character),
    playing: &[ClipId],
) -> Result<(), Failure> {
    let name = &character.name;
    let clips = crowd.clips(id)?;
    let played: Vec<_> =
        clips.iter().filter(|(id, _)| playing.contains(id)).map(|(_, clip)| clip.name()).collect();
    if played.is_empty() {
        talk!(
            "warning: \"{name}\" has no clips, and is no humanoid that could play those of the \
             built-in people; it stands as it rests; --clips FILE lends it clips"
        );
    } else {
        talk!(
            "\"{name}\" has no clips; it plays {} of the built-in people, retargeted",
            played.join(" and ")
        );
    }
    Ok(())
}

/// A character's clip by its name.
pub(crate) fn clip(crowd: &Crowd, id: CharacterId, name: &str) -> Result<ClipId, Failure> {
    let clips = crowd.clips(id)?;
    crowd.clip(id, name).map_err(|_| {
        let hint = hint(name, clips.iter().map(|(_, clip)| clip.name()));
        let character = crowd.character(id).map_or("", |character| &character.name);
        Failure::usage(format!("\"{character}\" has no clip \"{name}\"{hint}"))
    })
}

/// A clip with its root motion: whatever moves the body where that is asked for, else what the feet
/// of one that walks in place tell.
fn moving(
    crowd: &mut Crowd,
    role: CharacterId,
    clip: ClipId,
    wanted: Wanted,
) -> Result<Moving, Failure> {
    let Some((_, plain)) = crowd.clips(role)?.into_iter().find(|(id, _)| *id == clip) else {
        return Ok(Moving { id: clip, motion: None });
    };
    let walks = plain.stats().ground_speed_m_per_sec.is_some_and(|speed| speed > WALKING_M_PER_SEC);
    if !wanted.root_motion && !walks {
        return Ok(Moving { id: clip, motion: None });
    }
    let from = if wanted.root_motion { MotionSource::Auto } else { MotionSource::Feet };
    let settings = MotionSettings { from, ..MotionSettings::default() };
    let taken = plain.with_root_motion(&settings).map_err(|e| Failure::usage(e.to_string()))?;
    if taken.root_motion().is_none_or(|motion| *motion.origin() == MotionOrigin::Nothing) {
        return Ok(Moving { id: clip, motion: None });
    }
    let taken = Arc::new(taken);
    let skeleton = &crowd.character(role)?.skeleton;
    let [clip_roles, own] = [taken.skeleton(), skeleton].map(RoleMap::detect);
    let part = Binding::fitting(&taken, clip_roles.as_ref(), skeleton, own.as_ref())
        .map_or(1.0, |binding| binding.motion_scale());
    let motion = taken.root_motion().cloned().map(|motion| (motion, part));
    Ok(Moving { id: crowd.add_clip(role, &taken)?, motion })
}

/// The height asked for; in a crowd of mixed characters a sensible one.
fn scale(character: &Character, height_m: Option<f32>, mixed: bool) -> f32 {
    let own = character.height_m().max(1e-6);
    let longer_than_high = character.rest_bounds().is_some_and(|b| b.high[2] - b.low[2] > own);
    match height_m {
        Some(wanted) => wanted / own,
        None if !mixed || BELIEVED_M.contains(&own) => 1.0,
        None if longer_than_high => FOUR_LEGGED_M / own,
        None => UPRIGHT_M / own,
    }
}

/// The plainest walks and the plainest idle of a character, by name: of several, those with the
/// shortest names. Where there are none, all its clips.
fn usual_clips(crowd: &Crowd, id: CharacterId) -> Result<Vec<ClipId>, Failure> {
    let clips = crowd.clips(id)?;
    let plainest = |word: &str, most: usize| {
        let named = |name: &str| {
            name.to_lowercase().contains(word) && !name.to_lowercase().contains("pose")
        };
        let mut found: Vec<_> = clips.iter().filter(|(_, clip)| named(clip.name())).collect();
        found.sort_by_key(|(_, clip)| clip.name().len());
        found.into_iter().take(most).map(|(id, _)| *id).collect::<Vec<_>>()
    };
    let usual = [plainest("walk", 3), plainest("idle", 1)].concat();
    Ok(if usual.is_empty() { clips.into_iter().map(|(id, _)| id).collect() } else { usual })
}
