//! The characters of a crowd, from files.

use std::path::PathBuf;
use std::sync::Arc;

use populace::core::Character;
use populace::{CharacterId, ClipId, Crowd};

use crate::failure::Failure;

/// Height that characters get in a crowd of several files, whose units may differ.
const COMMON_HEIGHT_M: f32 = 1.75;

/// A character and what its members play.
pub(crate) struct Role {
    pub(crate) id: CharacterId,
    pub(crate) character: Arc<Character>,
    /// Clips to choose from; empty where the character has none.
    pub(crate) clips: Vec<ClipId>,
    pub(crate) scale: f32,
}

/// Loads the files into the crowd. Files without meshes lend their clips to all characters.
pub(crate) fn load(crowd: &mut Crowd, files: &[PathBuf], clip: Option<&str>) -> Result<Vec<Role>, Failure> {
    let mut drawn = Vec::new();
    let mut lent = Vec::new();
    for file in files {
        let imported = populace_assets::load(file)?;
        for note in &imported.notes {
            eprintln!("populace: {}: {}: {}", file.display(), note.place, note.what);
        }
        if imported.character.parts.is_empty() {
            lent.extend(imported.character.clips.iter().cloned());
        } else {
            drawn.push(Arc::new(imported.character));
        }
    }
    if drawn.is_empty() {
        let message = anyhow::anyhow!("none of the files holds a mesh to draw");
        return Err(Failure::Input(message));
    }
    let several = drawn.len() > 1;
    drawn
        .into_iter()
        .map(|character| {
            let id = crowd.add_character(Arc::clone(&character))?;
            for clip in &lent {
                crowd.add_clip(id, clip)?;
            }
            let clips = match clip {
                Some(name) => vec![crowd.clip(id, name)?],
                None => usual_clips(crowd, id)?,
            };
            let scale = if several { COMMON_HEIGHT_M / character.height_m().max(1e-6) } else { 1.0 };
            Ok(Role { id, character, clips, scale })
        })
        .collect()
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
