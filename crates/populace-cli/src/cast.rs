//! The characters of a crowd: from files, or the built-in people.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use populace::core::{Binding, Character, Clip, RoleMap, RootMotion};
use populace::{CharacterId, ClipId, Crowd, MotionOrigin, MotionSettings, MotionSource};

use crate::failure::Failure;
use crate::fit;

/// Slower clips are taken to stand still.
const WALKING_M_PER_SEC: f32 = 0.1;
/// Heights that are believed to be metres in a crowd of mixed characters; others are in some other unit.
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

/// Loads the inputs into the crowd: files, or built-in people as `@people` or one by name as `@child`. Files without
/// meshes lend their clips to all characters, and so do the lenders.
pub(crate) fn load(
    crowd: &mut Crowd,
    inputs: &[String],
    lenders: &[PathBuf],
    wanted: Wanted,
    height_m: Option<f32>,
) -> Result<Vec<Role>, Failure> {
    let mut drawn = Vec::new();
    let mut lent = Vec::new();
    for file in lenders {
        lent.extend(from_file(file)?.clips.iter().cloned());
    }
    for input in inputs {
        match input.strip_prefix('@') {
            Some(name) => drawn.extend(built_in(name)?),
            None => {
                let character = from_file(Path::new(input))?;
                if character.parts.is_empty() {
                    lent.extend(character.clips.iter().cloned());
                } else {
                    drawn.push(Arc::new(character));
                }
            }
        }
    }
    if drawn.is_empty() {
        return Err(Failure::Input(anyhow::anyhow!("none of the files holds a mesh to draw")));
    }
    let mixed = drawn.len() > 1;
    let role = |character: Arc<Character>| {
        let scale = scale(&character, height_m, mixed);
        Ok(Role { scale, ..role(crowd, character, &lent, wanted)? })
    };
    drawn.into_iter().map(role).collect()
}

/// Outfits of each build among `@people`.
const OUTFITS: usize = 5;

/// The built-in people: all of them, in several outfits, for `people`, else the one of that name.
pub(crate) fn built_in(name: &str) -> Result<Vec<Arc<Character>>, Failure> {
    let failed = |e: populace::core::Error| Failure::Run(e.into());
    if name == "people" {
        return Ok(populace_cast::people(OUTFITS).map_err(failed)?.into_iter().map(Arc::new).collect());
    }
    let looks = populace_cast::Look::presets();
    match looks.iter().find(|look| look.name == name) {
        Some(look) => Ok(vec![Arc::new(populace_cast::person(look).map_err(failed)?)]),
        None => {
            let list = looks.iter().map(|look| format!("\"@{}\"", look.name)).collect::<Vec<_>>().join(", ");
            Err(Failure::usage(format!("there is no built-in \"@{name}\"; there are \"@people\", {list}")))
        }
    }
}

fn from_file(file: &Path) -> Result<Character, Failure> {
    let imported = populace_assets::load(file)?;
    for note in &imported.notes {
        crate::report::talk!("{}: {}: {}", file.display(), note.place, note.what);
    }
    Ok(imported.character)
}

/// Adds a character to the crowd, with clips of others.
pub(crate) fn role(
    crowd: &mut Crowd,
    character: Arc<Character>,
    lent: &[Arc<Clip>],
    wanted: Wanted,
) -> Result<Role, Failure> {
    let id = crowd.add_character(Arc::clone(&character))?;
    let mut fits = Vec::new();
    for lent in lent {
        let (clip_roles, own) = (RoleMap::detect(lent.skeleton()), RoleMap::detect(&character.skeleton));
        let refused = match Binding::fitting(lent, clip_roles.as_ref(), &character.skeleton, own.as_ref()) {
            Ok(binding) if binding.bound_joint_count() > 0 => {
                fits.push((crowd.add_clip(id, lent)?, *binding.report()));
                continue;
            }
            Ok(_) => "it drives nothing".to_owned(),
            Err(error) => error.to_string(),
        };
        if wanted.clip == Some(lent.name()) {
            let (clip, name) = (lent.name(), &character.name);
            return Err(Failure::usage(format!("\"{name}\" cannot play the clip \"{clip}\": {refused}")));
        }
    }
    let clips = match wanted.clip {
        Some(name) => vec![crowd.clip(id, name)?],
        None => usual_clips(crowd, id)?,
    };
    for (clip, report) in fits.iter().filter(|(clip, _)| clips.contains(clip)) {
        let known = crowd.clips(id)?.into_iter().find(|(known, _)| known == clip);
        fit::warn(known.as_ref().map_or("", |(_, clip)| clip.name()), &character.name, report);
    }
    let clips = clips.into_iter().map(|clip| moving(crowd, id, clip, wanted)).collect::<Result<_, _>>()?;
    Ok(Role { id, character, clips, scale: 1.0 })
}

/// A clip with its root motion: whatever moves the body where that is asked for, else what the feet
/// of one that walks in place tell.
fn moving(crowd: &mut Crowd, role: CharacterId, clip: ClipId, wanted: Wanted) -> Result<Moving, Failure> {
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

/// The plainest walks and the plainest idle of a character, by name: of several, those with the shortest names. Where
/// there are none, all its clips.
fn usual_clips(crowd: &Crowd, id: CharacterId) -> Result<Vec<ClipId>, Failure> {
    let clips = crowd.clips(id)?;
    let plainest = |word: &str, most: usize| {
        let named = |name: &str| name.to_lowercase().contains(word) && !name.to_lowercase().contains("pose");
        let mut found: Vec<_> = clips.iter().filter(|(_, clip)| named(clip.name())).collect();
        found.sort_by_key(|(_, clip)| clip.name().len());
        found.into_iter().take(most).map(|(id, _)| *id).collect::<Vec<_>>()
    };
    let usual = [plainest("walk", 3), plainest("idle", 1)].concat();
    Ok(if usual.is_empty() { clips.into_iter().map(|(id, _)| id).collect() } else { usual })
}
