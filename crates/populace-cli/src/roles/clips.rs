//! The clips of a role: added, found by name and given root motion.

use std::sync::Arc;

use populace::character::Character;
use populace::clip::Clip;
use populace::model::RoleMap;
use populace::retarget::Binding;
use populace::{
    BindingReport, CharacterId, ClipId, Crowd, MotionOrigin, MotionSettings, MotionSource,
};

use super::{ClipChoice, RoleClip};
use crate::clip_words::shortest;
use crate::failure::Failure;
use crate::names::hint;

/// Clips with a slower ground speed are taken to stand still.
const WALKING_M_PER_SEC: f32 = 0.1;

/// Adds a clip if it fits the character. Returns how well it fits, or why it does not.
pub(super) fn add_fitting(
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
pub(super) fn role_clip(
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

/// Returns up to three walks and one idle of a character, found by name; the shortest names are
/// preferred. If there are none, returns all clips.
pub(super) fn default_clips(crowd: &Crowd, id: CharacterId) -> Result<Vec<ClipId>, Failure> {
    let clips = crowd.character(id)?.clips();
    let names = || clips.iter().map(|(_, clip)| clip.name());
    let defaults = [shortest(names(), "walk", 3), shortest(names(), "idle", 1)].concat();
    let all = if defaults.is_empty() { (0..clips.len()).collect() } else { defaults };
    Ok(all.into_iter().map(|index| clips[index].0).collect())
}
