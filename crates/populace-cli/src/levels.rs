//! Levels of detail of loaded characters, and their cache.
//!
//! The levels of `NAME.glb` are kept in `NAME.levels.glb` beside it, and those of `NAME.gltf` in
//! `NAME.gltf.levels.glb`: the character without its clips but with levels. The file's generator names a hash of the source and of all files that it refers to.
//! If the hash differs from the present one, the levels are made again.

use std::hash::Hasher;
use std::path::{Path, PathBuf};

use populace::character::{Character, Level, PaletteEntry, joints_needed};
use populace_assets::{WriteOptions, to_glb};
use siphasher::sip128::{Hasher128, SipHasher24};

use crate::cli::PictureArgs;
use crate::failure::Failure;
use crate::input::InputArgs;
use crate::output;
use crate::report::message;

/// Where the levels of detail of characters come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Levels {
    /// Characters have none.
    None,
    /// They are made.
    Made,
    /// They are read from beside the source, or made and written there.
    Cached,
}

/// Revision of the simplification. Caches of earlier revisions are made again.
const REVISION: u32 = 6;

/// The end of the names of caches.
const ENDING: &str = "levels.glb";

/// Returns true for the path of a cache.
pub(crate) fn is_cache(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    name.strip_suffix(ENDING).is_some_and(|stem| stem.ends_with('.'))
}

impl Levels {
    /// Returns where the levels of a picture come from.
    pub(crate) fn wanted(args: &PictureArgs) -> Self {
        match (args.full_detail, args.cache_levels) {
            (true, _) => Self::None,
            (false, true) => Self::Cached,
            (false, false) => Self::Made,
        }
    }

    /// Returns a character with levels of detail if they are wanted and it has none. `files` are
    /// the file that it was loaded from and all files that this one refers to; empty if it comes
    /// from elsewhere. A cache that cannot be written is reported, and the character is used.
    pub(crate) fn of(
        self,
        character: Character,
        files: &[PathBuf],
        input: &InputArgs,
    ) -> Result<Character, Failure> {
        if self == Self::None || !character.levels().is_empty() {
            return Ok(character);
        }
        let made =
            |character| populace_lod::with_levels(character).map_err(|e| Failure::Run(e.into()));
        let [source, ..] = files else { return made(character) };
        if self == Self::Made || source == Path::new("-") {
            return made(character);
        }
        let (cache, generator) = (cache_of(source), generator(files)?);
        let cached = input.load(&cache).ok();
        let is_other = cache.exists()
            && !cached.as_ref().is_some_and(|c| is_made_here(c.generator.as_deref()));
        let cached = cached.filter(|c| c.generator.as_deref() == Some(&generator));
        if let Some(levels) = cached.and_then(|cached| levels_for(&character, &cached.character)) {
            return character.with_levels(levels).map_err(|e| Failure::Run(e.into()));
        }
        let character = made(character)?;
        let not_cached = |reason: &dyn std::fmt::Display| {
            let source = source.display();
            message!("warning: levels of detail of {source} are not cached: {reason}");
        };
        if is_other {
            not_cached(&format_args!(
                "{} is another file; rename it, or leave out --cache-levels",
                cache.display()
            ));
            return Ok(character);
        }
        let options = WriteOptions { generator: &generator, ..WriteOptions::default() };
        let written = to_glb(&character, &options).map_err(Failure::from);
        if let Err(error) = written.and_then(|bytes| output::write(&cache, &bytes)) {
            not_cached(&format_args!(
                "{error}; make its folder writable, or leave out --cache-levels"
            ));
        }
        Ok(character)
    }
}

/// Returns the path of the cache of a file.
fn cache_of(source: &Path) -> PathBuf {
    let is_glb = source.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
    let stem = if is_glb { source.with_extension("") } else { source.to_owned() };
    let mut name = stem.into_os_string();
    name.push(".");
    name.push(ENDING);
    name.into()
}

/// Returns true for files that this program wrote as a cache, of this or another version.
fn is_made_here(generator: Option<&str>) -> bool {
    generator.is_some_and(|text| text.starts_with("populace ") && text.contains(", levels, "))
}

/// Returns the name by which a cache says what it was made from.
fn generator(files: &[PathBuf]) -> Result<String, Failure> {
    let mut hash = SipHasher24::new();
    for file in files {
        let unreadable = |e| anyhow::anyhow!("{} cannot be read: {e}", file.display());
        let bytes = std::fs::read(file).map_err(|e| Failure::Input(unreadable(e)))?;
        hash.write(&(bytes.len() as u64).to_le_bytes());
        hash.write(&bytes);
    }
    let digest = hash.finish128().as_u128();
    let version = env!("CARGO_PKG_VERSION");
    Ok(format!("populace {version}, levels, revision {REVISION}, of {digest:032x}"))
}

/// Returns the levels of a cached character for its source, whose palette may be in another order.
/// `None` if the parts or the palette differ.
fn levels_for(character: &Character, cached: &Character) -> Option<Vec<Level>> {
    let parts = |character: &Character| -> Vec<_> {
        character.parts.iter().map(|part| part.mesh.positions.len()).collect()
    };
    if parts(character) != parts(cached) {
        return None;
    }
    let name = |of: &Character, entry: &PaletteEntry| of.skeleton.name(entry.joint).to_owned();
    let entry = |entry: &PaletteEntry| {
        let wanted = name(cached, entry);
        let same = |own: &PaletteEntry| {
            own.joint_from_bind == entry.joint_from_bind && name(character, own) == wanted
        };
        u16::try_from(character.palette.iter().position(same)?).ok()
    };
    let entries: Vec<u16> = cached.palette.iter().map(entry).collect::<Option<_>>()?;
    let mut levels = cached.levels().to_vec();
    for level in &mut levels {
        level.joint_count = joints_needed(&character.skeleton, level.error_m);
        for mesh in &mut level.meshes {
            for entry in &mut mesh.influences.entries {
                *entry = *entries.get(usize::from(*entry))?;
            }
        }
    }
    Some(levels)
}
