//! The files and folders of a crowd's characters and clips.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use populace::character::Character;
use populace::clip::Clip;

use crate::built_in::{self, Clothes};
use crate::failure::Failure;
use crate::folder::paths_in;
use crate::input::InputArgs;
use crate::levels::is_cache;
use crate::progress::Progress;
use crate::report::message;

/// Loads characters from files, and records all files that they refer to.
pub(crate) struct Loader<'a> {
    pub(super) input: &'a InputArgs,
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

/// Characters to draw, with their files: none of those that are built in.
pub(super) type Drawn = Vec<(Character, Vec<PathBuf>)>;

/// The clips of a file that are added to all characters.
pub(super) struct AddedClips {
    file: PathBuf,
    pub(super) clips: Vec<Arc<Clip>>,
    /// True once one of them fits a character.
    pub(super) fits: bool,
    /// Why the last one that was refused does not fit.
    pub(super) reason: String,
}

impl AddedClips {
    fn new(file: &Path, clips: Vec<Arc<Clip>>) -> Self {
        Self { file: file.to_owned(), clips, fits: false, reason: "it has none".to_owned() }
    }

    /// Says that none of the clips fits any character.
    pub(super) fn unfit(&self) -> Option<String> {
        let Self { file, fits, reason, .. } = self;
        let file = file.display();
        (!fits).then(|| format!("no clip of {file} fits any of the characters: {reason}"))
    }
}

/// Reads the characters to draw, and the clips of the files that have nothing else.
pub(super) fn read(
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

/// Returns the inputs with folders replaced by the glTF files in them, by name.
pub(super) fn in_folders(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
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
