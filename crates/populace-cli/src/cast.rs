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
            let scale = if several {
                COMMON_HEIGHT_M / character.height_m().max(1e-6)
            } else {
                1.0
            };
            Ok(Role {
                id,
                character,
                clips,
                scale,
            })
        })
        .collect()
}

/// The walks and idles of a character by name; where there are none, all its clips.
fn usual_clips(crowd: &Crowd, id: CharacterId) -> Result<Vec<ClipId>, Failure> {
    let clips = crowd.clips(id)?;
    let usual = |name: &str| {
        let name = name.to_lowercase();
        (name.contains("walk") || name.contains("idle")) && !name.contains("pose") && !name.contains("lie")
    };
    let named: Vec<_> = clips
        .iter()
        .filter(|(_, clip)| usual(clip.name()))
        .map(|(id, _)| *id)
        .collect();
    Ok(if named.is_empty() {
        clips.into_iter().map(|(id, _)| id).collect()
    } else {
        named
    })
}
